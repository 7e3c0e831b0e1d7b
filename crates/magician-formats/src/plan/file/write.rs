//! Writer of plan files.

use std::collections::HashMap;
use std::io::{self, Write};

use magician_protocol::{Ctrl, FrameBuf, Set};
use serde::ser::{Error as _, SerializeMap};
use serde::{Serialize, Serializer};
use serde_json::ser::Formatter;

use super::{FORMAT, VERSION, VERSION_WITH_PARTS};
use crate::{Action, Grip, Part, Plan, Step, Tool, Travel};

impl Plan {
    /// Writes the plan as a file that [`from_json`](Self::from_json) reads back as the same plan.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write_to(&self, writer: &mut impl Write) -> io::Result<()> {
        let names = Names::of(self);
        write!(writer, "{{")?;
        entry(writer, "format", &FORMAT)?;
        write!(writer, ",")?;
        // The lowest version that can express the plan, so that older readers accept as many files
        // as possible.
        let silent = self.steps.iter().any(|step| step.action.is_silent());
        let version = if silent { VERSION_WITH_PARTS } else { VERSION };
        entry(writer, "version", &version)?;
        write!(writer, ",")?;
        entry(writer, "title", &self.title)?;
        write!(writer, ",")?;
        entry(writer, "tool", &self.tool.map(ToolName))?;
        if let Some(surface) = &self.surface {
            let [x, y] = surface.slope;
            let (height, slope) = (surface.height, Numbers([x, y]));
            write!(writer, ",\"surface\":{{")?;
            entry(writer, "height", &Number(height))?;
            write!(writer, ",")?;
            entry(writer, "slope", &slope)?;
            write!(writer, "}}")?;
        }
        if names.are_listed {
            write!(writer, ",")?;
            entry(writer, "names", &self.names)?;
        }
        write!(writer, ",\"steps\":[")?;
        for (at, step) in self.steps.iter().enumerate() {
            writer.write_all(if at == 0 { b"\n" } else { b",\n" })?;
            value(
                writer,
                &StepLine {
                    step,
                    names: &names,
                },
            )?;
        }
        writer.write_all(b"\n]}\n")
    }

    /// Returns the file as a text.
    #[must_use]
    pub fn to_json(&self) -> String {
        let mut bytes = Vec::new();
        // Writing to a vector cannot fail.
        let _ = self.write_to(&mut bytes);
        String::from_utf8(bytes).unwrap_or_default()
    }
}

fn entry(writer: &mut impl Write, key: &str, of: &impl Serialize) -> io::Result<()> {
    write!(writer, "\"{key}\":")?;
    value(writer, of)
}

fn value(writer: &mut impl Write, of: &impl Serialize) -> io::Result<()> {
    let mut serializer = serde_json::Serializer::with_formatter(writer, Short);
    of.serialize(&mut serializer).map_err(io::Error::from)
}

/// Formats numbers as short as possible: whole numbers without a point, tiny and huge ones with an
/// exponent.
struct Short;

impl Formatter for Short {
    fn write_f32<W: ?Sized + Write>(&mut self, writer: &mut W, value: f32) -> io::Result<()> {
        if value == 0.0 || (1e-4..1e7).contains(&value.abs()) {
            write!(writer, "{value}")
        } else {
            write!(writer, "{value:e}")
        }
    }

    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        if value == 0.0 || (1e-4..1e15).contains(&value.abs()) {
            write!(writer, "{value}")
        } else {
            write!(writer, "{value:e}")
        }
    }
}

/// A number. NaN and infinities are written as strings.
struct Number<T>(T);

impl Serialize for Number<f32> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() {
            serializer.serialize_f32(self.0)
        } else {
            serializer.collect_str(&self.0)
        }
    }
}

impl Serialize for Number<f64> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() {
            serializer.serialize_f64(self.0)
        } else {
            serializer.collect_str(&self.0)
        }
    }
}

struct Numbers<T, const N: usize>([T; N]);

impl<T: Copy, const N: usize> Serialize for Numbers<T, N>
where
    Number<T>: Serialize,
{
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.map(Number))
    }
}

struct ToolName(Tool);

impl Serialize for ToolName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Tool::Bias(bias) => Numbers(bias).serialize(serializer),
            named => serializer.collect_str(&named),
        }
    }
}

/// Spelling of names in steps. A step gives the text of its name if reading all steps rebuilds the
/// same list of names, else the index.
struct Names<'p> {
    list: &'p [String],
    /// Index of the first occurrence of each text.
    first: HashMap<&'p str, usize>,
    /// True if the file must list the names because the steps cannot rebuild the list.
    are_listed: bool,
}

