//! Row of the option table: the facts about an option that every front end needs.

mod accepted;
mod build;

use serde::Serialize;
use serde_json::Value;

pub(super) use self::accepted::join_with_or;
pub(super) use self::build::{
    area, choice, first_of, integer, list, number, pens, place, point, switch, switch_off, text,
};
use super::{SetupOptions, WorkOption};
use crate::Format;

/// Option of [`SetupOptions`]: name, kind, range, and help.
///
/// The serialised row contains everything that a form needs to offer the option.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct OptionSpec {
    /// Name of the option, and of its member in a JSON object.
    pub name: &'static str,
    /// Kind of the value.
    pub kind: OptionKind,
    /// Unit of the value: `mm`, `mm/s`, `deg`, `%`, `px`, or empty.
    pub unit: &'static str,
    /// Words that may be chosen.
    pub choices: &'static [&'static str],
    /// Default value; `None` if it depends on something else.
    pub default: Option<DefaultValue>,
    /// Inclusive lower bound of the numbers.
    pub least: Option<f64>,
    /// Exclusive lower bound of the numbers.
    pub above: Option<f64>,
    /// Inclusive upper bound of the numbers.
    pub most: Option<f64>,
    /// Other option without which this one has no effect; `None` if it always applies. The option
    /// `work` may be unset: then the tool decides, since a laser engraves and every other tool
    /// draws.
    pub with: Option<&'static str>,
    /// Values of the other option with which this one applies; if empty, the other must be on.
    pub when: &'static [&'static str],
    /// Group in forms and help.
    pub group: OptionGroup,
    /// True if users usually set the option.
    pub usual: bool,
    /// Purpose, in one sentence.
    pub about: &'static str,
    /// Further sentences for help with enough room; may be empty.
    #[serde(skip)]
    pub detail: &'static str,
    /// Purpose of switching the option off; empty unless it is a switch that is on by default.
    #[serde(skip)]
    pub off: &'static str,
    /// Description of a default that depends on something else, as part of a sentence; otherwise
    /// empty.
    #[serde(skip)]
    pub usually: &'static str,
    /// Accepted values as part of a sentence, if kind and range do not suffice.
    #[serde(skip)]
    pub expects: &'static str,
    /// Placeholder of the value on a command line; empty if it follows from kind and unit.
    #[serde(skip)]
    pub placeholder: &'static str,
    /// Kind of work to which the option belongs; the other kind refuses it. `None` if it belongs to
    /// both.
    #[serde(skip)]
    pub work: Option<WorkOption>,
    /// Other option without which this one is refused.
    #[serde(skip)]
    pub needs: Option<Need>,
    /// Options that contradict this one.
    #[serde(skip)]
    pub contradicts: &'static [&'static str],
    #[serde(skip)]
    formats: &'static [Format],
    #[serde(skip)]
    usual_for: &'static [Format],
    #[serde(skip)]
    changes: &'static [(&'static [Format], Change)],
}

/// Need of an option: another one without which it is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Need {
    /// Name of the needed option.
    pub name: &'static str,
    /// Values that suffice; if empty, any value does.
    pub values: &'static [&'static str],
}

impl Need {
    /// True if this value of the needed option suffices.
    pub(super) fn is_met_by(&self, value: &Value) -> bool {
        let is_named = |text| self.values.is_empty() || self.values.contains(&text);
        value.as_str().is_some_and(is_named)
    }
}

/// Kind of an option's value, which fixes its form in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum OptionKind {
    /// A word from a list of choices.
    Choice,
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// x and y: an array of two numbers.
    Point,
    /// x, y and z: an array of three numbers.
    Place,
    /// Rectangle: distance from the left, distance from the top, width and height as four whole
    /// numbers.
    Area,
    /// True or false.
    Switch,
    /// Text.
    Text,
    /// An array of texts.
    List,
    /// Array of objects like [`PenOptions`](super::PenOptions).
    Pens,
}

impl OptionKind {
    /// Names of all kinds in interfaces.
    pub const NAMES: [&'static str; 10] = [
        "choice", "number", "integer", "point", "place", "area", "switch", "text", "list", "pens",
    ];
}

