//! Full-screen picture of a job.
#![cfg(target_os = "linux")]

use crate::magician;
use std::process::Stdio;

use crate::magician::drawing::{Fixture, PAPER};
use crate::magician::run;
use crate::magician::terminal::Terminal;
use rustix::process::Signal;
use rustix::termios::{LocalModes, tcgetattr};

fn is_as_it_was(terminal: &Terminal) -> bool {
    let modes = tcgetattr(&terminal.line).expect("a terminal").local_modes;
    modes.contains(LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG)
}

#[test]
fn full_screen_job_obeys_the_keys_and_restores_the_terminal() {
    let fixture = Fixture::homed("5");
    let mut terminal = Terminal::running(fixture.draw(&["--tui"]));
    terminal.until_drawn("magician draw |");
    terminal.until_drawn("sheet");
    assert!(!is_as_it_was(&terminal));
    terminal.types("-");
    terminal.until_drawn("left, at 90 %");
    terminal.types("p");
    terminal.until_drawn("paused: p resumes");
    assert!(fixture.number("pose", "z") > PAPER + 9.0);
    terminal.types("p");
    terminal.until_drawn("running");
    // Shortly after a pause the pen may still be up.
    terminal.interrupts("s", "interrupted: ");
    assert!(is_as_it_was(&terminal));
}

#[test]
fn ctrl_z_restores_the_terminal_and_continuing_retakes_it() {
    let fixture = Fixture::homed("5");
    let mut terminal = Terminal::running(fixture.draw(&["--tui"]));
    terminal.until_drawn("sheet");
    terminal.types("\x1a");
    // The regular screen is restored.
    terminal.until("\x1b[?1049l");
    terminal.until_stopped();
    assert!(is_as_it_was(&terminal));
    terminal.tell(Signal::CONT);
    terminal.until("\x1b[?1049h");
    terminal.until_drawn("running");
    terminal.interrupts("\x03", "interrupted: ");
    assert!(is_as_it_was(&terminal));
}

#[test]
fn full_screen_job_ends_with_the_regular_result() {
    let fixture = Fixture::homed("50");
    let mut terminal = Terminal::running(fixture.draw(&["--tui"]));
    terminal.until_drawn("sheet");
    terminal.until("\x1b[?1049l");
    terminal.until_seen("steps");
    assert_eq!(terminal.child.wait().expect("it ends").code(), Some(0));
    assert!(is_as_it_was(&terminal));
}

#[test]
fn full_screen_job_needs_a_terminal() {
    let fixture = Fixture::homed("50");
    let refused = |more: &[&str], why: &str| {
        let mut command = fixture.draw(&[&["--tui"], more].concat());
        let output = command.stdin(Stdio::null()).output().expect("it runs");
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains(why), "{said}");
    };
    refused(&[], "draws on stderr, which is not a terminal");
    refused(&["--json"], "cannot be used with --json");
    refused(&["--check"], "needs a run");
    let shell = magician::run_with(
        &["--port", "sim", "shell"],
        b"run nothing.svg --tui\nexit\n",
    );
    assert!(shell.err.contains("which the shell uses"), "{shell:?}");
    assert_eq!(run(&["run", "-", "--tui"]).status, 2);
}
