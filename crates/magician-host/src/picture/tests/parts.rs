//! Motion, queue, homing, motors and readings, compared with a virtual arm.

use std::time::Duration;

use magician_protocol::commands::{
    AlarmsState, ClearAllAlarmsState, DeviceSn, Pose, PtpCommonParams, QueuedCmdClear,
    QueuedCmdCurrentIndex, QueuedCmdForceStopExec, QueuedCmdLeftSpace, QueuedCmdStartExec,
    QueuedCmdStopExec,
};
use magician_protocol::{Alarm, Ctrl, FrameBuf, NoArgs, QueuedCmdIndex, Set, Stepper};

use super::rig::PictureRig;
use crate::build;
use crate::connection::{Failure, Micros};
use crate::picture::{PictureEvent, QueueLook, QueuedPace};

const SECOND: Micros = 1_000_000;

/// An arm without alarms whose queue runs. It has executed a command, because its first index is 2
/// and only later indices are consecutive.
fn running() -> PictureRig {
    let mut rig = PictureRig::new(1);
    rig.set(ClearAllAlarmsState {});
    rig.read::<AlarmsState>();
    rig.set(QueuedCmdStartExec {});
    rig.queue(build::speed(50.0, 50.0));
    rig.wait(SECOND);
    rig.read::<QueuedCmdCurrentIndex>();
    rig
}

fn move_away() -> Set {
    build::move_to(220.0, 60.0, 20.0, 0.0)
}

fn current(rig: &PictureRig) -> u64 {
    rig.picture.current_index().unwrap()
}

/// A reading of the queue, as the driver makes it.
fn read_queue(rig: &mut PictureRig) -> QueueLook {
    let before = rig.picture.standing().writes_sent();
    rig.read::<QueuedCmdLeftSpace>();
    rig.read::<QueuedCmdCurrentIndex>();
    let queue = rig.pair.arm.state().queue;
    let look = QueueLook {
        left: (queue.capacity - queue.waiting) as u32,
        current: current(rig),
        places: queue.capacity as u32,
        at: rig.pair.now,
    };
    rig.picture.note_look(look, before);
    look
}

#[test]
fn queued_motion_is_in_flight_until_its_index_is_read() {
    let mut rig = running();
    assert!(!rig.picture.motion().is_moving());
    rig.queue(move_away());
    rig.wait(5 * SECOND);
    assert!(rig.picture.motion().is_moving());
    rig.read::<QueuedCmdCurrentIndex>();
    assert!(!rig.picture.motion().is_moving());
}

#[test]
fn command_that_waits_to_be_sent_and_program_under_way_are_in_flight() {
    let mut rig = running();
    let request = FrameBuf::set(&move_away(), Ctrl::QUEUED).unwrap();
    rig.picture.handed_over(&request.frame());
    assert!(rig.picture.motion().is_moving());
    rig.picture.returned(&request.frame());
    assert!(!rig.picture.motion().is_moving());
    rig.picture.program_runs(true);
    assert!(rig.picture.motion().is_moving() && !rig.picture.motion().stopped());
}

#[test]
fn queue_counts_as_running_once_its_start_is_sent() {
    let mut rig = running();
    rig.set(QueuedCmdStopExec {});
    rig.queue(move_away());
    assert!(!rig.picture.motion().is_moving() && rig.picture.motion().stopped());
    let start = FrameBuf::set(&QueuedCmdStartExec {}.into(), Ctrl::SET).unwrap();
    rig.picture.sent(rig.pair.now, &start.frame());
    assert!(rig.picture.motion().is_moving());
    assert_eq!(rig.picture.motion().started(), None);
}

#[test]
fn uncertain_command_is_in_flight_until_the_queue_is_cleared_and_has_ended() {
    let mut rig = running();
    let request = FrameBuf::set(&move_away(), Ctrl::QUEUED).unwrap();
    let failure = Failure::Uncertain {
        from: None,
        to: None,
    };
    for request in [Some(&request.frame()), None] {
        rig.picture.failed(request, &failure);
        rig.read::<QueuedCmdCurrentIndex>();
        assert!(rig.picture.motion().is_moving());
        rig.picture.reset();
        assert!(!rig.picture.motion().is_moving());
    }
    rig.picture
        .failed(Some(&request.frame()), &Failure::QueueFull);
    assert!(!rig.picture.motion().is_moving());
}

