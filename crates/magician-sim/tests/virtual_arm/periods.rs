//! The 20 ms law over the protocol: recordings of real arms, the phase of the periods, and the
//! start of actions.

use super::arm::*;
use magician_motion::{Geometry, Pose, ToolBias};
use magician_protocol::commands::*;
use magician_sim::{Controller, Profile};

const PERIOD_US: u64 = 20_000;

/// Public recording of a real arm; the head of each file describes it.
const RECORDING: &str = include_str!("data/jog-recording.tsv");
const COMMANDS: &str = include_str!("data/jog-commands.tsv");

fn switched_on() -> TestArm {
    let mut bench = TestArm {
        arm: Controller::new(Profile::default()),
    };
    bench.set(&ClearAlarmsState {});
    bench.start();
    bench
}

fn rows(text: &str) -> impl Iterator<Item = Vec<&str>> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.split('\t').collect())
}

fn number(text: &str) -> f64 {
    text.parse().expect("a number")
}

/// Largest deviation of x, y or z of a virtual arm from the recorded pose, mm.
fn worst(mut profile: Profile) -> f64 {
    let mut recorded = rows(RECORDING).map(|row| {
        let [at, x, y, z] = row[..] else {
            panic!("{row:?}")
        };
        (number(at) as u64, [x, y, z].map(number))
    });
    let (_, [x, y, z]) = recorded.next().expect("a pose");
    // The recorded arm's tool is not known. Without one J2 stays far from its limit.
    profile.power_up.tool = ToolBias::NONE;
    let geometry = Geometry::magician(profile.power_up.tool);
    let joints = geometry
        .inverse(&Pose::new(x, y, z, 0.0))
        .expect("in reach");
    profile.power_up.joints = joints.to_array();
    let mut bench = TestArm {
        arm: Controller::new(profile),
    };
    // The recording starts in the middle of a period. A jog needs no cleared alarm.
    let begin = PERIOD_US / 2;
    let mut commands = rows(COMMANDS)
        .map(|row| {
            let [period, axis, speed] = row[..] else {
                panic!("{row:?}")
            };
            let number_of = ["x", "y", "z"]
                .iter()
                .position(|name| *name == axis)
                .expect("an axis");
            let cmd = match number(speed) {
                0.0 => 0,
                speed => 1 + 2 * number_of as u8 + u8::from(speed < 0.0),
            };
            (begin + number(period) as u64 * PERIOD_US, cmd)
        })
        .peekable();
    recorded.fold(0.0, |worst, (at_ms, wanted)| {
        let at_us = begin + at_ms * 1000;
        while let Some((sent, cmd)) = commands.next_if(|(sent, _)| *sent <= at_us) {
            bench.arm.advance(at(sent));
            bench.set(&jog(false, cmd));
        }
        bench.arm.advance(at(at_us));
        let pose = bench.state().pose;
        [pose.x, pose.y, pose.z]
            .into_iter()
            .zip(wanted)
            .map(|(is, wanted)| (is - wanted).abs())
            .fold(worst, f64::max)
    })
}

#[test]
fn the_recorded_jogs_of_a_real_arm_are_made_to_15_micrometres() {
    let off = worst(Profile::default());
    assert!(off < 0.015, "{off} mm");
}

#[test]
fn continuous_time_misses_the_recording_by_millimetres() {
    let off = worst(Profile::continuous());
    assert!(off > 1.0, "{off} mm");
}

#[test]
fn a_command_acts_with_the_next_period_of_the_clock() {
    let bench = switched_on();
    let first = bench.state();
    for after_us in [100, 19_900, 20_000] {
        let mut bench = TestArm {
            arm: bench.arm.clone(),
        };
        let now = first.now.as_micros();
        let sent = now - now % PERIOD_US + PERIOD_US + after_us;
        bench.arm.advance(at(sent));
        bench.set(&jog(true, 1));
        let next = sent - sent % PERIOD_US + PERIOD_US;
        bench.arm.advance(at(next - 1));
        assert_eq!(bench.state().joints, first.joints);
        bench.arm.advance(at(next));
        // 50 deg/s2: each period adds one degree per second.
        assert!(
            (bench.state().joints.j1 - 0.02).abs() < 1e-9,
            "{:?}",
            bench.state()
        );
        bench.arm.advance(at(next + PERIOD_US - 1));
        assert!((bench.state().joints.j1 - 0.02).abs() < 1e-9);
        bench.arm.advance(at(next + PERIOD_US));
        assert!((bench.state().joints.j1 - 0.06).abs() < 1e-9);
    }
}

#[test]
fn commands_of_the_queue_follow_each_other_without_a_period_between() {
    let mut bench = switched_on();
    bench.enqueue(&ptp(2, [220.0, 0.0, 20.0, 0.0]));
    bench.enqueue(&ptp(2, [220.0, 10.0, 20.0, 0.0]));
    let mut ends = Vec::new();
    while let Some(due) = bench.arm.poll_timeout() {
        bench.arm.advance(due);
        ends.push(due.as_micros());
    }
    assert!(ends.iter().all(|end| end % PERIOD_US == 0), "{ends:?}");
    assert_eq!(bench.state().pose, Pose::new(220.0, 10.0, 20.0, 0.0));
}
