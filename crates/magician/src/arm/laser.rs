//! Permission to light the laser, its state, and switching it off.
//!
//! A laser may be lit by three means: the laser command, the burning commands of a path, and the
//! pins EIO 2 and 4 that it may be wired to. The driver cannot see the light. It combines what this
//! connection has sent with what the arm reports, and errs towards on: while commands that may burn
//! are in flight it counts as lit.

use magician_protocol::commands::{
    EndEffectorLaser, GetIoDo, GetIoMultiplexing, GetIoPwm, IoDo, IoMultiplexing, IoPwm,
};
use magician_protocol::{Flag, IoFunction, Set};

use super::{Arm, Shared};
use crate::build;
use crate::connection::Request;
use crate::message;
use crate::{Action, Error, ErrorCode, ErrorKind, LaserOffPose, Result};
use magician_host::{LASER_POWER, LASER_SUPPLY, burns};

/// Pins that a laser may be wired to.
const PINS: [u8; 2] = [LASER_SUPPLY, LASER_POWER];

/// Laser of an arm: permission to burn, state, and switching off. Returned by [`Arm::laser`].
#[derive(Clone, Copy, Debug)]
pub struct Laser<'a> {
    pub(super) arm: &'a Arm,
}

impl Arm {
    /// Returns the laser.
    ///
    /// ```
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> magician::Result<()> {
    /// let arm = magician::Arm::connect("sim").await?;
    /// assert_eq!(arm.laser().is_on().await?, Some(false));
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub const fn laser(&self) -> Laser<'_> {
        Laser { arm: self }
    }

    /// Returns a handle of the same connection whose calls may light the laser; see
    /// [`Options::allow_laser`](super::Options::allow_laser). Ask a person before using it.
    #[must_use]
    pub fn allowing_laser(&self) -> Self {
        Self {
            allows_laser: true,
            ..self.clone()
        }
    }

    /// True if the arm is virtual, so that nothing burns: it is in this process, or
    /// [`Options::virtual_arm`](super::Options::virtual_arm) says so. Any other arm counts as real,
    /// because a virtual one behind a line looks the same.
    #[must_use]
    pub fn is_virtual(&self) -> bool {
        self.inner.in_process || self.inner.options.virtual_arm
    }
}

impl Laser<'_> {
    /// True if calls of this handle may light the laser, or if the arm is virtual.
    #[must_use]
    pub fn may_burn(self) -> bool {
        self.arm.allows_laser || self.arm.is_virtual()
    }

    /// True if this command may light the laser of this arm: [`burns`](fn@crate::burns) for the
    /// pins of [`Options::laser_pins`](super::Options::laser_pins).
    #[must_use]
    pub fn burns(self, command: &Set) -> bool {
        burns(command, self.arm.inner.options.laser_pins)
    }
}

/// State of the laser.
impl Laser<'_> {
    /// Returns whether the laser is on, as far as this can be known.
    ///
    /// True while commands of this connection that light it may be in progress, and if the arm
    /// reports the laser or one of its pins as on. `None` if the arm does not report it, and while
    /// commands of another program are in the queue: they may burn, and cannot be read back.
    ///
    /// # Errors
    /// Same as [`get`](Arm::get); readings that some arms do not support are no error.
    pub async fn is_on(self) -> Result<Option<bool>> {
        let told = self.told().await?;
        if told != Some(false) {
            return Ok(told);
        }
        let foreign = self
            .arm
            .queue()
            .foreign_commands(&self.arm.known().look_at_queue().await?)
            > 0;
        self.arm.picture().note_foreign_commands(foreign);
        Ok(told.filter(|_| !foreign))
    }

    /// Returns the state of the laser from the commands of this connection and the reports of the
    /// arm. The queue is not read, so waiting commands of other programs do not count.
    pub(super) async fn told(self) -> Result<Option<bool>> {
        if self.may_have_lit() && self.arm.moving() {
            return Ok(Some(true));
        }
        let told = answered(self.arm.known().setting::<EndEffectorLaser>().await)?;
        let told = told.map(|laser| laser.is_ctrl_enabled.is_on() && laser.is_on.is_on());
        if told == Some(true) || !self.arm.inner.options.laser_pins {
            return Ok(told);
        }
        Ok(match self.read_pins().await? {
            Some(false) => told,
            high => high,
        })
    }

    /// Reads the laser's pins if their levels are unknown: [`told`](Self::told) skips them if the
    /// laser is on.
    pub(super) async fn learn_pins(self) -> Result<()> {
        // A lit laser answers the question before the pins are read, so they may still be unknown
        // here.
        let unknown = !self.arm.picture().knows_laser_pins();
        if unknown && self.arm.inner.options.laser_pins {
            self.read_pins().await?;
        }
        Ok(())
    }

    async fn read_pins(self) -> Result<Option<bool>> {
        let high = self.any_pin_is_high().await?;
        self.arm.picture().note_laser_pins(high);
        Ok(high)
    }

    /// True if one of the laser's pins is an output and high; `None` if one cannot be read.
    async fn any_pin_is_high(self) -> Result<Option<bool>> {
        let mut state = Some(false);
        for address in PINS {
            match self.pin_is_high(address).await? {
                Some(true) => return Ok(Some(true)),
                Some(false) => {}
                None => state = None,
            }
        }
        Ok(state)
    }

    /// True if commands of this connection may have lit the laser.
    fn may_have_lit(self) -> bool {
        self.arm.picture().may_be_lit()
    }

    /// True if this pin is an output and high.
    async fn pin_is_high(self, address: u8) -> Result<Option<bool>> {
        let high = match self.function_of(address).await? {
            None => None,
            Some(IoFunction::DigitalOutput) => {
                let query = GetIoDo {
                    address: Some(address),
                };
                answered(self.arm.get_with::<IoDo>(&query).await)?.map(|pin| pin.level.is_on())
            }
            Some(IoFunction::Pwm) => {
                let query = GetIoPwm {
                    address: Some(address),
                };
                answered(self.arm.get_with::<IoPwm>(&query).await)?.map(|pin| pin.duty_cycle > 0.0)
            }
            // A pin used as an input drives no laser.
            Some(_) => Some(false),
        };
        Ok(high)
    }

    async fn function_of(self, address: u8) -> Result<Option<IoFunction>> {
        let query = GetIoMultiplexing {
            address: Some(address),
        };
        let read = answered(
            self.arm
                .known()
                .setting_with::<IoMultiplexing>(&query)
                .await,
        )?;
        Ok(read.map(|read| read.multiplex))
    }

    /// Refuses to continue while the laser is on, because any motion would burn along its path.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] if the laser is on, else as [`is_on`](Self::is_on).
    pub async fn check_off(self) -> Result<()> {
        match self.told().await? {
            Some(true) => Err(Error::new(
                ErrorCode::LaserOn,
                message!(
                    "the laser is on, and the arm would burn along its path; nothing was sent"
                ),
            )
            .remedy(Action::LaserOff, "switches it off")),
            // An unknown state passes: an arm that reports nothing could otherwise never be used.
            _ => Ok(()),
        }
    }
}

