//! What the calls of a handle may do: light the laser of a real arm, start a jog that nothing holds.

use magician_host::{check_power, frame_burns, frame_releases_queue};
use magician_protocol::{Frame, Row, Set};

use super::Arm;
use crate::gate::{frame_jogs, refuse_unheld, unheld_jog};
use crate::message;
use crate::{Error, Result};

/// Permission of a handle: [`Arm::permission`] hands it out.
#[derive(Clone, Copy, Debug)]
pub struct Permission<'a> {
    arm: &'a Arm,
}

impl Arm {
    /// What calls of this handle may do.
    #[doc(hidden)]
    #[must_use]
    pub const fn permission(&self) -> Permission<'_> {
        Permission { arm: self }
    }
}

impl Permission<'_> {
    /// Refuses commands of which one would start a jog that nothing holds, would burn where that is not allowed, or has a duty or a
    /// laser power out of its range; nothing is sent.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`], with [`ErrorCode::LaserNotAllowed`] or [`ErrorCode::Guarded`] for what is not allowed.
    pub fn check<'a>(self, commands: impl IntoIterator<Item = &'a Set>) -> Result<()> {
        let may_burn = self.arm.laser().may_burn();
        commands.into_iter().try_for_each(|command| {
            check_power(command)?;
            self.check_command(command)?;
            if !may_burn && self.arm.laser().burns(command) {
                Err(self.refusal().with_command(command.row().set_name))
            } else {
                Ok(())
            }
        })
    }

    /// Refuses to let a queue run in which commands of another program wait, where the laser may not burn:
    /// they cannot be read there.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] with [`ErrorCode::LaserNotAllowed`], else as [`get`](Arm::get).
    pub async fn check_queue(self) -> Result<()> {
        if self.arm.laser().may_burn() {
            return Ok(());
        }
        match self
            .arm
            .queue()
            .foreign_commands(&self.arm.known().look_at_queue().await?)
        {
            0 => Ok(()),
            count => {
                let name = self.arm.name();
                Err(Error::burning(match count {
                    1 => message!(
                        "1 command in the queue of the arm at {name} that this program did not put there could \
                            light its laser; nothing was sent",
                        name
                    ),
                    _ => message!(
                        "{count} commands in the queue of the arm at {name} that this program did not put there could \
                            light its laser; nothing was sent",
                        count,
                        name
                    ),
                }))
            }
        }
    }

    /// The same for a frame: the net below all doors.
    pub(super) fn check_frame(self, frame: &Frame<'_>) -> Result<()> {
        let ctrl = frame.ctrl();
        let may = Row::with_id(frame.id()).is_some_and(|row| row.may_burn);
        if may
            && (ctrl.write() || ctrl.queued())
            && let Ok(command) = Set::decode(frame.id(), frame.params())
        {
            check_power(&command)?;
        }
        if !self.arm.laser().may_burn() && frame_burns(frame, self.arm.inner.options.laser_pins) {
            Err(self.refusal())
        } else {
            Ok(())
        }
    }

    /// As [`check_queue`](Self::check_queue), for a frame that lets the queue run.
    pub(super) async fn check_release(self, frame: &Frame<'_>) -> Result<()> {
        if frame_releases_queue(frame) {
            self.check_queue().await
        } else {
            Ok(())
        }
    }

    fn refusal(self) -> Error {
        let name = self.arm.name();
        Error::burning(message!(
            "this lights the laser of the arm at {name}; nothing was sent",
            name
        ))
    }

    /// Refuses a jog that nothing holds; nothing is sent.
    pub(super) fn check_jog(self, frame: &Frame<'_>) -> Result<()> {
        if frame_jogs(frame) && !self.lets_jogs_pass() {
            Err(unheld_jog())
        } else {
            Ok(())
        }
    }

    /// Refuses a command that starts a jog that nothing holds.
    pub(super) fn check_command(self, command: &Set) -> Result<()> {
        if self.lets_jogs_pass() {
            Ok(())
        } else {
            refuse_unheld(command)
        }
    }

    fn lets_jogs_pass(self) -> bool {
        self.arm.passes_jogs && !self.arm.inner.options.bounded_jogs
    }
}
