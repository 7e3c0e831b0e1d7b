//! Homing since power-up, derived from the traffic of one connection.
//!
//! The protocol has no query for it, and an arm that was not homed moves to wrong positions. So a
//! homing is accepted only on evidence: its command finished, no blocking alarm was raised, and the
//! arm stands at its home point.

use magician_protocol::commands::{HomeCmd, Pose, QueuedCmdClear, QueuedCmdForceStopExec};
use magician_protocol::{Alarm, AlarmSet, Frame, Row, Set, Writable};

/// Home point of the firmware: J1 to J3, deg (model section 11).
// J4 belongs to the tool, which an arm may lack.
const HOME_JOINTS: [f32; 3] = [0.0, 45.0, 45.0];
/// Largest deviation from the home point after a homing, deg.
// A choice: 2.5 mm at the tip, more than the error of homing and less than the distance to any
// other pose in use.
const AT_HOME: f32 = 0.5;

/// Homing state of one arm, as a connection sees it.
///
/// The home point must be checked because a stop by another program also makes the index count the
/// command as finished. If other motions were queued behind the homing, the arm has left the home
/// point, which is then not checked: a stop would show in the queue, because it drops these
/// motions.
///
/// Only queued homing can be followed: an immediate one has no index that shows its end.
#[derive(Clone, Debug, Default)]
pub struct HomingTracker {
    stage: Stage,
    /// Alarms of the last reading.
    alarms: Option<AlarmSet>,
    /// Alarms active when homing was sent: homing may run and end under them.
    before: AlarmSet,
    /// True if a homing was seen and not recorded yet.
    is_new: bool,
    /// True if motions were queued behind the homing, so that the arm's pose says nothing about it.
    followed: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    /// No homing was seen, or the arm was reset since.
    #[default]
    Unknown,
    /// A homing command was sent; its index is unknown.
    Sent,
    /// The homing command waits or runs under this index.
    Queued(u64),
    /// The homing command has finished; the alarms have yet to show whether it was aborted.
    Ended,
    /// No alarm aborted it; the pose has yet to show that the arm is at its home point.
    PoseUnchecked,
    /// The arm is homed.
    Homed,
}

impl HomingTracker {
    /// Processes a sent request.
    pub(super) fn sent(&mut self, request: &Frame<'_>) {
        let (ctrl, id) = (request.ctrl(), request.id());
        if !ctrl.write() {
            return;
        }
        if id == HomeCmd::ROW.id {
            // Until it has found its switch, a homing arm does not know its base angle, even if it
            // did before.
            self.before = self.alarms.unwrap_or_default();
            self.followed = false;
            self.set(Stage::Sent);
            return;
        }
        let drops = [QueuedCmdClear::ROW.id, QueuedCmdForceStopExec::ROW.id].contains(&id);
        let moves = Row::with_id(id).is_some_and(|row| row.effect.moves_arm());
        // A stop, or a motion outside the queue, aborts homing; the index counts it as finished
        // nevertheless.
        if self.is_under_way() && (drops || moves && !ctrl.queued()) {
            self.set(Stage::Unknown);
        }
        self.followed |= moves && ctrl.queued();
    }

    /// Notes that the arm accepted a queued command with this index.
    pub(super) fn accepted(&mut self, index: u64, command: &Set) {
        if self.stage == Stage::Sent && matches!(command, Set::HomeCmd(_)) {
            self.stage = Stage::Queued(index);
        }
    }

    /// Processes the index of the command finished last.
    pub(super) fn read_current(&mut self, current: u64) {
        if matches!(self.stage, Stage::Queued(index) if index <= current) {
            self.stage = Stage::Ended;
        }
    }

