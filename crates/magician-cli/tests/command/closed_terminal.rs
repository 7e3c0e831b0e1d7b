//! Terminals that are closed during a drawing, and signals in quick succession: the pen is lifted
//! and settings are restored.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::magician::drawing::{Fixture, PAPER};
use crate::magician::served::Served;
use crate::magician::terminal::Terminal;
use crate::magician::{command, run};

/// Returns the processes of commands that draw from this directory, started by any shell.
fn drawings(dir: &Path) -> Vec<u32> {
    let processes = std::fs::read_dir("/proc").expect("processes").flatten();
    let ids = processes.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    ids.filter(|id| {
        let runs_here = std::fs::read_link(format!("/proc/{id}/cwd")).is_ok_and(|cwd| cwd == dir);
        let words = std::fs::read(format!("/proc/{id}/cmdline")).unwrap_or_default();
        let mut words = words.split(|byte| *byte == 0);
        let is_ours = words
            .next()
            .is_some_and(|name| name.ends_with(b"/magician"));
        runs_here && is_ours && words.any(|word| word == b"draw")
    })
    .collect()
}

/// Waits until no command draws any more, and checks the state of the arm at the end.
fn ends_well(fixture: &Fixture, before: &[serde_json::Value], how: &str) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while !drawings(fixture.dir.path()).is_empty() {
        assert!(Instant::now() < deadline, "{how}: it does not end");
        // The request also takes the time that a sleep would.
        fixture.number("pose", "z");
    }
    let up = fixture.number("pose", "z") - PAPER;
    assert!((up - 10.0).abs() < 0.5, "{how}: the pen is up by {up} mm");
    assert_eq!(fixture.settings(), before, "{how}");
    assert_eq!(
        fixture.unrestored(),
        0,
        "{how}: nothing is left to the next command"
    );
    assert_eq!(fixture.number("queue", "left_space"), 32.0, "{how}");
    assert_eq!(fixture.journals(), 1, "{how}: it was not interrupted");
}

/// Returns the drawing command as a line for a shell.
fn line(draw: &Command) -> String {
    let words = std::iter::once(draw.get_program()).chain(draw.get_args());
    let words = words.map(|word| format!("'{}'", word.to_str().expect("UTF-8")));
    words.collect::<Vec<_>>().join(" ")
}

/// Creates a shell with the environment of this command.
fn shell(draw: &Command, words: &[&str]) -> Command {
    let mut shell = Command::new(words[0]);
    shell.args(&words[1..]);
    for (name, value) in draw.get_envs() {
        match value {
            Some(value) => shell.env(name, value),
            None => shell.env_remove(name),
        };
    }
    shell.current_dir(draw.get_current_dir().expect("a directory"));
    shell.env("PS1", "> ").env("HISTFILE", "/dev/null");
    shell
}

/// Starts an interactive bash on a separate terminal that runs this command.
fn bash(draw: &Command) -> Terminal {
    let words = ["setsid", "--ctty", "bash", "--norc", "--noprofile", "-i"];
    let mut bash = Terminal::running(shell(draw, &words));
    bash.types(&format!("{}\n", line(draw)));
    bash
}

fn kill(signal: &str, id: u32) {
    let kill = Command::new("kill")
        .args([signal, &id.to_string()])
        .stderr(Stdio::null())
        .status();
    kill.expect("kill runs");
}

fn draws(fixture: &Fixture, more: &[&str]) -> Child {
    let mut draw = fixture.draw(more);
    draw.stdout(Stdio::null()).stderr(Stdio::null());
    draw.spawn().expect("it starts")
}

#[test]
fn signals_in_quick_succession_lift_the_pen() {
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    for (nth, signals) in [
        &["-INT", "-INT"][..],
        &["-TERM", "-TERM"],
        &["-HUP", "-HUP"],
        &["-HUP", "-HUP", "-HUP", "-TERM"],
        &["-HUP", "-INT", "-HUP"],
        &["-TERM", "-HUP"],
        &["-QUIT"],
        &["-QUIT", "-INT"],
        &["-XCPU"],
    ]
    .into_iter()
    .enumerate()
    {
        let mut child = draws(&fixture, &[]);
        fixture.until_drawn(2.0 + 3.0 * nth as f64);
        for signal in signals {
            kill(signal, child.id());
        }
        let status = child.wait().expect("it ends");
        assert_eq!(status.code(), Some(130), "{signals:?}");
        ends_well(&fixture, &before, &format!("{signals:?}"));
    }
}

#[test]
fn repeated_hangups_do_not_stop_the_pen_lift() {
    let fixture = Fixture::homed("0.5");
    let before = fixture.settings();
    let mut child = draws(&fixture, &[]);
    fixture.until_drawn(2.0);
    while child.try_wait().expect("a child").is_none() {
        kill("-HUP", child.id());
    }
    ends_well(&fixture, &before, "hang-ups all along");
}

