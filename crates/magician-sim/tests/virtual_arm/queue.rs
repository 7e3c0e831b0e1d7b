//! Rules of the queue: places, indices, start, stop, forced stop, clear, waits.

use super::arm::{SECOND, arm, arm_with, hex, home, jog, joints_to, ptp, running_arm, suck, wait};
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, FrameBuf};
use magician_sim::Event;

#[test]
fn the_first_index_is_1_and_each_is_one_more_whatever_the_command() {
    let mut bench = arm();
    let common = PtpCommonParams {
        velocity_ratio: 10.0,
        acceleration_ratio: 10.0,
    };
    assert_eq!(bench.enqueue(&joints_to([10.0, 45.0, 45.0, 0.0])), 1);
    assert_eq!(bench.enqueue(&common), 2);
    assert_eq!(bench.enqueue(&wait(5)), 3);
    assert_eq!(bench.enqueue(&suck(true)), 4);
    assert_eq!(bench.enqueue(&home()), 5);
    assert_eq!(bench.current_index(), 0);
}

#[test]
fn the_first_index_is_the_profiles() {
    let mut bench = arm_with(|profile| profile.queue.first_index = 2);
    assert_eq!(bench.enqueue(&wait(5)), 2);
}

#[test]
fn nothing_queued_runs_before_the_first_start() {
    let mut bench = arm();
    bench.enqueue(&suck(true));
    bench.enqueue(&joints_to([10.0, 45.0, 45.0, 0.0]));
    bench.pass(60 * SECOND);
    assert_eq!(bench.current_index(), 0);
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0]);
    assert!(!bench.state().suction.commanded);
    bench.start();
    bench.rest();
    assert_eq!(bench.current_index(), 2);
    assert_eq!(bench.joints(), [10.0, 45.0, 45.0, 0.0]);
    assert!(bench.state().suction.commanded);
}

#[test]
fn a_full_queue_stores_nothing_and_says_so() {
    let mut bench = arm();
    for index in 1..=32 {
        assert_eq!(bench.enqueue(&wait(1)), index);
    }
    assert_eq!(bench.left_space(), 0);
    // The reply to a queued WAIT of 1 ms has eight zero bytes, and bit 2 of Ctrl set.
    let request = FrameBuf::new(110, Ctrl::QUEUED, &[1, 0, 0, 0]).unwrap();
    let replies = bench.send(request.bytes());
    assert_eq!(
        replies[0].bytes(),
        hex("AA AA 0A 6E 07 00 00 00 00 00 00 00 00 8B")
    );
    assert_eq!(bench.state().queue.overflows, 1);
    bench.start();
    assert_eq!(bench.rest(), 32_000);
    assert_eq!(bench.current_index(), 32);
    assert_eq!(
        bench.enqueue(&wait(1)),
        33,
        "a refused command costs no index"
    );
}

#[test]
fn parameters_take_effect_at_their_turn_and_finish_in_the_same_instant() {
    let mut bench = running_arm();
    bench.enqueue(&wait(100));
    bench.enqueue(&JogLParams {
        velocity: 7.0,
        acceleration: 8.0,
    });
    bench.enqueue(&suck(true));
    bench.enqueue(&wait(100));
    bench.pass(99_999);
    assert_eq!(bench.get::<JogLParams>().velocity, 100.0);
    assert_eq!(bench.current_index(), 0);
    bench.pass(1);
    assert_eq!(bench.get::<JogLParams>().velocity, 7.0);
    assert_eq!(bench.current_index(), 3);
    assert!(bench.state().suction.commanded);
    bench.pass(100_000);
    assert_eq!(bench.current_index(), 4);
}

#[test]
fn a_wait_counts_from_its_start() {
    let mut bench = running_arm();
    bench.pass(SECOND);
    bench.enqueue(&wait(1500));
    bench.pass(1_499_999);
    assert_eq!(bench.current_index(), 0);
    bench.pass(1);
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn stop_lets_the_motion_finish_and_keeps_what_waits() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&wait(0));
    bench.pass(SECOND);
    bench.set(&QueuedCmdStopExec {});
    assert_eq!(bench.rest(), 897_367);
    assert_eq!(bench.joints(), [90.0, 45.0, 45.0, 0.0]);
    assert_eq!(bench.current_index(), 1);
    assert_eq!(bench.left_space(), 31);
    assert_eq!(bench.enqueue(&wait(0)), 3, "still accepted and stored");
    bench.pass(SECOND);
    assert_eq!(bench.current_index(), 1);
    bench.start();
    assert_eq!(bench.current_index(), 3);
}

#[test]
fn force_stop_brakes_drops_the_motion_and_leaves_the_queue_stopped() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&joints_to([-90.0, 45.0, 45.0, 0.0]));
    // After 0.949 s J1 turns at 94.868 deg/s; twice 100 deg/s2 brakes it in 0.474 s.
    bench.pass(948_683);
    let fast = bench.joints()[0];
    bench.set(&QueuedCmdForceStopExec {});
    assert!(bench.state().moving);
    assert_eq!(bench.current_index(), 0, "it finishes when it stands");
    let braking = bench.rest();
    assert!((474_000..475_000).contains(&braking), "{braking}");
    let stopped = bench.joints()[0];
    assert!((stopped - fast - 22.5).abs() < 0.01, "{fast} {stopped}");
    assert_eq!(bench.current_index(), 1);
    assert!(bench.alarms().is_empty());
    bench.pass(10 * SECOND);
    assert_eq!(bench.joints()[0], stopped);
    assert_eq!(bench.left_space(), 31, "what waits stays until cleared");
    bench.start();
    bench.rest();
    assert_eq!(bench.joints()[0], -90.0);
}

