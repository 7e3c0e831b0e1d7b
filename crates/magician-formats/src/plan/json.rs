//! A JSON parser whose values remember their place in the text.
//!
//! A value is a slice of the text, so its place is the distance of its pointer from the start of
//! the text: nothing needs to be stored per value. Syntax is checked once for the whole text; after
//! that each object or array is split on demand.

#[cfg(feature = "programs")]
mod members;

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use magician_host::{Message, message};
use serde::Deserialize;
use serde::de::{Deserializer as _, Error as _, MapAccess, SeqAccess, Visitor};
use serde_json::value::RawValue;

use crate::{Diagnostic, Lines, Origin};

/// Largest number of members. A choice above any object of our formats; the check for duplicates is
/// quadratic.
const MAX_MEMBERS: usize = 64;

/// A JSON text. Values are slices of it.
pub(crate) struct Json<'t> {
    text: &'t str,
}

/// Member of an object.
pub(crate) struct Member<'t> {
    pub(crate) key: Cow<'t, str>,
    pub(crate) value: &'t str,
}

#[derive(Deserialize)]
struct Key<'t>(#[serde(borrow)] Cow<'t, str>);

impl<'t> Json<'t> {
    /// Wraps the text of a file.
    pub(crate) fn of(text: &'t str) -> Self {
        Self { text }
    }

