//! Commands in the schema of plan files: their fields, with the bounds of the protocol table. The
//! rest of the schema is written by hand. `schemars` could generate only that smaller part: it
//! derives schemas from Rust types, and the commands are rows of a table.

use std::error::Error;
use std::fs;
use std::path::Path;

use magician_protocol::commands::TABLE;
use magician_protocol::{Bounds, Field, FieldType, LayoutInfo, Range, Scalar};
use serde_json::{Map, Value, json};

use crate::python::field_description;

/// Schema of plan files.
const SCHEMA_FILE: &str = "crates/magician-formats/plan.schema.json";

/// Writes the commands into the schema.
pub(crate) fn write(root: &Path) -> Result<(), Box<dyn Error>> {
    let path = root.join(SCHEMA_FILE);
    let schema = with_commands(serde_json::from_str(&fs::read_to_string(&path)?)?)?;
    fs::write(path, serde_json::to_string_pretty(&schema)? + "\n")?;
    Ok(())
}

fn with_commands(mut schema: Value) -> Result<Value, Box<dyn Error>> {
    let steps = schema.pointer_mut("/$defs/step/oneOf");
    let steps = steps.and_then(Value::as_array_mut).ok_or("no steps")?;
    let command = steps
        .iter_mut()
        .find(|step| step.pointer("/properties/command").is_some());
    let command = command.and_then(Value::as_object_mut).ok_or("no command")?;
    let rows = TABLE.iter().filter(|row| row.queueable);
    let rows = rows.filter_map(|row| Some((row.name, row.doc, row.set?)));
    let mut commands = Map::new();
    let mut choices = Vec::new();
    for (name, doc, layout) in rows {
        commands.insert(name.to_owned(), command_schema(doc, layout));
        choices.push(json!({
            "if": { "properties": { "command": { "const": name } } },
            "then": { "properties": { "values": { "$ref": format!("#/$defs/commands/{name}") } } },
        }));
    }
    command.insert("allOf".to_owned(), choices.into());
    let defs = schema.pointer_mut("/$defs").and_then(Value::as_object_mut);
    let defs = defs.ok_or("no definitions")?;
    defs.insert("commands".to_owned(), commands.into());
    Ok(schema)
}

fn command_schema(doc: &str, layout: &LayoutInfo) -> Value {
    let fields = layout.fields.iter();
    let properties: Map<_, _> = fields
        .clone()
        .map(|field| (field.name.to_owned(), field_schema(field)))
        .collect();
    let required: Vec<_> = fields
        .filter(|field| !field.optional)
        .map(|field| field.name)
        .collect();
    json!({
        "description": doc,
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

fn field_schema(field: &Field) -> Value {
    let mut schema = match field.ty {
        FieldType::Scalar(scalar) => number_schema(scalar, field.range),
        FieldType::Array(scalar, count) => json!({
            "type": "array",
            "items": number_schema(scalar, field.range),
            "minItems": count,
            "maxItems": count,
        }),
        // Any value but 0 means on.
        FieldType::Flag => number_schema(Scalar::U8, Range::Any),
        FieldType::Enum(_) => number_schema(Scalar::U8, field.range),
        FieldType::Text | FieldType::Bytes => json!({ "type": "string" }),
        FieldType::Alarms => {
            json!({ "type": "array", "items": number_schema(Scalar::U8, Range::Any) })
        }
        FieldType::Outputs => json!({
            "type": "array",
            "items": { "oneOf": [{ "type": "string" }, { "$ref": "#/$defs/output" }] },
        }),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    };
    if let (Some(schema), Range::AtMost(max_length, _)) = (schema.as_object_mut(), field.range) {
        let keyword = match field.ty {
            FieldType::Text => "maxLength",
            _ => "maxItems",
        };
        schema.insert(keyword.to_owned(), max_length.into());
    }
    if let Some(schema) = schema.as_object_mut() {
        schema.insert("description".to_owned(), field_description(field).into());
    }
    schema
}

/// Returns the schema of a number, with the bounds of its type where its range has none.
fn number_schema(scalar: Scalar, range: Range) -> Value {
    let Bounds {
        minimum,
        exclusive_minimum,
        maximum,
    } = range.bounds();
    let (ty, type_minimum, type_maximum) = match scalar {
        Scalar::U8 => ("integer", Some(0), Some(u64::from(u8::MAX))),
        Scalar::U16 => ("integer", Some(0), Some(u64::from(u16::MAX))),
        Scalar::U32 => ("integer", Some(0), Some(u64::from(u32::MAX))),
        Scalar::U64 => ("integer", Some(0), None),
        Scalar::I32 => ("integer", None, None),
        Scalar::F32 => ("number", None, None),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    };
    let mut schema = Map::new();
    schema.insert("type".to_owned(), ty.into());
    let minimum = minimum.or(type_minimum.filter(|_| exclusive_minimum.is_none()));
    for (keyword, value) in [
        ("minimum", minimum.map(Value::from)),
        ("exclusiveMinimum", exclusive_minimum.map(Value::from)),
        (
            "maximum",
            maximum.map(Value::from).or(type_maximum.map(Value::from)),
        ),
    ] {
        if let Some(value) = value {
            schema.insert(keyword.to_owned(), value);
        }
    }
    schema.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schema() -> Value {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("..")
            .join(SCHEMA_FILE);
        serde_json::from_str(&fs::read_to_string(path).expect(SCHEMA_FILE)).expect("JSON")
    }

    #[test]
    fn schema_file_is_current() {
        let written = schema();
        let current = with_commands(written.clone()).expect("a schema");
        assert!(written == current, "cargo xtask plan-schema writes it anew");
    }

    #[test]
    fn bounds_agree_with_the_table() {
        let schema_at = |field: &str| {
            schema()
                .pointer(&format!("/$defs/commands/{field}"))
                .cloned()
        };
        let ratio = schema_at("PTPCommonParams/properties/velocity_ratio").expect("a field");
        assert_eq!(
            (&ratio["minimum"], &ratio["maximum"]),
            (&json!(1), &Value::Null)
        );
        let threshold = schema_at("TRIGCmd/properties/threshold").expect("a field");
        assert_eq!(threshold["maximum"], json!(4095));
        let speed = schema_at("PTPCoordinateParams/properties/xyz_velocity").expect("a field");
        assert_eq!(speed["exclusiveMinimum"], json!(0));
    }
}
