//! Statements of the contract that no other test checks.

use super::arm;
use super::arm::{SECOND, arm, arm_with, home, homing_lasts, joints_to, ptp, running_arm, wait};
use magician_motion::ToolBias;
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, Flag, FrameBuf, TABLE};
use magician_sim::{Controller, Event, LinkId, Refusal};

fn common(ratio: f32) -> PtpCommonParams {
    PtpCommonParams {
        velocity_ratio: ratio,
        acceleration_ratio: ratio,
    }
}

fn bias(x_bias: f32, y_bias: f32) -> EndEffectorParams {
    EndEffectorParams {
        x_bias,
        y_bias,
        z_bias: 0.0,
    }
}

/// Ctrl is echoed bit for bit for every command; only a full queue adds bit 2.
#[test]
fn every_ctrl_of_every_command_is_echoed_to_the_bit() {
    for row in TABLE {
        let mut bench = arm();
        for ctrl in 0..=255u8 {
            let count = row.set.map_or(0, |set| set.size().unwrap_or(3));
            let request = FrameBuf::new(row.id, Ctrl(ctrl), &vec![0; count]).unwrap();
            let replies = bench.send(request.bytes());
            let [reply] = &replies[..] else {
                panic!("{}: one reply and only one", row.name)
            };
            let full = ctrl & 2 != 0 && bench.state().queue.overflows > 0;
            let queued = full && reply.frame().params().len() == 8 && row.set.is_some();
            let added = if queued && !row.steers_queue() { 4 } else { 0 };
            assert_eq!(reply.bytes()[3..5], [row.id, ctrl | added], "{}", row.name);
        }
    }
}

/// Bit 1 alone decides whether a command is queued (errata E07), even for rows that the document
/// does not queue.
#[test]
fn whatever_can_be_set_can_be_queued_with_or_without_rw() {
    for row in TABLE.iter().filter(|row| !row.steers_queue()) {
        let Some(set) = row.set else { continue };
        let params = vec![0; set.size().unwrap_or(set.min_size())];
        for ctrl in [2, 3, 0x12, 0xC3] {
            let mut bench = arm();
            let reply = bench.frame(row.id, Ctrl(ctrl), &params);
            assert_eq!(reply.frame().params(), 1u64.to_le_bytes(), "{}", row.name);
            assert_eq!(bench.left_space(), 31);
            assert_eq!(bench.current_index(), 0);
        }
    }
}

/// Without rw a command that steers the queue does nothing, with or without isQueued.
#[test]
fn queue_steering_with_rw_0_is_answered_empty_and_does_nothing() {
    let mut bench = running_arm();
    bench.enqueue(&wait(1000));
    bench.enqueue(&wait(1000));
    for id in 240..=245 {
        for ctrl in [0, 2, 0x20] {
            let reply = bench.frame(id, Ctrl(ctrl), &[0; 8]);
            assert_eq!(reply.frame().params(), [0u8; 0], "id {id}");
        }
    }
    let queue = bench.state().queue;
    assert_eq!(
        (queue.started, queue.waiting, queue.running),
        (true, 1, Some(1))
    );
}

#[test]
fn current_index_and_left_space_answer_under_every_ctrl() {
    let mut bench = running_arm();
    bench.enqueue(&wait(0));
    bench.enqueue(&wait(1000));
    for ctrl in (0..=255).filter(|ctrl| ctrl & 4 == 0) {
        let index = bench.frame(246, Ctrl(ctrl), &[]);
        assert_eq!(index.frame().params(), 1u64.to_le_bytes());
        let left = bench.frame(247, Ctrl(ctrl), &[0; 3]);
        assert_eq!(left.frame().params(), 31u32.to_le_bytes());
    }
}

