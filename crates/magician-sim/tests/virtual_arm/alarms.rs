//! Alarms: their causes, their hold on the queue, and their end.

use super::arm::{SECOND, USB, arm, arm_with, home, joints_to, ptp, running_arm, wait};
use magician_motion::ToolBias;
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, FrameBuf};
use magician_sim::{Event, LimitChoice};

#[test]
fn an_unknown_id_is_met_with_silence_and_alarm_1() {
    let mut bench = running_arm();
    for id in [9, 99, 255] {
        for ctrl in [0, 1, 2, 3] {
            let request = FrameBuf::new(id, Ctrl(ctrl), &[1, 2, 3]).unwrap();
            assert!(bench.send(request.bytes()).is_empty());
        }
    }
    assert_eq!(bench.alarms(), [0x01]);
    assert_eq!(bench.enqueue(&wait(0)), 1);
    assert_eq!(bench.current_index(), 1, "it does not block");
}

#[test]
fn targets_out_of_reach_or_not_numbers_raise_11() {
    let targets = [
        [900.0, 0.0, 0.0, 0.0],
        // The wrist on the axis of the shoulder.
        [59.7, 0.0, 0.0, 0.0],
        [f32::NAN, 0.0, 0.0, 0.0],
        [200.0, f32::INFINITY, 0.0, 0.0],
        [f32::MAX, f32::MAX, f32::MAX, f32::MAX],
    ];
    for target in targets {
        for mode in [0, 1, 2, 9] {
            let mut bench = running_arm();
            let before = bench.pose();
            bench.enqueue(&ptp(mode, target));
            assert_eq!(bench.alarms(), [0x11], "mode {mode} to {target:?}");
            assert_eq!(bench.pose(), before);
            assert_eq!(bench.current_index(), 1, "refused counts as finished");
        }
    }
}

#[test]
fn a_joint_target_beyond_a_limit_runs_to_the_limit_and_stops_there() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([170.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&wait(0));
    assert!(bench.alarms().is_empty());
    // The whole move would take 2.7 s. It is at the limit, 35 degrees before its target,
    // sqrt(2 * 35 / 100) s before its end.
    assert_eq!(bench.rest(), 1_863_339);
    assert_eq!(bench.alarms(), [0x40]);
    assert_eq!(bench.joints(), [135.0, 45.0, 45.0, 0.0]);
    assert_eq!(
        bench.current_index(),
        1,
        "aborted counts as finished, and the rest is held"
    );
    assert!(bench.state().queue.held);
}

#[test]
fn out_of_a_limit_is_refused_into_it_is_made_and_the_bit_drops_by_itself() {
    let mut bench = running_arm();
    bench.set(&joints_to([170.0, 45.0, 45.0, 0.0]));
    bench.rest();
    bench.set(&joints_to([150.0, 45.0, 45.0, 0.0]));
    assert_eq!(bench.rest(), 0, "further out is refused");
    assert_eq!(bench.joints()[0], 135.0);
    bench.set(&ClearAlarmsState {});
    assert_eq!(bench.alarms(), [0x40], "its cause stands");
    assert_eq!(bench.enqueue(&wait(0)), 1);

    bench.set(&joints_to([100.0, 45.0, 45.0, 0.0]));
    assert_eq!(bench.alarms(), [0x40]);
    bench.pass(10_000);
    assert!(bench.alarms().is_empty(), "inside again");
    bench.rest();
    assert_eq!(bench.joints()[0], 100.0);
    // The hold is latched: it outlives the alarm bit.
    assert!(bench.state().queue.held);
    assert_eq!(bench.current_index(), 0);
    bench.set(&ClearAlarmsState {});
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn a_line_that_leaves_the_workspace_on_its_way_ends_there_with_2x() {
    // Both ends are in reach at the same radius; the middle is too close to the base.
    let mut bench = running_arm();
    bench.enqueue(&ptp(1, [30.0, 180.0, 0.0, 0.0]));
    bench.rest();
    assert!(bench.alarms().is_empty());
    bench.enqueue(&ptp(2, [30.0, -180.0, 0.0, 0.0]));
    bench.enqueue(&wait(0));
    assert!(bench.state().moving, "the end itself is in order");
    bench.rest();
    let [x, y, ..] = bench.pose();
    assert!((x - 30.0).abs() < 1e-3 && y > 0.0 && y < 180.0, "{x} {y}");
    assert!(matches!(bench.alarms()[..], [0x21 | 0x22]));
    assert_eq!(bench.current_index(), 2);
    assert!(bench.state().queue.held);
}

#[test]
fn speeds_that_are_none_raise_1a_when_a_motion_needs_them() {
    for bad in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
        let mut bench = running_arm();
        bench.set(&PtpJointParams {
            velocity: [bad, 100.0, 100.0, 100.0],
            acceleration: [100.0; 4],
        });
        bench.enqueue(&joints_to([0.0, 40.0, 45.0, 0.0]));
        assert!(
            bench.rest() > 0,
            "J1 does not move: its speed is not needed"
        );
        assert!(bench.alarms().is_empty());
        bench.enqueue(&joints_to([10.0, 40.0, 45.0, 0.0]));
        assert_eq!(bench.alarms(), [0x1A], "{bad}");
        assert_eq!(bench.current_index(), 2);
    }
}

