//! Position and description of an error in a scenario.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::document;

/// Reason why a text is not a valid scenario, with its position. The message says what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {message}")]
pub struct ScenarioError {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Description of the error.
    pub message: String,
}

/// Step of the path to a value in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Key {
    Name(&'static str),
    Nth(usize),
}

/// An invalid value: the path to it in the file, and the message.
#[derive(Debug)]
pub(super) struct Diagnostic {
    pub(super) path: Vec<Key>,
    pub(super) message: String,
}

impl ScenarioError {
    pub(super) fn syntax(text: &str, error: &toml::de::Error) -> Self {
        let (line, column, message) = document::locate(text, error);
        Self {
            line,
            column,
            message,
        }
    }

    /// Returns the error if a value stands where a section belongs, or a section where a list of
    /// sections belongs; `None` otherwise.
    ///
    /// Checked before the types: serde would report such a mistake in its own terms.
    pub(super) fn shape(text: &str, file: &Spanned<DeTable<'_>>) -> Option<Self> {
        const LISTS: [&str; 6] = ["object", "sensor", "input", "hand", "key", "fault"];
        const TABLES: [&str; 4] = ["arm", "tool", "table", "conveyor"];
        let file = file.get_ref();
        let list = LISTS.iter().find_map(|name| {
            let value = file.get(*name)?;
            let wrong = match value.get_ref() {
                DeValue::Array(entries) => {
                    let mut entries = entries.iter();
                    entries.find(|entry| !matches!(entry.get_ref(), DeValue::Table(_)))?
                }
                _ => value,
            };
            let message = format!("these form a list: write [[{name}]], not [{name}]");
            Some((wrong.span(), message))
        });
        let table = TABLES.iter().find_map(|name| {
            let value = file.get(*name)?;
            let message = format!(
                "only one of these is allowed: write [{name}] and its values \
                below it"
            );
            (!matches!(value.get_ref(), DeValue::Table(_))).then(|| (value.span(), message))
        });
        let (span, message) = list.or(table)?;
        Some(Self::at(text, span.start, message))
    }

    /// Locates the error at its value, or at the closest enclosing value that exists.
    pub(super) fn locate(text: &str, diagnostic: Diagnostic) -> Self {
        // Parsed again: the checked types keep no positions, and errors are rare.
        let span = DeTable::parse(text)
            .map(|file| find(&file, &diagnostic.path))
            .unwrap_or_default();
        Self::at(text, span.start, diagnostic.message)
    }

    fn at(text: &str, offset: usize, message: String) -> Self {
        let (line, column) = document::place(text, offset);
        Self {
            line,
            column,
            message,
        }
    }
}

/// Span of the deepest existing value along the path.
fn find(file: &Spanned<DeTable<'_>>, path: &[Key]) -> Range<usize> {
    let mut steps = path.iter();
    let Some(Key::Name(name)) = steps.next() else {
        return 0..0;
    };
    let Some(mut value) = file.get_ref().get(*name) else {
        return 0..0;
    };
    for step in steps {
        let next = match (step, value.get_ref()) {
            (Key::Name(name), DeValue::Table(table)) => table.get(*name),
            (Key::Nth(at), DeValue::Array(array)) => array.get(*at),
            _ => None,
        };
        match next {
            Some(next) => value = next,
            None => break,
        }
    }
    value.span()
}
