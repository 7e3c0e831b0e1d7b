//! Hand teaching: the unlock key, the hand, and points polled by hosts (model section 12).

use super::arm::{SECOND, TestArm, arm, arm_with, home, joints_to, ptp, running_arm, suck, wait};
use magician_protocol::commands::*;
use magician_protocol::{Flag, TeachTrigger};
use magician_sim::scenario::Scenario;
use magician_sim::world::{JointState, Press};
use magician_sim::{Controller, ExternalEvent, Profile, World};

fn teach(bench: &mut TestArm, mode: TeachTrigger) {
    bench.set(&HhtTrigMode { mode });
    bench.set(&HhtTrigOutputEnabled {
        is_enabled: Flag::ON,
    });
}

fn point(bench: &mut TestArm) -> bool {
    bench.get::<HhtTrigOutput>().is_triggered.is_on()
}

#[test]
fn a_hand_places_the_arm_and_the_pose_follows() {
    let mut bench = running_arm();
    bench.arm.guide([10.0, 10.0, 10.0, 10.0].into());
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0], "the motors hold it");
    bench.arm.unlock(true);
    assert!(bench.state().unlocked);
    for joints in [[5.0, 40.0, 50.0, 0.0], [-33.3, 20.1, 30.7, 12.5]] {
        bench.arm.guide(joints.into());
        let state = bench.state();
        assert_eq!(state.joints.to_array(), joints);
        assert_eq!(state.true_joints.to_array(), joints);
    }
    bench.arm.unlock(false);
    assert_eq!(bench.joints(), [-33.3, 20.1, 30.7, 12.5]);
    bench.arm.guide([10.0, 10.0, 10.0, 10.0].into());
    assert_eq!(bench.joints(), [-33.3, 20.1, 30.7, 12.5]);
    assert!(!bench.state().unlocked);
    // Motion continues from there.
    bench.enqueue(&joints_to([0.0, 45.0, 45.0, 0.0]));
    bench.rest();
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn a_hand_gets_no_further_than_the_limits() {
    let mut bench = arm();
    bench.arm.unlock(true);
    let mut guided = |joints: [f64; 4]| {
        bench.arm.guide(joints.into());
        assert!(bench.arm.state().alarms.is_empty());
        bench.arm.state().joints.to_array()
    };
    assert_eq!(
        guided([500.0, -50.0, 0.0, 500.0]),
        [135.0, -13.5, 0.0, 150.0]
    );
    assert_eq!(guided([0.0, 80.0, 0.0, 0.0]), [0.0, 80.0, 25.0, 0.0]);
    assert_eq!(
        guided([f64::NAN, f64::INFINITY, 30.0, f64::NAN]),
        [0.0, 80.0, 30.0, 0.0]
    );
}

#[test]
fn guiding_before_homing_keeps_the_offset_of_the_base_angle() {
    let mut bench = TestArm {
        arm: Controller::default().standing_at([40.0, 20.0, 20.0, 0.0].into()),
    };
    bench.arm.unlock(true);
    bench.arm.guide([50.0, 20.0, 20.0, 0.0].into());
    bench.arm.unlock(false);
    let state = bench.state();
    assert_eq!((state.joints.j1, state.true_joints.j1), (10.0, 50.0));
}

#[test]
fn pressing_the_key_reads_the_sensors() {
    let mut bench = arm();
    for (joint, degrees) in [(1, 9.0), (2, 8.0), (3, -7.0)] {
        bench.arm.inject(ExternalEvent::Slip { joint, degrees });
    }
    bench.arm.unlock(true);
    let state = bench.state();
    assert_eq!(state.joints.to_array(), [9.0, 53.0, 38.0, 0.0]);
    assert_eq!(state.joints, state.true_joints);
    bench.set(&LostStepCmd {});
    assert!(bench.state().alarms.is_empty());
}

#[test]
fn the_key_ends_what_moves_and_holds_the_queue() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&joints_to([20.0, 45.0, 45.0, 0.0]));
    bench.pass(SECOND);
    let there = bench.joints();
    bench.arm.unlock(true);
    assert!(!bench.state().moving);
    assert_eq!(bench.current_index(), 1, "it has finished");
    assert_eq!(bench.joints(), there);
    bench.pass(10 * SECOND);
    assert_eq!(bench.joints(), there);
    bench.arm.unlock(true);
    bench.arm.unlock(false);
    bench.rest();
    assert_eq!(bench.joints()[0], 20.0);
    assert_eq!(bench.current_index(), 2);
    assert!(bench.alarms().is_empty());
}

#[test]
fn a_wait_goes_on_while_the_key_is_held_and_the_next_command_does_not() {
    let mut bench = running_arm();
    bench.enqueue(&wait(1000));
    bench.enqueue(&wait(1000));
    bench.arm.unlock(true);
    bench.pass(5 * SECOND);
    assert_eq!(bench.current_index(), 1);
    bench.arm.unlock(false);
    assert_eq!(bench.rest(), SECOND);
}

