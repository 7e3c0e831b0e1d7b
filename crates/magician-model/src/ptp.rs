//! Point-to-point commands as requests for the planner (document 1.10, model section 7).

use magician_motion::{JointAngles, JumpHeights, Move, MoveKind, Pose, Target, Transfer};
use magician_protocol::commands::{PtpCmd, PtpPoCmd, PtpPoWithLCmd, PtpWithLCmd};
use magician_protocol::{PoList, PtpMode, Set};

/// A point-to-point move, from any of the four commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PtpMove {
    /// Kind of travel, and meaning of `numbers`.
    pub mode: PtpMode,
    /// x, y, z and r (mm, deg), or J1 to J4 (deg).
    pub numbers: [f32; 4],
    /// Rail position or, in a relative mode, displacement on the rail, mm. `None` if the command
    /// has none.
    pub rail: Option<f32>,
    /// Outputs switched on the way. `None` if the command has none.
    pub outputs: Option<PoList>,
}

impl PtpMove {
    /// The move of a command. `None` for commands other than the four.
    #[must_use]
    pub fn from_command(command: &Set) -> Option<Self> {
        Some(match command {
            Set::PtpCmd(ptp) => ptp.into(),
            Set::PtpWithLCmd(ptp) => ptp.into(),
            Set::PtpPoCmd(ptp) => ptp.into(),
            Set::PtpPoWithLCmd(ptp) => ptp.into(),
            _ => return None,
        })
    }

    /// Request for the planner, with these jump heights (errata E28). `None` for an unknown mode.
    #[must_use]
    pub fn request(&self, heights: JumpHeights) -> Option<Move> {
        let numbers = self.numbers.map(f64::from);
        let (pose, joints) = (Pose::from(numbers), JointAngles::from(numbers));
        let target = match (self.mode.is_pose(), self.mode.is_relative()) {
            (true, false) => Target::Pose(pose),
            (true, true) => Target::PoseIncrement(pose),
            (false, false) => Target::Joints(joints),
            (false, true) => Target::JointIncrement(joints),
        };
        let kind = match self.mode {
            PtpMode::JumpXyz | PtpMode::JumpAngle => MoveKind::Jump(heights, Transfer::Joint),
            PtpMode::JumpMovlXyz => MoveKind::Jump(heights, Transfer::Line),
            PtpMode::MovlXyz | PtpMode::MovlAngle | PtpMode::MovlXyzInc => MoveKind::Line,
            PtpMode::MovjXyz | PtpMode::MovjAngle | PtpMode::MovjAngleInc | PtpMode::MovjXyzInc => {
                MoveKind::Joint
            }
            PtpMode::Unknown(_) => return None,
        };
        Some(Move { target, kind })
    }

    /// Pose at the end of the move. `None` for relative and joint modes.
    #[must_use]
    pub fn pose(&self) -> Option<[f32; 4]> {
        self.mode.is_absolute_pose().then_some(self.numbers)
    }
}

macro_rules! moves {
    ($($command:ident, |$ptp:ident| $rail:expr, $outputs:expr;)+) => {$(
        impl From<&$command> for PtpMove {
            fn from($ptp: &$command) -> Self {
                Self {
                    mode: $ptp.ptp_mode,
                    numbers: [$ptp.x, $ptp.y, $ptp.z, $ptp.r],
                    rail: $rail,
                    outputs: $outputs,
                }
            }
        }
    )+};
}

moves! {
    PtpCmd, |ptp| None, None;
    PtpWithLCmd, |ptp| Some(ptp.l), None;
    PtpPoCmd, |ptp| None, Some(ptp.po);
    PtpPoWithLCmd, |ptp| Some(ptp.l), Some(ptp.po);
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHTS: JumpHeights = JumpHeights::even(20.0, 100.0);
    const NUMBERS: [f32; 4] = [1.0, 2.0, 3.0, 4.0];

    fn request(mode: u8) -> Option<Move> {
        let [x, y, z, r] = NUMBERS;
        let ptp_mode = PtpMode::from(mode);
        let command = PtpCmd {
            ptp_mode,
            x,
            y,
            z,
            r,
        };
        PtpMove::from_command(&command.into())?.request(HEIGHTS)
    }

    /// Follows the table of errata E28.
    #[test]
    fn each_mode_maps_to_its_target_and_kind() {
        let numbers = NUMBERS.map(f64::from);
        let (pose, joints) = (Target::Pose(numbers.into()), Target::Joints(numbers.into()));
        let by = Target::PoseIncrement(numbers.into());
        let jump = |transfer| MoveKind::Jump(HEIGHTS, transfer);
        let modes = [
            (pose, jump(Transfer::Joint)),
            (pose, MoveKind::Joint),
            (pose, MoveKind::Line),
            (joints, jump(Transfer::Joint)),
            (joints, MoveKind::Joint),
            (joints, MoveKind::Line),
            (Target::JointIncrement(numbers.into()), MoveKind::Joint),
            (by, MoveKind::Line),
            (by, MoveKind::Joint),
            (pose, jump(Transfer::Line)),
        ];
        for (mode, (target, kind)) in (0..).zip(modes) {
            assert_eq!(request(mode), Some(Move { target, kind }), "mode {mode}");
            let mode = PtpMode::from(mode);
            let is_pose = matches!(target, Target::Pose(_) | Target::PoseIncrement(_));
            let is_absolute = matches!(target, Target::Pose(_) | Target::Joints(_));
            assert_eq!((mode.is_pose(), mode.is_joint()), (is_pose, !is_pose));
            assert_eq!(
                (mode.is_absolute(), mode.is_relative()),
                (is_absolute, !is_absolute)
            );
            assert_eq!(mode.is_jump(), matches!(kind, MoveKind::Jump(..)));
            assert_eq!(mode.is_line(), kind == MoveKind::Line);
        }
        assert_eq!(request(10), None);
        let unknown = PtpMode::from(10);
        assert!(!unknown.is_absolute() && !unknown.is_relative() && !unknown.is_line());
    }
}
