//! Where the laser burns, as far as the program tells.

use magician_model::PtpMove;
use magician_protocol::Set;

use super::guards::refuse;
use super::readings::Readings;
use crate::Result;
use crate::message;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Laser {
    /// It was switched on.
    on: bool,
    /// The last segment of a path had power.
    along: bool,
}

/// What the arm does during a command, for a laser that burns meanwhile.
enum Doing {
    /// It stands for a while.
    Standing(crate::Message),
    /// It goes somewhere with its joints.
    Travelling,
    /// It draws a line.
    Drawing,
    /// Nothing that takes time, or a segment that says itself what the laser does.
    Other,
}

impl Doing {
    fn of(command: &Set) -> Self {
        if let Some(ptp) = PtpMove::of(command) {
            return if ptp.mode.is_line() {
                Self::Drawing
            } else {
                Self::Travelling
            };
        }
        match command {
            Set::WaitCmd(wait) if wait.timeout > 0 => Self::Standing(message!("waits")),
            Set::TrigCmd(_) => Self::Standing(message!("waits for an input")),
            Set::EMotorS(motor) if motor.is_enabled.is_on() => {
                Self::Standing(message!("waits for a motor"))
            }
            Set::HomeCmd(_) => Self::Standing(message!("homes")),
            Set::JogCmd(_) => Self::Travelling,
            Set::ArcCmd(_) | Set::CircleCmd(_) => Self::Drawing,
            _ => Self::Other,
        }
    }
}

impl Laser {
    pub(super) fn reported(readings: &Readings) -> Self {
        let laser = &readings.laser;
        Self {
            on: laser.is_ctrl_enabled.is_on() && laser.is_on.is_on(),
            along: false,
        }
    }

    /// Whether it may burn.
    pub(super) fn burns(self) -> bool {
        self.on || self.along
    }

    /// Whether it may burn during this command.
    pub(super) fn check(self, command: &Set, guard: bool) -> Result<()> {
        let doing = match Doing::of(command) {
            Doing::Standing(doing) if self.burns() => doing,
            Doing::Travelling if self.burns() => message!("travels"),
            Doing::Drawing if self.along => message!("leaves the path that it burns"),
            _ => return Ok(()),
        };
        let why = message!(
            "the laser would burn while the arm {doing}: switch it off first",
            doing
        );
        refuse(guard, "laser", why)
    }

    /// The laser after a command.
    pub(super) fn after(self, command: &Set) -> Self {
        match command {
            Set::SetEndEffectorLaser(laser) => {
                let on = laser.enable_ctrl.is_on() && laser.on.is_on();
                let along = on && self.along;
                Self { on, along }
            }
            Set::CpLeCmd(segment) => Self {
                along: segment.velocity_or_power > 0.0,
                ..self
            },
            Set::CpCmd(_) => Self {
                along: false,
                ..self
            },
            _ => self,
        }
    }
}
