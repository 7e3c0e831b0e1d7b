//! Fields of the protocol's table in a sentence.

use std::fmt::Write as _;

use magician_protocol::{Field, FieldType};

/// What a field is, its unit and its range, without a stop: where a type says what a choice or a flag may be, no range.
pub(crate) fn described(field: &Field) -> String {
    let mut about = field.doc.trim_end_matches('.').to_owned();
    if !matches!(
        field.unit,
        "" | "flag" | "enum" | "text" | "bytes" | "count" | "id" | "reserved"
    ) {
        let _ = write!(about, "; {}", field.unit);
    }
    let counts = !matches!(field.ty, FieldType::Enum(_) | FieldType::Flag);
    if !field.range.is_any() && counts {
        let _ = write!(about, "; {}", field.range);
    }
    about
}