    /// Processes a reading of the alarms.
    pub(super) fn read_alarms(&mut self, alarms: AlarmSet) {
        let before = self.alarms.replace(alarms);
        let is_set = |alarms: &AlarmSet| alarms.contains(Alarm::ResetOccurred);
        // An alarm that was active all along is not new: homing does not clear it.
        if is_set(&alarms) && before.is_some_and(|before| !is_set(&before)) {
            self.set(Stage::Unknown);
        }
        if self.stage != Stage::Ended {
            return;
        }
        let mut raised = alarms.codes().filter(|code| !self.before.contains(*code));
        if raised.any(Alarm::blocks) {
            self.set(Stage::Unknown);
        } else {
            self.set(Stage::PoseUnchecked);
            // The arm has moved on, and a stop would have dropped those motions.
            if self.followed {
                self.stood_at_home(true);
            }
        }
    }

    /// Processes a pose. A pose at the firmware's home point confirms the homing. Any other pose
    /// leaves it open, because the arm may have another home point; the caller then calls
    /// [`stood_at_home`](Self::stood_at_home).
    pub(super) fn read_pose(&mut self, pose: &Pose) {
        let turned = { pose.joint_angle.iter().zip(HOME_JOINTS) }.map(|(joint, home)| joint - home);
        if { turned }.all(|angle| angle.abs() <= AT_HOME) {
            self.stood_at_home(true);
        }
    }

    /// Notes whether the arm stands at its home point after the homing command.
    pub(super) fn stood_at_home(&mut self, at_home: bool) {
        match (self.stage, at_home) {
            (Stage::PoseUnchecked, true) => {
                self.set(Stage::Homed);
                self.is_new = true;
            }
            (Stage::PoseUnchecked, false) => self.set(Stage::Unknown),
            // In every other stage the position proves nothing about homing.
            _ => {}
        }
    }

    /// Notes a record from before this connection that the arm was homed since power-up.
    pub(super) fn remembered(&mut self) {
        // A homing under way counts more than the record.
        if self.stage == Stage::Unknown {
            self.set(Stage::Homed);
        }
    }

    /// Discards the state: the arm was reset, or may be another one.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// True if the arm was homed since power-up.
    #[must_use]
    pub fn is_homed(&self) -> bool {
        self.stage == Stage::Homed
    }

    /// True if a homing has finished and the alarms decide whether it counts.
    #[must_use]
    pub fn needs_alarms(&self) -> bool {
        self.stage == Stage::Ended
    }

    /// True if a homing has finished without an alarm and the arm's position decides whether it
    /// counts.
    #[must_use]
    pub fn needs_place(&self) -> bool {
        self.stage == Stage::PoseUnchecked
    }

    /// Returns true once for each homing that was seen.
    pub(super) fn take_new(&mut self) -> bool {
        std::mem::take(&mut self.is_new) && self.is_homed()
    }

    fn is_under_way(&self) -> bool {
        matches!(self.stage, Stage::Sent | Stage::Queued(_))
    }

