//! Examples of all methods and notifications, from JSON files.
//!
//! The documentation shows them and a test runs them against a station. The schemas of results are
//! derived from the examples, so an example must contain every member of a result.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use serde_json::{Map, Value, json};

use super::shape::or_null;
use super::{TYPES, Type};

/// Examples by method: `params`; in `after` the method whose result has the ids; `result`; in
/// `nullable` the places of the result that may be null, each with the schema of its other values
/// if it is null in the example; and `schema` for results that these do not describe.
static EXAMPLES: LazyLock<Map<String, Value>> =
    LazyLock::new(|| serde_json::from_str(include_str!("examples.json")).unwrap_or_default());

/// Call that succeeds on a fresh virtual arm, by a session that holds the lease if the method needs
/// it.
#[derive(Clone, Debug, PartialEq)]
pub struct Example {
    /// Parameters.
    pub params: Map<String, Value>,
    /// Method that is called first. Its result has the ids of these parameters under their names.
    pub after: Option<String>,
    /// Result, except for times and ids. `None` for a notification.
    pub result: Option<Value>,
    /// Places of the result that may be null, with their schema if they are null in the example.
    nullable: Map<String, Value>,
    /// JSON Schema of the result, if the example does not determine it.
    schema: Option<Value>,
}

impl Example {
    /// Returns the example of a method.
    #[must_use]
    pub fn of(method: &str) -> Option<Self> {
        let example = EXAMPLES.get(method)?;
        Some(Self {
            params: example["params"].as_object().cloned().unwrap_or_default(),
            after: example["after"].as_str().map(str::to_owned),
            result: example.get("result").cloned(),
            nullable: example["nullable"].as_object().cloned().unwrap_or_default(),
            schema: example.get("schema").cloned(),
        })
    }

    /// Returns the parameters with the ids from an earlier result.
    #[must_use]
    pub fn params_after(&self, earlier: &Value) -> Value {
        let with_ids = self.params.iter().map(|(name, value)| {
            let id = earlier.get(name).unwrap_or(value);
            (name.clone(), id.clone())
        });
        Value::Object(with_ids.collect())
    }

    /// Returns the JSON Schema of the result.
    pub(super) fn shape(&self) -> Value {
        match (&self.schema, &self.result) {
            (Some(schema), _) => schema.clone(),
            // A notification that is sent with an id is answered with null.
            (None, None | Some(Value::Null)) => json!({"type": "null"}),
            (None, Some(result)) => self.shape_of(result, "", None),
        }
    }

    /// Returns the JSON Schema of a place in the result.
    fn shape_at(&self, place: &str, component: &str) -> Value {
        let found = self.result.as_ref().and_then(|result| at(result, place));
        found.map_or_else(
            || json!({}),
            |found| self.shape_of(found, place, Some(component)),
        )
    }

    /// Returns the JSON Schema of a value. Objects that are components become references, except
    /// the component with this name.
    fn shape_of(&self, value: &Value, place: &str, component: Option<&str>) -> Value {
        let named = component_of(value).filter(|name| Some(*name) != component);
        let mut schema = match value {
            Value::Null => { self.nullable.get(place) }
                .cloned()
                .unwrap_or_else(|| json!({})),
            Value::Bool(_) => json!({"type": "boolean"}),
            Value::Number(_) => json!({"type": "number"}),
            Value::String(_) => json!({"type": "string"}),
            Value::Array(items) => match items.first() {
                Some(first) => {
                    let items = self.shape_of(first, &format!("{place}[]"), None);
                    json!({"type": "array", "items": items})
                }
                None => json!({"type": "array"}),
            },
            Value::Object(_) if named.is_some() => {
                let name = named.unwrap_or_default();
                json!({"$ref": format!("#/components/schemas/{name}")})
            }
            Value::Object(members) => {
                let members = members.iter().map(|(name, value)| {
                    let dot = if place.is_empty() { "" } else { "." };
                    let place = format!("{place}{dot}{name}");
                    (name.clone(), self.shape_of(value, &place, None))
                });
                let members: Map<_, _> = members.collect();
                let names: Vec<_> = members.keys().cloned().collect();
                json!({"type": "object", "properties": members, "required": names})
            }
        };
        if self.nullable.contains_key(place) && component.is_none() {
            schema = or_null(schema);
        }
        schema
    }
}

/// Components derived from examples: name, method, and place in its result.
const COMPONENTS: [(&str, &str, &str); 2] = [
    ("Field", "arm.io", "rows[].sets[]"),
    ("Choice", "arm.io", "rows[].sets[].choices[]"),
];

/// Components with optional members, which no example can describe: `schemas.json`.
static SCHEMAS: LazyLock<Map<String, Value>> =
    LazyLock::new(|| serde_json::from_str(include_str!("schemas.json")).unwrap_or_default());

/// Returns the components missing from the table of types, as JSON Schema by name.
pub(super) fn components() -> Map<String, Value> {
    let shape = |method, place, name| match Example::of(method) {
        Some(example) => example.shape_at(place, name),
        None => json!({}),
    };
    let components = COMPONENTS.iter();
    let components =
        components.map(|(name, method, place)| ((*name).to_owned(), shape(*method, *place, *name)));
    components.chain(SCHEMAS.clone()).collect()
}

