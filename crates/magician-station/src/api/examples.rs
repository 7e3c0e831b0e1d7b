//! An example of every method, as data: `examples.json`. The documents show them, and a test runs them.

use std::sync::LazyLock;

use serde_json::{Map, Value, json};

/// By method: `params`, the method in `after` whose result has the ids, the `result`, and the `schema` of results
/// where that one does not tell it.
static EXAMPLES: LazyLock<Map<String, Value>> =
    LazyLock::new(|| serde_json::from_str(include_str!("examples.json")).unwrap_or_default());

/// A call that succeeds on a virtual arm of its own, by a session that has the lease where the method needs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Example {
    /// What it is given.
    pub params: Map<String, Value>,
    /// The method that is called before, and whose result has the ids of these parameters under their names.
    pub after: Option<String>,
    /// What it answers, but for times and ids; `None` for a notification.
    pub result: Option<Value>,
    /// What the method answers, where its result does not tell it, as JSON Schema.
    pub(super) schema: Option<Value>,
}

impl Example {
    /// The example of a method.
    #[must_use]
    pub fn of(method: &str) -> Option<Self> {
        let example = EXAMPLES.get(method)?;
        Some(Self {
            params: example["params"].as_object().cloned().unwrap_or_default(),
            after: example["after"].as_str().map(str::to_owned),
            result: example.get("result").cloned(),
            schema: example.get("schema").cloned(),
        })
    }

    /// Its parameters with the ids of an earlier result.
    #[must_use]
    pub fn params_after(&self, earlier: &Value) -> Value {
        let with_ids = self.params.iter().map(|(name, value)| {
            let id = earlier.get(name).unwrap_or(value);
            (name.clone(), id.clone())
        });
        Value::Object(with_ids.collect())
    }

    /// The kind of its result, as JSON Schema.
    pub(super) fn shape(&self) -> Value {
        match &self.result {
            Some(Value::Null) => json!({"type": "null"}),
            Some(result) => shape(result, false),
            None => json!({}),
        }
    }
}

/// Members that are null where they are not known, or where there is nothing to tell.
const NULLABLE: &[&str] = &[
    "alarms",
    "asks",
    "belt",
    "bias",
    "can",
    "drawing",
    "drawn_mm",
    "duty_cycle",
    "ended",
    "error",
    "first_step",
    "format",
    "frequency",
    "gripper",
    "holder",
    "homed",
    "job",
    "jog",
    "joint",
    "l",
    "laser",
    "least",
    "level",
    "loops",
    "most",
    "name",
    "parent",
    "part",
    "rail",
    "reason",
    "seconds_left",
    "sets",
    "speed",
    "started",
    "steps",
    "strokes",
    "suction",
    "table",
    "tells",
    "title",
    "travel_mm",
    "watch",
];

fn shape(value: &Value, nullable: bool) -> Value {
    let mut schema = match value {
        Value::Null => return json!({}),
        Value::Bool(_) => json!({"type": "boolean"}),
        Value::Number(_) => json!({"type": "number"}),
        Value::String(_) => json!({"type": "string"}),
        Value::Array(items) => match items.first() {
            Some(first) => json!({"type": "array", "items": shape(first, false)}),
            None => json!({"type": "array"}),
        },
        Value::Object(members) => {
            let members = members.iter().map(|(name, value)| {
                let nullable = NULLABLE.contains(&name.as_str());
                (name.clone(), shape(value, nullable))
            });
            json!({"type": "object", "properties": members.collect::<Map<_, _>>()})
        }
    };
    if nullable {
        schema["type"] = json!([schema["type"], "null"]);
    }
    schema
}
