//! Pins, motors and sensors of the connectors (document 1.15, model section 13).

use magician_protocol::commands::*;
use magician_protocol::{Flag, IoFunction, PoCmd, Port, Stepper, Writable};

use crate::core::Core;
use crate::dispatch::{Apply, Report, Step, Turn};
use crate::event::Refusal;
use crate::fidelity::Basis;
use crate::profile::{PINS, PinFunctions};

/// What one pin was told.
#[derive(Clone, Copy, Debug)]
struct Pin {
    function: IoFunction,
    level: Flag,
    frequency: f32,
    duty_cycle: f32,
}

impl Pin {
    const NEW: Self = Self {
        function: IoFunction::None,
        level: Flag::OFF,
        frequency: 0.0,
        duty_cycle: 0.0,
    };
}

/// The pins, by address less one.
#[derive(Clone, Debug)]
pub(crate) struct Connectors {
    pins: [Pin; PINS],
    /// What a get without an address asks for (errata E39).
    last_address: u8,
}

impl Default for Connectors {
    fn default() -> Self {
        Self {
            pins: [Pin::NEW; PINS],
            last_address: 1,
        }
    }
}

impl Connectors {
    /// The pin of an address, `None` when there is none; it is now the one addressed last.
    fn addressed(&mut self, address: u8) -> Option<&mut Pin> {
        let pin = self.pins.get_mut(usize::from(address).checked_sub(1)?)?;
        self.last_address = address;
        Some(pin)
    }

    /// Address and pin of a get; an address that there is not reads as a pin that was told nothing.
    fn asked(&mut self, address: Option<u8>) -> (u8, Pin) {
        let address = address.unwrap_or(self.last_address);
        (
            address,
            self.addressed(address).copied().unwrap_or(Pin::NEW),
        )
    }
}

fn can_do(pin: PinFunctions, function: IoFunction) -> bool {
    match function {
        IoFunction::None => true,
        IoFunction::DigitalOutput => pin.digital_output,
        IoFunction::Pwm => pin.pwm,
        IoFunction::DigitalInput
        | IoFunction::DigitalInputPullUp
        | IoFunction::DigitalInputPullDown => pin.digital_input,
        IoFunction::AnalogInput => pin.analog_input,
        IoFunction::Unknown(_) => false,
    }
}

impl Report for IoMultiplexing {
    fn report(core: &mut Core, query: &GetIoMultiplexing) -> Self {
        let (address, pin) = core.connectors.asked(query.address);
        let multiplex = pin.function;
        Self { address, multiplex }
    }
}

impl Apply for IoMultiplexing {
    /// A function that the pin lacks is stored and read back and has no effect, unless the profile is strict.
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        let Self { address, multiplex } = *self;
        let at = usize::from(address).wrapping_sub(1);
        let able = core.profile.io.pins.get(at).copied().unwrap_or_default();
        let fits = can_do(able, multiplex);
        core.rests_on(Basis::PinTable);
        if !fits && !core.may_rest_on(Self::ROW.id, Basis::LackingFunction) {
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
    fn report(core: &mut Core, query: &GetIoDo) -> Self {
        let (address, pin) = core.connectors.asked(query.address);
        let level = pin.level;
        Self { address, level }
    }
}

impl Apply for IoDo {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        let Some(pin) = core.connectors.addressed(self.address) else {
            return core.refuse(Self::ROW.id, Refusal::Pin);
        };
        pin.level = self.level;
        Step::Done
    }
}

impl Core {
    /// Switches an output that a move has come to.
    pub(crate) fn switch(&mut self, output: PoCmd) {
        let address = u8::try_from(output.address).unwrap_or(u8::MAX);
        let level = Flag(output.level);
        // A pin that there is not is refused like the command that it stands for; the move goes on.
        let _: Step = IoDo { address, level }.apply(self, Turn::Queued);
    }
}

impl Report for IoPwm {
    fn report(core: &mut Core, query: &GetIoPwm) -> Self {
        let (address, pin) = core.connectors.asked(query.address);
        Self {
            address,
            frequency: pin.frequency,
            duty_cycle: pin.duty_cycle,
        }
    }
}

impl Apply for IoPwm {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        let Some(pin) = core.connectors.addressed(self.address) else {
            return core.refuse(Self::ROW.id, Refusal::Pin);
        };
        (pin.frequency, pin.duty_cycle) = (self.frequency, self.duty_cycle);
        Step::Done
    }
}

impl Report for IoDi {
    fn report(core: &mut Core, query: &GetIoDi) -> Self {
        let (address, _) = core.connectors.asked(query.address);
        let level = Flag::from(core.world.digital(core.now, address));
        Self { address, level }
    }
}

impl Report for IoAdc {
    fn report(core: &mut Core, query: &GetIoAdc) -> Self {
        let (address, _) = core.connectors.asked(query.address);
        let value = core.world.analog(core.now, address);
        Self { address, value }
    }
}

impl Apply for EMotor {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        let at = match self.index {
            Stepper::Stepper1 => 0,
            Stepper::Stepper2 => 1,
            Stepper::Unknown(_) => return core.refuse(Self::ROW.id, Refusal::Pin),
        };
        if let Some(stepper) = core.settings.steppers.get_mut(at) {
            *stepper = *self;
        }
        core.not_simulated(Self::ROW)
    }
}

impl Apply for EMotorS {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        core.not_simulated(Self::ROW)
    }
}

impl Report for ColorSensor {
    /// A sensor that is off sees nothing.
    fn report(core: &mut Core, query: &GetColorSensor) -> Self {
        let sensor = core.settings.color_sensor;
        let port = query.port.unwrap_or(sensor.port);
        let [r, g, b] = if sensor.is_enabled.is_on() {
            core.world.color(core.now, port)
        } else {
            [0; 3]
        };
        Self { r, g, b }
    }
}

impl Apply for SetColorSensor {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        core.settings.color_sensor = *self;
        Step::Done
    }
}

impl Report for IrSwitch {
    /// A sensor that is off sees nothing.
    fn report(core: &mut Core, query: &GetIrSwitch) -> Self {
        let sensor = core.settings.ir_switch;
        let port: Port = query.port.unwrap_or(sensor.port);
        let seen = sensor.is_enabled.is_on() && core.world.infrared(core.now, port);
        Self {
            state: Flag::from(seen),
        }
    }
}

impl Apply for SetIrSwitch {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        core.settings.ir_switch = *self;
        Step::Done
    }
}
