//! Permission checks below all front ends: lighting the laser of a real arm, unbounded jogs.
//!
//! They are made twice. Calls that take typed commands check them before anything is sent, to
//! report the command by name and step. Every frame is checked once more on its way to the driver
//! task, so that no call can bypass the check.

use magician_host::{check_power, frame_burns, frame_releases_queue};
use magician_protocol::{Frame, Row, Set};

use super::Arm;
use crate::gate::{frame_jogs, refuse_unheld, unheld_jog};
use crate::message;
use crate::{Error, Result};

/// Permissions of a handle, returned by [`Arm::permission`].
#[derive(Clone, Copy, Debug)]
pub struct Permission<'a> {
    arm: &'a Arm,
}

impl Arm {
    /// Returns the permissions of this handle.
    #[doc(hidden)]
    #[must_use]
    pub const fn permission(&self) -> Permission<'_> {
        Permission { arm: self }
    }
}

impl Permission<'_> {
    /// Checks commands before any of them is sent.
    ///
    /// Refuses jogs without a hold time, commands that burn without permission, and a duty or laser
    /// power out of range.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`], with [`ErrorCode::LaserNotAllowed`] or [`ErrorCode::Guarded`]
    /// for a missing permission.
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

    /// Refuses to start a queue that holds commands of another program unless the laser may burn,
    /// because those commands cannot be read back.
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
            // Any of them may light the laser.
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

    /// Checks a frame. Every request of every call is checked here.
    pub(super) fn check_frame(self, frame: &Frame<'_>) -> Result<()> {
        let ctrl = frame.ctrl();
        let row_may_burn = Row::with_id(frame.id()).is_some_and(|row| row.may_burn);
        // Decoding is only needed for the few commands with a power or a duty.
        if row_may_burn
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

    /// Checks as [`check_queue`](Self::check_queue) does if the frame starts the queue or lifts a
    /// hold on it.
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

    /// Refuses a frame that starts a jog without a hold time.
    pub(super) fn check_jog(self, frame: &Frame<'_>) -> Result<()> {
        if frame_jogs(frame) && !self.allows_raw_jogs() {
            Err(unheld_jog())
        } else {
            Ok(())
        }
    }

    /// Refuses a command that starts a jog without a hold time.
    pub(super) fn check_command(self, command: &Set) -> Result<()> {
        if self.allows_raw_jogs() {
            Ok(())
        } else {
            refuse_unheld(command)
        }
    }

    fn allows_raw_jogs(self) -> bool {
        // With bounded jogs even a handle for raw jogs is refused: nothing would end them.
        self.arm.passes_jogs && !self.arm.inner.options.bounded_jogs
    }
}
