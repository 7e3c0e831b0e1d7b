//! Protocol table as Lua tables.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use magician_protocol::{
    Alarm, EnumInfo, Field, FieldType, Layout, LayoutInfo, NoArgs, QueuedCmdIndex, Row, Scalar,
    TABLE,
};

use super::forms::{self, Fit, Plan};
use super::quoted;

/// Returns all tables.
pub(super) fn all() -> String {
    [enums(), alarms(), notes(), layouts(), rows()].concat()
}

/// Returns the prefix of a row's filter names.
pub(super) fn prefix(row: &Row) -> String {
    let name = row.value.or(row.set).map_or(row.name, |layout| layout.name);
    let mut prefix = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !prefix.is_empty() {
            prefix.push('_');
        }
        prefix.push(letter.to_ascii_lowercase());
    }
    prefix
}

/// Returns the type of a field on the wire: the engine's name, the count and the enum.
pub(super) fn kind(ty: FieldType) -> String {
    let number = |scalar| match scalar {
        Scalar::U8 => "u8",
        Scalar::U16 => "u16",
        Scalar::U32 => "u32",
        Scalar::U64 => "u64",
        Scalar::I32 => "i32",
        Scalar::F32 => "f32",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    };
    match ty {
        FieldType::Scalar(scalar) => format!("kind = \"{}\"", number(scalar)),
        FieldType::Array(scalar, count) => {
            format!("kind = \"{}\", count = {count}", number(scalar))
        }
        FieldType::Flag => "kind = \"flag\"".to_owned(),
        FieldType::Enum(info) => format!("kind = \"enum\", enum = \"{}\"", info.name),
        FieldType::Text => "kind = \"text\"".to_owned(),
        FieldType::Bytes => "kind = \"bytes\"".to_owned(),
        FieldType::Alarms => "kind = \"alarms\"".to_owned(),
        FieldType::Outputs => "kind = \"outputs\"".to_owned(),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

fn enums() -> String {
    let mut known = BTreeSet::new();
    let mut text = String::from("local ENUMS = {\n");
    for (_, layout) in all_layouts() {
        for field in layout.fields {
            if let FieldType::Enum(info) = field.ty
                && known.insert(info.name)
            {
                text += &enumeration(info);
            }
        }
    }
    text + "}\n\n"
}

fn enumeration(info: &EnumInfo) -> String {
    let mut text = format!("    {} = {{\n", info.name);
    for variant in info.variants {
        let _ = writeln!(
            text,
            "        [{}] = {},",
            variant.value,
            quoted(variant.name)
        );
    }
    text + "    },\n"
}

fn alarms() -> String {
    let mut text = String::from("local ALARMS = {\n");
    for alarm in Alarm::TABLE {
        let says = quoted(&format!("{}: {}", alarm.name, alarm.cause));
        let _ = writeln!(text, "    [{:#04x}] = {says},", alarm.code);
    }
    text + "}\n\n"
}

/// Returns the names of the leniencies that do not depend on the command.
fn notes() -> String {
    let mut text = String::from("local NOTES = {\n");
    for (name, note) in forms::notes() {
        let _ = writeln!(text, "    {name} = {},", quoted(note));
    }
    text + "}\n\n"
}

/// Returns every layout once, with the prefix of its filter names.
fn all_layouts() -> impl Iterator<Item = (String, &'static LayoutInfo)> {
    let shared = [NoArgs::INFO, QueuedCmdIndex::INFO].map(|layout| (String::new(), layout));
    let own = TABLE.iter().flat_map(|row| {
        let layouts = [row.query, row.value, row.set].into_iter().flatten();
        layouts.map(|layout| (format!("{}.", prefix(row)), layout))
    });
    let mut known = BTreeSet::new();
    (shared.into_iter().chain(own)).filter(move |(_, layout)| known.insert(layout.name))
}

fn layouts() -> String {
    let mut text = String::from("local LAYOUTS = {}\n\n");
    for (prefix, layout) in all_layouts() {
        let head = layout.fields.split_last().map_or(0, |(_, head)| {
            head.iter().filter_map(|field| field.ty.size()).sum()
        });
        let _ = writeln!(text, "LAYOUTS.{} = {{", layout.name);
        let _ = writeln!(
            text,
            "    prefix = {},\n    head = {head},",
            quoted(&prefix)
        );
        text += "    fields = {\n";
        for field in layout.fields {
            let _ = writeln!(text, "        {},", field_text(field));
        }
        text += "    },\n    fits = {\n";
        for fit in forms::fits(layout) {
            let _ = writeln!(text, "        {},", fit_text(&fit));
        }
        text += "    },\n}\n\n";
    }
    text
}

fn field_text(field: &Field) -> String {
    let doc = if field.range.is_any() {
        field.doc.to_owned()
    } else {
        format!("{} Range: {}.", field.doc, field.range)
    };
    // Fields without a quantity have a word in place of a unit.
    let unit = match field.ty {
        FieldType::Scalar(_) | FieldType::Array(..) => match field.unit {
            "count" | "counts" | "id" | "index" | "reserved" | "free" | "EIO address"
            | "level or counts" => "",
            unit => unit,
        },
        _ => "",
    };
    let short = match field.name {
        name if name == QueuedCmdIndex::INFO.fields[0].name => "short = \"index\", ",
        _ => "",
    };
    let (name, kind) = (quoted(field.name), kind(field.ty));
    let (unit, doc) = (quoted(unit), quoted(&doc));
    format!("{{ name = {name}, {short}{kind}, unit = {unit}, doc = {doc} }}")
}

fn fit_text(fit: &Fit) -> String {
    let mut text = format!("{{ from = {}, to = {}", fit.from, fit.to);
    if fit.skip > 0 {
        let _ = write!(text, ", skip = {}", fit.skip);
    }
    if fit.bytes {
        text += ", bytes = true";
    }
    if let Some(note) = fit.note {
        let _ = write!(text, ", note = {}", quoted(note));
    }
    text + " }"
}

/// Returns for each id and each value of Ctrl's low two bits the form's name, both layouts, and
/// remarks.
fn rows() -> String {
    let mut text = String::from("local ROWS = {}\n\n");
    for row in TABLE {
        let _ = writeln!(
            text,
            "ROWS[{}] = {{\n    name = {},",
            row.id,
            quoted(row.name)
        );
        for ctrl in 0..4 {
            let _ = writeln!(
                text,
                "    [{ctrl}] = {},",
                plan_text(&forms::plan(row, ctrl))
            );
        }
        text += "}\n\n";
    }
    text
}

fn plan_text(plan: &Plan) -> String {
    let notes: Vec<String> = plan.notes.iter().map(|note| quoted(note)).collect();
    let notes = match &notes[..] {
        [] => "{}".to_owned(),
        notes => format!("{{ {} }}", notes.join(", ")),
    };
    format!(
        "{{ name = {}, request = LAYOUTS.{}, reply = LAYOUTS.{}, notes = {notes} }}",
        quoted(plan.name),
        plan.request.name,
        plan.reply.name
    )
}