#[test]
fn too_few_parameters_do_nothing_at_once_and_take_a_place_in_the_queue() {
    for row in TABLE.iter().filter(|row| !row.steers_queue()) {
        let Some(set) = row.set.filter(|set| set.min_size() > 0) else {
            continue;
        };
        let params = vec![0; set.min_size() - 1];
        if set.normalise(params.len()).is_ok() {
            continue;
        }
        let mut bench = running_arm();
        let reply = bench.frame(row.id, Ctrl::SET, &params);
        assert_eq!(reply.frame().params(), [0u8; 0], "{}", row.name);
        let refusals = bench.events().into_iter();
        let refused = |event| matches!(event, Event::Refused { reason: Refusal::Parameters, id } if id == row.id);
        assert_eq!(
            refusals.filter(|event| refused(*event)).count(),
            1,
            "{}",
            row.name
        );
        let reply = bench.frame(row.id, Ctrl::QUEUED, &params);
        assert_eq!(reply.frame().params(), 1u64.to_le_bytes(), "{}", row.name);
        let reply = bench.frame(row.id, Ctrl(2), &params);
        assert_eq!(reply.frame().params(), 2u64.to_le_bytes(), "{}", row.name);
        assert_eq!(bench.current_index(), 2);
        assert!(!bench.state().moving && bench.alarms().is_empty());
    }
}

#[test]
fn unreadable_frames_overflow_a_full_queue_like_others() {
    let mut bench = arm();
    for _ in 0..32 {
        bench.frame(84, Ctrl::QUEUED, &[1, 2, 3]);
    }
    let reply = bench.frame(84, Ctrl::QUEUED, &[1, 2, 3]);
    assert_eq!(reply.frame().params(), [0; 8]);
    assert_eq!(reply.frame().ctrl(), Ctrl::QUEUED.with_error());
    assert_eq!(bench.state().queue.overflows, 1);
}

#[test]
fn homing_at_once_replaces_a_queued_motion_and_the_queue_goes_on_after_it() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&joints_to([20.0, 45.0, 45.0, 0.0]));
    bench.pass(SECOND);
    bench.set(&home());
    assert_eq!(bench.current_index(), 1, "replaced counts as finished");
    bench.pass(10 * SECOND);
    assert_eq!(bench.current_index(), 1);
    bench.pass(5 * SECOND);
    assert!(bench.state().homed && bench.state().moving);
    bench.rest();
    assert_eq!(bench.joints()[0], 20.0);
    assert_eq!(bench.current_index(), 2);
    assert!(bench.alarms().is_empty());
}

#[test]
fn homing_at_once_begins_a_queued_homing_anew() {
    let mut bench = running_arm();
    bench.enqueue(&home());
    bench.pass(4 * SECOND);
    let there = bench.state().joints.j1;
    bench.set(&home());
    assert_eq!(bench.current_index(), 1);
    let lasted = bench.rest() as f64 / 1e6;
    assert!((lasted - homing_lasts(there)).abs() < 1e-4, "{lasted}");
}

