//! Pins, motors and sensors of the connectors (document 1.15, model section 13).

mod motors;
mod sensors;

use magician_protocol::commands::*;
use magician_protocol::{Flag, Writable};

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::device::io::pins::can_do;
use crate::event::Refusal;
use crate::fidelity::Assumption;

impl Report for IoMultiplexing {
    fn report(cx: &mut Context<'_>, query: &GetIoMultiplexing) -> Self {
        let (address, pin) = cx.io.pins.asked(query.address);
        let multiplex = pin.function;
        Self { address, multiplex }
    }
}

impl Apply for IoMultiplexing {
    /// A function that the pin lacks is stored and read back and has no effect, unless the profile is strict.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let Self { address, multiplex } = *self;
        let fits = can_do(cx.io.pins.abilities_of(address), multiplex);
        cx.record.assume(Assumption::PinTable);
        if !fits && !cx.record.allows(Self::ROW.id, Assumption::LackingFunction) {
            return Effects::none();
        }
        if !fits && cx.firmware.profile.io.strict {
            return Effect::Refuse(Refusal::Pin).into();
        }
        let Some(pin) = cx.io.pins.addressed(address) else {
            return Effect::Refuse(Refusal::Pin).into();
        };
        pin.function = multiplex;
        if fits {
            Effects::none()
        } else {
            Effect::NotSimulated.into()
        }
    }
}

impl Report for IoDo {
    fn report(cx: &mut Context<'_>, query: &GetIoDo) -> Self {
        let (address, pin) = cx.io.pins.asked(query.address);
        let level = pin.level;
        Self { address, level }
    }
}

impl Apply for IoDo {
    /// Stored for whatever the pin is; it shows while the pin is a digital output.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let Some(pin) = cx.io.pins.addressed(self.address) else {
            return Effect::Refuse(Refusal::Pin).into();
        };
        pin.level = self.level;
        Effects::none()
    }
}

impl Report for IoPwm {
    fn report(cx: &mut Context<'_>, query: &GetIoPwm) -> Self {
        let (address, pin) = cx.io.pins.asked(query.address);
        Self {
            address,
            frequency: pin.frequency,
            duty_cycle: pin.duty_cycle,
        }
    }
}

impl Apply for IoPwm {
    /// Stored for whatever the pin is; it shows while the pin is a pulse-width output.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let Some(pin) = cx.io.pins.addressed(self.address) else {
            return Effect::Refuse(Refusal::Pin).into();
        };
        (pin.frequency, pin.duty_cycle) = (self.frequency, self.duty_cycle);
        Effects::none()
    }
}

impl Report for IoDi {
    fn report(cx: &mut Context<'_>, query: &GetIoDi) -> Self {
        let (address, _) = cx.io.pins.asked(query.address);
        let level = Flag::from(cx.digital(address));
        Self { address, level }
    }
}

impl Report for IoAdc {
    fn report(cx: &mut Context<'_>, query: &GetIoAdc) -> Self {
        let (address, _) = cx.io.pins.asked(query.address);
        let value = cx.analog(address);
        Self { address, value }
    }
}