/// Switching the laser off.
impl Laser<'_> {
    /// Returns the pose at which this connection switched the laser off; `None` if a command was
    /// queued since or the arm has not reported the pose.
    ///
    /// A stop of an arm that may burn reads the pose right after it. This method sends no frame.
    #[must_use]
    pub fn lights_out(self) -> Option<LaserOffPose> {
        self.arm.picture().lights_out()
    }

    /// Switches the laser off immediately, and lowers its pins if they are outputs.
    ///
    /// # Errors
    /// Same as [`set`](Arm::set).
    pub async fn switch_off(self) -> Result<()> {
        self.arm.set_any(&build::laser(false)).await?;
        if self.arm.inner.options.laser_pins {
            for address in PINS {
                match self.function_of(address).await? {
                    Some(IoFunction::DigitalOutput) => {
                        let level = Flag::OFF;
                        self.arm.set(&IoDo { address, level }).await?;
                    }
                    Some(IoFunction::Pwm) => {
                        self.arm
                            .set_any(&build::pwm(address, FREQUENCY, 0.0))
                            .await?;
                    }
                    // Unknown, or no output: a pin that is an input must not be driven.
                    _ => {}
                }
            }
        }
        self.arm.picture().darkened();
        Ok(())
    }

    /// Switches the laser off as [`switch_off`](Self::switch_off) does, if this connection may have
    /// lit it and none of its commands is in progress any more.
    ///
    /// # Errors
    /// Same as [`set`](Arm::set).
    pub async fn switch_off_after(self) -> Result<()> {
        if self.may_have_lit() && !self.arm.moving() {
            self.switch_off().await
        } else {
            Ok(())
        }
    }
}

/// PWM frequency in Hz, required by the command. At a duty of 0 any valid value will do.
const FREQUENCY: f32 = 1000.0;

impl Shared {
    /// Returns the requests that lower the laser's pins as part of a stop; empty if this connection
    /// did not raise them.
    pub(super) fn lowered_pins(&self) -> Vec<Request> {
        if self.picture().pins_may_be_high() {
            lowered_pins()
        } else {
            Vec::new()
        }
    }
}

/// Returns the requests that lower the laser's pins as level and as pulses, whichever function they
/// have.
fn lowered_pins() -> Vec<Request> {
    let level = Flag::OFF;
    let pulses = IoPwm {
        address: LASER_POWER,
        frequency: FREQUENCY,
        duty_cycle: 0.0,
    };
    // A stop has no time to read the function of each pin. The arm ignores the form that does not
    // fit.
    let levels = PINS.map(|address| Request::set(&IoDo { address, level }));
    let requests = levels.into_iter().chain([Request::set(&pulses)]);
    let stop = |request: Request| request.priority(crate::connection::Priority::Stop);
    requests.flatten().map(stop).collect()
}

/// Maps the errors of an arm that does not support a reading to `None`.
pub(super) fn answered<T>(answer: Result<T>) -> Result<Option<T>> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(error) => match error.kind() {
            ErrorKind::Timeout | ErrorKind::Unsupported | ErrorKind::Unexpected => Ok(None),
            // A broken line says nothing about what the arm supports.
            _ => Err(error),
        },
    }
}