#[test]
fn motion_at_once_is_refused_while_the_key_is_held() {
    let mut bench = arm();
    bench.arm.unlock(true);
    bench.set(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.set(&home());
    bench.set(&JogCmd {
        is_joint: Flag::ON,
        cmd: 1.into(),
    });
    bench.arm.press(Press::Long);
    bench.arm.press(Press::Short);
    assert!(!bench.state().moving);
    assert_eq!(bench.rest(), 0);
    assert!(bench.alarms().is_empty());
}

#[test]
fn the_key_ends_homing_too() {
    let mut bench = running_arm();
    bench.enqueue(&home());
    bench.pass(2 * SECOND);
    bench.arm.unlock(true);
    assert!(!bench.state().moving && !bench.state().homed);
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn a_point_is_there_once_when_the_key_is_released() {
    let mut bench = arm();
    teach(&mut bench, TeachTrigger::OnRelease);
    assert!(!point(&mut bench));
    bench.arm.unlock(true);
    bench.pass(10 * SECOND);
    assert!(!point(&mut bench));
    bench.arm.unlock(false);
    bench.pass(SECOND);
    assert!(point(&mut bench));
    assert!(!point(&mut bench), "the read clears it");
    bench.arm.unlock(false);
    assert!(!point(&mut bench), "it was not held");
}

#[test]
fn points_are_there_period_by_period_while_the_key_is_held() {
    let mut bench = arm_with(|profile| profile.teach.period = 0.5);
    teach(&mut bench, TeachTrigger::Periodic);
    // Periods count from the key press.
    bench.pass(SECOND * 7 / 10);
    bench.arm.unlock(true);
    assert_eq!(bench.arm.poll_timeout(), None, "nothing happens by itself");
    let mut points = Vec::new();
    for tenth in 1..=20 {
        bench.pass(SECOND / 10);
        if point(&mut bench) {
            points.push(tenth);
        }
    }
    assert_eq!(points, [5, 10, 15, 20]);
    bench.pass(3 * SECOND);
    assert!(point(&mut bench));
    assert!(!point(&mut bench), "those that nobody asked for are one");
    bench.pass(SECOND / 2);
    bench.arm.unlock(false);
    bench.pass(5 * SECOND);
    assert!(point(&mut bench), "the last one before the release");
    assert!(!point(&mut bench));
}

#[test]
fn there_is_no_point_unless_the_output_is_enabled() {
    for mode in [TeachTrigger::OnRelease, TeachTrigger::Periodic] {
        let mut bench = arm();
        teach(&mut bench, mode);
        let enable = |bench: &mut TestArm, on| {
            bench.set(&HhtTrigOutputEnabled {
                is_enabled: Flag::from(on),
            });
        };
        let press = |bench: &mut TestArm| {
            bench.arm.unlock(true);
            bench.pass(2 * SECOND);
            bench.arm.unlock(false);
        };
        enable(&mut bench, false);
        press(&mut bench);
        enable(&mut bench, true);
        assert!(!point(&mut bench));
        press(&mut bench);
        enable(&mut bench, false);
        enable(&mut bench, true);
        assert!(!point(&mut bench), "disabled, it is forgotten");
        press(&mut bench);
        assert!(point(&mut bench));
    }
}

#[test]
fn a_mode_counts_from_when_it_is_set() {
    let mut bench = arm();
    teach(&mut bench, TeachTrigger::OnRelease);
    bench.arm.unlock(true);
    bench.pass(3 * SECOND);
    let mode = TeachTrigger::Periodic;
    bench.set(&HhtTrigMode { mode });
    assert!(!point(&mut bench));
    bench.pass(SECOND / 2);
    assert!(point(&mut bench));
}

#[test]
fn a_reset_finds_the_key_still_held() {
    let mut bench = running_arm();
    bench.arm.unlock(true);
    bench.arm.guide([10.0, 20.0, 30.0, 0.0].into());
    bench.arm.inject(ExternalEvent::Reset);
    assert!(bench.state().unlocked);
    assert_eq!(bench.joints(), [0.0, 20.0, 30.0, 0.0]);
    bench.start();
    bench.set(&ClearAlarmsState {});
    bench.enqueue(&joints_to([5.0, 45.0, 45.0, 0.0]));
    assert_eq!(bench.rest(), 0);
    bench.arm.unlock(false);
    bench.rest();
    assert_eq!(bench.joints()[0], 5.0);
}

#[test]
fn held_object_follows_a_hand_guided_arm() {
    let scenario = Scenario::from_toml(
        r#"
        tool.kind = "suction"
        table.height = -70
        [[object]]
        name = "cube"
        size = [20, 20, 20]
        at = [220, 0]
        color = "red"
        "#,
    );
    let world = World::from_scenario(&scenario.unwrap());
    let mut bench = TestArm {
        arm: Controller::in_world(Profile::continuous(), world),
    };
    bench.suction_bias();
    bench.set(&ptp(1, [220.0, 0.0, -50.0, 0.0]));
    bench.rest();
    bench.set(&suck(true));
    bench.rest();
    bench.arm.unlock(true);
    let mut joints = bench.state().joints;
    joints.j2 -= 10.0;
    bench.arm.guide(joints);
    joints.j1 = 40.0;
    bench.arm.guide(joints);
    bench.set(&suck(false));
    bench.rest();
    let state = bench.state();
    let joint_state = JointState {
        joints: state.true_joints,
        rail: 0.0,
    };
    let look = bench.arm.world().look(state.now, &joint_state);
    let place = look.object("cube").unwrap().place();
    assert!((place.x - state.pose.x).abs() < 1e-9 && (place.y - state.pose.y).abs() < 1e-9);
    assert!(place.y > 100.0);
}
