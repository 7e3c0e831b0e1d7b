//! Named schemas of the OpenRPC document.

use magician_program::{OptionKind, OptionSpec, PLAN_SCHEMA, SetupOptions};
use serde_json::{Map, Value, json};

use super::examples;
use super::notifications::EVENT;
use super::shape::{Member, Shape, Type, is, object};
use super::{EVENTS, TYPES};

const SCHEMA_PREFIX: &str = "#/components/schemas/";

/// Returns all components.
pub(super) fn components() -> Map<String, Value> {
    let mut all = Map::new();
    for one in TYPES {
        all.insert(one.name.to_owned(), one.schema());
    }
    all.insert("StateChange".to_owned(), state_change());
    all.insert("Event".to_owned(), event());
    all.insert("Fields".to_owned(), fields());
    all.insert("Setup".to_owned(), setup());
    all.insert("PenSetup".to_owned(), pen());
    plan(&mut all);
    all.extend(examples::components());
    all
}

/// Returns the schema of a change of state.
fn state_change() -> Value {
    let members = Type::named("State").map_or(&[][..], |state| state.members);
    let mut schema = object(members);
    schema["required"] = json!(["t"]);
    schema["description"] = json!(
        "A State, or what of it is other than in the last one: each member that is there takes the place of the one before, whole"
    );
    schema
}

/// Returns the schema of an event of any kind.
fn event() -> Value {
    let kinds = EVENTS.iter().map(|row| {
        let mut members = EVENT.to_vec();
        members.extend(row.members);
        let mut schema = object(&members);
        schema["properties"]["event"] = json!({"type": "string", "enum": [row.name]});
        schema["description"] = json!(row.when);
        schema
    });
    json!({"anyOf": kinds.collect::<Vec<_>>(), "description": "Something that happened at an arm"})
}

/// Returns the schema of a command's fields.
fn fields() -> Value {
    let number_or_text = json!([{"type": "number"}, {"type": "string"}, {"type": "boolean"}]);
    let output = json!({"type": "object", "additionalProperties": {"type": "number"}});
    let items = json!({"anyOf": [{"type": "number"}, {"type": "string"}, output]});
    json!({
        "type": "object",
        "description": "Fields of a command by their names in the protocol's table: numbers, texts, and lists of them",
        "additionalProperties": {"anyOf": [
            number_or_text[0], number_or_text[1], number_or_text[2], {"type": "array", "items": items}
        ]},
    })
}

/// Returns the schema of drawing options, from the table of options.
fn setup() -> Value {
    let mut properties = Map::new();
    let preset =
        json!({"type": "string", "description": "A preset, which says what the rest leaves open"});
    properties.insert("preset".to_owned(), preset);
    for row in SetupOptions::OPTIONS {
        properties.insert(row.name.to_owned(), option(row));
    }
    json!({
        "type": "object",
        "description": "How a program is drawn or engraved",
        "properties": properties,
        "required": [],
    })
}

fn option(row: &OptionSpec) -> Value {
    let mut schema = match row.kind {
        // A fixed set of words. Choices that also accept other text are plain strings.
        OptionKind::Choice if row.expects.is_empty() => {
            json!({"type": "string", "enum": row.choices})
        }
        OptionKind::Number | OptionKind::Integer => number(row),
        OptionKind::Point => numbers(2, "number"),
        OptionKind::Place => numbers(3, "number"),
        OptionKind::Area => numbers(4, "integer"),
        OptionKind::Switch => json!({"type": "boolean"}),
        OptionKind::List => json!({"type": "array", "items": {"type": "string"}}),
        OptionKind::Pens => {
            json!({"type": "array", "items": {"$ref": format!("{SCHEMA_PREFIX}PenSetup")}})
        }
        // Text, and choices that accept other text as well.
        _ => json!({"type": "string"}),
    };
    match row.name {
        // The table of options cannot express that these two options take more than one type.
        "power" => schema = json!({"anyOf": [{"type": "number"}, {"type": "string"}]}),
        "tool" => schema = json!({"anyOf": [{"type": "string"}, numbers(3, "number")]}),
        _ => {}
    }
    let unit = match row.unit {
        "" => String::new(),
        unit => format!(", {unit}"),
    };
    schema["description"] = json!(format!("{}{unit}", row.about));
    schema
}