    /// Checks the syntax of the whole text and returns its value.
    pub(crate) fn whole(&self) -> Result<&'t str, Diagnostic> {
        let value = serde_json::from_str::<&RawValue>(self.text);
        value
            .map(RawValue::get)
            .map_err(|error| self.syntax(self.text, &error))
    }

    /// Creates a diagnostic at the place of a value.
    pub(crate) fn diagnostic(&self, value: &str, message: impl Into<Message>) -> Diagnostic {
        Diagnostic::new(self.origin(value, value.len()), message)
    }

    /// Creates the diagnostic for an unknown member, with the known ones.
    pub(crate) fn unknown(&self, member: &Member<'_>, known: impl Into<Message>) -> Diagnostic {
        // A key with escapes was copied and has no place in the text.
        let place = match &member.key {
            Cow::Borrowed(key) => key,
            Cow::Owned(_) => member.value,
        };
        let message = message!("unknown member '{name}'", name = member.key);
        self.diagnostic(place, message)
            .help(message!("known are {known}", known = known.into()))
    }

    fn start(&self, part: &str) -> usize {
        (part.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize)
    }

    fn origin(&self, part: &str, length: usize) -> Origin {
        let start = self.start(part);
        Lines::new(self.text).origin(start..start.saturating_add(length))
    }

    /// Converts an error of the parser, which counts lines and columns (in bytes) from the start of
    /// `part`.
    fn syntax(&self, part: &str, error: &serde_json::Error) -> Diagnostic {
        let lines = part
            .split_inclusive('\n')
            .take(error.line().saturating_sub(1));
        let start: usize = lines.map(str::len).sum();
        let mut at = (start + error.column().saturating_sub(1)).min(part.len());
        while !part.is_char_boundary(at) {
            at -= 1;
        }
        let full = error.to_string();
        let what = full
            .rsplit_once(" at line")
            .map_or(full.as_str(), |(what, _)| what);
        let place = part.get(at..).unwrap_or_default();
        let origin = self.origin(place, place.chars().next().map_or(0, char::len_utf8));
        Diagnostic::new(origin, message!("this is not JSON: {what}", what))
    }

    /// Returns the members of an object. A duplicate member is an error.
    pub(crate) fn object(&self, value: &'t str) -> Result<Vec<Member<'t>>, Diagnostic> {
        struct Members;

        impl<'t> Visitor<'t> for Members {
            type Value = Vec<Member<'t>>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'t>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut members = Vec::new();
                while let Some((Key(key), value)) = map.next_entry::<Key<'t>, &'t RawValue>()? {
                    if members.len() == MAX_MEMBERS {
                        return Err(A::Error::custom("far too many members"));
                    }
                    let value = value.get();
                    members.push(Member { key, value });
                }
                Ok(members)
            }
        }

        if !value.starts_with('{') {
            return Err(self.not_an_object(value));
        }
        let mut parser = serde_json::Deserializer::from_str(value);
        let members = parser
            .deserialize_map(Members)
            .map_err(|error| self.syntax(value, &error))?;
        for (at, member) in members.iter().enumerate() {
            if members.iter().take(at).any(|other| other.key == member.key) {
                let message = message!("'{name}' appears twice", name = member.key);
                return Err(self.diagnostic(member.value, message));
            }
        }
        Ok(members)
    }

    fn not_an_object(&self, value: &str) -> Diagnostic {
        self.diagnostic(value, message!("expected an object, {form}", form = "{..}"))
    }

    /// Calls `visit` for each item of an array.
    pub(crate) fn each(
        &self,
        value: &'t str,
        visit: impl FnMut(&'t str) -> Result<(), Diagnostic>,
    ) -> Result<(), Diagnostic> {
        struct Items<'p, F> {
            visit: F,
            diagnostic: &'p mut Option<Diagnostic>,
        }

        impl<'t, F: FnMut(&'t str) -> Result<(), Diagnostic>> Visitor<'t> for Items<'_, F> {
            type Value = ();

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an array")
            }

            fn visit_seq<A: SeqAccess<'t>>(mut self, mut items: A) -> Result<(), A::Error> {
                while let Some(item) = items.next_element::<&'t RawValue>()? {
                    // serde carries only messages, so the diagnostic is passed around it.
                    if let Err(diagnostic) = (self.visit)(item.get()) {
                        *self.diagnostic = Some(diagnostic);
                        return Err(A::Error::custom("a problem"));
                    }
                }
                Ok(())
            }
        }

        if !value.starts_with('[') {
            return Err(self.diagnostic(value, message!("expected an array, [..]")));
        }
        let mut diagnostic = None;
        let items = Items {
            visit,
            diagnostic: &mut diagnostic,
        };
        let parsed = serde_json::Deserializer::from_str(value).deserialize_seq(items);
        parsed.map_err(|error| diagnostic.unwrap_or_else(|| self.syntax(value, &error)))
    }

    /// Returns the items of an array.
    pub(crate) fn array(&self, value: &'t str) -> Result<Vec<&'t str>, Diagnostic> {
        let mut items = Vec::new();
        self.each(value, |item| {
            items.push(item);
            Ok(())
        })?;
        Ok(items)
    }

    /// Parses a string.
    pub(crate) fn string(&self, value: &'t str) -> Result<Cow<'t, str>, Diagnostic> {
        if !value.starts_with('"') {
            return Err(self.diagnostic(value, message!("expected a string, \"..\"")));
        }
        let text: Key<'t> =
            serde_json::from_str(value).map_err(|error| self.syntax(value, &error))?;
        Ok(text.0)
    }

    /// Parses a whole number that fits into `T`; `what` describes it in the message.
    pub(crate) fn number<T: FromStr>(
        &self,
        value: &str,
        what: fn() -> Message,
    ) -> Result<T, Diagnostic> {
        let wrong = |_| self.diagnostic(value, message!("expected {what}", what = what()));
        value.parse().map_err(wrong)
    }

    /// Parses a boolean.
    pub(crate) fn boolean(&self, value: &str) -> Result<bool, Diagnostic> {
        value
            .parse()
            .map_err(|_| self.diagnostic(value, message!("expected true or false")))
    }

    /// Parses one of a few words.
    pub(crate) fn one_of<T: Copy>(
        &self,
        value: &str,
        words: &[(&str, T)],
    ) -> Result<T, Diagnostic> {
        let word = value
            .strip_prefix('"')
            .and_then(|rest| rest.strip_suffix('"'));
        let found = words.iter().find(|(known, _)| Some(*known) == word);
        found.map(|(_, value)| *value).ok_or_else(|| {
            let names: Vec<String> = words
                .iter()
                .map(|(known, _)| format!("\"{known}\""))
                .collect();
            self.diagnostic(value, message!("expected {what}", what = or(&names)))
        })
    }
}

/// Joins names as `a, b or c`.
fn or(names: &[String]) -> Message {
    match names {
        [before @ .., last] if !before.is_empty() => {
            message!("{names} or {last}", names = before.join(", "), last)
        }
        _ => names.concat().into(),
    }
}