/// Returns the component that has exactly these members.
fn component_of(value: &Value) -> Option<&'static str> {
    let names = |value: &Value| Some(value.as_object()?.keys().cloned().collect::<BTreeSet<_>>());
    let members = names(value)?;
    let is_type = |one: &&Type| {
        // The same names and no others: a superset would be another object.
        one.members.len() == members.len()
            && one
                .members
                .iter()
                .all(|member| members.contains(member.name))
    };
    if let Some(one) = TYPES.iter().find(is_type) {
        return Some(one.name);
    }
    let is = |(_, method, place): &&(&str, &str, &str)| {
        let example = &EXAMPLES[*method]["result"];
        at(example, place).and_then(names).as_ref() == Some(&members)
    };
    COMPONENTS.iter().find(is).map(|(name, ..)| *name)
}

/// Examples by notification (for `arm.event` by event): the calls that cause it, the client that
/// receives it, and its `params`. From `notifications.json`.
static NOTIFICATION_EXAMPLES: LazyLock<Map<String, Value>> =
    LazyLock::new(|| serde_json::from_str(include_str!("notifications.json")).unwrap_or_default());

/// Call in the example of a notification.
#[derive(Clone, Debug, PartialEq)]
pub struct ExampleCall {
    /// Client that calls.
    pub client: String,
    /// Method, or `server.ending` for the end of the station.
    pub method: String,
    /// Parameters. Ids are those of earlier results.
    pub params: Value,
}

/// Notification or event as received by a client, with its cause.
#[derive(Clone, Debug, PartialEq)]
pub struct NotificationExample {
    /// Calls that cause it, in order.
    pub after: Vec<ExampleCall>,
    /// Client that receives it.
    pub recipient: String,
    /// Parameters, except for times and ids.
    pub params: Value,
}

impl NotificationExample {
    /// Returns the example of a notification or an event.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        let example = NOTIFICATION_EXAMPLES.get(name)?;
        let after = example["after"].as_array()?.iter().map(|call| {
            Some(ExampleCall {
                client: call[0].as_str()?.to_owned(),
                method: call[1].as_str()?.to_owned(),
                params: call.get(2).cloned().unwrap_or_else(|| json!({})),
            })
        });
        Some(Self {
            after: after.collect::<Option<_>>()?,
            recipient: example["heard_by"].as_str()?.to_owned(),
            params: example["params"].clone(),
        })
    }
}

/// Returns the value at a place: member names separated by points; `[]` selects the first item of a
/// list.
fn at<'v>(value: &'v Value, place: &str) -> Option<&'v Value> {
    let steps = place.split('.').filter(|step| !step.is_empty());
    steps
        .flat_map(|step| {
            let (name, lists) = step
                .split_once("[]")
                .map_or((step, 0), |(name, _)| (name, step.matches("[]").count()));
            // `[]` may follow a name several times, for lists of lists.
            std::iter::once(Some(name)).chain(std::iter::repeat_n(None, lists))
        })
        .try_fold(value, |value, step| match step {
            Some(name) => value.get(name),
            None => value.get(0),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Collects the places of a value that are null, except within components, which describe it
    /// themselves.
    fn nulls(value: &Value, place: &str, found: &mut Vec<String>) {
        match value {
            Value::Null => found.push(place.to_owned()),
            Value::Array(items) => {
                if let Some(first) = items.first() {
                    nulls(first, &format!("{place}[]"), found);
                }
            }
            Value::Object(members) if place.is_empty() || component_of(value).is_none() => {
                for (name, value) in members {
                    let dot = if place.is_empty() { "" } else { "." };
                    nulls(value, &format!("{place}{dot}{name}"), found);
                }
            }
            _ => {}
        }
    }

    #[test]
    fn nullable_places_match_the_nulls_of_examples() {
        for name in EXAMPLES.keys() {
            let example = Example::of(name).unwrap();
            let result = example.result.clone().unwrap_or_default();
            for (place, schema) in &example.nullable {
                let there = at(&result, place).unwrap_or_else(|| panic!("{name}: {place}"));
                assert_eq!(there.is_null(), !schema.is_null(), "{name}: {place}");
            }
            if result.is_null() || example.schema.is_some() || component_of(&result).is_some() {
                continue;
            }
            let mut found = Vec::new();
            nulls(&result, "", &mut found);
            for place in found {
                assert!(example.nullable.contains_key(&place), "{name}: {place}");
            }
        }
    }

    #[test]
    fn null_is_allowed_only_at_its_place() {
        let schema = |method| Example::of(method).unwrap().shape();
        let arms = schema("arm.list")["properties"]["arms"]["items"]["properties"].clone();
        assert_eq!(arms["name"]["type"], json!("string"));
        let holder = json!({"$ref": "#/components/schemas/Holder"});
        assert_eq!(arms["holder"], json!({"anyOf": [holder, {"type": "null"}]}));
        let started = schema("job.start");
        assert_eq!(started["properties"]["job"]["type"], json!("string"));
    }

    #[test]
    fn component_is_referenced_at_every_occurrence() {
        let job = json!({"$ref": "#/components/schemas/Job"});
        for method in ["job.get", "job.pause", "job.resume", "job.stop"] {
            assert_eq!(Example::of(method).unwrap().shape(), job, "{method}");
        }
        let list = Example::of("job.list").unwrap().shape();
        assert_eq!(list["properties"]["jobs"]["items"], job);
        let state = json!({"$ref": "#/components/schemas/State"});
        assert_eq!(Example::of("arm.state").unwrap().shape(), state);
    }
}
