//! `io`: reads and drives the pins of the arm's connectors.

use clap::{Args, Subcommand};
use magician::commands::{
    GetIoAdc, GetIoDi, GetIoDo, GetIoMultiplexing, GetIoPwm, IoAdc, IoDi, IoDo, IoMultiplexing,
    IoPwm,
};
use magician::{Arm, Set, build};
use magician_protocol::IoFunction;
use serde::Serialize;

use crate::catalogue::kebab;
use crate::columns::{Columns, note};
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::options::number;
use crate::output::Output;

/// Highest address of a pin (document 1.15.1).
pub(super) const PIN_COUNT: u8 = 20;

/// Read and set the pins of the arm's connectors
#[derive(Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "A pin does nothing until it has a function: `magician io mux 4 digital-output`."
)]
pub(crate) struct Io {
    /// Also show pins without a function
    #[arg(long)]
    all: bool,
    #[command(subcommand)]
    action: Option<Action>,
}

#[derive(Clone, Copy, Debug, Subcommand)]
enum Action {
    /// List the pins with function and state
    List {
        /// Also show pins without a function
        #[arg(long)]
        all: bool,
    },
    /// Read a pin according to its function
    Get {
        /// Pin, 1 to 20
        #[arg(value_parser = pin)]
        pin: u8,
    },
    /// Set the level of a digital output
    Set {
        /// Pin, 1 to 20
        #[arg(value_parser = pin)]
        pin: u8,
        /// Level: 0 or 1, off or on, low or high
        #[arg(value_parser = level, action = clap::ArgAction::Set)]
        level: bool,
    },
    /// Set the function of a pin: none, digital-output, pwm, digital-input, analog-input,
    /// digital-input-pull-up, digital-input-pull-down, or 0 to 6
    Mux {
        /// Pin, 1 to 20
        #[arg(value_parser = pin)]
        pin: u8,
        /// Function: one of these names or numbers
        #[arg(value_parser = function)]
        function: IoFunction,
    },
    /// Set frequency and duty cycle of a PWM output
    Pwm {
        /// Pin, 1 to 20
        #[arg(value_parser = pin)]
        pin: u8,
        /// Frequency in Hz, 10 to 1000000
        #[arg(value_parser = number::<f32>)]
        hertz: f32,
        /// Duty cycle in percent, 0 to 100
        #[arg(value_parser = number::<f32>)]
        percent: f32,
    },
    /// Read an analog input
    Adc {
        /// Pin, 1 to 20
        #[arg(value_parser = pin)]
        pin: u8,
    },
}

fn pin(text: &str) -> Result<u8, String> {
    let pin = text
        .parse()
        .ok()
        .filter(|pin| (1..=PIN_COUNT).contains(pin));
    pin.ok_or_else(|| format!("expected a pin, 1 to {PIN_COUNT}"))
}

fn level(text: &str) -> Result<bool, String> {
    match text.to_ascii_lowercase().as_str() {
        "0" | "off" | "low" => Ok(false),
        "1" | "on" | "high" => Ok(true),
        _ => Err("expected 0 or 1, off or on, low or high".to_owned()),
    }
}

fn function(text: &str) -> Result<IoFunction, String> {
    let known = IoFunction::INFO.value_of(text);
    let value = known.or_else(|| text.parse().ok().filter(|value| *value <= 6));
    value.map(IoFunction::from).ok_or_else(|| {
        let names: Vec<_> = IoFunction::INFO
            .variants
            .iter()
            .map(|variant| kebab(variant.name))
            .collect();
        format!("expected one of {}, or 0 to 6", names.join(", "))
    })
}

/// State of a pin. Only the fields that belong to its function are set.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Pin {
    pub(super) address: u8,
    #[serde(skip_serializing_if = "Option::is_none")]
    multiplex: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    level: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    duty_cycle: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    value: Option<u16>,
}

#[derive(Serialize)]
struct List {
    pins: Vec<Pin>,
}

impl Pin {
    /// Returns the name of the pin's function; `None` if unknown.
    pub(super) fn function(&self) -> Option<String> {
        let value = self.multiplex?;
        Some(match IoFunction::INFO.name_of(value) {
            Some(name) => kebab(name),
            None => value.to_string(),
        })
    }

    /// Returns a letter for the pin's function: output, pulse width, input, analog; a space for
    /// none.
    pub(super) fn letter(&self) -> char {
        match self.multiplex.map(IoFunction::from) {
            None | Some(IoFunction::None) => ' ',
            Some(IoFunction::DigitalOutput) => 'o',
            Some(IoFunction::Pwm) => 'w',
            Some(
                IoFunction::DigitalInput
                | IoFunction::DigitalInputPullUp
                | IoFunction::DigitalInputPullDown,
            ) => 'i',
            Some(IoFunction::AnalogInput) => 'a',
            Some(IoFunction::Unknown(_)) => '?',
        }
    }

    /// True if the pin has a function.
    pub(super) fn has_function(&self) -> bool {
        self.letter() != ' '
    }

    /// True if the pin is high, at least part of the time.
    pub(super) fn is_on(&self) -> bool {
        let pulses = self.duty_cycle.is_some_and(|percent| percent > 0.0);
        pulses || self.level.or(Some(0)) != Some(0) || self.value.is_some_and(|value| value > 0)
    }

    #[cfg(test)]
    pub(super) fn analog(address: u8, value: u16) -> Self {
        Self {
            address,
            multiplex: Some(IoFunction::AnalogInput.into()),
            value: Some(value),
            ..Self::default()
        }
    }
}