#[test]
fn clear_ends_an_immediate_motion_and_lets_a_running_wait_go_on() {
    let mut bench = running_arm();
    bench.enqueue(&wait(500));
    bench.enqueue(&wait(500));
    bench.set(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.set(&QueuedCmdClear {});
    assert!(!bench.state().moving);
    assert_eq!(bench.left_space(), 31, "the wait keeps its place");
    bench.pass(500_000);
    assert_eq!((bench.current_index(), bench.left_space()), (1, 32));
    bench.rest();
    assert_eq!(bench.joints()[0], 0.0);
    assert_eq!(bench.current_index(), 1, "the current index stands");
}

#[test]
fn the_end_of_an_immediate_motion_is_not_the_end_of_a_running_wait() {
    let mut bench = running_arm();
    bench.enqueue(&wait(60_000));
    bench.set(&joints_to([10.0, 45.0, 45.0, 0.0]));
    bench.pass(30 * SECOND);
    assert!(!bench.state().moving);
    assert_eq!(bench.current_index(), 0);
    bench.set(&joints_to([0.0, 45.0, 45.0, 0.0]));
    bench.set(&joints_to([5.0, 45.0, 45.0, 0.0]));
    assert_eq!(bench.current_index(), 0, "nor is its replacement");
    assert_eq!(bench.rest(), 30 * SECOND);
}

#[test]
fn a_held_queue_fills_up_and_nothing_in_it_runs() {
    let mut bench = running_arm();
    bench.set(&ptp(1, [900.0, 0.0, 0.0, 0.0]));
    for index in 1..=32 {
        assert_eq!(bench.enqueue(&arm::suck(true)), index);
    }
    assert_eq!((bench.left_space(), bench.current_index()), (0, 0));
    assert!(!bench.state().suction.commanded);
    bench.set(&ClearAllAlarmsState {});
    assert_eq!((bench.left_space(), bench.current_index()), (32, 32));
}

#[test]
fn stop_lets_an_immediate_motion_finish_and_force_stop_brakes_it() {
    let mut bench = running_arm();
    bench.set(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.pass(SECOND);
    bench.set(&QueuedCmdStopExec {});
    bench.rest();
    assert_eq!(bench.joints()[0], 90.0);
    bench.set(&joints_to([0.0, 45.0, 45.0, 0.0]));
    bench.pass(SECOND);
    bench.set(&QueuedCmdForceStopExec {});
    bench.rest();
    assert!(bench.joints()[0] > 5.0 && bench.joints()[0] < 45.0);
    assert_eq!(bench.current_index(), 0);
}

#[test]
fn while_it_brakes_stop_and_force_stop_change_nothing_and_start_waits_for_the_end() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&wait(0));
    bench.pass(948_683);
    bench.set(&QueuedCmdForceStopExec {});
    let end = bench.arm.poll_timeout();
    bench.pass(100_000);
    bench.set(&QueuedCmdForceStopExec {});
    bench.set(&QueuedCmdStopExec {});
    bench.start();
    assert_eq!(bench.arm.poll_timeout(), end);
    assert_eq!((bench.current_index(), bench.left_space()), (0, 30));
    bench.rest();
    assert_eq!(bench.current_index(), 2);
}

#[test]
fn a_force_stop_with_nothing_under_way_only_stops_the_queue() {
    let mut bench = running_arm();
    let before = bench.get::<Pose>();
    bench.set(&QueuedCmdForceStopExec {});
    assert_eq!(bench.arm.poll_timeout(), None);
    assert_eq!(bench.get::<Pose>(), before);
    bench.enqueue(&wait(0));
    assert_eq!(bench.current_index(), 0);
    assert!(bench.alarms().is_empty());
}

#[test]
fn a_motion_at_once_while_it_brakes_finishes_the_braked_command() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.pass(948_683);
    bench.set(&QueuedCmdForceStopExec {});
    bench.pass(100_000);
    bench.set(&joints_to([0.0, 45.0, 45.0, 0.0]));
    assert_eq!(bench.current_index(), 1);
    bench.rest();
    assert_eq!(bench.joints()[0], 0.0);
}

/// Braking takes the time of acceleration divided by the profile's factor: 0.3 s / factor.
#[test]
fn a_force_stop_brakes_by_the_profiles_factor_times_the_acceleration_in_force() {
    for factor in [0.5, 1.0, 2.0, 5.0] {
        let mut bench = arm_with(|profile| profile.stop.force_factor = factor);
        bench.start();
        // The ceiling of 300 deg/s2 applies first, then the ratio, then the factor.
        bench.set(&PtpJointParams {
            velocity: [200.0; 4],
            acceleration: [600.0; 4],
        });
        bench.enqueue(&joints_to([-60.0, 45.0, 45.0, 0.0]));
        bench.pass(300_000);
        bench.set(&QueuedCmdForceStopExec {});
        let seconds = bench.rest() as f64 / 1e6;
        assert!((seconds - 0.3 / factor).abs() < 1e-5, "{factor}: {seconds}");
    }
}

