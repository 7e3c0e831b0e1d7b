//! `magician sim --tui` at a terminal.
#![cfg(target_os = "linux")]

use std::io::Read;
use std::process::{Command, Stdio};

use crate::magician::terminal::Terminal;
use crate::magician::{command, run};
use rustix::termios::{Termios, tcgetattr};

/// Returns the flags of the terminal's mode that programs change.
fn mode(terminal: &Terminal) -> [u32; 4] {
    let Termios {
        input_modes,
        output_modes,
        control_modes,
        local_modes,
        ..
    } = tcgetattr(&terminal.line).expect("a terminal");
    [
        input_modes.bits(),
        output_modes.bits(),
        control_modes.bits(),
        local_modes.bits(),
    ]
}

/// Starts the picture of an arm. Returns its terminal and the mode from before.
fn picture(arguments: &[&str]) -> (Terminal, [u32; 4]) {
    // A new terminal always has the same mode, so that of an idle one is used.
    let mut idle = command();
    idle.arg("--version");
    let before = mode(&Terminal::with_stdout(idle, Some(Stdio::null())));
    let mut sim = command();
    sim.args(["sim", "--tcp", "127.0.0.1:0", "--tui"])
        .args(arguments);
    let mut terminal = Terminal::with_stdout(sim, Some(Stdio::piped()));
    terminal.until("\x1b[?1049h");
    terminal.until_seen("from above");
    terminal.until_seen("quit");
    assert_ne!(mode(&terminal), before);
    (terminal, before)
}

/// Types keys and waits for their effect. Ctrl-L makes the program redraw the whole screen instead
/// of the difference.
fn shows(terminal: &mut Terminal, keys: &str, text: &str) {
    terminal.types(keys);
    terminal.types("\x0c");
    terminal.until_seen(text);
}

/// Waits for the exit status, and checks that the terminal is restored.
fn ends(mut terminal: Terminal, before: [u32; 4], status: i32) {
    terminal.until("\x1b[?1049l");
    terminal.until("\x1b[?25h");
    let ended = terminal.child.wait().expect("it ends");
    assert_eq!(ended.code(), Some(status));
    assert_eq!(mode(&terminal), before);
    let mut said = String::new();
    let mut stdout = terminal.child.stdout.take().expect("stdout");
    stdout.read_to_string(&mut said).expect("UTF-8");
    assert_eq!(said, "ready\n");
}

#[test]
fn keys_act_and_q_ends() {
    let (mut terminal, before) = picture(&[]);
    shows(&mut terminal, "?", "redraw the screen");
    terminal.types("x");
    shows(&mut terminal, "u", "the unlock key is held");
    shows(&mut terminal, "u", "the unlock key is released");
    shows(&mut terminal, "a12\r", "PlanInvLimit raised");
    shows(&mut terminal, "p", "the cable was pulled");
    shows(&mut terminal, "p", "the cable is back");
    terminal.types("q");
    ends(terminal, before, 0);
}

#[test]
fn ctrl_c_exits_as_interrupted() {
    let (mut terminal, before) = picture(&[]);
    terminal.types("\x03");
    ends(terminal, before, 130);
}

#[test]
fn signals_restore_the_terminal() {
    for (signal, status) in [("-TERM", 0), ("-INT", 130), ("-HUP", 0)] {
        let (terminal, before) = picture(&[]);
        let id = terminal.child.id().to_string();
        let kill = Command::new("kill").args([signal, &id]).status();
        assert!(kill.expect("kill runs").success());
        ends(terminal, before, status);
    }
}

#[test]
fn several_arms_are_shown_one_by_one() {
    let (mut terminal, before) = picture(&["--arms", "3"]);
    shows(&mut terminal, "\t", "2 of 3");
    shows(&mut terminal, "\x1b[Z\x1b[Z", "3 of 3");
    terminal.types("q");
    ends(terminal, before, 0);
}

#[test]
fn picture_without_a_terminal_is_refused() {
    let refused = run(&["sim", "--tcp", "127.0.0.1:0", "--tui"]);
    assert_eq!((refused.status, refused.out.as_str()), (2, ""));
    assert!(refused.err.contains("not a terminal"), "{}", refused.err);
}
