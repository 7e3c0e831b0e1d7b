//! The picture compared with a virtual arm, for generated programs on a line that may lose replies.

use magician_protocol::Set;
use magician_protocol::commands::{
    ClearAllAlarmsState, Pose, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdForceStopExec,
    QueuedCmdStartExec, QueuedCmdStopExec,
};

use super::rig::PictureRig;
use crate::connection::Request;
use crate::faults::Dice;
use crate::{ToolBias, build};

/// A random switching command.
fn any_output(dice: &mut Dice) -> Set {
    match dice.below(9) {
        0 => build::suction(dice.chance(0.5)),
        1 => build::grip(),
        2 => build::release(),
        3 => build::pump_off(),
        4 => build::laser(true),
        5 => build::laser(false),
        6 => build::tool(if dice.chance(0.5) {
            ToolBias::PEN
        } else {
            ToolBias::LASER
        }),
        7 => build::speed(1.0 + dice.below(99) as f32, 50.0),
        _ => build::output(3, true),
    }
}

fn any_segment(dice: &mut Dice) -> Set {
    let power = if dice.chance(0.6) { 60.0 } else { 0.0 };
    let (x, y) = (dice.below(20) as f32, dice.below(20) as f32);
    build::engrave_to(210.0 + x, y - 10.0, 0.0, power)
}

fn stop(bench: &mut PictureRig) {
    for request in Request::halt().unwrap() {
        bench.ask(*request.frame());
    }
    assert_eq!(
        bench.picture.outputs().laser,
        Some(false),
        "after a stop: {:#?}",
        bench.picture
    );
}

/// Performs a step of a program.
fn step(bench: &mut PictureRig, dice: &mut Dice) {
    match dice.below(16) {
        0..=3 => bench.set(any_output(dice)),
        4..=6 => bench.queue(any_output(dice)),
        7..=9 => bench.queue(any_segment(dice)),
        10 => bench.set(QueuedCmdStartExec {}),
        11 => bench.set(QueuedCmdStopExec {}),
        12 => bench.read::<QueuedCmdCurrentIndex>(),
        13 => bench.wait(dice.below(1_500_000)),
        14 => stop(bench),
        _ => match dice.below(4) {
            0 => bench.set(QueuedCmdClear {}),
            1 => bench.set(QueuedCmdForceStopExec {}),
            2 => {
                bench.read_all();
                bench.read::<Pose>();
            }
            _ => bench.queue(build::move_to(220.0, 10.0, 20.0, 0.0)),
        },
    }
}

fn program(seed: u64, lossy: bool) -> u32 {
    let mut dice = Dice::new(seed);
    let mut bench = PictureRig::new(seed);
    bench.set(ClearAllAlarmsState {});
    bench.set(QueuedCmdStartExec {});
    bench.queue(build::move_to(220.0, 0.0, 20.0, 0.0));
    bench.wait(3_000_000);
    bench.read_all();
    for _ in 0..40 {
        if lossy && dice.chance(0.1) {
            if dice.chance(0.5) {
                bench.pair.lose_next_reply()
            } else {
                bench.pair.lose_next_request()
            }
        }
        step(&mut bench, &mut dice);
    }
    // Let it end, and switch the laser off.
    bench.set(QueuedCmdStartExec {});
    bench.wait(60_000_000);
    bench.read::<QueuedCmdCurrentIndex>();
    if lossy {
        // Only a stop shows that an unanswered command is not in the queue.
        stop(&mut bench);
    } else {
        bench.set(build::laser(false));
    }
    // An arm that reverses shows each pose twice, and no pose three times.
    for _ in 0..3 {
        bench.wait(100_000);
        bench.read::<Pose>();
    }
    if lossy || bench.picture.snapshot().lapses > 0 {
        bench.read_all();
    }
    bench.agrees();
    assert!(bench.moved > 0);
    bench.burnt
}

#[test]
fn output_estimates_match_the_arm_for_any_program() {
    let burnt: u32 = (0..400).map(|seed| program(seed, false)).sum();
    assert!(burnt > 1000, "{burnt}");
}

#[test]
fn laser_estimate_errs_towards_on_when_replies_are_lost() {
    let burnt: u32 = (1000..1300).map(|seed| program(seed, true)).sum();
    assert!(burnt > 1000, "{burnt}");
}