#[test]
fn braking_into_a_limit_ends_there_with_its_alarm() {
    let mut bench = arm_with(|profile| profile.stop.force_factor = 0.1);
    bench.start();
    bench.enqueue(&joints_to([130.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&wait(0));
    bench.pass(1_500_000);
    bench.set(&QueuedCmdForceStopExec {});
    bench.rest();
    assert_eq!(bench.joints()[0], 135.0);
    assert_eq!(bench.alarms(), [0x40]);
    assert_eq!(bench.current_index(), 1);
    bench.start();
    assert_eq!(bench.current_index(), 1, "held");
}

#[test]
fn queued_parameters_count_for_the_moves_behind_them_only() {
    let mut bench = arm();
    bench.enqueue(&ptp(7, [0.0, 100.0, 0.0, 0.0]));
    bench.enqueue(&common(100.0));
    bench.enqueue(&ptp(7, [0.0, -100.0, 0.0, 0.0]));
    bench.start();
    bench.pass(1_999_999);
    assert_eq!(bench.current_index(), 0);
    assert_eq!(bench.get::<PtpCommonParams>(), common(50.0));
    bench.pass(2);
    assert_eq!(bench.current_index(), 2);
    let left = bench.rest();
    assert!(
        (left as f64 / 1e6 - 2.0_f64.sqrt()).abs() < 1e-5,
        "{left} us"
    );
}

/// A bias queued behind a move changes the pose and the moves after it, but not the joints.
#[test]
fn a_queued_bias_takes_effect_at_its_turn() {
    let mut bench = arm_with(|profile| profile.power_up.tool = ToolBias::NONE);
    bench.enqueue(&ptp(1, [220.0, 0.0, 0.0, 0.0]));
    bench.enqueue(&bias(59.7, 0.0));
    bench.enqueue(&ptp(7, [0.0, 10.0, 0.0, 0.0]));
    bench.start();
    bench.rest();
    let [x, y, ..] = bench.pose();
    assert!((x - 279.7).abs() < 1e-3 && (y - 10.0).abs() < 1e-3);
    assert_eq!(bench.current_index(), 3);
}

#[test]
fn a_bias_that_is_no_number_refuses_targets_in_space_and_moves_joints() {
    let mut bench = running_arm();
    bench.set(&bias(f32::NAN, 0.0));
    bench.set(&ptp(2, [200.0, 10.0, 0.0, 0.0]));
    assert_eq!(bench.alarms(), [0x11]);
    bench.set(&ptp(7, [0.0, 1.0, 0.0, 0.0]));
    bench.set(&ptp(0, [200.0, 10.0, 0.0, 0.0]));
    assert_eq!(bench.rest(), 0);
    bench.set(&joints_to([10.0, 45.0, 45.0, 0.0]));
    assert!(bench.rest() > 0);
    assert_eq!(bench.joints(), [10.0, 45.0, 45.0, 0.0]);
    bench.set(&bias(0.0, 0.0));
    assert!(bench.pose()[0].is_finite());
}

#[test]
fn a_target_with_one_number_that_is_none_is_refused_in_every_mode() {
    for mode in 0..=9 {
        for axis in 0..4 {
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let mut bench = running_arm();
                let before = bench.get::<Pose>();
                let mut target = if matches!(mode, 3..=5) {
                    [0.0, 40.0, 40.0, 0.0]
                } else {
                    [200.0, 0.0, 0.0, 0.0]
                };
                target[axis] = bad;
                bench.enqueue(&ptp(mode, target));
                assert_eq!(bench.alarms(), [0x11], "mode {mode} to {target:?}");
                assert_eq!(bench.current_index(), 1);
                assert_eq!((bench.rest(), bench.get::<Pose>()), (0, before));
            }
        }
    }
}

#[test]
fn jump_heights_that_are_no_numbers_refuse_jumps_and_nothing_else() {
    for mode in [0, 3, 9] {
        let mut bench = running_arm();
        let heights = PtpJump2Params {
            start_jump_height: 10.0,
            end_jump_height: f32::NAN,
            z_limit: 100.0,
        };
        bench.set(&heights);
        bench.enqueue(&ptp(1, [200.0, 10.0, 0.0, 0.0]));
        assert!(bench.rest() > 0);
        let target = match mode {
            3 => [0.0, 40.0, 40.0, 0.0],
            _ => [220.0, 0.0, 10.0, 0.0],
        };
        bench.enqueue(&ptp(mode, target));
        assert_eq!(bench.alarms(), [0x11]);
        assert_eq!(bench.current_index(), 2);
    }
}

#[test]
fn moves_below_the_shortest_finish_at_once_and_those_above_move() {
    for (by, moves) in [(0.000_09, false), (0.000_2, true)] {
        for mode in [6, 7, 8] {
            let mut bench = running_arm();
            bench.enqueue(&ptp(mode, [0.0, by, 0.0, by]));
            assert_eq!(bench.rest() > 0, moves, "mode {mode}, {by}");
            assert_eq!(bench.current_index(), 1);
            assert!(bench.alarms().is_empty());
        }
    }
}

#[test]
fn a_move_without_length_at_once_still_replaces_what_is_under_way() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.pass(SECOND);
    bench.set(&ptp(6, [0.0; 4]));
    assert!(!bench.state().moving);
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn a_mode_above_9_at_once_disturbs_nothing_under_way() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.pass(SECOND);
    bench.set(&ptp(200, [0.0; 4]));
    assert_eq!(bench.alarms(), [0x01]);
    bench.rest();
    assert_eq!(bench.joints()[0], 90.0);
}

