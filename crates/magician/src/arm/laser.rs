//! The laser: permission to light it, its state, and switching it off.

use magician_protocol::commands::{
    EndEffectorLaser, GetIoDo, GetIoMultiplexing, GetIoPwm, IoDo, IoMultiplexing, IoPwm,
};
use magician_protocol::{Flag, IoFunction, Set};

use super::{Arm, Shared};
use crate::build;
use crate::connection::Request;
use crate::message;
use crate::{Action, Error, ErrorCode, ErrorKind, LightsOut, Result};
use magician_host::{LASER_POWER, LASER_SUPPLY, burns};

/// The laser's pins.
const PINS: [u8; 2] = [LASER_SUPPLY, LASER_POWER];

/// The laser of an arm: whether it may burn, whether it is on, and switching it off. [`Arm::laser`] hands it out.
#[derive(Clone, Copy, Debug)]
pub struct Laser<'a> {
    pub(super) arm: &'a Arm,
}

impl Arm {
    /// The laser.
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

    /// A handle of the same connection whose calls may light the laser: see
    /// [`Options::allow_laser`](super::Options::allow_laser). Ask a person before.
    #[must_use]
    pub fn allowing_laser(&self) -> Self {
        Self {
            allows_laser: true,
            ..self.clone()
        }
    }

    /// Whether it is a virtual arm, where nothing burns: one in this process, or by the word of
    /// [`Options::virtual_arm`](super::Options::virtual_arm). Any other counts as real: it is impossible to tell them apart.
    #[must_use]
    pub fn is_virtual(&self) -> bool {
        self.inner.in_process || self.inner.options.virtual_arm
    }
}

impl Laser<'_> {
    /// Whether calls of this handle may light the laser, or there is none.
    #[must_use]
    pub fn may_burn(self) -> bool {
        self.arm.allows_laser || self.arm.is_virtual()
    }

    /// Whether this command may light the laser of this arm: [`burns`](fn@crate::burns) for the pins of
    /// [`Options::laser_pins`](super::Options::laser_pins).
    #[must_use]
    pub fn burns(self, command: &Set) -> bool {
        burns(command, self.arm.inner.options.laser_pins)
    }
}

/// Whether it burns.
impl Laser<'_> {
    /// Whether the laser is on, as far as can be told: while commands of this connection that light it may be under way, and
    /// where the arm says so of the laser or of its pins. `None` where the arm does not say, and while commands of another
    /// program are in the queue: they may burn, and cannot be read there.
    ///
    /// # Errors
    /// As [`get`](Arm::get), but for answers that some arms do not give.
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

    /// State of the laser by the commands of this connection and by what the arm tells of it. Commands of other programs in
    /// the queue do not count: the queue is not looked at.
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

    /// Reads the laser's pins if their levels are not known: a laser that is on leaves them unread.
    pub(super) async fn learn_pins(self) -> Result<()> {
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

    /// Whether one of the laser's pins is an output and high.
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

    /// Whether this pin is an output and high.
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

    /// Refuses to go on while the laser is on: whatever moves then would burn along its way.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] when it is on, else as [`is_on`](Self::is_on).
    pub async fn check_off(self) -> Result<()> {
        match self.told().await? {
            Some(true) => Err(Error::new(
                ErrorCode::LaserOn,
                message!(
                    "the laser is on, and the arm would burn along its path; nothing was sent"
                ),
            )
            .remedy(Action::LaserOff, "switches it off")),
            _ => Ok(()),
        }
    }
}

/// How it is put out.
impl Laser<'_> {
    /// Returns where the arm was when this connection put its laser out, if no command was queued since and the arm has told
    /// its pose. A stop of an arm that may burn asks for the pose as soon as it goes out; no frame is sent here.
    #[must_use]
    pub fn lights_out(self) -> Option<LightsOut> {
        self.arm.picture().lights_out()
    }

    /// Switches the laser off at once, and lowers its pins where they are outputs.
    ///
    /// # Errors
    /// As [`set`](Arm::set).
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
                    _ => {}
                }
            }
        }
        self.arm.picture().darkened();
        Ok(())
    }

    /// As [`switch_off`](Self::switch_off), if this connection may have lit the laser and nothing of it is under way any more.
    ///
    /// # Errors
    /// As [`set`](Arm::set).
    pub async fn switch_off_after(self) -> Result<()> {
        if self.may_have_lit() && !self.arm.moving() {
            self.switch_off().await
        } else {
            Ok(())
        }
    }
}

/// Any frequency that the arm takes.
const FREQUENCY: f32 = 1000.0;

impl Shared {
    /// What has to be said besides to put a laser out whose pins were raised over this connection.
    pub(super) fn lowered_pins(&self) -> Vec<Request> {
        if self.picture().pins_may_be_high() {
            lowered_pins()
        } else {
            Vec::new()
        }
    }
}

/// The requests that lower the laser's pins, whatever they are at present.
fn lowered_pins() -> Vec<Request> {
    let level = Flag::OFF;
    let pulses = IoPwm {
        address: LASER_POWER,
        frequency: FREQUENCY,
        duty_cycle: 0.0,
    };
    let levels = PINS.map(|address| Request::set(&IoDo { address, level }));
    let requests = levels.into_iter().chain([Request::set(&pulses)]);
    let stop = |request: Request| request.priority(crate::connection::Priority::Stop);
    requests.flatten().map(stop).collect()
}

/// Nothing where an arm has no such thing.
pub(super) fn answered<T>(answer: Result<T>) -> Result<Option<T>> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(error) => match error.kind() {
            ErrorKind::Timeout | ErrorKind::Unsupported | ErrorKind::Unexpected => Ok(None),
            _ => Err(error),
        },
    }
}