impl Io {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let action = self.action.unwrap_or(Action::List { all: self.all });
        let burns = match action.command() {
            Some(command) => context.permit([&command])?,
            None => false,
        };
        let policy = if burns {
            StopPolicy::lights(context)
        } else {
            StopPolicy::order_if(action.changes())
        };
        let pins = context.arm(policy, async |arm, _| act(arm, action).await)?;
        match (pins.as_slice(), action) {
            (_, Action::List { all }) => {
                let list = List { pins };
                context.show(&list, |out| overview(&list.pins, all, out))
            }
            ([pin], _) => context.show(pin, |out| write([pin], out)),
            // Every action on a pin returns exactly one pin, so no other case occurs.
            _ => Ok(()),
        }
    }
}

impl Action {
    fn changes(self) -> bool {
        match self {
            Self::List { .. } | Self::Get { .. } | Self::Adc { .. } => false,
            Self::Set { .. } | Self::Mux { .. } | Self::Pwm { .. } => true,
        }
    }

    /// Returns the command for an output; `None` if the action only reads.
    fn command(self) -> Option<Set> {
        match self {
            Self::Set { pin, level } => Some(build::output(pin, level)),
            Self::Pwm {
                pin,
                hertz,
                percent,
            } => Some(build::pwm(pin, hertz, percent)),
            _ => None,
        }
    }
}

async fn act(arm: &Arm, action: Action) -> Result<Vec<Pin>, Failure> {
    let pin = match action {
        Action::List { .. } => {
            let mut pins = Vec::new();
            for address in 1..=PIN_COUNT {
                pins.push(read(arm, address).await?);
            }
            return Ok(pins);
        }
        Action::Get { pin } => pin,
        Action::Set { pin, .. } | Action::Pwm { pin, .. } => {
            if let Some(command) = action.command() {
                arm.pins().drive(&command).await?;
            }
            pin
        }
        Action::Mux { pin, function } => {
            let multiplex = function;
            arm.set(&IoMultiplexing {
                address: pin,
                multiplex,
            })
            .await?;
            pin
        }
        Action::Adc { pin } => {
            let value = arm
                .get_with::<IoAdc>(&GetIoAdc { address: Some(pin) })
                .await?
                .value;
            return Ok(vec![Pin {
                address: pin,
                value: Some(value),
                ..Pin::default()
            }]);
        }
    };
    Ok(vec![read(arm, pin).await?])
}

/// Reads a pin according to its function.
pub(super) async fn read(arm: &Arm, address: u8) -> Result<Pin, Failure> {
    let query = Some(address);
    let function = arm
        .get_with::<IoMultiplexing>(&GetIoMultiplexing { address: query })
        .await?
        .multiplex;
    let mut pin = Pin {
        address,
        multiplex: Some(function.into()),
        ..Pin::default()
    };
    match function {
        IoFunction::DigitalOutput => {
            let read = arm.get_with::<IoDo>(&GetIoDo { address: query }).await?;
            pin.level = Some(read.level.0);
        }
        IoFunction::Pwm => {
            let read = arm.get_with::<IoPwm>(&GetIoPwm { address: query }).await?;
            (pin.frequency, pin.duty_cycle) = (Some(read.frequency), Some(read.duty_cycle));
        }
        IoFunction::DigitalInput
        | IoFunction::DigitalInputPullUp
        | IoFunction::DigitalInputPullDown => {
            let read = arm.get_with::<IoDi>(&GetIoDi { address: query }).await?;
            pin.level = Some(read.level.0);
        }
        IoFunction::AnalogInput => {
            let read = arm.get_with::<IoAdc>(&GetIoAdc { address: query }).await?;
            pin.value = Some(read.value);
        }
        IoFunction::None | IoFunction::Unknown(_) => (),
    }
    Ok(pin)
}

/// Lists the pins that have a function, and counts the others.
fn overview(pins: &[Pin], all: bool, out: &mut Output) -> Result<(), Failure> {
    let none = Some(u8::from(IoFunction::None));
    write(pins.iter().filter(|pin| all || pin.multiplex != none), out)?;
    let idle = pins.iter().filter(|pin| pin.multiplex == none).count();
    let other_pins = match idle {
        _ if all => return Ok(()),
        0 => return Ok(()),
        1 => "1 pin has no function".to_owned(),
        count if count == pins.len() => format!("none of the {count} pins has a function"),
        count => format!("{count} pins have no function"),
    };
    let hint = "`io --all` shows them, `io mux PIN FUNCTION` gives one a function";
    note(&format!("{other_pins}; {hint}"), out)
}

fn write<'a>(pins: impl IntoIterator<Item = &'a Pin>, out: &mut Output) -> Result<(), Failure> {
    let mut columns = Columns::default();
    for pin in pins {
        columns.row([
            format!("EIO {}", pin.address),
            pin.function().unwrap_or_default(),
            state(pin),
        ]);
    }
    columns.write(out)
}

/// Describes the state of a pin.
pub(super) fn state(pin: &Pin) -> String {
    match (pin.level, pin.frequency, pin.duty_cycle, pin.value) {
        (Some(level), ..) => if level == 0 { "low" } else { "high" }.to_owned(),
        (_, Some(hertz), Some(percent), _) => format!("{hertz} Hz, {percent} %"),
        (.., Some(value)) => format!("{value} of {}", build::ANALOG_COUNTS),
        _ => String::new(),
    }
}