#[test]
fn asking_for_a_time_while_moving_counts_from_where_the_arm_is() {
    let mut bench = running_arm();
    bench.enqueue(&ptp(2, [259.104_13, 100.0, -8.485_281, 0.0]));
    bench.pass(SECOND);
    let query = GetPtpTime {
        ptp_mode: magician_protocol::PtpMode::MovlXyz,
        x: 259.104_13,
        y: 100.0,
        z: -8.485_281,
        r: 0.0,
    };
    // 50 mm are left: 2 * sqrt(50 / 100) s.
    assert_eq!(bench.get_with::<PtpTime>(&query).ptp_time, 1415);
    assert_eq!(bench.rest(), SECOND, "and the motion goes on");
}

/// A limit alarm drops on a path out of the limit, even if the path ends at the limit again.
#[test]
fn a_limit_bit_drops_on_a_line_that_ends_at_the_limit_again() {
    let mut bench = arm();
    bench.set(&ResetPose {
        manual: Flag::ON,
        rear_arm_angle: 75.0,
        front_arm_angle: 20.0,
    });
    bench.set(&joints_to([0.0, 80.0, 20.0, 0.0]));
    assert_eq!(bench.alarms(), [0x48]);
    // A line to the same J2 and J3 at J1 = 20 degrees: its middle is closer to the base.
    bench.set(&ptp(5, [20.0, 75.0, 20.0, 0.0]));
    assert_eq!(bench.alarms(), [0x48]);
    bench.pass(100_000);
    assert!(bench.alarms().is_empty());
    bench.rest();
    assert_eq!(bench.joints(), [20.0, 75.0, 20.0, 0.0]);
    assert!(bench.alarms().is_empty(), "where it led was allowed");
}

#[test]
fn a_hold_ends_with_the_clear_and_not_with_the_way_out_of_the_limit_or_homing() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([170.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&wait(0));
    bench.rest();
    bench.set(&ClearAllAlarmsState {});
    assert_eq!(bench.alarms(), [0x40], "the cause stands");
    bench.set(&home());
    bench.rest();
    assert!(bench.alarms().is_empty(), "level-like");
    assert_eq!(bench.current_index(), 1);
    bench.start();
    assert_eq!(bench.current_index(), 1);
    bench.set(&ClearAllAlarmsState {});
    assert_eq!(bench.current_index(), 2);
}

