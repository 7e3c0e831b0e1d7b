//! Ctrl-Z while a job runs: the arm pauses before the process stops, and nothing burns again by
//! itself.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::Child;

use crate::magician::drawing::{Fixture, PAPER, last};
use crate::magician::terminal::Terminal;
use rustix::process::Signal;
use rustix::termios::{LocalModes, tcgetattr};

/// Returns the signals that a process catches.
fn caught(child: &Child) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id()));
    let status = status.expect("it is there");
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    u64::from_str_radix(caught.expect("a mask").trim(), 16).expect("a mask")
}

/// True if the terminal is restored: line mode with echo.
fn is_as_it_was(terminal: &Terminal) -> bool {
    let modes = tcgetattr(&terminal.line).expect("a terminal").local_modes;
    modes.contains(LocalModes::ICANON | LocalModes::ECHO)
}

fn draws(fixture: &Fixture) -> Terminal {
    let mut terminal = Terminal::running(fixture.draw(&[]));
    terminal.until_step(3);
    terminal
}

/// Asserts that the arm's queue is empty.
fn is_at_rest(fixture: &Fixture) {
    assert_eq!(fixture.number("queue", "left_space"), 32.0);
}

fn pen_is_up(fixture: &Fixture) -> bool {
    fixture.number("pose", "z") > PAPER + 9.0
}

fn laser_is_on(fixture: &Fixture) -> bool {
    last(&fixture.run(&["info"]))["laser"]
        .as_bool()
        .expect("known")
}

#[test]
fn job_pauses_before_the_process_is_stopped_and_resumes_when_continued() {
    let fixture = Fixture::homed("5");
    let mut terminal = draws(&fixture);
    assert!(!is_as_it_was(&terminal));
    for _ in 0..2 {
        terminal.tell(Signal::TSTP);
        // A second request on the way has no effect.
        terminal.until_seen("pausing");
        terminal.tell(Signal::TSTP);
        terminal.until_stopped();
        assert!(is_as_it_was(&terminal));
        is_at_rest(&fixture);
        assert!(pen_is_up(&fixture));
        terminal.until_seen("paused: p resumes");
        terminal.tell(Signal::CONT);
        terminal.until_seen("left");
        assert!(!is_as_it_was(&terminal));
    }
    terminal.types("p");
    terminal.until_seen("paused: p resumes, space stops");
    terminal.interrupts(" ", "interrupted:");
    assert!(is_as_it_was(&terminal));
}

/// During the check, if this test is as fast as usual.
#[test]
fn suspend_during_the_check_is_executed() {
    let fixture = Fixture::homed("5");
    let mut terminal = Terminal::running(fixture.draw(&[]));
    while caught(&terminal.child) >> (Signal::TSTP.as_raw() - 1) & 1 == 0 {
        std::thread::yield_now();
    }
    terminal.tell(Signal::TSTP);
    terminal.until_stopped();
    assert!(is_as_it_was(&terminal));
    is_at_rest(&fixture);
    terminal.tell(Signal::CONT);
    terminal.until_step(3);
    terminal.interrupts("s", "interrupted:");
}

#[test]
fn job_paused_by_the_user_stays_paused() {
    let fixture = Fixture::homed("5");
    let mut terminal = draws(&fixture);
    terminal.types("p");
    terminal.until_seen("paused: p resumes");
    terminal.tell(Signal::TSTP);
    terminal.until_stopped();
    terminal.tell(Signal::CONT);
    terminal.until_seen("paused: p resumes");
    is_at_rest(&fixture);
    terminal.types("p");
    terminal.until_seen("left");
    terminal.interrupts("s", "interrupted:");
}

#[test]
fn job_that_cannot_resume_stays_paused_and_says_why() {
    let fixture = Fixture::homed("5");
    let mut terminal = draws(&fixture);
    terminal.tell(Signal::TSTP);
    terminal.until_stopped();
    // Meanwhile another program moves the arm into an alarm.
    let far = [
        "enqueue",
        "PTPCmd",
        "ptp_mode=2",
        "x=900",
        "y=0",
        "z=0",
        "r=0",
        "--start",
    ];
    fixture.run(&far);
    terminal.tell(Signal::CONT);
    terminal.until_seen("still paused: the arm is held by");
    assert!(fixture.run(&["alarms", "--clear"]).status.success());
    terminal.types("p");
    terminal.until_seen("left");
    terminal.interrupts("s", "interrupted:");
}

/// Slow line that burns.
const BURNS: &str = "G21\nG90\nM3 S0\nG0 X10 Y0\nG1 X70 Y0 S500 F200\nG1 X10 Y20 S500 F200\nM5\n";

#[test]
fn burning_job_does_not_relight_by_itself() {
    let fixture = Fixture::homed("5");
    fixture.write("burn.gcode", BURNS);
    let burn = ["engrave", "burn.gcode", "--surface", "-50", "--yes"];
    let mut terminal = Terminal::running(fixture.command(&burn));
    terminal.until_seen("left");
    // The laser's power is right only for the planned speed.
    terminal.types("-");
    terminal.until_seen("speed unchanged: the job burns");
    terminal.tell(Signal::TSTP);
    terminal.until_stopped();
    is_at_rest(&fixture);
    terminal.tell(Signal::CONT);
    terminal.until_seen("the job burns: it stays paused, laser off, until you press p");
    is_at_rest(&fixture);
    assert!(!laser_is_on(&fixture));
    // A second continuation does not light it either.
    terminal.tell(Signal::TSTP);
    terminal.until_stopped();
    terminal.tell(Signal::CONT);
    terminal.until_seen("paused: p resumes");
    is_at_rest(&fixture);
    terminal.types("p");
    terminal.until_seen("left");
    terminal.interrupts("s", "interrupted:");
}

#[test]
fn keys_make_a_drawing_slower_and_faster() {
    let fixture = Fixture::homed("5");
    let mut terminal = draws(&fixture);
    terminal.types("---");
    terminal.until_seen("left, at 70 %");
    terminal.types("+");
    terminal.until_seen("left, at 80 %");
    // The escape sequences of F1 and F4 contain letters that have a meaning alone.
    terminal.types("\x1bOP\x1bOS++");
    terminal.until_seen("left");
    terminal.types("-");
    terminal.until_seen("left, at 90 %");
    terminal.interrupts("s", "interrupted:");
}

/// M4 throughout: its power follows the speed.
#[test]
fn job_with_power_proportional_to_speed_can_be_slowed() {
    let fixture = Fixture::homed("5");
    fixture.write("burn.gcode", &BURNS.replace("M3", "M4"));
    let burn = ["engrave", "burn.gcode", "--surface", "-50", "--yes"];
    let mut terminal = Terminal::running(fixture.command(&burn));
    terminal.until_seen("left");
    terminal.types("-");
    terminal.until_seen("left, at 90 %");
    terminal.interrupts("s", "interrupted:");
}

/// Verbs without a job are stopped by the system: the signal is not caught.
#[test]
fn other_verbs_are_suspended_by_the_system() {
    let fixture = Fixture::homed("5");
    let mut terminal = Terminal::running(fixture.command(&["sim", "--tcp", "127.0.0.1:0"]));
    terminal.until("tcp");
    let caught = caught(&terminal.child);
    let bit = |signal: Signal| caught >> (signal.as_raw() - 1) & 1;
    assert_eq!((bit(Signal::TSTP), bit(Signal::CONT)), (0, 0));
    assert_eq!(bit(Signal::INT), 1, "{caught:x}");
}
