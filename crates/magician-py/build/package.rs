//! Generated parts of the Python package, which are not kept in git: classes of commands and alarms
//! from the protocol's table, the blocking interface from the asyncio one, and `DobotDllType` from
//! the sources beside the C library. Used by the build script and by `cargo xtask generate`.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use magician_protocol::commands::TABLE;
use magician_protocol::{Alarm, EnumInfo, Field, FieldType, LayoutInfo, Row, Scalar, Source};

const HEAD: &str = r#"#
# Generated from the protocol's table when the package is built, or by `cargo xtask generate python`.
"""All commands of the protocol, as value classes.

To read a value, pass its class: ``arm.get(commands.Pose)`` returns a :class:`Pose`. Read the value of a pin, a port
or a target with a query: ``arm.get(commands.GetIoDi(address=19))`` returns an :class:`IoDi`. To set a value, pass an
object: ``arm.set(commands.PtpCommonParams(velocity_ratio=50, acceleration_ratio=50))``. Commands that can be queued
are also accepted by ``arm.enqueue`` and ``arm.perform``.

The names are the vendor's, in Python's spelling. Lengths are mm, angles degrees. E numbers cite the errata to the
vendor's document.
"""

from __future__ import annotations

from typing import NamedTuple

from . import _meaning
from ._protocol import Answer, OpenEnum, Query, Queueable, Readable, Writable
from .alarms import Alarm

"#;

const OUTPUT: &str = r#"class Output(NamedTuple):
    """An output that a move switches along its path."""

    percent: int
    """Point of the move at which the output switches: percentage of the path, 0 to 100."""
    address: int
    """EIO address, 1 to 20."""
    high: bool
    """Level to set."""


"#;

const ALARMS_HEAD: &str = r#"#
# Generated from the protocol's table when the package is built, or by `cargo xtask generate python`.
"""Alarms of the controller, each with its cause and remedy."""

from __future__ import annotations

from ._protocol import OpenEnum

__all__ = ["Alarm"]


class Alarm(OpenEnum):
    """An alarm of the controller. Its value is the code, 0x00 to 0xFF; unnamed codes are kept as numbers.

    ``print(alarm)`` prints the cause and the remedy.
    """

"#;

const ALARMS_TAIL: &str = r#"
    @property
    def cause(self) -> str:
        """Cause of the alarm."""
        return _TEXTS.get(self, _NONE)[0]

    @property
    def cure(self) -> str:
        """Remedy for the alarm."""
        return _TEXTS.get(self, _NONE)[1]

    @property
    def holds_queue(self) -> bool:
        """True if the alarm holds the queue until it is cleared: all but 0x00 to 0x07."""
        return self > 0x07

    def __str__(self) -> str:
        return f"0x{int(self):02x} {self.name}: {self.cause} ({self.cure})"

    def __format__(self, spec: str) -> str:
        # Python 3.10 would write the text above in every format.
        return format(int(self), spec) if spec else str(self)


