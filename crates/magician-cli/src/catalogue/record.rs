//! JSON form of the command table.

use magician_protocol::{Bounds, Confidence, Field, FieldType, LayoutInfo, Row, Scalar, Source};
use serde::Serialize;

use super::find::kebab;

/// Command as JSON.
#[derive(Serialize)]
pub(crate) struct Entry {
    id: u8,
    name: &'static str,
    get: Option<&'static str>,
    set: Option<&'static str>,
    queueable: bool,
    dangerous: bool,
    effect: &'static str,
    may_burn: bool,
    chapter: String,
    about: &'static str,
    section: &'static str,
    #[serde(skip_serializing_if = "str::is_empty")]
    errata: &'static str,
    source: &'static str,
    confidence: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    layouts: Option<Layouts>,
}

#[derive(Serialize)]
struct Layouts {
    query: Option<Layout>,
    value: Option<Layout>,
    set: Option<Layout>,
}

#[derive(Serialize)]
struct Layout {
    bytes: Option<usize>,
    fields: Vec<Member>,
    tolerated: Vec<Tolerated>,
}

#[derive(Serialize)]
struct Member {
    name: &'static str,
    r#type: String,
    unit: &'static str,
    range: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    minimum: Option<i32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exclusive_minimum: Option<i32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    maximum: Option<i32>,
    about: &'static str,
    optional: bool,
    default: Option<u8>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    values: Vec<Value>,
}

#[derive(Serialize)]
struct Value {
    value: u8,
    name: &'static str,
    about: &'static str,
}

#[derive(Serialize)]
struct Tolerated {
    bytes: usize,
    about: &'static str,
}

impl Entry {
    /// Creates the short form, as the list shows it.
    pub(crate) fn brief(row: &'static Row) -> Self {
        Self {
            id: row.id,
            name: row.name,
            get: row.value.map(|_| row.get_name),
            set: row.set.map(|_| row.set_name),
            queueable: row.queueable,
            dangerous: row.dangerous,
            effect: row.effect.name(),
            may_burn: row.may_burn,
            chapter: chapter_name(row),
            about: row.doc,
            section: section(row),
            errata: row.errata,
            source: source(row),
            confidence: confidence(row),
            layouts: None,
        }
    }

    /// Creates the full form with layouts, limits and notes.
    pub(crate) fn full(row: &'static Row) -> Self {
        Self {
            layouts: Some(Layouts {
                query: row.query.filter(|_| row.value.is_some()).map(layout),
                value: row.value.map(layout),
                set: row.set.map(layout),
            }),
            ..Self::brief(row)
        }
    }
}

fn layout(info: &'static LayoutInfo) -> Layout {
    let tolerated = info.forms.iter().map(|form| Tolerated {
        bytes: form.len,
        about: form.note,
    });
    Layout {
        bytes: info.size(),
        fields: info.fields.iter().map(member).collect(),
        tolerated: tolerated.collect(),
    }
}

fn member(field: &'static Field) -> Member {
    let Bounds {
        minimum,
        exclusive_minimum,
        maximum,
    } = field.range.bounds();
    Member {
        name: field.name,
        r#type: type_name(field.ty),
        unit: field.unit,
        range: field.range.to_string(),
        minimum,
        exclusive_minimum,
        maximum,
        about: field.doc,
        optional: field.optional,
        default: field.default,
        values: match field.ty {
            FieldType::Enum(info) => info.variants.iter().map(Value::from).collect(),
            _ => Vec::new(),
        },
    }
}

impl From<&magician_protocol::Variant> for Value {
    fn from(variant: &magician_protocol::Variant) -> Self {
        Self {
            value: variant.value,
            name: variant.name,
            about: variant.doc,
        }
    }
}

/// Returns a chapter's name in the command line's notation, such as `lost-step`.
pub(crate) fn chapter_name(row: &Row) -> String {
    kebab(&format!("{:?}", row.chapter))
}

/// Returns the section of the vendor's document; empty for a command without one.
pub(super) fn section(row: &Row) -> &'static str {
    match row.section {
        "none" => "",
        section => section,
    }
}

/// Returns a short name for the document that describes the command.
pub(super) fn source(row: &Row) -> &'static str {
    match row.source {
        Source::Document => "v1.1.3",
        Source::Addition => "v1.1.5-addition",
        Source::Header => "vendor header only",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

/// Returns a short name for the confidence in the command's layout.
pub(super) fn confidence(row: &Row) -> &'static str {
    match row.confidence {
        Confidence::High => "high",
        Confidence::Medium => "medium",
        Confidence::Low => "low",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

/// Returns the name of a field's type, such as `f32`, `f32[4]` or `flag`.
pub(super) fn type_name(ty: FieldType) -> String {
    match ty {
        FieldType::Scalar(scalar) => scalar_name(scalar).to_owned(),
        FieldType::Array(scalar, count) => format!("{}[{count}]", scalar_name(scalar)),
        FieldType::Flag => "flag".to_owned(),
        FieldType::Enum(_) => "enum".to_owned(),
        FieldType::Text => "text".to_owned(),
        FieldType::Bytes => "bytes".to_owned(),
        FieldType::Alarms => "alarm bits".to_owned(),
        FieldType::Outputs => "outputs".to_owned(),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

fn scalar_name(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::U8 => "u8",
        Scalar::U16 => "u16",
        Scalar::U32 => "u32",
        Scalar::U64 => "u64",
        Scalar::I32 => "i32",
        Scalar::F32 => "f32",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}
