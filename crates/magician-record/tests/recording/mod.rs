//! Reads a recording back and validates every message against its schema.

use std::collections::BTreeMap;

use serde_json::{Value, json};

/// Microseconds since the start of the recording.
pub(crate) type Micros = u64;

/// Epoch of the recordings, ns since 1970: not a whole second.
pub(crate) const EPOCH: u64 = 1_800_000_000_123_000_000;
/// A message read back.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RecordedMessage {
    pub(crate) topic: String,
    pub(crate) at: Micros,
    pub(crate) value: Value,
}

/// Messages of a file in the order of writing, and whether the file is incomplete.
pub(crate) fn read(file: &[u8]) -> (Vec<RecordedMessage>, bool) {
    let (mut all, mut schemas) = (Vec::new(), BTreeMap::new());
    let options = mcap::read::Options::IgnoreEndMagic.into();
    for message in mcap::MessageStream::new_with_options(file, options).expect("a recording") {
        let Ok(message) = message else {
            return (all, true);
        };
        assert_eq!(message.log_time, message.publish_time);
        let since = message.log_time - EPOCH;
        assert!(since.is_multiple_of(1000));
        let value: Value = serde_json::from_slice(&message.data).expect("JSON");
        let schema = message.channel.schema.as_ref().expect("a schema");
        assert_eq!(
            (&*schema.encoding, &*message.channel.message_encoding),
            ("jsonschema", "json")
        );
        let schema = schemas
            .entry(schema.name.clone())
            .or_insert_with(|| serde_json::from_slice::<Value>(&schema.data).expect("JSON"));
        // Each entity of a scene has its own timestamp.
        let timestamps = match value["entities"].as_array() {
            Some(entities) => entities.iter().map(|entity| &entity["timestamp"]).collect(),
            None => vec![&value["timestamp"]],
        };
        assert_eq!(
            timestamps,
            vec![
                &json!({"sec": message.log_time / 1_000_000_000, "nsec": message.log_time % 1_000_000_000});
                timestamps.len()
            ]
        );
        check(schema, &value);
        all.push(RecordedMessage {
            topic: message.channel.topic.clone(),
            at: since / 1000,
            value,
        });
    }
    (all, false)
}

/// Validates a value by the keywords of JSON Schema that the schemas use, and refuses properties
/// that the schema does not name.
fn check(schema: &Value, value: &Value) {
    if let Some(choices) = schema.get("oneOf") {
        let choices = choices.as_array().expect("a list");
        assert!(choices.iter().any(|choice| choice["const"] == *value));
        return;
    }
    let kinds = match &schema["type"] {
        Value::Array(kinds) => kinds.clone(),
        kind => vec![kind.clone()],
    };
    let fits = |kind: &Value| match kind.as_str().expect("a type") {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_u64(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        other => panic!("{other}"),
    };
    assert!(kinds.iter().any(fits), "{value} is not {kinds:?}");
    if let Some(choices) = schema.get("enum") {
        assert!(choices.as_array().expect("a list").contains(value));
    }
    if let (Some(most), Some(number)) = (schema["maximum"].as_u64(), value.as_u64()) {
        assert!(number <= most);
    }
    for item in value.as_array().into_iter().flatten() {
        check(&schema["items"], item);
    }
    if let (Some(object), Some(properties)) = (value.as_object(), schema["properties"].as_object())
    {
        for (name, member) in object {
            check(properties.get(name).expect(name), member);
        }
        for name in schema["required"].as_array().expect("a list") {
            assert!(object.contains_key(name.as_str().expect("a name")));
        }
    }
}

pub(crate) fn of<'a>(all: &'a [RecordedMessage], topic: &str) -> Vec<&'a RecordedMessage> {
    all.iter().filter(|read| read.topic == topic).collect()
}