#[test]
fn stopped_arm_counts_as_braking_until_seen_at_rest() {
    let mut rig = running();
    rig.queue(move_away());
    rig.wait(SECOND / 5);
    assert!(rig.pair.arm.state().moving);
    let before = rig.picture.motion().stops();
    rig.set(QueuedCmdForceStopExec {});
    rig.picture.stood_after(before);
    assert!(rig.picture.motion().is_braking(), "that was before it");
    assert!(rig.picture.motion().stopped());
    let stops = rig.picture.motion().stops();
    rig.picture.stood_after(stops);
    assert!(!rig.picture.motion().is_braking() && rig.picture.motion().has_stood_after(stops));
    rig.picture.stop_asked();
    assert!(rig.picture.motion().is_braking());
}

#[test]
fn clear_drops_waiting_commands_and_keeps_the_current_one() {
    let mut rig = running();
    rig.queue(move_away());
    rig.queue(build::home());
    rig.queue(move_away());
    let first = current(&rig) + 1;
    assert_eq!(rig.picture.own().waiting(current(&rig), false), 3);
    assert!(rig.picture.own().homes(QueuedCmdIndex(first + 1)));
    rig.set(QueuedCmdClear {});
    assert_eq!(rig.picture.own().waiting(current(&rig), true), 0);
    assert!(rig.picture.motion().is_moving());
    rig.wait(5 * SECOND);
    rig.read::<QueuedCmdCurrentIndex>();
    assert!(!rig.picture.motion().is_moving());
}

#[test]
fn command_that_runs_is_known_unless_another_program_may_be_before_it() {
    let mut rig = running();
    let current = current(&rig);
    rig.queue(build::wait(Duration::from_secs(3)));
    let pause = QueuedPace::Pause(Duration::from_secs(3));
    let own = |rig: &PictureRig, current| rig.picture.own().running(current);
    assert_eq!(own(&rig, current), Some(pause));
    rig.picture.accepted(current + 3, Some(&move_away()));
    assert_eq!(own(&rig, current + 1), None, "one of another's comes first");
    rig.picture.queue_is_empty();
    rig.picture.accepted(current + 6, Some(&move_away()));
    assert_eq!(own(&rig, current + 3), Some(QueuedPace::Motion));
}

#[test]
fn commands_of_a_run_do_not_wait_for_the_next_start() {
    let mut rig = running();
    let current = current(&rig);
    rig.queue(move_away());
    rig.picture.accepted(current + 2, Some(&move_away()));
    assert_eq!(rig.picture.own().waiting(current, false), 1);
    assert_eq!(rig.picture.own().waiting(current, true), 2);
}

#[test]
fn reset_reports_the_dropped_indices_and_clears_the_picture() {
    let mut rig = running();
    let before = current(&rig);
    rig.queue(move_away());
    rig.queue(move_away());
    rig.set(build::motor(Stepper::Stepper1, 5_000));
    rig.read::<PtpCommonParams>();
    assert_eq!(rig.picture.motors().running().count(), 1);
    assert!(rig.picture.runs_queue());
    assert!(rig.picture.get::<PtpCommonParams>(0).is_some());
    assert_eq!(rig.picture.reset(), Some((before + 1, before + 2)));
    let picture = &rig.picture;
    assert!(!picture.motion().is_moving() && !picture.runs_queue());
    assert_eq!(picture.motors().held(true).count(), 0);
    assert_eq!(picture.own().waiting(before, true), 0);
    assert_eq!(picture.get::<PtpCommonParams>(0), None);
    assert_eq!(rig.picture.reset(), None);
}

