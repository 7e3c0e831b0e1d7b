//! Pens for the parts of a drawing.

use magician_host::{Message, OptionName, message};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::SetupOptions;
use crate::artwork::PartPen;
use crate::fill::FillMode;
use crate::{PartMatch, PartRule};

/// Pen, and the parts that it draws. Missing options are those of the whole drawing. Lengths are
/// mm, speeds mm/s, power percent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "expected a pen: the parts that it is for, and its options"
)]
pub struct PenOptions {
    /// Parts that the pen draws: a name, a colour or a number.
    #[serde(rename = "match")]
    pub matches: PenMatch,
    /// Height offset of the pen while drawing; positive is up.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_offset: Option<f64>,
    /// Pen lift between lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lift: Option<f64>,
    /// Drawing speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Laser power.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power: Option<f64>,
    /// Number of passes over its parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes: Option<u32>,
    /// Fill of the shapes in its parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fill: Option<FillMode>,
}

/// Selection of the parts of a pen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a name, a colour, or a whole number from 1"
)]
pub enum PenMatch {
    /// Part with this number, from 1.
    Number(u64),
    /// Parts with this name or colour.
    Name(String),
}

impl PenOptions {
    /// Returns the first option that is out of range, in a sentence.
    pub(super) fn problem(&self) -> Option<Message> {
        if self.matches == PenMatch::Number(0) {
            return Some(message!("match counts parts from 1"));
        }
        // Ranges are those of the options with the same names.
        for (key, value) in [
            ("lift", self.lift),
            ("speed", self.speed),
            ("passes", self.passes.map(f64::from)),
        ] {
            let row = SetupOptions::option(key)?;
            if let Some(value) = value.map(Value::from)
                && !row.is_within(&value)
            {
                return Some(row.refusal(&value));
            }
        }
        let fits = |power: &f64| *power > 0.0 && *power <= 100.0;
        if let Some(power) = self.power.filter(|power| !fits(power)) {
            return Some(message!(
                "{name} is percent above 0, not {power}",
                name = OptionName("power"),
                power
            ));
        }
        if let Some(offset) = self
            .surface_offset
            .filter(|offset| !(-100.0..=100.0).contains(offset))
        {
            return Some(message!(
                "{name} is -100 to 100 mm, not {offset}",
                name = OptionName("surface_offset"),
                offset
            ));
        }
        None
    }
}

impl From<&PenOptions> for PartRule {
    fn from(options: &PenOptions) -> Self {
        Self {
            matches: match &options.matches {
                PenMatch::Name(name) => PartMatch::Name(name.clone()),
                PenMatch::Number(n) => PartMatch::Number(*n),
            },
            pen: PartPen {
                surface_offset: options.surface_offset.unwrap_or(0.0),
                lift: options.lift,
                speed: options.speed,
                power: options.power,
                fill: options.fill,
            },
            passes: options.passes,
        }
    }
}