#[test]
fn a_bash_whose_terminal_is_closed_lifts_the_pen() {
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    for (nth, more) in [&[][..], &["--verbose"], &["--json"], &["--tui"]]
        .into_iter()
        .enumerate()
    {
        let mut bash = bash(&fixture.draw(more));
        fixture.until_drawn(2.0 + 5.0 * nth as f64);
        bash.closes();
        ends_well(&fixture, &before, &format!("a closed terminal, {more:?}"));
    }
}

/// The signal and the end of the input may come in either order.
#[test]
fn a_shell_whose_terminal_is_closed_switches_its_belt_off() {
    let fixture = Fixture::homed("5");
    let trace = fixture.dir.path().join("trace.pcapng");
    let trace = trace.to_str().expect("UTF-8");
    let shell_of_ours = fixture.command(&["--trace", trace, "shell"]);
    let words = [
        &["setsid", "--ctty", env!("CARGO_BIN_EXE_magician")][..],
        &["--port", &fixture.endpoint(), "--trace", trace, "shell"],
    ];
    for _ in 0..4 {
        let mut terminal = Terminal::running(shell(&shell_of_ours, &words.concat()));
        terminal.types("conveyor run 50\r");
        terminal.until_seen("running at 50 mm/s");
        terminal.closes();
        let status = terminal.child.wait().expect("it ends");
        assert_eq!(status.code(), Some(130));
        let sent = run(&["decode", trace]).out;
        let motors = sent.matches("request  SetEMotor\n").count();
        assert_eq!(motors, 3, "on, and both off: {sent}");
    }
}

/// In a script the command is no job of an interactive shell, so only the terminal sends the
/// signal.
#[test]
fn a_script_whose_terminal_is_closed_lifts_the_pen() {
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    let draw = fixture.draw(&[]);
    let script = format!("{}; exit $?", line(&draw));
    let words = ["setsid", "--ctty", "bash", "-c", &script];
    let mut terminal = Terminal::running(shell(&draw, &words));
    fixture.until_drawn(4.0);
    terminal.closes();
    ends_well(&fixture, &before, "a script");
}

/// The kernel continues a stopped process when its terminal closes; the drawing must not resume.
#[test]
fn a_suspended_drawing_whose_terminal_is_closed_stays_up_and_restores_settings() {
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    let mut bash = bash(&fixture.draw(&[]));
    fixture.until_drawn(4.0);
    bash.types("\x1a");
    bash.until_seen("Stopped");
    bash.closes();
    ends_well(&fixture, &before, "suspended");
}

#[test]
fn a_tmux_session_that_is_killed_lifts_the_pen() {
    if Command::new("tmux").arg("-V").output().is_err() {
        eprintln!("skipped: tmux is not installed");
        return;
    }
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    let draw = fixture.draw(&[]);
    let socket = fixture.dir.path().join("tmux");
    let socket = socket.to_str().expect("UTF-8");
    let tmux = |words: &[&str]| {
        let words = [&["tmux", "-S", socket, "-f", "/dev/null"], words].concat();
        let status = shell(&draw, &words).env("TERM", "xterm").status();
        assert!(status.expect("tmux runs").success(), "{words:?}");
    };
    let drawing = line(&draw);
    for (nth, (session, kill)) in [("one", "kill-session"), ("two", "kill-server")]
        .into_iter()
        .enumerate()
    {
        tmux(&[
            "new-session",
            "-d",
            "-s",
            session,
            "bash --norc --noprofile -i",
        ]);
        tmux(&["send-keys", "-t", session, &drawing, "Enter"]);
        fixture.until_drawn(2.0 + 4.0 * nth as f64);
        match kill {
            "kill-session" => tmux(&[kill, "-t", session]),
            _ => tmux(&[kill]),
        }
        ends_well(&fixture, &before, kill);
    }
}

#[test]
fn a_drawing_through_a_station_whose_terminal_is_closed_lifts_the_pen() {
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    let (_station, url) = station(&fixture);
    let draw = fixture.draw_at(&["--station", &url], &[]);
    let mut bash = bash(&draw);
    fixture.until_drawn(4.0);
    bash.closes();
    ends_well(&fixture, &before, "through a station");
}

/// Starts a station for the arm of this place.
fn station(fixture: &Fixture) -> (Served, String) {
    let mut serve = command();
    serve.env("XDG_STATE_HOME", fixture.dir.path().join("state"));
    let port = fixture.endpoint();
    let served = Served::of(
        serve,
        "serve",
        &["--port", &port, "--listen", "127.0.0.1:0"],
        1,
    );
    let url = served.endpoint("http").replace("http:http:", "http:");
    (served, url)
}