#[test]
fn force_stop_clear_start_in_one_breath_ends_at_rest_and_ready() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&joints_to([-90.0, 45.0, 45.0, 0.0]));
    bench.pass(SECOND);
    bench.set(&QueuedCmdForceStopExec {});
    bench.set(&QueuedCmdClear {});
    bench.start();
    bench.rest();
    assert_eq!(bench.current_index(), 1);
    assert_eq!(bench.left_space(), 32);
    assert!(bench.joints()[0] > 50.0);
    assert_eq!(bench.enqueue(&wait(0)), 3);
    assert_eq!(
        bench.current_index(),
        3,
        "the index jumps over what was dropped"
    );
}

#[test]
fn a_profile_may_let_the_motion_finish_after_a_clear() {
    let mut bench = arm_with(|profile| profile.queue.clear_ends_motion = false);
    bench.start();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&wait(0));
    bench.enqueue(&wait(0));
    bench.pass(SECOND);
    let drops = |events: Vec<Event>| -> Vec<usize> {
        let dropped = events.into_iter().filter_map(|event| match event {
            Event::Dropped { count } => Some(count),
            _ => None,
        });
        dropped.collect()
    };
    assert!(drops(bench.events()).is_empty());
    bench.set(&QueuedCmdClear {});
    assert_eq!(drops(bench.events()), [2]);
    bench.set(&QueuedCmdClear {});
    assert!(drops(bench.events()).is_empty(), "nothing waits any more");
    assert_eq!(bench.left_space(), 31);
    assert_eq!(bench.current_index(), 0);
    bench.rest();
    assert_eq!(bench.joints()[0], 90.0);
    assert_eq!(bench.current_index(), 1);
    assert_eq!(bench.enqueue(&wait(0)), 4, "numbering goes on");
}

#[test]
fn clear_drops_what_waits_and_ends_the_motion_where_it_is() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&wait(0));
    bench.pass(SECOND);
    bench.set(&QueuedCmdClear {});
    let state = bench.state();
    assert!(!state.moving && (10.0..80.0).contains(&state.joints.j1));
    assert_eq!((bench.current_index(), bench.left_space()), (1, 32));
    assert_eq!(bench.enqueue(&wait(0)), 3, "numbering goes on");
}

#[test]
fn start_ends_the_motion_where_it_is_and_goes_on_with_the_next() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&wait(100));
    bench.pass(SECOND);
    bench.start();
    let state = bench.state();
    assert!(!state.moving && (10.0..80.0).contains(&state.joints.j1));
    assert_eq!((bench.current_index(), bench.left_space()), (1, 31));
}

#[test]
fn a_jog_and_the_ramp_of_a_forced_stop_go_on_through_clear_and_start() {
    let mut jogging = running_arm();
    jogging.set(&jog(true, 1));
    jogging.pass(SECOND);
    jogging.set(&QueuedCmdClear {});
    jogging.start();
    assert!(jogging.state().moving);
    let mut braking = running_arm();
    braking.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    braking.pass(SECOND);
    braking.set(&QueuedCmdForceStopExec {});
    braking.set(&QueuedCmdClear {});
    assert!(braking.state().moving);
}

#[test]
fn queue_steering_is_never_queued_itself() {
    let mut bench = arm();
    for id in 240..=245 {
        let params: &[u8] = if id == 243 { &[1, 1] } else { &[] };
        let reply = bench.frame(id, Ctrl::QUEUED, params);
        assert_eq!(reply.frame().params(), [0u8; 0], "id {id}");
    }
    assert_eq!(bench.enqueue(&wait(0)), 1);
    // Ids 246 and 247 return their value under any Ctrl.
    assert_eq!(
        bench.frame(247, Ctrl::QUEUED, &[]).frame().params().len(),
        4
    );
    assert_eq!(bench.frame(246, Ctrl::SET, &[]).frame().params().len(), 8);
}

#[test]
fn a_queued_frame_of_the_wrong_size_takes_an_index_and_does_nothing() {
    let mut bench = running_arm();
    let before = bench.joints();
    let reply = bench.frame(84, Ctrl::QUEUED, &[1, 2, 3]);
    assert_eq!(reply.frame().params(), [1, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(bench.current_index(), 1);
    assert_eq!(bench.joints(), before);
    // Immediate: an empty reply, and no effect.
    assert_eq!(bench.frame(84, Ctrl::SET, &[1]).frame().params(), [0u8; 0]);
    assert!(!bench.state().moving);
    assert!(bench.alarms().is_empty());
}

#[test]
fn motions_run_one_after_the_other_each_from_rest() {
    let mut bench = running_arm();
    bench.enqueue(&ptp(2, [259.104_13, 100.0, -8.485_281, 0.0]));
    bench.enqueue(&ptp(2, [259.104_13, 0.0, -8.485_281, 0.0]));
    assert_eq!(bench.rest(), 4 * SECOND);
    assert_eq!(bench.current_index(), 2);
}
