//! Rules for single values, and the diagnostics that they give.

use std::ops::RangeInclusive;

use super::{Diagnostic, Key, diagnostic};
use crate::{ArmInstant, Micros};

/// A valid value, or the diagnostic.
pub(super) type Checked<T> = Result<T, Diagnostic>;

/// Latest instant of a script, s: about four months. It keeps microseconds far from overflow.
const MAX_INSTANT_SECONDS: f64 = 1e7;

/// A section of the file, for naming its values in diagnostics.
pub(super) struct SectionPath {
    path: Vec<Key>,
}

impl SectionPath {
    pub(super) fn section(name: &'static str) -> Self {
        let path = vec![Key::Name(name)];
        Self { path }
    }

    /// Entry `nth`, from 0, of the list of sections `name`.
    pub(super) fn entry(name: &'static str, nth: usize) -> Self {
        let path = vec![Key::Name(name), Key::Nth(nth)];
        Self { path }
    }

    /// Creates the diagnostic of a value in the section, or of the section itself if the name is
    /// empty.
    pub(super) fn diagnostic<T>(
        &self,
        name: &'static str,
        message: impl Into<String>,
    ) -> Checked<T> {
        let mut path = self.path.clone();
        if !name.is_empty() {
            path.push(Key::Name(name));
        }
        diagnostic(path, message)
    }

    pub(super) fn number(
        &self,
        name: &'static str,
        value: f64,
        range: RangeInclusive<f64>,
        unit: &str,
    ) -> Checked<f64> {
        self.numbers(name, &[value], range, unit)?;
        Ok(value)
    }

    /// Checks that every number is in the range; NaN never is.
    pub(super) fn numbers(
        &self,
        name: &'static str,
        values: &[f64],
        range: RangeInclusive<f64>,
        unit: &str,
    ) -> Checked<()> {
        match values.iter().find(|value| !range.contains(value)) {
            None => Ok(()),
            Some(value) => {
                let (from, to) = range.into_inner();
                let message = format!("{name} is {value}, it must be {from} to {to} {unit}");
                self.diagnostic(name, message.trim_end())
            }
        }
    }

    /// Checks a length: above 0, at most `most`.
    pub(super) fn length(&self, name: &'static str, value: f64, most: f64) -> Checked<f64> {
        // False for NaN as well.
        if value > 0.0 && value <= most {
            return Ok(value);
        }
        let message = format!("{name} is {value}, it must be above 0 and at most {most} mm");
        self.diagnostic(name, message)
    }

    /// Converts an instant in seconds of the arm's clock.
    pub(super) fn time(&self, name: &'static str, seconds: f64) -> Checked<ArmInstant> {
        Ok(ArmInstant::from_micros(self.micros(name, seconds)?))
    }

    fn micros(&self, name: &'static str, seconds: f64) -> Checked<Micros> {
        self.number(name, seconds, 0.0..=MAX_INSTANT_SECONDS, "s")?;
        Ok((seconds * 1e6).round() as Micros)
    }

    /// Converts a time span; it must be above 0.
    pub(super) fn span(&self, name: &'static str, seconds: f64) -> Checked<Micros> {
        match self.micros(name, seconds)? {
            0 => self.diagnostic(name, format!("{name} is {seconds}, it must be above 0 s")),
            span => Ok(span),
        }
    }

    /// Requires a value.
    pub(super) fn needed<T>(&self, name: &'static str, value: Option<T>, hint: &str) -> Checked<T> {
        match value {
            Some(value) => Ok(value),
            None => self.diagnostic("", format!("{name} is missing: {hint}")),
        }
    }

    /// Refuses a value that has no meaning in this place.
    pub(super) fn absent(&self, name: &'static str, present: bool, why: &str) -> Checked<()> {
        if present {
            return self.diagnostic(name, format!("{name} has no meaning here: {why}"));
        }
        Ok(())
    }
}
