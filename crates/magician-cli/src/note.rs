//! What was read or done in a certain way, as JSON has it.

use magician::Remedy;
use magician_program::Diagnostic;
use serde::Serialize;

use crate::voice;

/// A note as JSON has it.
#[derive(Debug, Serialize)]
pub(crate) struct Note {
    code: &'static str,
    text: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    element: Option<String>,
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "voice::json")]
    remedies: Vec<Remedy>,
}

impl Note {
    /// All of them, each with what to do about it.
    pub(crate) fn all<'p>(notes: impl IntoIterator<Item = &'p Diagnostic>) -> Vec<Self> {
        let told = |note: &Diagnostic| Self {
            code: note.code.name(),
            text: voice::advised(note.message.clone(), note),
            line: Some(note.origin.line).filter(|line| *line > 0),
            element: note.name.clone(),
            remedies: note.remedies.clone(),
        };
        notes.into_iter().map(told).collect()
    }
}