fn number(row: &OptionSpec) -> Value {
    let kind = match row.kind {
        OptionKind::Integer => "integer",
        _ => "number",
    };
    let mut schema = json!({"type": kind});
    for (name, bound) in [
        ("minimum", row.least),
        ("exclusiveMinimum", row.above),
        ("maximum", row.most),
    ] {
        if let Some(bound) = bound {
            schema[name] = json!(bound);
        }
    }
    schema
}

fn numbers(count: usize, kind: &str) -> Value {
    json!({"type": "array", "items": {"type": kind}, "minItems": count, "maxItems": count})
}

/// Returns the schema of an entry of `pens`.
fn pen() -> Value {
    const PART: Shape = Shape::Either(&[Shape::Text, Shape::Count]);
    const PEN: &[Member] = &[
        is(
            "match",
            PART,
            "the parts that it is for: a name or a colour, or a number from 1",
        ),
        is("surface_offset", Shape::Number, "how much higher it draws")
            .in_unit("mm")
            .optional(),
        is("lift", Shape::Number, "pen lift between lines")
            .in_unit("mm")
            .optional(),
        is("speed", Shape::Number, "speed along the lines")
            .in_unit("mm/s")
            .optional(),
        is("power", Shape::Number, "power along the lines")
            .in_unit("percent")
            .optional(),
        is("passes", Shape::Count, "how often its parts are drawn").optional(),
        is("fill", Shape::Text, "how their shapes are filled").optional(),
    ];
    object(PEN)
}

/// Adds the schemas of plans, without the fields of each command, which the schema file of plans
/// lists.
fn plan(all: &mut Map<String, Value>) {
    let Ok(mut plan) = serde_json::from_str::<Value>(PLAN_SCHEMA) else {
        return;
    };
    let parts = plan["$defs"].take();
    if let Some(properties) = plan["properties"].as_object_mut() {
        properties.remove("$schema");
    }
    let kept = ["type", "description", "properties", "required"];
    if let Value::Object(plan) = &mut plan {
        plan.retain(|name, _| kept.contains(&name.as_str()));
    }
    all.insert("Plan".to_owned(), named(plan));
    let steps = [
        ("at", "PlanOrigin"),
        ("name", "PlanName"),
        ("output", "PlanOutput"),
        ("step", "PlanStep"),
    ];
    for (part, name) in steps {
        all.insert(name.to_owned(), named(parts[part].clone()));
    }
}

/// Renames the references in a schema of plans to those of this document.
fn named(schema: Value) -> Value {
    match schema {
        // Plan files may write NaN and infinities as text. No step of a client contains one.
        Value::Object(members) if members.get("$ref") == Some(&json!("#/$defs/number")) => {
            json!({"type": "number"})
        }
        Value::Object(members) => {
            let members = members.into_iter().filter(|(name, _)| name != "allOf");
            Value::Object(members.map(|(name, value)| (name, named(value))).collect())
        }
        Value::Array(items) => Value::Array(items.into_iter().map(named).collect()),
        Value::String(text) => match text.strip_prefix("#/$defs/") {
            None => Value::String(text),
            Some("at") => json!(format!("{SCHEMA_PREFIX}PlanOrigin")),
            Some("name") => json!(format!("{SCHEMA_PREFIX}PlanName")),
            Some("output") => json!(format!("{SCHEMA_PREFIX}PlanOutput")),
            Some(_) => json!(format!("{SCHEMA_PREFIX}PlanStep")),
        },
        other => other,
    }
}