#[test]
fn replies_of_two_links_that_talk_at_once_do_not_mix() {
    let mut bench = running_arm();
    let (usb, udp) = (LinkId(0), LinkId(9));
    let frames: Vec<FrameBuf> = (0..60)
        .map(|count: u8| FrameBuf::new(110, Ctrl(3 | (count << 4)), &[1, 0, 0, 0]).unwrap())
        .collect();
    // Alternately, byte by byte.
    for (a, b) in frames[..15].iter().zip(&frames[15..30]) {
        for (a, b) in a.bytes().iter().zip(b.bytes()) {
            bench.arm.receive(usb, &[*a]);
            bench.arm.receive(udp, &[*b]);
        }
    }
    for (link, first, sent) in [(usb, 1, &frames[..15]), (udp, 2, &frames[15..30])] {
        let replies = bench.replies(link);
        assert_eq!(replies.len(), sent.len());
        for (at, (request, reply)) in sent.iter().zip(replies).enumerate() {
            assert_eq!(reply.frame().ctrl(), request.frame().ctrl());
            let index = first + 2 * at as u64;
            assert_eq!(reply.frame().params(), index.to_le_bytes());
        }
    }
}

/// Neither an expiry nor an empty receive counts as traffic: the link stays the longest silent.
#[test]
fn expired_link_stays_longest_silent() {
    let mut arm = Controller::default();
    arm.receive(LinkId(0), &[0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6]);
    for link in 1..64 {
        arm.receive(LinkId(link), &[0xAA]);
    }
    arm.expire(LinkId(0));
    arm.receive(LinkId(0), &[]);
    arm.receive(LinkId(64), &[0xAA]);
    assert_eq!(arm.poll_transmit(LinkId(0)), None, "pushed out");
}

#[test]
fn what_is_not_simulated_is_told_once_a_row_and_counted() {
    let mut bench = running_arm();
    bench.events();
    for count in 1..=1000u64 {
        bench.frame(32, Ctrl::QUEUED, &[0; 5]);
        bench.frame(160, Ctrl::SET, &[]);
        assert_eq!(bench.state().not_simulated, 2 * count);
        let told = bench.events().into_iter();
        let told = told.filter(|event| matches!(event, Event::NotSimulated { .. }));
        assert_eq!(told.count(), if count == 1 { 2 } else { 0 });
    }
}

/// At a speed close to zero a motion outlasts the clock; at the clock's last instant it ends at its
/// target.
#[test]
fn at_the_end_of_time_motions_still_end_where_they_lead() {
    let mut bench = running_arm();
    bench.set(&PtpJointParams {
        velocity: [f32::MIN_POSITIVE; 4],
        acceleration: [200.0; 4],
    });
    bench.enqueue(&joints_to([10.0, 45.0, 45.0, 0.0]));
    bench.rest();
    assert_eq!(bench.joints()[0], 10.0);
    bench.set(&PtpJointParams {
        velocity: [200.0; 4],
        acceleration: [200.0; 4],
    });
    bench.enqueue(&joints_to([20.0, 45.0, 45.0, 0.0]));
    assert_eq!(bench.joints()[0], 20.0);
    assert_eq!(bench.current_index(), 2);
}

/// Laser and suction cup keep their state through a forced stop and a clear.
#[test]
fn stops_and_clears_leave_the_tool_alone() {
    let mut bench = running_arm();
    bench.set(&SetEndEffectorLaser {
        enable_ctrl: Flag::ON,
        on: Flag::ON,
    });
    bench.set(&arm::suck(true));
    bench.set(&QueuedCmdForceStopExec {});
    bench.set(&QueuedCmdClear {});
    let state = bench.state();
    assert!(state.laser && state.suction.commanded);
}
