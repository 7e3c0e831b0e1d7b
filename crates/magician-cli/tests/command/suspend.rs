//! Ctrl-Z while a job runs: the arm pauses before the process stops, and nothing burns again by
//! itself.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::Child;

use crate::magician::drawing::{PAPER, Place, last};
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

fn draws(place: &Place) -> Terminal {
    let mut terminal = Terminal::running(place.draw(&[]));
    terminal.until_step(3);
    terminal
}

/// Asserts that the arm's queue is empty.
fn is_at_rest(place: &Place) {
    assert_eq!(place.number("queue", "left_space"), 32.0);
}

fn pen_is_up(place: &Place) -> bool {
    place.number("pose", "z") > PAPER + 9.0
}

fn laser_is_on(place: &Place) -> bool {
    last(&place.run(&["info"]))["laser"]
        .as_bool()
        .expect("known")
}

#[test]
fn a_job_pauses_before_it_is_stopped_and_goes_on_when_it_is_continued() {
    let place = Place::homed("5");
    let mut terminal = draws(&place);
    assert!(!is_as_it_was(&terminal));
    for _ in 0..2 {
        terminal.tell(Signal::TSTP);
        // A second request on the way has no effect.
        terminal.until_seen("pausing");
        terminal.tell(Signal::TSTP);
        terminal.until_stopped();
        assert!(is_as_it_was(&terminal));
        is_at_rest(&place);
        assert!(pen_is_up(&place));
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
fn a_wish_that_comes_at_once_is_followed() {
    let place = Place::homed("5");
    let mut terminal = Terminal::running(place.draw(&[]));
    while caught(&terminal.child) >> (Signal::TSTP.as_raw() - 1) & 1 == 0 {
        std::thread::yield_now();
    }
    terminal.tell(Signal::TSTP);
    terminal.until_stopped();
    assert!(is_as_it_was(&terminal));
    is_at_rest(&place);
    terminal.tell(Signal::CONT);
    terminal.until_step(3);
    terminal.interrupts("s", "interrupted:");
}

#[test]
fn a_job_that_a_person_has_paused_stays_paused() {
    let place = Place::homed("5");
    let mut terminal = draws(&place);
    terminal.types("p");
    terminal.until_seen("paused: p resumes");
    terminal.tell(Signal::TSTP);
    terminal.until_stopped();
    terminal.tell(Signal::CONT);
    terminal.until_seen("paused: p resumes");
    is_at_rest(&place);
    terminal.types("p");
    terminal.until_seen("left");
    terminal.interrupts("s", "interrupted:");
}

#[test]
fn what_cannot_go_on_stays_paused_and_says_why() {
    let place = Place::homed("5");
    let mut terminal = draws(&place);
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
    place.run(&far);
    terminal.tell(Signal::CONT);
    terminal.until_seen("still paused: the arm is held by");
    assert!(place.run(&["alarms", "--clear"]).status.success());
    terminal.types("p");
    terminal.until_seen("left");
    terminal.interrupts("s", "interrupted:");
}

/// Slow line that burns.
const BURNS: &str = "G21\nG90\nM3 S0\nG0 X10 Y0\nG1 X70 Y0 S500 F200\nG1 X10 Y20 S500 F200\nM5\n";

#[test]
fn a_job_that_burns_is_not_lit_again_by_itself() {
    let place = Place::homed("5");
    place.write("burn.gcode", BURNS);
    let burn = ["engrave", "burn.gcode", "--surface", "-50", "--yes"];
    let mut terminal = Terminal::running(place.command(&burn));
    terminal.until_seen("left");
    // The laser's power is right only for the planned speed.
    terminal.types("-");
    terminal.until_seen("speed unchanged: the job burns");
    terminal.tell(Signal::TSTP);
    terminal.until_stopped();
    is_at_rest(&place);
    terminal.tell(Signal::CONT);
    terminal.until_seen("the job burns: it stays paused, laser off, until you press p");
    is_at_rest(&place);
    assert!(!laser_is_on(&place));
    // A second continuation does not light it either.
    terminal.tell(Signal::TSTP);
    terminal.until_stopped();
    terminal.tell(Signal::CONT);
    terminal.until_seen("paused: p resumes");
    is_at_rest(&place);
    terminal.types("p");
    terminal.until_seen("left");
    terminal.interrupts("s", "interrupted:");
}

#[test]
fn keys_make_a_drawing_slower_and_faster() {
    let place = Place::homed("5");
    let mut terminal = draws(&place);
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
fn what_burns_in_proportion_to_speed_is_made_slower() {
    let place = Place::homed("5");
    place.write("burn.gcode", &BURNS.replace("M3", "M4"));
    let burn = ["engrave", "burn.gcode", "--surface", "-50", "--yes"];
    let mut terminal = Terminal::running(place.command(&burn));
    terminal.until_seen("left");
    terminal.types("-");
    terminal.until_seen("left, at 90 %");
    terminal.interrupts("s", "interrupted:");
}

/// Verbs without a job are stopped by the system: the signal is not caught.
#[test]
fn other_verbs_leave_it_to_the_system() {
    let place = Place::homed("5");
    let mut terminal = Terminal::running(place.command(&["sim", "--tcp", "127.0.0.1:0"]));
    terminal.until("tcp");
    let caught = caught(&terminal.child);
    let bit = |signal: Signal| caught >> (signal.as_raw() - 1) & 1;
    assert_eq!((bit(Signal::TSTP), bit(Signal::CONT)), (0, 0));
    assert_eq!(bit(Signal::INT), 1, "{caught:x}");
}
