//! Parameters of a program: numbered (`#1`), named (`#<depth>`, `#<_global>`), and predefined ones
//! that expose its state.

use std::cell::Cell;
use std::collections::HashMap;

use magician_host::{Message, message};

use super::modes::Modes;

/// Number of parameters that are local to a call: #1 to #30.
const CALL_PARAMETERS: usize = 30;
/// Last parameter that programs may use freely; those beyond belong to the machine.
const LAST_FREE_PARAMETER: u16 = 5000;
/// Last parameter.
pub(super) const LAST_PARAMETER: u16 = 5602;
/// Largest number of names at a time. It bounds memory.
const MAX_NAMES: usize = 100_000;

/// Parameter key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Key {
    Number(u16),
    /// Name in lower case, without blanks.
    Name(Box<str>),
}

impl std::fmt::Display for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "#{number}"),
            Self::Name(name) => write!(f, "#<{name}>"),
        }
    }
}

/// Creates the error that a parameter is the tool's position.
fn unknown_position(parameter: &str) -> Message {
    message!(
        "{parameter} is the tool's position, which is unknown here",
        parameter
    )
}

type Names = HashMap<Box<str>, f64>;

/// Call parameters of the caller, saved during a call.
#[derive(Debug)]
pub(super) struct SavedParameters(Box<[Option<f64>; CALL_PARAMETERS]>);

#[derive(Debug)]
pub(super) struct Parameters {
    numbered: HashMap<u16, f64>,
    globals: Names,
    /// Local names of the main program and of each active call.
    locals: Vec<Names>,
    names: usize,
    pub(super) modes: Modes,
    /// Return value of the last subroutine.
    pub(super) value: Option<f64>,
    pub(super) level: usize,
    pub(super) line: u32,
    /// First parameter read before it was set.
    unset: Cell<Option<u16>>,
}

impl Parameters {
    pub(super) fn new(modes: Modes) -> Self {
        Self {
            numbered: HashMap::new(),
            globals: Names::new(),
            locals: vec![Names::new()],
            names: 0,
            modes,
            value: None,
            level: 0,
            line: 0,
            unset: Cell::new(None),
        }
    }

    /// Creates an empty set for parsing without a program.
    pub(super) fn none() -> Self {
        Self::new(Modes::new(None, false))
    }

    /// Returns the value of a parameter. The error is a sentence if it cannot be known.
    pub(super) fn read(&self, key: &Key) -> Result<f64, Message> {
        match key {
            Key::Number(number) if *number <= LAST_FREE_PARAMETER => {
                let value = self.numbered.get(number).copied();
                if value.is_none() && self.unset.get().is_none() {
                    self.unset.set(Some(*number));
                }
                Ok(value.unwrap_or(0.0))
            }
            Key::Number(number) => self.machine_parameter(*number),
            Key::Name(name) => match self.named(name)? {
                Some(value) => Ok(value),
                None => Err(message!(
                    "{key} is read, but never set",
                    key = key.to_string()
                )),
            },
        }
    }

    /// Returns the parameter that was read before it was set, and clears it.
    pub(super) fn take_unset(&self) -> Option<u16> {
        self.unset.take()
    }

    pub(super) fn exists(&self, name: &str) -> bool {
        matches!(self.named(name), Ok(Some(_)))
    }

    fn machine_parameter(&self, number: u16) -> Result<f64, Message> {
        let axis = |first: u16| usize::from(number - first);
        let place =
            |place: Option<f64>| place.ok_or_else(|| unknown_position(&format!("#{number}")));
        let modes = &self.modes;
        let unknown = |what: Message| {
            Err(message!(
                "#{number} is {what}, which is unknown here",
                number,
                what
            ))
        };
        match number {
            5021..=5023 => place(modes.machine_place(axis(5021))),
            5420..=5422 => place(modes.place(axis(5420))),
            5024..=5029 | 5423..=5428 => Ok(0.0),
            5061..=5070 => unknown(message!("the result of a probe")),
            5161..=5169 | 5181..=5189 => {
                unknown(message!("a position stored in the controller (G28, G30)"))
            }
            5210 => Ok(f64::from(u8::from(modes.offsets.local() != [0.0; 3]))),
            5211..=5213 => Ok(modes.offsets.local()[axis(5211)] / modes.unit),
            5214..=5219 => Ok(0.0),
            5220 => Ok(modes.offsets.system() as f64),
            5221..=5390 if (number - 5221) % 20 < 10 => {
                let zero = modes.offsets.zero_of(axis(5221) / 20 + 1);
                let zero = zero.and_then(|zero| zero.get(axis(5221) % 20).copied());
                Ok(zero.unwrap_or(0.0) / modes.unit)
            }
            5399 => unknown(message!("an input of a machine (M66)")),
            5081..=5089 | 5400..=5413 => unknown(message!("a property of a machine's tool")),
            5599 => Ok(1.0),
            _ => unknown(message!("a property of a machine")),
        }
    }