_NONE = ("unknown to this package", "look it up in the arm's manual")
_TEXTS = {
"#;

/// Classes with a hand-written base that interprets their numbers.
const INTERPRETED_CLASSES: [(&str, &str); 5] = [
    ("Pose", "PoseMeaning"),
    ("ColorSensor", "ColorMeaning"),
    ("IrSwitch", "InfraredMeaning"),
    ("IoDi", "LevelMeaning"),
    ("IoAdc", "AnalogMeaning"),
];

/// Python programs that generate the other files.
const GENERATORS: [&str; 2] = ["tools/blocking.py", "tools/dobotdll.py"];

/// Writes the generated files that have changed into the package at `package`. `python` is its
/// interpreter.
pub(crate) fn write(package: &Path, python: &str) -> Result<(), Box<dyn Error>> {
    for (name, text) in [("commands.py", commands()), ("alarms.py", alarms())] {
        let path = package.join("python/magician").join(name);
        // Leave unchanged files alone: Cargo and make rebuild by modification time.
        if fs::read_to_string(&path).is_ok_and(|written| written == text) {
            continue;
        }
        fs::write(path, text)?;
    }
    for tool in GENERATORS {
        let mut command = Command::new(python);
        let command = command.arg("-B").arg(package.join(tool));
        let status = command
            .status()
            .map_err(|error| format!("{python}: {error}"))?;
        if !status.success() {
            return Err(format!("{tool}: {status}").into());
        }
    }
    Ok(())
}

/// Describes a field: meaning, unit and range. Enums and flags have no range.
pub(crate) fn field_description(field: &Field) -> String {
    let mut about = field.doc.trim_end_matches('.').to_owned();
    if !matches!(
        field.unit,
        "" | "flag" | "enum" | "text" | "bytes" | "count" | "id" | "reserved"
    ) {
        let _ = write!(about, "; {}", field.unit);
    }
    let counts = !matches!(field.ty, FieldType::Enum(_) | FieldType::Flag);
    if !field.range.is_any() && counts {
        let _ = write!(about, "; {}", field.range);
    }
    about
}

fn commands() -> String {
    let mut classes = String::new();
    let kinds = [
        "Answer",
        "Output",
        "Query",
        "Queueable",
        "Readable",
        "Writable",
    ];
    let mut names = kinds.map(str::to_owned).to_vec();
    for info in enums() {
        names.push(info.name.to_owned());
        named_values(&mut classes, info);
    }
    classes += OUTPUT;
    for row in TABLE {
        command(&mut classes, &mut names, row);
    }
    names.sort();
    let mut page = HEAD.trim_start_matches("#\n").to_owned();
    page += "__all__ = [\n";
    for name in names {
        let _ = writeln!(page, "    \"{name}\",");
    }
    page += "]\n\n\n";
    page + classes.trim_end() + "\n"
}

fn alarms() -> String {
    let mut page = ALARMS_HEAD.trim_start_matches("#\n").to_owned();
    for alarm in Alarm::TABLE {
        let (name, code) = (upper(alarm.name), alarm.code);
        let _ = writeln!(page, "    {name} = 0x{code:02X}");
        doc(&mut page, &format!("{}.", capital(alarm.cause)));
    }
    page += ALARMS_TAIL;
    for alarm in Alarm::TABLE {
        let (code, cause, cure) = (alarm.code, alarm.cause, alarm.remedy);
        let entry = format!("    0x{code:02X}: ({cause:?}, {cure:?}),");
        let _ = match entry.len() {
            0..=120 => writeln!(page, "{entry}"),
            _ => writeln!(
                page,
                "    0x{code:02X}: (\n        {cause:?},\n        {cure:?},\n    ),"
            ),
        };
    }
    page + "}\n"
}

/// All enums of the table's fields, in table order.
fn enums() -> Vec<&'static EnumInfo> {
    let mut all: Vec<&EnumInfo> = Vec::new();
    let layouts = TABLE.iter().flat_map(|row| [row.query, row.value, row.set]);
    for field in layouts.flatten().flat_map(|layout| layout.fields) {
        if let FieldType::Enum(info) = field.ty
            && !all.iter().any(|known| known.name == info.name)
        {
            all.push(info);
        }
    }
    all
}

fn named_values(page: &mut String, info: &EnumInfo) {
    let about = match info.name {
        "PtpMode" => {
            "Kind of travel of a point-to-point move, and meaning of its numbers (document 1.10.5, E28)."
        }
        "JogCommand" => {
            "Direction of a jog; the axis is a joint or a coordinate (document 1.9.4, E25)."
        }
        "CpMode" => "Reference of the coordinates of a continuous-path segment (document 1.11.2).",
        "RailVersion" => "Generation of the sliding rail (E15).",
        "SensorVersion" => "Generation of a colour or infrared sensor (E42, E43).",
        "TeachTrigger" => "Trigger mode of hand teaching (document 1.7.1).",
        "IoFunction" => "Function of an EIO pin (document 1.15.1, E40).",
        "Port" => "Connector that a sensor is plugged into (E42).",
        "Stepper" => "External motor output (document 1.15.6).",
        "TriggerMode" => "Signal that a trigger observes (document 1.14.1).",
        "TriggerCondition" => "Comparison of a trigger with its threshold (document 1.14.1, E35).",
        "Handedness" => "Elbow side of a SCARA arm; without meaning for the Magician.",
        _ => "Named values.",
    };
    let _ = writeln!(
        page,
        "class {}(OpenEnum):\n    \"\"\"{about}\"\"\"\n",
        info.name
    );
    for variant in info.variants {
        let _ = writeln!(page, "    {} = {}", upper(variant.name), variant.value);
        doc(page, variant.doc);
    }
    *page += "\n\n";
}

