//! An example of every method, as data: `examples.json`. The documents show them, and a test runs them.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use serde_json::{Map, Value, json};

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
            (None, Some(Value::Null)) => json!({"type": "null"}),
            (None, Some(result)) => self.shape_of(result, "", None),
            (None, None) => json!({}),
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
                json!({"type": "object", "properties": members.collect::<Map<_, _>>()})
            }
        };
        if self.nullable.contains_key(place) && component.is_none() {
            match schema.get("type").cloned() {
                Some(kind) => schema["type"] = json!([kind, "null"]),
                None => schema = json!({"anyOf": [schema, {"type": "null"}]}),
            }
        }
        schema
    }
}

/// What several methods answer, or answer often: its name, and a method with the place of it in that one's result.
const COMPONENTS: [(&str, &str, &str); 8] = [
    ("State", "arm.state", ""),
    ("Tool", "arm.state", "tool"),
    ("Holder", "arm.home", "holder"),
    ("Pose", "jog.stop", "pose"),
    ("Lease", "lease.acquire", ""),
    ("Job", "job.get", ""),
    ("Field", "arm.io", "rows[].sets[]"),
    ("Choice", "arm.io", "rows[].sets[].choices[]"),
];

/// What has members that are not always there, which no example tells: `schemas.json`.
static SCHEMAS: LazyLock<Map<String, Value>> =
    LazyLock::new(|| serde_json::from_str(include_str!("schemas.json")).unwrap_or_default());

/// The components by their names, as JSON Schema.
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
    let is = |(_, method, place): &&(&str, &str, &str)| {
        let example = &EXAMPLES[*method]["result"];
        at(example, place).and_then(names).as_ref() == Some(&members)
    };
    COMPONENTS.iter().find(is).map(|(name, ..)| *name)
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
            let component = component_of(&result);
            // The component itself is checked where it is spelled out.
            let elsewhere = COMPONENTS
                .iter()
                .any(|(each, method, _)| Some(*each) == component && method != name);
            if result.is_null() || example.schema.is_some() || elsewhere {
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
        let components = components();
        // The names of tools may be unknown, those of arms and of jobs' holders are not.
        assert_eq!(
            components["Tool"]["properties"]["name"]["type"],
            json!(["string", "null"])
        );
        assert_eq!(
            components["Holder"]["properties"]["name"]["type"],
            json!("string")
        );
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
        let components = components();
        assert_eq!(components["Job"]["type"], json!("object"));
        assert_eq!(components.len(), COMPONENTS.len() + SCHEMAS.len());
    }
}
