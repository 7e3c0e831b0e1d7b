//! Streaming access to large objects, such as a file of points with a member per point.

use std::borrow::Cow;
use std::fmt;

use serde::de::{Deserializer as _, Error as _, MapAccess, Visitor};
use serde_json::value::RawValue;

use super::{Json, Key};
use crate::{Diagnostic, Lines, Origin};

impl<'t> Json<'t> {
    /// Indexes the lines of the text, for repeated use of [`place`](Self::place).
    pub(crate) fn lines(&self) -> Lines<'t> {
        Lines::new(self.text)
    }

    /// Returns the place of a value.
    pub(crate) fn place(&self, lines: &Lines<'_>, value: &str) -> Origin {
        let start = self.start(value);
        lines.origin(start..start.saturating_add(value.len()))
    }

    /// Calls `visit` for each member of an object of any size. Duplicates are not detected.
    pub(crate) fn members(
        &self,
        value: &'t str,
        visit: impl FnMut(Cow<'t, str>, &'t str) -> Result<(), Diagnostic>,
    ) -> Result<(), Diagnostic> {
        struct Members<'p, F> {
            visit: F,
            diagnostic: &'p mut Option<Diagnostic>,
        }

        impl<'t, F> Visitor<'t> for Members<'_, F>
        where
            F: FnMut(Cow<'t, str>, &'t str) -> Result<(), Diagnostic>,
        {
            type Value = ();

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'t>>(mut self, mut map: A) -> Result<(), A::Error> {
                while let Some((Key(key), value)) = map.next_entry::<Key<'t>, &'t RawValue>()? {
                    if let Err(diagnostic) = (self.visit)(key, value.get()) {
                        *self.diagnostic = Some(diagnostic);
                        return Err(A::Error::custom("a problem"));
                    }
                }
                Ok(())
            }
        }

        if !value.starts_with('{') {
            return Err(self.not_an_object(value));
        }
        let mut diagnostic = None;
        let members = Members {
            visit,
            diagnostic: &mut diagnostic,
        };
        let parsed = serde_json::Deserializer::from_str(value).deserialize_map(members);
        parsed.map_err(|error| diagnostic.unwrap_or_else(|| self.syntax(value, &error)))
    }
}
