//! Pins, motors and sensors of the connectors (document 1.15, model section 13).

mod motors;
mod sensors;

use magician_protocol::commands::*;
use magician_protocol::{Flag, PoCmd, Writable};

use crate::device::Device;
use crate::device::dispatch::{Apply, Report, Step, Turn};
use crate::device::io::pins::can_do;
use crate::event::Refusal;
use crate::fidelity::Assumption;

pub(crate) use sensors::Detectors;

impl Report for IoMultiplexing {
    fn report(core: &mut Device, query: &GetIoMultiplexing) -> Self {
        let (address, pin) = core.connectors.asked(query.address);
        let multiplex = pin.function;
        Self { address, multiplex }
    }
}

impl Apply for IoMultiplexing {
    /// A function that the pin lacks is stored and read back and has no effect, unless the profile is strict.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let Self { address, multiplex } = *self;
        let fits = can_do(core.abilities(address), multiplex);
        core.assume(Assumption::PinTable);
        if !fits && !core.allows(Self::ROW.id, Assumption::LackingFunction) {
            return Step::Done;
        }
        if !fits && core.profile.io.strict {
            return core.refuse(Self::ROW.id, Refusal::Pin);
        }
        let Some(pin) = core.connectors.addressed(address) else {
            return core.refuse(Self::ROW.id, Refusal::Pin);
        };
        pin.function = multiplex;
        if fits {
            Step::Done
        } else {
            core.not_simulated(Self::ROW)
        }
    }
}

impl Report for IoDo {
    fn report(core: &mut Device, query: &GetIoDo) -> Self {
        let (address, pin) = core.connectors.asked(query.address);
        let level = pin.level;
        Self { address, level }
    }
}

impl Apply for IoDo {
    /// Stored for whatever the pin is; it shows while the pin is a digital output.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let Some(pin) = core.connectors.addressed(self.address) else {
            return core.refuse(Self::ROW.id, Refusal::Pin);
        };
        pin.level = self.level;
        Step::Done
    }
}

impl Device {
    /// Switches an output that a move has come to.
    pub(crate) fn switch(&mut self, output: PoCmd) {
        let address = u8::try_from(output.address).unwrap_or(u8::MAX);
        let level = Flag(output.level);
        // A pin that there is not is refused like the command that it stands for; the move goes on.
        let _: Step = IoDo { address, level }.apply(self, Turn::Queued);
    }
}

impl Report for IoPwm {
    fn report(core: &mut Device, query: &GetIoPwm) -> Self {
        let (address, pin) = core.connectors.asked(query.address);
        Self {
            address,
            frequency: pin.frequency,
            duty_cycle: pin.duty_cycle,
        }
    }
}

impl Apply for IoPwm {
    /// Stored for whatever the pin is; it shows while the pin is a pulse-width output.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let Some(pin) = core.connectors.addressed(self.address) else {
            return core.refuse(Self::ROW.id, Refusal::Pin);
        };
        (pin.frequency, pin.duty_cycle) = (self.frequency, self.duty_cycle);
        Step::Done
    }
}

impl Report for IoDi {
    fn report(core: &mut Device, query: &GetIoDi) -> Self {
        let (address, _) = core.connectors.asked(query.address);
        let level = Flag::from(core.digital(address));
        Self { address, level }
    }
}

impl Report for IoAdc {
    fn report(core: &mut Device, query: &GetIoAdc) -> Self {
        let (address, _) = core.connectors.asked(query.address);
        let value = core.analog(address);
        Self { address, value }
    }
}