impl<'p> Names<'p> {
    fn of(plan: &'p Plan) -> Self {
        let mut first = HashMap::new();
        for (at, name) in plan.names.iter().enumerate() {
            first.entry(name.as_str()).or_insert(at);
        }
        let mut seen = 0;
        let mut in_order = true;
        for index in plan
            .steps
            .iter()
            .filter_map(|step| step.origin.name_index())
        {
            // In order means that each name first appears after all names before it in the list.
            in_order &= index <= seen;
            seen += usize::from(index == seen);
        }
        let each_once = first.len() == plan.names.len();
        Self {
            list: &plan.names,
            first,
            are_listed: !(in_order && each_once && seen == plan.names.len()),
        }
    }

    /// Returns the text of a name if it identifies this index.
    fn text(&self, index: usize) -> Option<&'p str> {
        let text = self.list.get(index)?.as_str();
        (self.first.get(text) == Some(&index)).then_some(text)
    }
}

struct StepLine<'p> {
    step: &'p Step,
    names: &'p Names<'p>,
}

impl Serialize for StepLine<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        action(&mut map, &self.step.action)?;
        let origin = self.step.origin;
        let place = [origin.line, origin.column, origin.length];
        if place != [0; 3] {
            map.serialize_entry("at", &place)?;
        }
        if let Some(index) = origin.name_index() {
            match self.names.text(index) {
                Some(text) => map.serialize_entry("name", text)?,
                None => map.serialize_entry("name", &origin.name)?,
            }
        }
        map.end()
    }
}

fn action<M: SerializeMap>(map: &mut M, action: &Action) -> Result<(), M::Error> {
    let key = action.name();
    match action {
        Action::Move { to, by } => {
            map.serialize_entry(key, &Numbers(*to))?;
            map.serialize_entry("by", travel(*by))
        }
        Action::Joints { to, by } => {
            map.serialize_entry(key, &Numbers(*to))?;
            map.serialize_entry("by", travel(*by))
        }
        Action::Shift { by, line } => {
            map.serialize_entry(key, &Numbers(*by))?;
            let way = if *line { Travel::Line } else { Travel::Joints };
            map.serialize_entry("by", travel(way))
        }
        Action::Arc { via, to } => {
            map.serialize_entry(key, &Numbers(*to))?;
            map.serialize_entry("via", &Numbers(*via))
        }
        Action::Path { to } => map.serialize_entry(key, &Numbers(*to)),
        Action::Burn { to, power } => {
            map.serialize_entry(key, &Numbers(*to))?;
            map.serialize_entry("power", &Number(*power))
        }
        Action::Suction(on) => map.serialize_entry(key, on),
        Action::Gripper(grip) => map.serialize_entry(key, grip_name(*grip)),
        Action::Laser(on) => map.serialize_entry(key, on),
        Action::Wait(milliseconds) => {
            map.serialize_entry(key, &(f64::from(*milliseconds) / 1000.0))
        }
        Action::Home => map.serialize_entry(key, &true),
        Action::Command(command) => {
            map.serialize_entry(key, command.row().name)?;
            map.serialize_entry("values", &CommandValues(command))
        }
        Action::Part(part) => map.serialize_entry(key, &PartLine(part)),
        Action::Pause(pause) => {
            map.serialize_entry(key, &pause.text)?;
            map.serialize_entry("reason", pause.cause.name())
        }
    }
}

pub(super) fn travel(by: Travel) -> &'static str {
    match by {
        Travel::Joints => "joints",
        Travel::Line => "line",
        Travel::Jump => "jump",
    }
}

pub(super) fn grip_name(grip: Grip) -> &'static str {
    match grip {
        Grip::Off => "off",
        Grip::Open => "open",
        Grip::Close => "close",
    }
}

struct PartLine<'p>(&'p Part);

impl Serialize for PartLine<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Part {
            n,
            name,
            color,
            pass,
        } = self.0;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("n", n)?;
        map.serialize_entry("name", name)?;
        map.serialize_entry("color", &color.map(|color| color.to_string()))?;
        if let Some(pass) = pass {
            map.serialize_entry("pass", pass)?;
        }
        map.end()
    }
}

/// Fields of a command under the names of the protocol's table.
struct CommandValues<'c>(&'c Set);

impl Serialize for CommandValues<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let frame = FrameBuf::set(self.0, Ctrl::QUEUED).map_err(S::Error::custom)?;
        let layout = self.0.row().set;
        let values = layout.map(|layout| layout.values(frame.frame().params()));
        let mut map = serializer.serialize_map(None)?;
        for (field, value) in values
            .transpose()
            .map_err(S::Error::custom)?
            .into_iter()
            .flatten()
        {
            map.serialize_entry(field.name, &value)?;
        }
        map.end()
    }
}
