//! Types of parameters: one description for the check, the schema and the documentation.

use magician::{Message, message};
use serde_json::{Map, Value, json};

use super::{IdKind, RpcError};

/// Type and range of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Text of at most this many characters.
    Text(usize),
    /// An id.
    Id(IdKind),
    /// A text from this list.
    Choice(&'static [&'static str]),
    /// True or false.
    Switch,
    /// A whole number within these bounds.
    Integer(i64, i64),
    /// A finite number within these bounds.
    Number(f64, f64),
    /// Array of finite numbers: least and largest count.
    Numbers(usize, usize),
    /// Array of at most this many texts, each at most 80 characters.
    Texts(usize),
    /// Object of this type.
    Object(&'static str),
    /// Array of objects of this type.
    Objects(&'static str),
    /// The value null.
    Null,
    /// Any of these types.
    Either(&'static [Kind]),
}

/// Parameter of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param {
    /// Name.
    pub name: &'static str,
    /// Type and range.
    pub kind: Kind,
    /// True if the parameter must be given.
    pub required: bool,
    /// Meaning, with its unit.
    pub about: &'static str,
}

/// Ids are texts of at most 64 characters, except those of subscriptions, which are numbers.
const ID: Kind = Kind::Text(64);
const SUBSCRIPTION: Kind = Kind::Integer(1, 65535);

/// Returns the schema of a named type.
fn reference(name: &str) -> Value {
    json!({"$ref": format!("#/components/schemas/{name}")})
}

impl Kind {
    /// Returns the type of an id.
    const fn of_id(id: IdKind) -> Self {
        match id {
            IdKind::Subscription => SUBSCRIPTION,
            _ => ID,
        }
    }

    fn takes(self, value: &Value) -> bool {
        let finite = |value: &Value| value.as_f64().is_some_and(f64::is_finite);
        match self {
            Self::Id(id) => Self::of_id(id).takes(value),
            Self::Text(most) => value
                .as_str()
                .is_some_and(|text| text.chars().count() <= most),
            Self::Choice(names) => value.as_str().is_some_and(|text| names.contains(&text)),
            Self::Switch => value.is_boolean(),
            Self::Integer(least, most) => value
                .as_i64()
                .is_some_and(|number| (least..=most).contains(&number)),
            Self::Number(least, most) => value
                .as_f64()
                .is_some_and(|number| (least..=most).contains(&number)),
            Self::Numbers(least, most) => value.as_array().is_some_and(|items| {
                (least..=most).contains(&items.len()) && items.iter().all(finite)
            }),
            Self::Texts(most) => value.as_array().is_some_and(|items| {
                items.len() <= most && items.iter().all(|item| Self::Text(80).takes(item))
            }),
            Self::Object(_) => value.is_object(),
            Self::Objects(_) => {
                { value.as_array() }.is_some_and(|items| items.iter().all(Value::is_object))
            }
            Self::Null => value.is_null(),
            Self::Either(kinds) => kinds.iter().any(|kind| kind.takes(value)),
        }
    }

    /// Returns the type in words, as in "`rate` must be ..".
    #[must_use]
    pub fn describe(self) -> String {
        self.in_words().into()
    }

    /// Returns the type in words, for sentences.
    fn in_words(self) -> Message {
        match self {
            Self::Id(id) => Self::of_id(id).in_words(),
            Self::Text(most) => message!("text of at most {most} characters", most),
            Self::Choice(names) => message!("one of {names}", names = names.join(", ")),
            Self::Switch => message!("true or false"),
            Self::Integer(least, most) => {
                message!("a whole number from {least} to {most}", least, most)
            }
            // `f64::MIN` and `f64::MAX` stand for no bound.
            Self::Number(least, most) if least <= f64::MIN && most >= f64::MAX => {
                message!("a number")
            }
            Self::Number(least, most) if most >= f64::MAX => {
                message!("a number, {least} or more", least)
            }
            Self::Number(least, most) => message!("a number from {least} to {most}", least, most),
            Self::Numbers(least, most) if least == most => message!("{least} numbers", least),
            Self::Numbers(least, most) => message!("{least} to {most} numbers", least, most),
            Self::Texts(most) => message!("an array of at most {most} names", most),
            Self::Object(_) => message!("an object"),
            Self::Objects(_) => message!("an array of objects"),
            Self::Null => message!("null"),
            Self::Either(kinds) => {
                let kinds = kinds.iter().map(|kind| kind.in_words());
                let all = kinds.reduce(|one, other| message!("{one}, or {other}", one, other));
                all.unwrap_or_default()
            }
        }
    }

    /// Returns the JSON Schema.
    #[must_use]
    pub fn schema(self) -> Value {
        match self {
            Self::Id(id) => Self::of_id(id).schema(),
            Self::Text(most) => json!({"type": "string", "maxLength": most}),
            Self::Choice(names) => json!({"type": "string", "enum": names}),
            Self::Switch => json!({"type": "boolean"}),
            Self::Integer(least, most) => {
                json!({"type": "integer", "minimum": least, "maximum": most})
            }
            Self::Number(least, most) => {
                let mut schema = json!({"type": "number"});
                if least > f64::MIN {
                    schema["minimum"] = json!(least);
                }
                if most < f64::MAX {
                    schema["maximum"] = json!(most);
                }
                schema
            }
            Self::Numbers(least, most) => json!({
                "type": "array", "items": {"type": "number"}, "minItems": least, "maxItems": most
            }),
            Self::Texts(most) => {
                json!({"type": "array", "items": {"type": "string"}, "maxItems": most})
            }
            Self::Object(name) => reference(name),
            Self::Objects(name) => json!({"type": "array", "items": reference(name)}),
            Self::Null => json!({"type": "null"}),
            Self::Either(kinds) => {
                let kinds: Vec<_> = kinds.iter().map(|kind| kind.schema()).collect();
                json!({"oneOf": kinds})
            }
        }
    }
}

/// Parameters that have passed the check of their method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Params(Map<String, Value>);

impl Params {
    /// Checks names, types and ranges, and that all required parameters are given.
    ///
    /// # Errors
    /// The first parameter that is wrong.
    pub fn check(wanted: &[Param], given: Map<String, Value>) -> Result<Self, RpcError> {
        // Unknown parameters are refused, because a misspelt one must not be ignored at a moving
        // arm.
        for (name, value) in &given {
            let Some(param) = wanted.iter().find(|param| param.name == name) else {
                let names: Vec<_> = wanted.iter().map(|param| param.name).collect();
                let why = match names.as_slice() {
                    [] => message!("unknown parameter `{name}`: the method takes none", name),
                    names => message!(
                        "unknown parameter `{name}`: the method takes {names}",
                        name,
                        names = names.join(", ")
                    ),
                };
                return Err(RpcError::param(name, why));
            };
            if !param.kind.takes(value) {
                let kind = param.kind.in_words();
                let why = message!("`{name}` must be {kind}", name, kind);
                return Err(RpcError::param(name, why));
            }
        }
        for param in wanted.iter().filter(|param| param.required) {
            if !given.contains_key(param.name) {
                let name = param.name;
                return Err(RpcError::param(name, message!("`{name}` is missing", name)));
            }
        }
        Ok(Self(given))
    }

    /// Returns a parameter.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.get(name)
    }

    /// Returns a parameter that is text.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<&str> {
        self.get(name)?.as_str()
    }

    pub(crate) fn number(&self, name: &str) -> Option<f64> {
        self.get(name)?.as_f64()
    }

    pub(crate) fn integer(&self, name: &str) -> Option<u64> {
        self.get(name)?.as_u64()
    }

    pub(crate) fn is_on(&self, name: &str) -> bool {
        self.get(name).and_then(Value::as_bool) == Some(true)
    }

    pub(crate) fn switch(&self, name: &str) -> Option<bool> {
        self.get(name)?.as_bool()
    }

    pub(crate) fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let items = self.get(name)?.as_array()?;
        Some(items.iter().filter_map(Value::as_f64).collect())
    }

    #[cfg(feature = "class")]
    pub(crate) fn texts(&self, name: &str) -> Option<Vec<&str>> {
        let items = self.get(name)?.as_array()?;
        Some(items.iter().filter_map(Value::as_str).collect())
    }

    pub(crate) fn object(&self, name: &str) -> Option<&Map<String, Value>> {
        self.get(name)?.as_object()
    }

    /// Returns the objects of a list. Empty if it is not given.
    #[cfg(feature = "class")]
    pub(crate) fn objects(&self, name: &str) -> &[Value] {
        let items = self.get(name).and_then(Value::as_array);
        items.map_or(&[], Vec::as_slice)
    }

    /// Returns all parameters.
    #[must_use]
    pub fn into_map(self) -> Map<String, Value> {
        self.0
    }

    /// Returns the parameters for the journal: without secrets, and programs reduced to their
    /// length.
    pub(crate) fn for_journal(&self) -> Value {
        let shown = |(name, value): (&String, &Value)| {
            let value = match (name.as_str(), value) {
                // The journal is a file that others may be given to read.
                ("token" | "resume" | "pin", _) => return None,
                // The name without the code.
                ("pupil", pupil) => json!({"name": pupil.get("name")}),
                // Programs may be large, and are the user's own.
                ("data" | "text", Value::String(text)) => json!({"bytes": text.len()}),
                _ => value.clone(),
            };
            Some((name.clone(), value))
        };
        Value::Object(self.0.iter().filter_map(shown).collect())
    }
}
