//! State of the laser during a program, and the check that it does not burn in one place.

use magician_model::PtpMove;
use magician_protocol::Set;

use super::guards::refuse;
use super::readings::Readings;
use crate::Result;
use crate::message;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Laser {
    /// The switched laser is on.
    on: bool,
    /// The last segment of a path had power.
    along: bool,
}

/// Motion of the arm during a command, for a laser that is burning.
enum Doing {
    /// Stands still for a while.
    Standing(crate::Message),
    /// Moves by joints, along an unknown curve.
    Travelling,
    /// Moves along a line or arc.
    Drawing,
    /// Takes no time, or is a segment with its own power.
    Other,
}

impl Doing {
    fn of(command: &Set) -> Self {
        if let Some(ptp) = PtpMove::from_command(command) {
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

    /// True if the laser may burn.
    pub(super) fn burns(self) -> bool {
        self.on || self.along
    }

    /// Refuses a command during which the laser would burn where it should not.
    pub(super) fn check(self, command: &Set, guard: bool) -> Result<()> {
        let doing = match Doing::of(command) {
            Doing::Standing(doing) if self.burns() => doing,
            Doing::Travelling if self.burns() => message!("travels"),
            // The power of a path applies to its segments; on other lines the firmware's behaviour
            // is unknown.
            Doing::Drawing if self.along => message!("leaves the path that it burns"),
            _ => return Ok(()),
        };
        let why = message!(
            "the laser would burn while the arm {doing}: switch it off first",
            doing
        );
        refuse(guard, "laser", why)
    }

    /// State of the laser after a command.
    pub(super) fn after(self, command: &Set) -> Self {
        match command {
            Set::SetEndEffectorLaser(laser) => {
                let on = laser.enable_ctrl.is_on() && laser.on.is_on();
                // Switching off ends the power of a path, too; switching on leaves it.
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
