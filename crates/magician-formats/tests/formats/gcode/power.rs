//! Laser power over a program, as the guards accept it.

use magician::build;
use magician::preflight::Preflight;
use magician::{JointAngles, ToolBias};
use magician_formats::Action;
use magician_formats::formats::{Dialect, GcodeOptions};

use super::{actions_with, burn, notes, path, travel, try_read};

fn motions_with(text: &str, set: impl FnOnce(&mut GcodeOptions)) -> Vec<Action> {
    let all = actions_with(text, set).into_iter();
    all.filter(|action| !matches!(action, Action::Command(_)))
        .collect()
}

/// Returns the motions and burns of a program, after the guards accepted all its commands.
fn steps(text: &str) -> Vec<Action> {
    let (plan, _) = try_read(text).unwrap_or_else(|diagnostic| panic!("{text}: {diagnostic}"));
    let mut arm = Preflight::at(JointAngles::HOME, ToolBias::LASER);
    for command in plan.commands() {
        assert!(arm.check(&command).is_ok(), "{text}: {command:?}");
    }
    motions_with(text, |_| {})
}

#[test]
fn power_is_modal_and_travel_is_dark() {
    assert_eq!(
        steps(
            "G0 X220 Y0 Z0\nM3 S200\nG1 X221 F600\nX222\nS400\nX223\nG0 X230\nG1 X231 S0\nM5\nG0 X220\n"
        ),
        [
            travel(220.0, 0.0, 0.0),
            burn(221.0, 0.0, 0.0, 20.0),
            burn(222.0, 0.0, 0.0, 20.0),
            burn(223.0, 0.0, 0.0, 40.0),
            burn(230.0, 0.0, 0.0, 0.0),
            burn(231.0, 0.0, 0.0, 0.0),
            Action::Laser(false),
            travel(220.0, 0.0, 0.0),
        ]
    );
}

#[test]
fn laser_is_off_without_m3_unless_the_program_only_uses_s() {
    let off = "G0 X220 Y0 Z0\nM5 S1000\nG1 X221\nM3\nG1 X222\nM5\nG1 X223\n";
    assert_eq!(
        steps(off),
        [
            travel(220.0, 0.0, 0.0),
            burn(221.0, 0.0, 0.0, 0.0),
            burn(222.0, 0.0, 0.0, 100.0),
            Action::Laser(false),
            burn(223.0, 0.0, 0.0, 0.0),
            Action::Laser(false),
        ]
    );
    assert_eq!(
        steps("G0 X220 Y0 Z0\nG1 X221 S1000\nG1 X222 S0\n"),
        [
            travel(220.0, 0.0, 0.0),
            burn(221.0, 0.0, 0.0, 100.0),
            burn(222.0, 0.0, 0.0, 0.0),
            Action::Laser(false),
        ]
    );
    // A laser without S words is only switched on and off.
    assert_eq!(
        steps("G0 X220 Y0 Z0\nM3\nG1 X221\nM5\n")[1],
        burn(221.0, 0.0, 0.0, 100.0)
    );
}

#[test]
fn fan_output_is_the_laser_of_an_engraving_printer() {
    assert_eq!(
        steps("G0 X220 Y0 Z0\nM106 S51\nG1 X221\nM106\nG1 X222\nM107\nG0 X220\n"),
        [
            travel(220.0, 0.0, 0.0),
            burn(221.0, 0.0, 0.0, 20.0),
            burn(222.0, 0.0, 0.0, 100.0),
            Action::Laser(false),
            travel(220.0, 0.0, 0.0),
        ]
    );
}

#[test]
fn pen_program_ignores_the_spindle() {
    let program = "G0 X220 Y0 Z0\nM3 S12000\nG1 X221 S1\nM5\n";
    let pen = motions_with(program, |options| options.dialect = Dialect::Pen);
    assert_eq!(pen, [travel(220.0, 0.0, 0.0), path(221.0, 0.0, 0.0)]);
    let laser = motions_with("G0 X220 Y0 Z0\nG1 X221\n", |options| {
        options.dialect = Dialect::Laser;
    });
    assert!(matches!(laser[1], Action::Burn { .. }));
}

#[test]
fn laser_is_off_at_rest() {
    let pause = "G0 X220 Y0 Z0\nM3 S1000\nG4 P100\nG1 X221\nG4 P500\nG1 X222\n";
    assert_eq!(
        steps(pause),
        [
            travel(220.0, 0.0, 0.0),
            Action::Wait(100),
            burn(221.0, 0.0, 0.0, 100.0),
            Action::Laser(false),
            Action::Wait(500),
            burn(222.0, 0.0, 0.0, 100.0),
            Action::Laser(false),
        ]
    );
    let dark = "line 5, column 1: the laser is off during pauses (G4): it would burn a hole";
    assert!(notes(pause).iter().any(|note| note == dark));
    for end in ["", "M2", "M5", "M0", "M30\nG1 X250"] {
        steps(&format!("G0 X220 Y0 Z0\nM4 S255\nG1 X221\n{end}\n"));
    }
    let homed = actions_with("G0 X220 Y0 Z0\nM3 S9\nG1 X221\nG28\n", |options| {
        options.home = true
    });
    assert_eq!(
        homed[homed.len() - 2..],
        [Action::Laser(false), Action::Home]
    );
}

#[test]
fn burn_needs_a_known_start() {
    let known = actions_with("M3 S1000\nG91\nG1 X20 F600\n", |options| {
        options.start = Some([200.0, 0.0, 0.0]);
    });
    assert_eq!(
        known,
        [
            build::line_speed(200.0, 200.0).into(),
            travel(200.0, 0.0, 0.0),
            build::path_speed(10.0, 100.0).into(),
            burn(220.0, 0.0, 0.0, 100.0),
            Action::Laser(false)
        ]
    );
}
