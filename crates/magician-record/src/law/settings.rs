//! Speeds that a session uses: those of power-up, and its own settings.

use magician_model::{MotionSettings, PtpMove};
use magician_protocol::commands::{CpCommonParams, PtpCoordinateParams, Set};
use magician_protocol::{Direction, Flag, Frame, PtpMode, Request};
use magician_sim::Profile;

use super::{Kind, Speeds};
use crate::replay::Replay;

/// Speeds of the motions in a session, each once, in order of first use.
///
/// A setting applies from its frame on. That matches the arm, because queued settings take effect
/// in the order of the queue.
pub(super) fn speeds(session: &Replay<'_>, profile: &Profile) -> Vec<Speeds> {
    let mut settings = Settings::new(profile);
    let mut all: Vec<Speeds> = Vec::new();
    for packet in session.packets() {
        let request = packet.direction == Some(Direction::Request);
        let frame = Frame::new(packet.bytes).filter(|_| request);
        let Some(Ok(Request::Set(set) | Request::Queue(set))) = frame.as_ref().map(Request::decode)
        else {
            continue;
        };
        for speeds in settings.take(&set) {
            if !all.contains(&speeds) {
                all.push(speeds);
            }
        }
    }
    all
}

#[derive(Clone, Debug)]
struct Settings {
    motion: MotionSettings,
    cp_common: CpCommonParams,
}

impl Settings {
    fn new(profile: &Profile) -> Self {
        let cp = &profile.defaults.cp;
        Self {
            motion: MotionSettings::at_power_up(&profile.arm_model()),
            cp_common: CpCommonParams {
                velocity_ratio: cp.velocity_ratio,
                acceleration_ratio: cp.acceleration_ratio,
            },
        }
    }

    /// Applies a setting; returns the speeds of a motion.
    fn take(&mut self, set: &Set) -> Vec<Speeds> {
        self.motion.apply(set);
        if let Some(ptp) = PtpMove::from_command(set) {
            return self.moves(ptp.mode);
        }
        match set {
            Set::CpCommonParams(set) => self.cp_common = *set,
            Set::JogCmd(jog) => {
                let Some((axis, _)) = jog.cmd.axis() else {
                    return Vec::new();
                };
                return if jog.is_joint == Flag::OFF {
                    vec![self.jog_of(
                        if axis < 3 {
                            Kind::JogSpace
                        } else {
                            Kind::JogRotation
                        },
                        self.motion.jog_coordinate.velocity[axis],
                        self.motion.jog_coordinate.acceleration[axis],
                    )]
                } else {
                    vec![self.jog_of(
                        Kind::JogJoint,
                        self.motion.jog_joint.velocity[axis],
                        self.motion.jog_joint.acceleration[axis],
                    )]
                };
            }
            Set::CpCmd(_) | Set::CpLeCmd(_) => {
                let ratios = [
                    self.cp_common.velocity_ratio,
                    self.cp_common.acceleration_ratio,
                ];
                return vec![scaled(
                    Kind::Path,
                    self.motion.cp.junction_vel,
                    self.motion.cp.plan_acc,
                    ratios,
                )];
            }
            // Arcs use the speeds of lines (model section 9).
            Set::ArcCmd(_) | Set::CircleCmd(_) => return vec![self.line(Kind::Arc)],
            // Any other command sets nothing that a speed depends on.
            _ => {}
        }
        Vec::new()
    }

    /// Speeds of a jog. The ratio scales the speed but not the acceleration (model section 6).
    fn jog_of(&self, kind: Kind, speed: f32, acceleration: f32) -> Speeds {
        scaled(
            kind,
            speed,
            acceleration,
            [self.motion.jog_common.velocity_ratio, 100.0],
        )
    }

    /// Speeds of moves along lines.
    fn line(&self, kind: Kind) -> Speeds {
        let ratios = [
            self.motion.ptp_common.velocity_ratio,
            self.motion.ptp_common.acceleration_ratio,
        ];
        let PtpCoordinateParams {
            xyz_velocity,
            xyz_acceleration,
            ..
        } = self.motion.ptp_coordinate;
        scaled(kind, xyz_velocity, xyz_acceleration, ratios)
    }

    fn moves(&self, mode: PtpMode) -> Vec<Speeds> {
        let ratios = [
            self.motion.ptp_common.velocity_ratio,
            self.motion.ptp_common.acceleration_ratio,
        ];
        let line = || self.line(Kind::Line);
        let joints = || {
            let joint = &self.motion.ptp_joint;
            let pairs = joint.velocity.into_iter().zip(joint.acceleration);
            let mut all: Vec<Speeds> = Vec::new();
            for (speed, acceleration) in pairs {
                let speeds = scaled(Kind::Joints, speed, acceleration, ratios);
                if !all.contains(&speeds) {
                    all.push(speeds);
                }
            }
            all
        };
        match mode {
            mode if mode.is_line() => vec![line()],
            PtpMode::MovjXyz | PtpMode::MovjAngle | PtpMode::MovjAngleInc | PtpMode::MovjXyzInc => {
                joints()
            }
            // A jump lifts and descends along lines, or by joints.
            _ => std::iter::once(line()).chain(joints()).collect(),
        }
    }
}

fn scaled(kind: Kind, speed: f32, acceleration: f32, [faster, steeper]: [f32; 2]) -> Speeds {
    // Ratios above 100 count as 100 (model section 6).
    let share = |value: f32, ratio: f32| f64::from(value) * f64::from(ratio.min(100.0)) / 100.0;
    Speeds {
        kind,
        acceleration: share(acceleration, steeper),
        speed: Some(share(speed, faster)),
        ratio: Some(f64::from(faster)),
    }
}