/// Group of options.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum OptionGroup {
    /// Tool, position and size.
    Place,
    /// Filling of shapes.
    Fill,
    /// Setting of text.
    Text,
    /// Parts, and the choice among them.
    Parts,
    /// Treatment of images.
    Image,
    /// Burning.
    Laser,
    /// Motion of the pen, and lines of drawings.
    Pen,
    /// All other options.
    More,
}

impl OptionGroup {
    /// Names of all groups in interfaces.
    pub const NAMES: [&'static str; 8] = [
        "place", "fill", "text", "parts", "image", "laser", "pen", "more",
    ];
}

/// Default value of an option.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum DefaultValue {
    /// A number.
    Number(f64),
    /// A word from the choices.
    Word(&'static str),
    /// On or off.
    Switch(bool),
}

/// Difference of an option for certain formats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    /// Switch without which the option has no effect.
    With(&'static str),
    /// Another default.
    Default(DefaultValue),
}

impl OptionSpec {
    /// True if the option applies to files of this format.
    #[must_use]
    pub fn counts_for(&self, format: Format) -> bool {
        self.formats.contains(&format)
    }

    /// True if users of some format usually set the option.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        !self.usual_for.is_empty()
    }

    /// True for a switch whose default depends on the format: users may have to set it on or off.
    #[must_use]
    pub fn has_both_positions(&self) -> bool {
        let is_default = |(_, change): &(_, Change)| matches!(change, Change::Default(_));
        self.kind == OptionKind::Switch && self.changes.iter().any(is_default)
    }

    /// True for a switch that is off by default.
    #[must_use]
    pub fn is_off(&self) -> bool {
        self.default == Some(DefaultValue::Switch(false))
    }

    /// Returns the row as it applies to files of this format.
    fn of(&self, format: Format) -> Self {
        let mut row = *self;
        row.usual = self.usual_for.contains(&format);
        let changes = self.changes.iter();
        for (_, change) in changes.filter(|(formats, _)| formats.contains(&format)) {
            match change {
                Change::With(switch) => (row.with, row.when) = (Some(*switch), &[]),
                Change::Default(default) => row.default = Some(*default),
            }
        }
        let partner = row.with.and_then(SetupOptions::option);
        if let Some(partner) = partner.filter(|_| row.when.is_empty()) {
            // For a choice any value will do; a switch must be on.
            row.when = partner.choices;
        }
        // A test grid is burnt with any tool, so it has only one kind of work.
        if let Some(work) = self.work
            && row.with.is_none()
            && format != Format::TestGrid
        {
            row.with = Some("work");
            row.when = work.values();
        }
        row
    }
}

impl SetupOptions {
    /// Returns the options that apply to files of this format, usual ones first.
    ///
    /// ```
    /// use magician_program::{Format, SetupOptions};
    ///
    /// let all = SetupOptions::options_for(Format::Svg);
    /// let inset = all.iter().find(|option| option.name == "fill_inset").unwrap();
    /// assert_eq!((inset.with, inset.least), (Some("fill"), Some(0.0)));
    /// assert!(all.len() > 30);
    /// let usual = |format| {
    ///     let options = SetupOptions::options_for(format).into_iter();
    ///     options.filter(|option| option.usual).map(|option| option.name).collect::<Vec<_>>()
    /// };
    /// assert_eq!(usual(Format::Image), ["tool", "image", "surface", "at", "width", "rotate", "fit"]);
    /// assert!(usual(Format::Playback).is_empty());
    /// ```
    #[must_use]
    pub fn options_for(format: Format) -> Vec<OptionSpec> {
        let rows = Self::OPTIONS.iter();
        let mut all: Vec<_> = { rows }
            .filter(|row| row.counts_for(format))
            .map(|row| row.of(format))
            .collect();
        all.sort_by_key(|row| !row.usual);
        all
    }

    /// Returns the option of this name.
    #[must_use]
    pub fn option(name: &str) -> Option<&'static OptionSpec> {
        Self::OPTIONS.iter().find(|row| row.name == name)
    }
}

#[cfg(test)]
mod tests;
