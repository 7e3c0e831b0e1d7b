//! Fields of a command with their values, formatted for people and parsed from `key=value` words.

use magician_protocol::{Description, LayoutInfo, MAX_PARAMS, Row, Writer, encode_text};

use crate::columns::Columns;
use crate::failure::Failure;

/// Formats the fields of a frame: name, value, unit.
pub(crate) fn columns(description: &Description<'_>, indent: usize) -> Result<Columns, Failure> {
    let mut columns = Columns::indented(indent);
    let values = description.values();
    for (field, value) in values.map_err(|error| Failure::unexpected(error.to_string()))? {
        let value = value.to_string().replace(", ", ",").replace(',', ", ");
        let text = format!("{value} {}", unit(field.unit));
        columns.row([field.name, text.trim_end()]);
    }
    Ok(columns)
}

/// Formats a unit for display after a value; empty if the field is not a quantity.
pub(crate) fn unit(unit: &'static str) -> String {
    match unit {
        "flag" | "enum" | "text" | "bytes" | "bitmap" | "reserved" | "index" | "id" | "count" => {
            String::new()
        }
        unit if unit.contains([',', ';', ':']) => format!("({unit})"),
        unit => unit.to_owned(),
    }
}

/// Encodes the parameters given by `key=value` words.
pub(crate) fn params(row: &Row, layout: &LayoutInfo, words: &[String]) -> Result<Vec<u8>, Failure> {
    let mut pairs = Vec::with_capacity(words.len());
    for word in words {
        let pair = word.split_once('=');
        pairs.push(pair.ok_or_else(|| {
            let message = format!(
                "`{word}` is not a field of {}: expected key=value",
                row.name
            );
            Failure::usage(message).hint(fields_hint(row, layout))
        })?);
    }
    let mut params = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    encode_text(layout, &pairs, &mut writer).map_err(|error| {
        Failure::usage(format!("{}: {error}", row.name)).hint(fields_hint(row, layout))
    })?;
    let count = writer.finish();
    let count = count.map_err(|error| Failure::usage(format!("{}: {error}", row.name)))?;
    Ok(params.get(..count).unwrap_or_default().to_vec())
}

fn fields_hint(row: &Row, layout: &LayoutInfo) -> String {
    let names: Vec<_> = layout.fields.iter().map(|field| field.name).collect();
    match names.as_slice() {
        [] => format!("{} takes no fields", row.name),
        names => format!(
            "fields: {}; `magician commands {}` explains them",
            names.join(", "),
            row.name
        ),
    }
}