#[test]
fn belt_runs_until_it_is_switched_off() {
    let mut rig = running();
    let running = |rig: &PictureRig| rig.picture.motors().running().collect::<Vec<_>>();
    rig.set(build::motor(Stepper::Stepper2, 5_000));
    assert_eq!(running(&rig), [Stepper::Stepper2]);
    rig.set(build::motor(Stepper::Stepper2, 0));
    assert_eq!(running(&rig), []);
}

#[test]
fn finished_foreign_command_discards_known_settings() {
    let mut rig = running();
    rig.queue(move_away());
    rig.wait(5 * SECOND);
    rig.read::<PtpCommonParams>();
    let seen = read_queue(&mut rig);
    let setting = |rig: &PictureRig| -> Option<PtpCommonParams> {
        rig.picture.setting(rig.pair.now, &NoArgs)
    };
    assert!(setting(&rig).is_some());
    let before = rig.picture.standing().writes_sent();
    let foreign = QueueLook {
        current: seen.current + 1,
        ..seen
    };
    rig.picture.note_look(foreign, before);
    assert_eq!(setting(&rig), None);
}

#[test]
fn known_setting_needs_visible_resets_and_expires_on_a_shared_line() {
    let mut rig = running();
    let setting = |rig: &PictureRig, after: Micros| -> Option<PtpCommonParams> {
        rig.picture.setting(rig.pair.now + after, &NoArgs)
    };
    rig.read::<PtpCommonParams>();
    rig.picture.reset();
    rig.read::<PtpCommonParams>();
    assert_eq!(
        setting(&rig, 0),
        None,
        "its index would be 0 after a reset, too"
    );
    rig.queue(move_away());
    assert!(setting(&rig, 60 * SECOND).is_some());
    rig.picture = rig.picture.on_shared_line(true);
    assert!(setting(&rig, SECOND / 2).is_some());
    assert_eq!(setting(&rig, 2 * SECOND), None);
}

#[test]
fn queue_reading_is_fresh_briefly_and_until_a_write() {
    let mut rig = running();
    read_queue(&mut rig);
    let fresh = |rig: &PictureRig, after| {
        rig.picture
            .standing()
            .fresh_look(rig.pair.now + after)
            .is_some()
    };
    assert!(fresh(&rig, SECOND / 20) && !fresh(&rig, SECOND / 5));
    rig.queue(move_away());
    assert!(!fresh(&rig, 0));
}

#[test]
fn rest_pose_is_known_until_the_arm_may_have_moved() {
    let mut rig = running();
    rig.queue(move_away());
    rig.wait(5 * SECOND);
    rig.read::<Pose>();
    let pose = rig.picture.snapshot().readings;
    assert_eq!(pose, None, "the left space was not read");
    let seen = read_queue(&mut rig);
    let pose = rig.picture.snapshot().readings.unwrap().pose;
    let left = |rig: &mut PictureRig| {
        let now = rig.pair.now;
        rig.picture.note_left_at(now, seen.current, pose);
    };
    let stands = |rig: &PictureRig, after: Micros| {
        let standing = rig.picture.standing().pose(rig.pair.now + after, &seen);
        (
            standing.is_some(),
            rig.picture.standing().was_left_at(&pose, &seen),
        )
    };
    left(&mut rig);
    assert_eq!(stands(&rig, 0), (true, true));
    assert_eq!(
        stands(&rig, 2 * SECOND),
        (false, true),
        "a hand may move it"
    );
    let later = QueueLook {
        current: seen.current + 1,
        ..seen
    };
    assert!(rig.picture.standing().pose(rig.pair.now, &later).is_none());
    // With another tool the tip is elsewhere, and a reading shows where.
    rig.set(build::tool(crate::ToolBias::PEN));
    assert_eq!(stands(&rig, 0), (false, true));
    left(&mut rig);
    rig.set(move_away());
    assert_eq!(
        stands(&rig, 0),
        (false, false),
        "it moves outside of the queue"
    );
}