#[test]
fn a_profile_may_let_the_queue_go_on_regardless() {
    let mut bench = arm_with(|profile| profile.queue.alarms_hold = false);
    bench.start();
    bench.enqueue(&ptp(1, [900.0, 0.0, 0.0, 0.0]));
    bench.enqueue(&wait(0));
    assert_eq!(bench.current_index(), 2);
    assert_eq!(bench.alarms(), [0x11]);
}

#[test]
fn homing_runs_through_a_hold_at_the_head_of_the_queue_and_clears_nothing() {
    let mut bench = running_arm();
    bench.enqueue(&ptp(1, [900.0, 0.0, 0.0, 0.0]));
    bench.enqueue(&home());
    bench.enqueue(&wait(0));
    bench.enqueue(&home());
    assert!(bench.state().moving);
    bench.rest();
    assert!(bench.state().homed);
    assert_eq!(bench.current_index(), 2, "it overtakes nothing");
    assert_eq!(bench.alarms(), [0x11]);
    bench.set(&home());
    assert!(bench.rest() > 0, "at once it runs, too");
    assert_eq!(bench.current_index(), 2);
    bench.set(&ClearAlarmsState {});
    bench.rest();
    assert_eq!(bench.current_index(), 4);
}

#[test]
fn homing_waits_in_a_stopped_queue() {
    let mut bench = arm();
    bench.enqueue(&home());
    assert!(!bench.state().moving);
}

#[test]
fn a_wait_under_way_ends_in_spite_of_an_alarm() {
    let mut bench = running_arm();
    bench.enqueue(&wait(1000));
    bench.enqueue(&wait(0));
    bench.set(&ptp(1, [900.0, 0.0, 0.0, 0.0]));
    bench.pass(SECOND);
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn the_guaranteed_limits_are_narrower() {
    let mut bench = arm_with(|profile| profile.limits.in_force = LimitChoice::Guaranteed);
    bench.start();
    bench.enqueue(&joints_to([100.0, 45.0, 45.0, 0.0]));
    bench.rest();
    assert_eq!(bench.joints()[0], 90.0);
    assert_eq!(bench.alarms(), [0x40]);
}

#[test]
fn events_tell_the_story() {
    let mut bench = running_arm();
    bench.events();
    bench.enqueue(&ptp(1, [900.0, 0.0, 0.0, 0.0]));
    bench.set(&ClearAlarmsState {});
    let id = PTP;
    let story = bench.events();
    assert!(
        matches!(
            story[..],
            [
                Event::Accepted { index: 1, id: a },
                Event::Started { index: 1, id: b },
                Event::AlarmRaised { code: 0x11 },
                Event::Refused { id: c, .. },
                Event::Finished { index: 1, id: d },
                Event::AlarmCleared { code: 0x11 },
            ] if [a, b, c, d] == [id; 4]
        ),
        "{story:?}"
    );
}

const PTP: u8 = 84;

#[test]
fn events_that_nobody_reads_are_counted_not_kept() {
    let mut bench = arm();
    for _ in 0..1000 {
        bench
            .arm
            .receive(USB, &[0xAA, 0xAA, 0x02, 0x0A, 0x00, 0x00]);
    }
    assert_eq!(bench.events().len(), 256);
    assert!(bench.state().events_lost >= 744);
}

/// A pose out of reach of the wrist may be in reach of the mounted tool.
#[test]
fn a_pose_out_of_reach_of_an_arm_without_a_tool_says_that_its_tool_is_unknown() {
    let told = |tool: ToolBias, target: [f32; 4]| {
        let mut bench = arm_with(|profile| profile.power_up.tool = tool);
        bench.start();
        bench.events();
        bench.enqueue(&ptp(1, target));
        bench.rest();
        let told = |event: &Event| match event {
            Event::ToolUnknown { code } => Some(*code),
            _ => None,
        };
        let told: Vec<_> = bench.events().iter().filter_map(told).collect();
        (bench.alarms(), told)
    };
    // In reach with the suction cup only.
    let far = [300.0, 0.0, 0.0, 0.0];
    assert_eq!(told(ToolBias::NONE, far), (vec![0x11], vec![0x11]));
    assert_eq!(told(ToolBias::SUCTION, far), (vec![], vec![]));
    // J1 at 180 degrees.
    let behind = [-200.0, 0.0, 0.0, 180.0];
    assert_eq!(told(ToolBias::NONE, behind), (vec![0x12], vec![0x12]));
    // `ToolUnknown` follows neither an alarm with a tool set nor one that does not depend on the
    // tool.
    assert_eq!(
        told(ToolBias::SUCTION, [900.0, 0.0, 0.0, 0.0]),
        (vec![0x11], vec![])
    );
    let mut bench = arm_with(|profile| profile.power_up.tool = ToolBias::NONE);
    bench.start();
    bench.enqueue(&joints_to([170.0, 45.0, 45.0, 0.0]));
    bench.rest();
    assert_eq!(bench.alarms(), [0x40]);
    let events = bench.events();
    assert!(
        !events
            .iter()
            .any(|event| matches!(event, Event::ToolUnknown { .. }))
    );
}