/// Writes the classes of a command: value, query and set.
fn command(page: &mut String, names: &mut Vec<String>, row: &Row) {
    let asks = row.query.filter(|query| !query.fields.is_empty());
    let set = match (row.queueable, row.steers_queue()) {
        (true, false) => "Queueable",
        _ => "Writable",
    };
    let mut class = |page: &mut String, layout: &LayoutInfo, bases: &str, form: &str| {
        names.push(layout.name.to_owned());
        let meaning = INTERPRETED_CLASSES
            .iter()
            .find(|(name, _)| *name == layout.name);
        let bases = match meaning {
            Some((_, meaning)) => format!("_meaning.{meaning}, {bases}"),
            None => bases.to_owned(),
        };
        let _ = writeln!(page, "class {}({bases}):", layout.name);
        let (about, form) = (wrap_text(&format!("\"\"\"{}", row.doc)), wrap_text(form));
        let _ = writeln!(page, "{about}\n\n{form}\n    \"\"\"\n");
        let _ = writeln!(
            page,
            "    ID = {}\n    LAYOUT = \"{}\"",
            row.id, layout.name
        );
        if !layout.fields.is_empty() {
            *page += "\n";
        }
        layout.fields.iter().for_each(|field| line(page, field));
        *page += "\n\n";
    };
    let source = source(row);
    let asked = if asks.is_some() { "Answer" } else { "Readable" };
    match (row.value, row.set) {
        (Some(value), Some(set_layout)) if value == set_layout => {
            let form = format!("{}, {}; {source}.", row.get_name, row.set_name);
            class(page, value, &format!("{asked}, {set}"), &form);
        }
        (value, set_layout) => {
            if let Some(value) = value {
                let form = format!("{}; {source}.", row.get_name);
                class(page, value, asked, &form);
            }
            if let Some(layout) = set_layout {
                let form = format!("{}; {source}.", row.set_name);
                class(page, layout, set, &form);
            }
        }
    }
    if let (Some(query), Some(value)) = (asks, row.value) {
        let form = format!(
            "Query of {} for a :class:`{}`; {source}.",
            row.get_name, value.name
        );
        class(page, query, &format!("Query[{}]", value.name), &form);
    }
}

/// Id, source and restrictions of a command.
fn source(row: &Row) -> String {
    let mut source = format!("id {}, ", row.id);
    source += match row.source {
        Source::Document => "document V1.1.3",
        Source::Addition => "document V1.1.5",
        Source::Header => "vendor headers",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    };
    if !matches!(row.section, "" | "none") {
        let _ = write!(source, " section {}", row.section);
    }
    if !row.errata.is_empty() {
        let _ = write!(source, ", errata {}", row.errata);
    }
    if row.dangerous && row.set.is_some() {
        source += "; dangerous: requires ``allow_dangerous=True``";
    }
    source
}

/// Writes a field with type, default and description.
fn line(page: &mut String, field: &Field) {
    let optional = field.optional && field.default.is_none();
    let ty = type_of(field.ty);
    let (ty, default) = match (optional, field.default) {
        (true, _) if field.ty == FieldType::Bytes => (ty, " = b\"\"".to_owned()),
        (true, _) => (format!("{ty} | None"), " = None".to_owned()),
        (false, Some(default)) => (ty, format!(" = {default}")),
        (false, None) => (ty, String::new()),
    };
    let _ = writeln!(page, "    {}: {ty}{default}", field.name);
    doc(page, &format!("{}.", field_description(field)));
}

/// Writes a docstring, wrapped at 120 columns.
fn doc(page: &mut String, text: &str) {
    let _ = writeln!(page, "{}\"\"\"", wrap_text(&format!("\"\"\"{text}")));
}

/// Wraps words at 117 columns, indented.
fn wrap_text(text: &str) -> String {
    let mut lines = vec![String::from("   ")];
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.len() + word.len() < 117 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(format!("    {word}")),
        }
    }
    lines.join("\n")
}

fn type_of(ty: FieldType) -> String {
    let number = |scalar| match scalar {
        Scalar::F32 => "float",
        _ => "int",
    };
    match ty {
        FieldType::Scalar(scalar) => number(scalar).to_owned(),
        FieldType::Array(scalar, count) => {
            let numbers = vec![number(scalar); count];
            format!("tuple[{}]", numbers.join(", "))
        }
        FieldType::Flag => "bool".to_owned(),
        FieldType::Enum(info) => info.name.to_owned(),
        FieldType::Text => "str".to_owned(),
        FieldType::Bytes => "bytes".to_owned(),
        FieldType::Alarms => "tuple[Alarm, ...]".to_owned(),
        FieldType::Outputs => "tuple[Output, ...]".to_owned(),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

/// Converts `MovjXyz` to `MOVJ_XYZ`, and `LimitAxis23Pos` to `LIMIT_AXIS23_POS`.
fn upper(name: &str) -> String {
    let mut upper = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !upper.is_empty() {
            upper.push('_');
        }
        upper.push(letter.to_ascii_uppercase());
    }
    upper
}

fn capital(sentence: &str) -> String {
    let mut letters = sentence.chars();
    let first = letters.next().map(|letter| letter.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_layout_is_a_class() {
        let page = commands();
        let layouts = TABLE.iter().flat_map(|row| [row.query, row.value, row.set]);
        for layout in layouts.flatten().filter(|layout| layout.name != "NoArgs") {
            let class = format!("\nclass {}(", layout.name);
            assert_eq!(page.matches(&class).count(), 1, "{}", layout.name);
        }
    }

    #[test]
    fn names_follow_python_conventions() {
        assert_eq!(upper("MovjXyzInc"), "MOVJ_XYZ_INC");
        assert_eq!(upper("LimitAxis23Pos"), "LIMIT_AXIS23_POS");
        assert_eq!(upper("V1"), "V1");
    }
}
