//! Pins that are driven as what they are.

use magician_protocol::commands::{GetIoMultiplexing, IoMultiplexing};
use magician_protocol::{IoFunction, Set};

use super::Arm;
use super::laser::answered;
use crate::{Act, Error, PinUse, Result};

impl Arm {
    /// Drives a pin: [`build::output`](crate::build::output), [`build::pwm`](crate::build::pwm) or
    /// [`build::servo`](crate::build::servo), as [`set_any`](Self::set_any) does, but refused unless the
    /// pin has the function for it: otherwise the arm takes the command and nothing happens.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) for a pin without that function; else as `set_any`.
    pub async fn drive(&self, command: &Set) -> Result<()> {
        let wanted = match command {
            Set::IoDo(output) => Some((output.address, PinUse::DigitalOutput)),
            Set::IoPwm(output) => Some((output.address, PinUse::Pwm)),
            _ => None,
        };
        if let Some((address, wanted)) = wanted {
            self.permit([command])?;
            self.check_pin(address, wanted)
                .await
                .map_err(|error| error.with_command(command.row().set_name))?;
        }
        self.set_any(command).await
    }

    async fn check_pin(&self, address: u8, wanted: PinUse) -> Result<()> {
        let address_of = GetIoMultiplexing {
            address: Some(address),
        };
        // An arm that does not tell is taken at its word.
        let Some(pin) = answered(self.get_with::<IoMultiplexing>(&address_of).await)? else {
            return Ok(());
        };
        let (needed, is) = match wanted {
            PinUse::DigitalOutput => (IoFunction::DigitalOutput, "a digital output"),
            PinUse::Pwm => (IoFunction::Pwm, "a pulse-width output"),
        };
        if pin.multiplex == needed {
            return Ok(());
        }
        let has = match pin.multiplex {
            IoFunction::None => "has no function",
            _ => "has another function",
        };
        let message = format!("EIO {address} {has}, it has to be {is}; nothing was sent");
        let give = Act::SetPin(address, wanted);
        Err(Error::invalid(message).remedy(give, "gives it that function"))
    }
}
