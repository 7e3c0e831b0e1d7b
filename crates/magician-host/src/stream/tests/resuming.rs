use magician_protocol::{ArmInstant, FrameBuf};

use super::rig::{Rig, SECOND, along, laser, mixed, rest_to_rest, segment};
use crate::connection::Settings;
use crate::stream::{Item, StreamFailure, StreamSettings};

/// Runs a program and breaks the line at the given turn. `None` if the program was over by then.
fn broken(program: &[Item], turn: usize) -> Option<Rig> {
    let mut rig = Rig::new(Settings::ORDERED, StreamSettings::default(), program);
    for _ in 0..turn {
        if rig.stream.is_over() {
            return None;
        }
        rig.turn(600 * SECOND);
    }
    if rig.stream.is_over() {
        return None;
    }
    rig.interrupt();
    Some(rig)
}

/// Like [`broken`], with the line restored after a time that depends on the turn.
fn resumed(program: &[Item], turn: usize) -> Option<Rig> {
    let mut rig = broken(program, turn)?;
    let back = rig.pair.now + [0, 30_000, 400_000, 3 * SECOND][turn % 4];
    rig.pair.run_until(back);
    rig.resume();
    Some(rig)
}

#[test]
fn interrupted_program_runs_every_command_once_in_order() {
    let program = mixed();
    let all: Vec<_> = (0..program.len()).collect();
    let (mut turn, mut whole) = (0, 0);
    while let Some(mut rig) = resumed(&program, turn) {
        let outcome = rig.run(120 * SECOND);
        let done = rig.done(&program);
        assert_eq!(
            done,
            all[..done.len()],
            "turn {turn}: each at most once, in order"
        );
        match outcome {
            Ok(()) => {
                assert_eq!(done, all, "turn {turn}");
                assert_eq!(rig.reported_accepted, program.len() as u64, "turn {turn}");
                whole += 1;
            }
            Err(failure) => println!("turn {turn}: {failure}"),
        }
        turn += 1;
    }
    assert!(turn > 100, "{turn}");
    assert_eq!(whole, turn, "nothing had to be refused");
}

#[test]
fn two_interruptions_are_no_worse_than_one() {
    let program = mixed();
    let all: Vec<_> = (0..program.len()).collect();
    for first in (0..120).step_by(7) {
        for second in (0..60).step_by(3) {
            let Some(mut rig) = resumed(&program, first) else {
                break;
            };
            for _ in 0..second {
                if !rig.stream.is_over() {
                    rig.turn(600 * SECOND);
                }
            }
            if !rig.stream.is_over() {
                rig.interrupt();
                rig.resume();
            }
            rig.run(120 * SECOND).unwrap();
            assert_eq!(rig.done(&program), all, "turns {first} and {second}");
        }
    }
}

#[test]
fn interrupted_engraving_completes_and_ends_with_laser_off() {
    let lit = |at: usize| Item {
        laser: true,
        ..segment(along(1.0, at), rest_to_rest(1.0, at))
    };
    let mut program = vec![segment(along(1.0, 1), 300_000), laser(true, along(1.0, 1))];
    program.extend((2..30).map(lit));
    program.push(laser(false, along(1.0, 29)));
    let segments: Vec<_> = (0..program.len())
        .filter(|at| *at != 1 && *at != 30)
        .collect();
    let mut turn = 0;
    while let Some(mut rig) = broken(&program, turn) {
        // On a copy to which no host reconnects, the arm must switch the laser off by itself.
        let end = rig.pair.now + 4 * SECOND;
        let mut arm = rig.pair.arm.clone();
        arm.advance(ArmInstant::from_micros(end));
        assert!(!arm.state().laser, "turn {turn}");
        rig.resume();
        rig.run(120 * SECOND).unwrap();
        let mut done = rig.done(&program);
        done.retain(|at| segments.contains(at));
        assert_eq!(done, segments, "turn {turn}");
        assert!(!rig.pair.arm.state().laser);
        turn += 3;
    }
    assert!(turn > 100);
}

#[test]
fn program_is_not_resumed_on_a_moved_arm() {
    let program = mixed();
    for turn in [40, 70, 100] {
        let mut rig = broken(&program, turn).unwrap();
        let back = rig.pair.now + 5 * SECOND;
        rig.pair.run_until(back);
        let taken = rig.pair.accepted.len();
        rig.pair.arm.unlock(true);
        rig.pair.arm.guide([20.0, 30.0, 40.0, 0.0].into());
        rig.pair.arm.unlock(false);
        rig.resume();
        let failure = rig.run(60 * SECOND).unwrap_err();
        let StreamFailure::Pose { expected, found } = failure else {
            panic!("{failure}");
        };
        assert!((expected[0] - found[0]).abs() > 0.5 || (expected[1] - found[1]).abs() > 0.5);
        assert_eq!(rig.pair.accepted.len(), taken, "nothing was sent");
    }
}

#[test]
fn program_is_not_resumed_on_a_reset_arm() {
    let program = mixed();
    let mut turn = 0;
    while let Some(mut rig) = broken(&program, turn) {
        let moved = !rig.started.is_empty();
        rig.pair.power_cycle();
        let heard = rig.pair.heard.len();
        rig.resume();
        let outcome = rig.run(60 * SECOND);
        if moved {
            outcome.unwrap_err();
            let set = |frame: &FrameBuf| frame.frame().ctrl().write();
            let sets = rig.pair.heard[heard..]
                .iter()
                .filter(|frame| set(frame))
                .count();
            assert_eq!(sets, 0, "turn {turn}");
        }
        turn += 5;
    }
    assert!(turn > 100);
}

#[test]
fn resuming_at_an_unknown_pose_needs_the_callers_pose() {
    let mut program = mixed();
    for item in &mut program {
        item.end = None;
    }
    let mut rig = broken(&program, 80).unwrap();
    rig.resume();
    let failure = rig.run(60 * SECOND).unwrap_err();
    assert!(
        matches!(failure, StreamFailure::PoseUnknown { .. }),
        "{failure}"
    );
    rig.settings.trust_pose = true;
    rig.resume();
    rig.run(60 * SECOND).unwrap();
    assert_eq!(rig.done(&program), (0..program.len()).collect::<Vec<_>>());
}

#[test]
fn commands_of_another_host_do_not_count_as_program_commands() {
    let program = mixed();
    let mut rig = broken(&program, 60).unwrap();
    let wait = FrameBuf::new(110, magician_protocol::Ctrl::QUEUED, &[1, 0, 0, 0]).unwrap();
    for _ in 0..3 {
        rig.pair.arm.receive(magician_sim::LinkId(7), wait.bytes());
    }
    let taken = rig.pair.accepted.len();
    rig.resume();
    let failure = rig.run(60 * SECOND).unwrap_err();
    assert!(matches!(failure, StreamFailure::Tail { .. }), "{failure}");
    assert_eq!(rig.pair.accepted.len(), taken);
}
