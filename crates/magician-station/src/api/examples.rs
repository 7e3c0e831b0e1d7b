//! An example of every method, as data: `examples.json`. The documents show them, and a test runs them.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use serde_json::{Map, Value, json};

use super::shape::or_null;
use super::{TYPES, Type};

/// By method: `params`, the method in `after` whose result has the ids, the `result`, the places of it that are null where something
/// is not known or where there is nothing to tell (`nullable`: each with what is there otherwise if it is null in the example), and
/// the `schema` of results where all that does not tell it.
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
    /// Places of the result that may be null; their schema where they are in the example.
    nullable: Map<String, Value>,
    /// What the method answers, where its result does not tell it, as JSON Schema.
    schema: Option<Value>,
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
            nullable: example["nullable"].as_object().cloned().unwrap_or_default(),
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
        match (&self.schema, &self.result) {
            (Some(schema), _) => schema.clone(),
            // A notification that is sent as a request is answered with null.
            (None, None | Some(Value::Null)) => json!({"type": "null"}),
            (None, Some(result)) => self.shape_of(result, "", None),
        }
    }

    /// The kind of what stands there in its result.
    fn shape_at(&self, place: &str, component: &str) -> Value {
        let found = self.result.as_ref().and_then(|result| at(result, place));
        found.map_or_else(
            || json!({}),
            |found| self.shape_of(found, place, Some(component)),
        )
    }

    /// The kind of a value there; the component of this name is spelled out.
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

/// Objects that an example tells: the name of each, and a method with the place of it in that one's result.
const COMPONENTS: [(&str, &str, &str); 2] = [
    ("Field", "arm.io", "rows[].sets[]"),
    ("Choice", "arm.io", "rows[].sets[].choices[]"),
];

/// What has members that are not always there, which no example tells: `schemas.json`.
static SCHEMAS: LazyLock<Map<String, Value>> =
    LazyLock::new(|| serde_json::from_str(include_str!("schemas.json")).unwrap_or_default());

/// The components that no table tells, by their names, as JSON Schema.
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

/// The component that has these members.
fn component_of(value: &Value) -> Option<&'static str> {
    let names = |value: &Value| Some(value.as_object()?.keys().cloned().collect::<BTreeSet<_>>());
    let members = names(value)?;
    let is_type = |one: &&Type| {
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

/// By notification: what has it sent (`after`: who calls which method with what), who hears it, and its `params`; of `arm.event` by
/// event. `notifications.json`.
static TOLD: LazyLock<Map<String, Value>> =
    LazyLock::new(|| serde_json::from_str(include_str!("notifications.json")).unwrap_or_default());

/// A call of an example of a notification.
#[derive(Clone, Debug, PartialEq)]
pub struct Said {
    /// The client that calls.
    pub who: String,
    /// The method; `server.ending` for a station that is ended.
    pub method: String,
    /// What it is given; ids are those of earlier results.
    pub params: Value,
}

/// A notification, or an event, as a client gets it, and what has it sent.
#[derive(Clone, Debug, PartialEq)]
pub struct NotificationExample {
    /// Calls, one after the other.
    pub after: Vec<Said>,
    /// The client that hears it.
    pub heard_by: String,
    /// Its parameters, but for times and ids.
    pub params: Value,
}

impl NotificationExample {
    /// The example of a notification, or of an event.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        let example = TOLD.get(name)?;
        let after = example["after"].as_array()?.iter().map(|call| {
            Some(Said {
                who: call[0].as_str()?.to_owned(),
                method: call[1].as_str()?.to_owned(),
                params: call.get(2).cloned().unwrap_or_else(|| json!({})),
            })
        });
        Some(Self {
            after: after.collect::<Option<_>>()?,
            heard_by: example["heard_by"].as_str()?.to_owned(),
            params: example["params"].clone(),
        })
    }
}

/// What stands there: members after dots, and the first of a list.
fn at<'v>(value: &'v Value, place: &str) -> Option<&'v Value> {
    let steps = place.split('.').filter(|step| !step.is_empty());
    steps
        .flat_map(|step| {
            let (name, lists) = step
                .split_once("[]")
                .map_or((step, 0), |(name, _)| (name, step.matches("[]").count()));
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

    /// The places of a value that are null, but those within components, which say it themselves.
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
    fn each_null_of_an_example_has_a_kind_and_each_nullable_place_is_there() {
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
    fn what_may_be_null_is_so_in_its_place_alone() {
        let schema = |method| Example::of(method).unwrap().shape();
        let arms = schema("arm.list")["properties"]["arms"]["items"]["properties"].clone();
        assert_eq!(arms["name"]["type"], json!("string"));
        let holder = json!({"$ref": "#/components/schemas/Holder"});
        assert_eq!(arms["holder"], json!({"anyOf": [holder, {"type": "null"}]}));
        let started = schema("job.start");
        assert_eq!(started["properties"]["job"]["type"], json!("string"));
    }

    #[test]
    fn a_component_is_named_wherever_it_stands() {
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
