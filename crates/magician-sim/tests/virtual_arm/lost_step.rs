//! Lost steps: detected when a host asks, they hold the queue; homing is the remedy (model section
//! 12).

use super::arm::{TestArm, arm, home, joints_to, running_arm, wait};
use magician_protocol::commands::*;
use magician_sim::{Controller, ExternalEvent};

fn slip(bench: &mut TestArm, joint: u8, degrees: f64) {
    bench.arm.inject(ExternalEvent::Slip { joint, degrees });
}

#[test]
fn a_joint_that_is_off_by_more_than_the_threshold_has_lost_steps() {
    for (joint, degrees, found) in [
        (1, 4.9, None),
        (1, 5.1, Some(0x50)),
        (2, 5.0, None),
        (2, -5.1, Some(0x51)),
        (3, 5.1, Some(0x52)),
        (3, -4.9, None),
        (4, 50.0, None),
    ] {
        let mut bench = arm();
        slip(&mut bench, joint, degrees);
        assert!(bench.alarms().is_empty(), "nobody has asked");
        bench.set(&LostStepCmd {});
        let codes: Vec<u8> = found.into_iter().collect();
        assert_eq!(bench.alarms(), codes, "joint {joint} by {degrees}");
    }
}

#[test]
fn the_threshold_is_the_hosts() {
    let mut bench = arm();
    for (value, found) in [(1.5, false), (0.9, true), (f32::NAN, false), (0.0, true)] {
        bench.arm.inject(ExternalEvent::Reset);
        bench.set(&ClearAlarmsState {});
        slip(&mut bench, 2, 1.0);
        bench.set(&LostStepParams { value });
        bench.set(&LostStepCmd {});
        assert_eq!(!bench.alarms().is_empty(), found, "{value}");
    }
    let mut bench = arm();
    bench.set(&LostStepParams { value: 0.0 });
    bench.set(&joints_to([33.3, 44.4, 41.1, 9.9]));
    bench.rest();
    bench.set(&LostStepCmd {});
    assert!(bench.alarms().is_empty(), "an arm in order loses nothing");
}

#[test]
fn it_holds_the_queue_until_homing_has_cured_it() {
    let mut bench = running_arm();
    slip(&mut bench, 2, 8.0);
    assert_eq!(bench.enqueue(&LostStepCmd {}), 1);
    assert_eq!(bench.enqueue(&joints_to([30.0, 45.0, 45.0, 0.0])), 2);
    assert_eq!(bench.current_index(), 1, "the look itself has finished");
    assert!(bench.state().queue.held);
    assert_eq!(bench.rest(), 0);

    // Cleared without homing, the alarm comes back.
    bench.set(&QueuedCmdClear {});
    bench.set(&ClearAllAlarmsState {});
    bench.set(&LostStepCmd {});
    assert_eq!(bench.alarms(), [0x51]);

    bench.enqueue(&home());
    bench.enqueue(&wait(10));
    bench.rest();
    assert_eq!(bench.alarms(), [0x51], "homing clears nothing");
    assert_eq!(bench.current_index(), 3);
    bench.set(&ClearAllAlarmsState {});
    bench.set(&LostStepCmd {});
    assert!(bench.alarms().is_empty());
    bench.rest();
    assert_eq!(bench.current_index(), 4);
}

#[test]
fn a_base_that_was_never_homed_has_lost_nothing() {
    let mut bench = TestArm {
        arm: Controller::default().standing_at([60.0, 20.0, 20.0, 0.0].into()),
    };
    bench.set(&ClearAlarmsState {});
    bench.set(&LostStepCmd {});
    assert!(bench.alarms().is_empty());
    slip(&mut bench, 1, -6.0);
    bench.set(&LostStepCmd {});
    assert_eq!(bench.alarms(), [0x50]);
}

#[test]
fn a_stall_on_the_way_is_found() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([0.0, 60.0, 45.0, 0.0]));
    bench.pass(400_000);
    let body = magician_sim::world::Body::Table;
    bench
        .arm
        .inject(ExternalEvent::Touch { body, stalls: true });
    bench.rest();
    bench.set(&LostStepCmd {});
    assert_eq!(bench.alarms(), [0x51]);
}

#[test]
fn what_the_host_says_of_the_pose_counts_as_commanded() {
    let mut bench = arm();
    let reset = |manual| ResetPose {
        manual: magician_protocol::Flag(manual),
        rear_arm_angle: 30.0,
        front_arm_angle: 45.0,
    };
    bench.set(&reset(1));
    bench.set(&LostStepCmd {});
    assert_eq!(bench.alarms(), [0x51]);
    bench.set(&reset(0));
    bench.set(&ClearAllAlarmsState {});
    bench.set(&LostStepCmd {});
    assert!(bench.alarms().is_empty());
}

#[test]
fn slips_that_make_no_sense_leave_the_arm_in_its_mind() {
    let mut bench = arm();
    for degrees in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        slip(&mut bench, 1, degrees);
    }
    slip(&mut bench, 0, 5.0);
    slip(&mut bench, 5, 5.0);
    assert_eq!(bench.state().joints, bench.state().true_joints);
    slip(&mut bench, 1, f64::MAX);
    assert_eq!(bench.state().true_joints.j1, 360.0);
    bench.set(&home());
    bench.rest();
    assert_eq!(bench.state().joints, bench.state().true_joints);
}