#[test]
fn alarms_are_believed_for_a_second_unless_one_holds_the_queue_or_they_were_cleared() {
    let mut rig = running();
    let harmless = |rig: &PictureRig, after: Micros| {
        rig.picture.harmless_alarms(rig.pair.now + after).is_some()
    };
    rig.read::<AlarmsState>();
    assert!(harmless(&rig, SECOND / 2) && !harmless(&rig, 2 * SECOND));
    rig.set(ClearAllAlarmsState {});
    assert!(!harmless(&rig, 0));
    rig.set(QueuedCmdStartExec {});
    assert!(rig.picture.runs_queue());
    // A point out of reach raises an alarm that stops the queue.
    rig.queue(build::move_to(900.0, 0.0, 0.0, 0.0));
    rig.wait(SECOND);
    rig.read::<AlarmsState>();
    assert!(!harmless(&rig, 0) && !rig.picture.runs_queue());
    let raised = |event: &&PictureEvent| matches!(event, PictureEvent::AlarmRaised(_));
    assert_eq!(rig.events.iter().filter(raised).count(), 1);
}

#[test]
fn cleared_alarm_and_finished_commands_are_reported() {
    let mut rig = PictureRig::new(1);
    rig.read::<AlarmsState>();
    rig.read::<QueuedCmdCurrentIndex>();
    assert_eq!(rig.events, [], "a first reading shows no change");
    assert_eq!(rig.picture.homed(), Some(false));
    rig.set(ClearAllAlarmsState {});
    rig.read::<AlarmsState>();
    rig.set(QueuedCmdStartExec {});
    for _ in 0..3 {
        rig.queue(build::speed(50.0, 50.0));
    }
    rig.wait(SECOND);
    rig.read::<QueuedCmdCurrentIndex>();
    let last = QueuedCmdIndex(current(&rig));
    let first = QueuedCmdIndex(last.0 - 2);
    let cleared = PictureEvent::AlarmCleared(Alarm::ResetOccurred);
    assert_eq!(
        rig.events,
        [cleared, PictureEvent::Finished { first, last }]
    );
    assert_eq!(rig.picture.homed(), None);
}

#[test]
fn arm_that_was_seen_to_home_is_homed_until_the_line_is_lost() {
    let mut rig = running();
    rig.queue(build::home());
    rig.wait(60 * SECOND);
    rig.read::<QueuedCmdCurrentIndex>();
    assert!(rig.picture.homing().needs_alarms());
    rig.read::<AlarmsState>();
    assert_eq!(rig.picture.homed(), None);
    rig.read::<Pose>();
    assert_eq!(rig.picture.homed(), Some(true));
    assert!(rig.picture.take_new_homing() && !rig.picture.take_new_homing());
    rig.picture.lost();
    assert_eq!(rig.picture.homed(), None);
    rig.picture.remember_homing();
    assert_eq!(rig.picture.homed(), Some(true));
}

#[test]
fn laser_off_pose_of_a_stop_is_known_until_a_command_is_queued() {
    let mut rig = running();
    rig.queue(move_away());
    rig.wait(SECOND / 5);
    let stopped = rig.pair.now;
    rig.set(QueuedCmdForceStopExec {});
    rig.read::<Pose>();
    let seen = rig.picture.lights_out().unwrap();
    assert!(seen.stopped);
    assert_eq!(seen.late, Duration::from_micros(rig.pair.now - stopped));
    rig.wait(SECOND);
    rig.read::<Pose>();
    assert_eq!(
        rig.picture.lights_out(),
        Some(seen),
        "the first pose counts"
    );
    rig.picture.lost();
    assert_eq!(rig.picture.lights_out(), Some(seen));
    rig.queue(move_away());
    assert_eq!(rig.picture.lights_out(), None);
    rig.set(build::laser(false));
    rig.picture.lost();
    rig.read::<Pose>();
    assert_eq!(
        rig.picture.lights_out(),
        None,
        "the frame may not have arrived"
    );
}

#[test]
fn serial_number_stays_when_the_line_is_lost() {
    let mut rig = running();
    rig.read::<DeviceSn>();
    let serial = rig.picture.serial().map(str::to_owned);
    assert!(serial.is_some());
    rig.picture.lost();
    rig.picture.reset();
    assert_eq!(rig.picture.serial(), serial.as_deref());
}
