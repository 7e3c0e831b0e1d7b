//! Full description of one command of the protocol (`magician commands NAME`).

use magician_protocol::{Effect, Field, FieldType, LayoutInfo, Row};

use super::record::{chapter_name, confidence, section, source, type_name};
use super::{Entry, example, find};
use crate::columns::{Columns, wrap};
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Output;

/// Shows what a command takes, returns and means.
pub(crate) fn explain(name: &str, context: &mut Context) -> Result<(), Failure> {
    let row = find(name)?;
    context.show(&Entry::full(row), |out| write_text(row, out))
}

fn write_text(row: &'static Row, out: &mut Output) -> Result<(), Failure> {
    let paint = out.paint;
    out.line(format_args!("{}  id {}", paint.name(row.name), row.id))?;
    for line in wrap(row.doc, out.width()) {
        out.line(line)?;
    }
    out.line("")?;
    facts(row).write(out)?;
    if let Some(query) = row.query.filter(|_| row.value.is_some()) {
        write_layout("Parameters of a get", query, out)?;
    }
    match (row.value, row.set) {
        (Some(value), Some(set)) if value == set => write_layout("Value", value, out)?,
        (value, set) => {
            value.map_or(Ok(()), |info| write_layout("Reply to a get", info, out))?;
            set.map_or(Ok(()), |info| {
                write_layout("Parameters of a set", info, out)
            })?;
        }
    }
    out.line("")?;
    out.line(paint.heading("Examples"))?;
    for line in example::lines(row) {
        out.line(format_args!("  {line}"))?;
    }
    Ok(())
}

fn facts(row: &Row) -> Columns {
    let mut columns = Columns::indented(2);
    let names = [
        row.value.map(|_| row.get_name),
        row.set.map(|_| row.set_name),
    ];
    let names: Vec<_> = names.into_iter().flatten().collect();
    columns.row(["forms", &names.join(", ")]);
    columns.row(["queue", queue(row)]);
    if row.set.is_some() {
        columns.row(["effect", effect(row)]);
    }
    if let Some(danger) = row.danger() {
        columns.row(["danger", &format!("{danger}: a set needs --yes")]);
    }
    columns.row(["chapter", &chapter_name(row)]);
    let section = match section(row) {
        "" => String::new(),
        section => format!(", section {section}"),
    };
    let errata = match row.errata {
        "" => String::new(),
        errata => format!(", corrected by errata {errata}"),
    };
    let origin = format!(
        "{}{section}{errata}; confidence in its layout: {}",
        source(row),
        confidence(row)
    );
    columns.row(["source", &origin]);
    columns
}

/// Describes what a set changes on the arm.
fn effect(row: &Row) -> &'static str {
    match row.effect {
        Effect::Look | Effect::Consume => "",
        Effect::Setting if row.may_burn => "sets a value; can light the laser",
        Effect::Setting => "sets a value",
        Effect::Store => "changes a value in non-volatile memory",
        Effect::Motion if row.may_burn => "moves the arm; can light the laser",
        Effect::Motion => "moves the arm",
        Effect::Jog => "moves the arm until it is stopped",
        Effect::Motor => "runs an external motor",
        Effect::Laser => "switches the laser",
        Effect::Wait => "pauses the queue",
        Effect::Queue => "controls the queue",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

fn queue(row: &Row) -> &'static str {
    match (row.set, row.queueable) {
        (None, _) => "no: read-only",
        (Some(_), _) if row.steers_queue() => {
            "no: it takes effect at once, regardless of the bit isQueued"
        }
        (Some(_), true) => "a set may be queued",
        (Some(_), false) => "no: a set takes effect at once",
    }
}

fn write_layout(title: &str, info: &'static LayoutInfo, out: &mut Output) -> Result<(), Failure> {
    let size = match (info.size(), info.fields) {
        (_, []) => return out.line(format_args!("\n{}: nothing", out.paint.heading(title))),
        (Some(1), _) => "1 byte".to_owned(),
        (Some(size), _) => format!("{size} bytes"),
        (None, [_]) => "the rest of the frame".to_owned(),
        (None, fields) => {
            let fixed: usize = fields.iter().filter_map(|field| field.ty.size()).sum();
            format!("{fixed} bytes and the rest of the frame")
        }
    };
    out.line(format_args!("\n{}, {size}", out.paint.heading(title)))?;
    let mut columns = Columns::indented(2);
    for field in info.fields {
        add_field_row(field, &mut columns);
    }
    columns.write(out)?;
    for form in info.forms {
        out.line(format_args!(
            "  also accepted in {} bytes: {}",
            form.len, form.note
        ))?;
    }
    Ok(())
}

fn add_field_row(field: &'static Field, columns: &mut Columns) {
    let unit = match field.unit {
        "flag" | "enum" | "text" | "bytes" => "",
        unit => unit,
    };
    let mut about = field.doc.to_owned();
    if !field.range.is_any() && !matches!(field.ty, FieldType::Enum(_) | FieldType::Flag) {
        about.push_str(&format!(" Range: {}.", field.range));
    }
    match (field.optional, field.default) {
        (_, Some(default)) => about.push_str(&format!(" Default: {default}.")),
        (true, None) => about.push_str(" Optional."),
        (false, None) => (),
    }
    columns.row([field.name, &type_name(field.ty), unit, &about]);
    if let FieldType::Enum(info) = field.ty {
        for variant in info.variants {
            let about = format!("{:>2} {}: {}", variant.value, variant.name, variant.doc);
            columns.row(["", "", "", &about]);
        }
    }
}