    /// Returns the value of a name, or `None` if it is not set.
    fn named(&self, name: &str) -> Result<Option<f64>, Message> {
        let Some(rest) = name.strip_prefix('_') else {
            let local = self.locals.last().and_then(|names| names.get(name));
            return Ok(local.copied());
        };
        if let Some(value) = self.globals.get(name) {
            return Ok(Some(*value));
        }
        let axis = |name: &str| ["x", "y", "z"].iter().position(|axis| *axis == name);
        let place = |place: Option<f64>| match place {
            Some(place) => Ok(Some(place)),
            None => Err(unknown_position(&format!("#<{name}>"))),
        };
        if let Some(axis) = axis(rest) {
            return place(self.modes.place(axis));
        }
        if let Some(axis) = rest.strip_prefix("abs_").and_then(axis) {
            return place(self.modes.machine_place(axis));
        }
        let unknown = ["ini[", "hal[", "current_", "selected_"];
        if unknown.iter().any(|begin| rest.starts_with(begin)) {
            return Err(message!(
                "#<{name}> is a property of a machine, which is unknown here",
                name
            ));
        }
        Ok(match rest {
            "value" => Some(self.value.unwrap_or(0.0)),
            "value_returned" => Some(f64::from(u8::from(self.value.is_some()))),
            "call_level" => Some(self.level as f64),
            "line" => Some(f64::from(self.line)),
            "a" | "b" | "c" | "u" | "v" | "w" => Some(0.0),
            _ => self.modes.named(name),
        })
    }

    /// Sets a parameter. The error is a sentence if it is read-only.
    pub(super) fn set(&mut self, key: Key, value: f64) -> Result<(), Message> {
        match key {
            Key::Number(number) if number <= LAST_FREE_PARAMETER => {
                self.numbered.insert(number, value);
                Ok(())
            }
            // Controls whether messages are shown, which does not matter here.
            Key::Number(5599) => Ok(()),
            Key::Number(number) => Err(message!(
                "#{number} is a property of a machine and cannot be set",
                number
            )),
            Key::Name(name) if self.is_read_only(&name) => {
                Err(message!("#<{name}> is read-only", name = &*name))
            }
            Key::Name(name) => {
                let names = if name.starts_with('_') {
                    Some(&mut self.globals)
                } else {
                    self.locals.last_mut()
                };
                let is_new = names.is_some_and(|names| names.insert(name, value).is_none());
                self.names += usize::from(is_new);
                if self.names > MAX_NAMES {
                    return Err(message!(
                        "the program has more than {most} named parameters",
                        most = MAX_NAMES
                    ));
                }
                Ok(())
            }
        }
    }

    fn is_read_only(&self, name: &str) -> bool {
        name.starts_with('_')
            && !self.globals.contains_key(name)
            && !matches!(self.named(name), Ok(None))
    }

    /// Enters a subroutine: its arguments become the first parameters, and names are local.
    pub(super) fn enter(&mut self, arguments: &[f64]) -> SavedParameters {
        let mut saved = [None; CALL_PARAMETERS];
        for (number, saved) in (1..).zip(&mut saved) {
            *saved = self.numbered.get(&number).copied();
        }
        for (number, value) in (1..).zip(arguments.iter().take(CALL_PARAMETERS)) {
            self.numbered.insert(number, *value);
        }
        self.locals.push(Names::new());
        self.value = None;
        SavedParameters(Box::new(saved))
    }

    /// Leaves a subroutine and restores the caller's parameters.
    pub(super) fn leave(&mut self, SavedParameters(saved): SavedParameters) {
        for (number, value) in (1..).zip(*saved) {
            match value {
                Some(value) => self.numbered.insert(number, value),
                None => self.numbered.remove(&number),
            };
        }
        if let Some(names) = self.locals.pop() {
            self.names -= names.len();
        }
    }
}
