//! Inputs over time, faults, keys and hands.

use magician_motion::JointAngles;

use std::time::Duration;

use super::{SECOND, World, world};
use crate::Micros;
use crate::world::{ExternalEvent, JointState, Press};

/// All events up to an instant, with their times.
fn until(world: &mut World, to: Micros) -> Vec<(Micros, ExternalEvent)> {
    let mut happened = Vec::new();
    while let Some(at) = world.next_event().filter(|at| *at <= to) {
        happened.extend(world.poll_external(at).map(|event| (at, event)));
    }
    happened
}

#[test]
fn an_empty_world_is_still() {
    let mut world = World::default();
    world.index_started(5, 1);
    world.stepper(5, 0, 100.0);
    assert_eq!(size_of::<World>(), size_of::<usize>());
    assert_eq!(world.next_event(), None);
    assert_eq!(world.poll_external(9 * SECOND), None);
    assert!(world.digital(0, 1).is_none() && world.analog(0, 1).is_none() && !world.holding());
    let joint_state = JointState {
        joints: JointAngles::HOME,
        rail: 0.0,
    };
    assert!(world.look(0, &joint_state).object("cube").is_none());
    assert!(world.drawing().is_none() && world.drawing_at(0, None).is_empty());
}

#[test]
fn inputs_change_when_they_should() {
    let mut world = world(
        "[[input]]\naddress = 5\nlevel = 1\nat = 3.2\n\
         [[input]]\naddress = 9\nvalue = 2048\n\
         [[input]]\naddress = 5\nlevel = 0\nat = 4\n",
    );
    assert_eq!(
        (world.digital(0, 5), world.analog(0, 9)),
        (None, Some(2048))
    );
    assert_eq!(world.next_event(), Some(3_200_000));
    assert_eq!(world.poll_external(3_199_999), None);
    assert_eq!(world.poll_external(3_200_000), Some(ExternalEvent::Input));
    assert_eq!(world.poll_external(3_200_000), None);
    assert_eq!(world.digital(3_200_000, 5), Some(true));
    assert_eq!(
        until(&mut world, 9 * SECOND),
        [(4 * SECOND, ExternalEvent::Input)]
    );
    assert_eq!(world.digital(5 * SECOND, 5), Some(false));
    assert_eq!(world.next_event(), None);
}

#[test]
fn an_input_is_overridden_until_it_changes() {
    let mut world = world("[[input]]\naddress = 5\nlevel = 0\nat = 1\n");
    assert!(world.set_input(5, true) && world.set_analog(1, 9000));
    assert_eq!(
        until(&mut world, 0),
        [(0, ExternalEvent::Input)],
        "once for both"
    );
    assert_eq!(world.digital(0, 5), Some(true));
    assert_eq!(world.analog(0, 1), Some(4095));
    assert_eq!(until(&mut world, SECOND), [(SECOND, ExternalEvent::Input)]);
    assert_eq!(world.digital(SECOND, 5), Some(false));
    assert!(!world.set_input(0, true) && !world.set_input(21, true));
}

#[test]
fn an_empty_world_takes_inputs() {
    let mut world = World::default();
    assert!(world.set_input(20, true));
    assert_eq!(world.digital(0, 20), Some(true));
    assert_eq!(world.digital(0, 19), None);
    assert_eq!(until(&mut world, 0), [(0, ExternalEvent::Input)]);
}

#[test]
fn faults_come_at_their_time_and_pass() {
    let mut world = world(
        "[[fault]]\nkind = \"cable\"\nat = 5\nfor = 2\n\
         [[fault]]\nkind = \"slow\"\nat = 1\nfor = 5\ndelay = 0.25\n\
         [[fault]]\nkind = \"slip\"\nat = 6.5\njoint = 2\ndegrees = 8\n\
         [[fault]]\nkind = \"reset\"\nat = 9\n\
         [[key]]\npress = \"long\"\nat = 0\n",
    );
    let expected = [
        (0, ExternalEvent::Key(Press::Long)),
        (SECOND, ExternalEvent::Delay(Duration::from_millis(250))),
        (5 * SECOND, ExternalEvent::Cable { plugged: false }),
        (6 * SECOND, ExternalEvent::Delay(Duration::ZERO)),
        (
            6_500_000,
            ExternalEvent::Slip {
                joint: 2,
                degrees: 8.0,
            },
        ),
        (7 * SECOND, ExternalEvent::Cable { plugged: true }),
        (9 * SECOND, ExternalEvent::Reset),
    ];
    assert_eq!(until(&mut world, 10 * SECOND), expected);
}

#[test]
fn a_fault_waits_for_its_index_and_comes_once() {
    let mut world = world(
        "[[fault]]\nkind = \"alarm\"\nalarm = \"LimitAxis1Pos\"\nindex = 40\n\
         [[fault]]\nkind = \"cable\"\nfor = 2\nindex = 40\n",
    );
    world.index_started(SECOND, 39);
    assert_eq!(world.next_event(), None);
    world.index_started(2 * SECOND, 40);
    let expected = [
        (2 * SECOND, ExternalEvent::Alarm(0x40)),
        (2 * SECOND, ExternalEvent::Cable { plugged: false }),
        (4 * SECOND, ExternalEvent::Cable { plugged: true }),
    ];
    assert_eq!(until(&mut world, 10 * SECOND), expected);
    world.index_started(11 * SECOND, 40);
    assert_eq!(world.next_event(), None);
}

#[test]
fn a_hand_leads_the_arm_evenly() {
    let mut world = world(
        "[[hand]]\nkind = \"unlock\"\nat = 1\n\
         [[hand]]\nkind = \"guide\"\nat = 2\njoints = [0, 45, 45, 0]\n\
         [[hand]]\nkind = \"guide\"\nat = 3\njoints = [40, 30, 50, 0]\nover = 0.05\n\
         [[hand]]\nkind = \"release\"\nat = 4\n",
    );
    let guide = |j1, j2, j3| ExternalEvent::Guide(JointAngles::new(j1, j2, j3, 0.0));
    let expected = [
        (SECOND, ExternalEvent::Unlock(true)),
        (2 * SECOND, guide(0.0, 45.0, 45.0)),
        (3 * SECOND, guide(0.0, 45.0, 45.0)),
        (3_020_000, guide(16.0, 39.0, 47.0)),
        (3_040_000, guide(32.0, 33.0, 49.0)),
        (3_050_000, guide(40.0, 30.0, 50.0)),
        (4 * SECOND, ExternalEvent::Unlock(false)),
    ];
    assert_eq!(until(&mut world, 10 * SECOND), expected);
}

#[test]
fn a_copy_goes_on_by_itself() {
    let mut world = world("[[input]]\naddress = 5\nlevel = 1\nat = 1\n");
    let mut copy = world.clone();
    assert_eq!(until(&mut world, SECOND).len(), 1);
    assert_eq!(world.digital(SECOND, 5), Some(true));
    assert_ne!(copy.digital(SECOND, 5), Some(true));
    assert_eq!(until(&mut copy, SECOND).len(), 1);
}
