//! EIO pins: reading inputs, waiting for them, and driving outputs with a check of their function.

use magician_protocol::commands::{GetIoDi, GetIoMultiplexing, IoDi, IoMultiplexing};
use magician_protocol::{IoFunction, Set};

use super::laser::answered;
use super::{Arm, RunSummary};
use crate::{Act, Error, PinUse, Result, build, message};

/// EIO pins of an arm, returned by [`Arm::pins`].
#[derive(Clone, Copy, Debug)]
pub struct Pins<'a> {
    arm: &'a Arm,
}

impl Pins<'_> {
    /// Reads a digital input (EIO address 1 to 20, document 1.15.4); true if it is high. The pin
    /// must be configured as an input first: [`build::multiplex`].
    ///
    /// # Errors
    /// Same as [`get`](Arm::get); [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) if the arm has
    /// no such pin.
    pub async fn input(self, address: u8) -> Result<bool> {
        let address = Some(address);
        let read: IoDi = self.arm.get_with(&GetIoDi { address }).await?;
        Ok(read.level.is_on())
    }

    /// Waits in the arm's queue until a digital input (EIO address 1 to 20) has this level
    /// (document 1.14.1). There is no timeout: a [`stop`](Arm::stop) ends the wait.
    ///
    /// # Errors
    /// Same as [`move_to`](Arm::move_to).
    pub async fn wait_for_input(self, address: u8, high: bool) -> Result<RunSummary> {
        self.arm.run(&[build::wait_for_level(address, high)]).await
    }

    /// Drives a pin by [`build::output`](crate::build::output), [`build::pwm`](crate::build::pwm)
    /// or [`build::servo`](crate::build::servo).
    ///
    /// The command is sent as by [`set_any`](Arm::set_any), but refused unless the pin has the
    /// required function. Without this check the arm accepts the command and nothing happens.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) for a pin without that function; else as
    /// `set_any`.
    pub async fn drive(self, command: &Set) -> Result<()> {
        let wanted = match command {
            Set::IoDo(output) => Some((output.address, PinUse::DigitalOutput)),
            Set::IoPwm(output) => Some((output.address, PinUse::Pwm)),
            // Other commands need no function of a pin and pass unchecked.
            _ => None,
        };
        if let Some((address, wanted)) = wanted {
            self.arm.permission().check([command])?;
            self.check(address, wanted)
                .await
                .map_err(|error| error.with_command(command.row().set_name))?;
        }
        self.arm.set_any(command).await
    }

    async fn check(self, address: u8, wanted: PinUse) -> Result<()> {
        let address_of = GetIoMultiplexing {
            address: Some(address),
        };
        // Without a reading of the function the command is sent unchecked.
        let Some(pin) = answered(self.arm.get_with::<IoMultiplexing>(&address_of).await)? else {
            return Ok(());
        };
        let (needed, is) = match wanted {
            PinUse::DigitalOutput => (IoFunction::DigitalOutput, message!("a digital output")),
            PinUse::Pwm => (IoFunction::Pwm, message!("a pulse-width output")),
        };
        if pin.multiplex == needed {
            return Ok(());
        }
        let message = match pin.multiplex {
            IoFunction::None => message!(
                "EIO {address} has no function, it has to be {is}; nothing was sent",
                address,
                is
            ),
            _ => message!(
                "EIO {address} has another function, it has to be {is}; nothing was sent",
                address,
                is
            ),
        };
        let give = Act::SetPin(address, wanted);
        Err(Error::invalid(message).remedy(give, "gives it that function"))
    }
}

impl Arm {
    /// Returns the EIO pins.
    #[must_use]
    pub const fn pins(&self) -> Pins<'_> {
        Pins { arm: self }
    }
}
