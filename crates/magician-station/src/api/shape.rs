//! Types of values in results and notifications: one description for the schema, the documentation,
//! generated types and tests.

use serde_json::{Map, Value, json};

use super::IdKind;

/// Member of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member {
    /// Name.
    pub name: &'static str,
    /// Type.
    pub shape: Shape,
    /// Unit of a number. Empty without a unit.
    pub unit: &'static str,
    /// Meaning of null. `None` if the member is never null.
    pub null: Option<&'static str>,
    /// True if the member may be missing.
    pub optional: bool,
    /// Meaning.
    pub about: &'static str,
}

/// Type of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Text.
    Text,
    /// True or false.
    Switch,
    /// A number.
    Number,
    /// A whole number, 0 or more.
    Count,
    /// A text from this list.
    Choice(&'static [&'static str]),
    /// An id.
    Id(IdKind),
    /// List of any length.
    List(&'static Shape),
    /// List of this length.
    Several(usize, &'static Shape),
    /// Type of the API with this name.
    Type(&'static str),
    /// An object.
    Object(&'static [Member]),
    /// Any of these types.
    Either(&'static [Shape]),
}

/// Named type of an object, used in several places or too large to repeat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Type {
    /// Name.
    pub name: &'static str,
    /// Description.
    pub about: &'static str,
    /// Members.
    pub members: &'static [Member],
}

pub(super) const fn is(name: &'static str, shape: Shape, about: &'static str) -> Member {
    Member {
        name,
        shape,
        unit: "",
        null: None,
        optional: false,
        about,
    }
}

impl Member {
    pub(super) const fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    pub(super) const fn null(self, means: &'static str) -> Self {
        Self {
            null: Some(means),
            ..self
        }
    }

    pub(super) const fn optional(self) -> Self {
        Self {
            optional: true,
            ..self
        }
    }

    /// Returns meaning, unit and the meaning of null in words.
    #[must_use]
    pub fn describe(&self) -> String {
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(", {unit}"),
        };
        let null = match self.null {
            Some(means) => format!("; null: {means}"),
            None => String::new(),
        };
        format!("{}{unit}{null}", self.about)
    }

    /// Returns the JSON Schema.
    #[must_use]
    pub fn schema(&self) -> Value {
        let mut schema = self.shape.schema();
        if self.null.is_some() {
            schema = or_null(schema);
        }
        schema["description"] = json!(self.describe());
        schema
    }
}

/// Extends a schema by null.
pub(super) fn or_null(mut schema: Value) -> Value {
    match schema.get("type") {
        Some(Value::String(kind)) if schema.get("enum").is_none() => {
            let kinds = json!([kind, "null"]);
            schema["type"] = kinds;
            schema
        }
        // References and enums cannot be extended in place.
        _ => json!({"anyOf": [schema, {"type": "null"}]}),
    }
}

impl Shape {
    /// Returns the JSON Schema.
    #[must_use]
    pub fn schema(self) -> Value {
        match self {
            Self::Text | Self::Id(_) if self != Self::Id(IdKind::Subscription) => {
                json!({"type": "string"})
            }
            Self::Text | Self::Id(_) => json!({"type": "integer", "minimum": 1, "maximum": 65535}),
            Self::Switch => json!({"type": "boolean"}),
            Self::Number => json!({"type": "number"}),
            Self::Count => json!({"type": "integer", "minimum": 0}),
            Self::Choice(names) => json!({"type": "string", "enum": names}),
            Self::List(item) => json!({"type": "array", "items": item.schema()}),
            Self::Several(count, item) => {
                let items = vec![item.schema(); count];
                json!({"type": "array", "items": items, "minItems": count, "maxItems": count})
            }
            Self::Type(name) => json!({"$ref": format!("#/components/schemas/{name}")}),
            Self::Object(members) => object(members),
            Self::Either(shapes) => {
                let shapes: Vec<_> = shapes.iter().map(|shape| shape.schema()).collect();
                json!({"anyOf": shapes})
            }
        }
    }

    /// Returns the type in words.
    #[must_use]
    pub fn describe(self) -> String {
        match self {
            Self::Text | Self::Id(_) if self != Self::Id(IdKind::Subscription) => "text".to_owned(),
            Self::Text | Self::Id(_) => "number".to_owned(),
            Self::Switch => "true or false".to_owned(),
            Self::Number => "number".to_owned(),
            Self::Count => "whole number".to_owned(),
            Self::Choice(names) => {
                let names: Vec<_> = names.iter().map(|name| format!("`{name}`")).collect();
                names.join(", ")
            }
            Self::List(item) => format!("list of: {}", item.describe()),
            Self::Several(count, item) => format!("{count} of: {}", item.describe()),
            Self::Type(name) => format!("[{name}](#{})", name.to_lowercase()),
            Self::Object(members) => {
                let members: Vec<_> = { members.iter() }
                    .map(|member| format!("`{}`", member.name))
                    .collect();
                format!("{{{}}}", members.join(", "))
            }
            Self::Either(shapes) => {
                let shapes: Vec<_> = shapes.iter().map(|shape| shape.describe()).collect();
                shapes.join(", or ")
            }
        }
    }
}

/// Returns the JSON Schema of an object with these members.
pub(super) fn object(members: &[Member]) -> Value {
    let properties: Map<_, _> = { members.iter() }
        .map(|member| (member.name.to_owned(), member.schema()))
        .collect();
    let required: Vec<_> = { members.iter() }
        .filter(|member| !member.optional)
        .map(|member| member.name)
        .collect();
    json!({"type": "object", "properties": properties, "required": required})
}

impl Type {
    /// Returns the type with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        super::TYPES.iter().find(|one| one.name == name)
    }

    pub(super) fn schema(&self) -> Value {
        let mut schema = object(self.members);
        schema["description"] = json!(self.about);
        schema
    }
}
