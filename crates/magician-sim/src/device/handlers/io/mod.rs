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
use crate::fidelity::{Assumption, AssumptionSet};

/// Pins of laser, valve and pump: setting one drives its tool.
const TOOL_PINS: [u8; 4] = [2, 4, 16, 17];

/// Assumptions of setting a pin.
fn told(basis: Assumption, address: u8) -> AssumptionSet {
    AssumptionSet::from(basis).and_if(TOOL_PINS.contains(&address), Assumption::ToolPins)
}

/// Assumptions of reading a pin.
fn asked(basis: Assumption, address: Option<u8>) -> AssumptionSet {
    AssumptionSet::from(basis).and_if(address.is_none(), Assumption::LastPin)
}

/// Assumptions of reading an input.
fn read(cx: &Context<'_>, address: Option<u8>) -> AssumptionSet {
    let (world, now) = (cx.world, cx.now);
    let is_open = |pin| world.digital(now, pin).is_none() && world.analog(now, pin).is_none();
    asked(Assumption::IoInputs, address).and_if(address.is_some_and(is_open), Assumption::OpenInput)
}

impl Report for IoMultiplexing {
    const ASSUMPTION: Assumption = Assumption::IoFunctions;

    fn assumptions(_: &mut Context<'_>, query: &GetIoMultiplexing) -> AssumptionSet {
        asked(<Self as Report>::ASSUMPTION, query.address)
    }

    fn report(cx: &mut Context<'_>, query: &GetIoMultiplexing) -> Self {
        let (address, pin) = cx.io.pins.asked(query.address);
        let multiplex = pin.function;
        Self { address, multiplex }
    }
}

impl Apply for IoMultiplexing {
    const ASSUMPTION: Assumption = Assumption::IoFunctions;

    fn assumptions(&self, _: &Context<'_>, _: ExecMode) -> AssumptionSet {
        told(<Self as Apply>::ASSUMPTION, self.address)
    }

    /// A function that the pin lacks is stored and read back without effect, unless the profile is
    /// strict.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let Self { address, multiplex } = *self;
        let fits = can_do(cx.io.pins.abilities_of(address), multiplex);
        // The table of functions is a third party's (model section 13).
        cx.record.assume(Assumption::PinTable);
        if !fits && !cx.record.allows(Self::ROW.id, Assumption::LackingFunction) {
            return Effects::none();
        }
        // Two switches: `fidelity.strict` refuses all choices, `io.strict` this one alone.
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
    const ASSUMPTION: Assumption = Assumption::IoOutputs;

    fn assumptions(_: &mut Context<'_>, query: &GetIoDo) -> AssumptionSet {
        asked(<Self as Report>::ASSUMPTION, query.address)
    }

    fn report(cx: &mut Context<'_>, query: &GetIoDo) -> Self {
        let (address, pin) = cx.io.pins.asked(query.address);
        let level = pin.level;
        Self { address, level }
    }
}

impl Apply for IoDo {
    const ASSUMPTION: Assumption = Assumption::IoOutputs;

    fn assumptions(&self, _: &Context<'_>, _: ExecMode) -> AssumptionSet {
        told(<Self as Apply>::ASSUMPTION, self.address)
    }

    /// Stored whatever the pin's function is; it shows while the pin is a digital output.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let Some(pin) = cx.io.pins.addressed(self.address) else {
            return Effect::Refuse(Refusal::Pin).into();
        };
        pin.level = self.level;
        Effects::none()
    }
}

impl Report for IoPwm {
    const ASSUMPTION: Assumption = Assumption::IoOutputs;

    fn assumptions(_: &mut Context<'_>, query: &GetIoPwm) -> AssumptionSet {
        asked(<Self as Report>::ASSUMPTION, query.address)
    }

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
    const ASSUMPTION: Assumption = Assumption::IoOutputs;

    fn assumptions(&self, _: &Context<'_>, _: ExecMode) -> AssumptionSet {
        told(<Self as Apply>::ASSUMPTION, self.address)
    }

    /// Stored whatever the pin's function is; it shows while the pin is a PWM output.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let Some(pin) = cx.io.pins.addressed(self.address) else {
            return Effect::Refuse(Refusal::Pin).into();
        };
        (pin.frequency, pin.duty_cycle) = (self.frequency, self.duty_cycle);
        Effects::none()
    }
}

impl Report for IoDi {
    const ASSUMPTION: Assumption = Assumption::IoInputs;

    fn assumptions(cx: &mut Context<'_>, query: &GetIoDi) -> AssumptionSet {
        read(cx, query.address)
    }

    fn report(cx: &mut Context<'_>, query: &GetIoDi) -> Self {
        let (address, _) = cx.io.pins.asked(query.address);
        let level = Flag::from(cx.digital(address));
        Self { address, level }
    }
}

impl Report for IoAdc {
    const ASSUMPTION: Assumption = Assumption::IoInputs;

    fn assumptions(cx: &mut Context<'_>, query: &GetIoAdc) -> AssumptionSet {
        read(cx, query.address)
    }

    fn report(cx: &mut Context<'_>, query: &GetIoAdc) -> Self {
        let (address, _) = cx.io.pins.asked(query.address);
        let value = cx.analog(address);
        Self { address, value }
    }
}