    fn set(&mut self, stage: Stage) {
        (self.stage, self.is_new) = (stage, false);
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::{Ctrl, FrameBuf};

    use super::*;
    use crate::build;

    const LOST_STEP: u8 = Alarm::LoseStepAxis1;

    fn alarms(codes: &[u8]) -> AlarmSet {
        let mut set = AlarmSet::default();
        codes.iter().for_each(|code| set.insert(*code));
        set
    }

    fn sends(homing: &mut HomingTracker, command: impl Into<Set>, ctrl: Ctrl) {
        let frame = FrameBuf::set(&command.into(), ctrl).unwrap();
        homing.sent(&frame.frame());
    }

    /// Tracker of an arm whose homing is queued under index 3.
    fn homing_under_way(standing: &[u8]) -> HomingTracker {
        let mut homing = HomingTracker::default();
        homing.read_alarms(alarms(standing));
        sends(&mut homing, build::home(), Ctrl::QUEUED);
        homing.accepted(3, &build::home());
        homing
    }

    fn ends(mut homing: HomingTracker, standing: &[u8]) -> HomingTracker {
        homing.read_current(3);
        assert!(!homing.is_homed());
        homing.read_alarms(alarms(standing));
        homing.stood_at_home(true);
        homing
    }

    #[test]
    fn homing_that_ends_under_the_alarms_of_its_start_counts() {
        for standing in [&[][..], &[0x00], &[LOST_STEP], &[0x00, LOST_STEP]] {
            let mut homing = ends(homing_under_way(standing), standing);
            assert!(homing.is_homed(), "{standing:?}");
            assert!(homing.take_new() && !homing.take_new());
        }
    }

    #[test]
    fn homing_that_ends_away_from_the_home_point_does_not_count() {
        let ended = |queue_behind: bool| {
            let mut homing = homing_under_way(&[]);
            if queue_behind {
                let behind = build::move_to(220.0, 0.0, 20.0, 0.0);
                sends(&mut homing, behind, Ctrl::QUEUED);
            }
            homing.read_current(3);
            homing.read_alarms(alarms(&[]));
            homing.stood_at_home(false);
            homing
        };
        assert!(!ended(false).is_homed());
        assert!(ended(true).is_homed(), "it has gone on from there");
    }

    #[test]
    fn homing_that_raises_a_blocking_alarm_does_not_count() {
        assert!(!ends(homing_under_way(&[0x00]), &[0x00, LOST_STEP]).is_homed());
    }

    #[test]
    fn aborted_homing_does_not_count() {
        use magician_protocol::JogCommand;
        use magician_protocol::commands::{JogCmd, QueuedCmdStopExec};
        let jog = JogCmd {
            is_joint: magician_protocol::Flag::ON,
            cmd: JogCommand::Axis1Plus,
        };
        let aborting: [Set; 4] = [
            QueuedCmdClear {}.into(),
            QueuedCmdForceStopExec {}.into(),
            jog.into(),
            build::move_to(220.0, 0.0, 20.0, 0.0),
        ];
        for command in aborting {
            let mut homing = homing_under_way(&[]);
            sends(&mut homing, command, Ctrl::SET);
            assert!(!ends(homing, &[]).is_homed(), "{command:?}");
        }
        let mut homing = homing_under_way(&[]);
        sends(&mut homing, QueuedCmdStopExec {}, Ctrl::SET);
        sends(
            &mut homing,
            build::move_to(220.0, 0.0, 20.0, 0.0),
            Ctrl::QUEUED,
        );
        assert!(ends(homing, &[]).is_homed(), "what waits behind it");
    }

    #[test]
    fn homed_arm_that_homes_again_is_not_homed_meanwhile() {
        let mut homing = ends(homing_under_way(&[]), &[]);
        sends(&mut homing, build::home(), Ctrl::QUEUED);
        assert!(!homing.is_homed());
        sends(&mut homing, QueuedCmdForceStopExec {}, Ctrl::SET);
        assert!(!homing.is_homed());
    }

    #[test]
    fn immediate_homing_never_counts() {
        let mut homing = HomingTracker::default();
        sends(&mut homing, build::home(), Ctrl::SET);
        homing.read_current(9);
        homing.read_alarms(alarms(&[]));
        homing.stood_at_home(true);
        assert!(!homing.is_homed());
    }

    #[test]
    fn new_reset_alarm_ends_homed_state_and_standing_one_does_not() {
        let mut homing = ends(homing_under_way(&[0x00]), &[0x00]);
        homing.read_alarms(alarms(&[0x00]));
        assert!(homing.is_homed());
        homing.read_alarms(alarms(&[]));
        homing.read_alarms(alarms(&[0x00]));
        assert!(!homing.is_homed());
    }

    #[test]
    fn earlier_record_counts_unless_homing_is_under_way() {
        let mut homing = HomingTracker::default();
        homing.remembered();
        assert!(homing.is_homed() && !homing.take_new());
        let mut homing = homing_under_way(&[]);
        homing.remembered();
        assert!(!homing.is_homed());
        homing.forget();
        assert!(!homing.is_homed());
    }
}
