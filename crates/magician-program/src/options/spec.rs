//! A row of the table of options: the facts about an option that every door needs.

mod accepted;
mod build;

use serde::Serialize;
use serde_json::Value;

pub(super) use self::accepted::either;
pub(super) use self::build::{
    area, choice, first_of, integer, list, number, pens, place, point, switch, switch_off, text,
};
use super::{SetupOptions, WorkOption};
use crate::Format;

/// An option of [`SetupOptions`]: its name, its kind, its range, and what people are told of it.
///
/// As JSON it is what a form needs to ask for it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct OptionSpec {
    /// Name of its member in an object.
    pub name: &'static str,
    /// Kind of its value.
    pub kind: OptionKind,
    /// `mm`, `mm/s`, `deg`, `%`, `px`, or empty.
    pub unit: &'static str,
    /// Words that may be chosen.
    pub choices: &'static [&'static str],
    /// Value that holds where it is not given; `None` if that depends on something else.
    pub default: Option<DefaultValue>,
    /// Inclusive lower bound of its numbers.
    pub least: Option<f64>,
    /// Exclusive lower bound of its numbers.
    pub above: Option<f64>,
    /// Inclusive upper bound of its numbers.
    pub most: Option<f64>,
    /// Option without which it does not count; `None` if it always counts. `work` is not asked: the
    /// tool decides it where it is not given, the laser engraves and every other tool draws.
    pub with: Option<&'static str>,
    /// Values of that option with which it counts; if empty, that option must be on.
    pub when: &'static [&'static str],
    /// Group that a form or a help shows it in.
    pub group: OptionGroup,
    /// True if it is seldom left out.
    pub usual: bool,
    /// Purpose, in one sentence.
    pub about: &'static str,
    /// Further sentences, where there is room for them; empty if there are none.
    #[serde(skip)]
    pub detail: &'static str,
    /// Purpose of switching it off; empty if it is no switch that is on by default.
    #[serde(skip)]
    pub off: &'static str,
    /// Default as part of a sentence, where it depends on something else; empty if it does not.
    #[serde(skip)]
    pub usually: &'static str,
    /// Accepted values as part of a sentence, where kind and range do not say it.
    #[serde(skip)]
    pub expects: &'static str,
    /// Placeholder of its value on a command line; empty if kind and unit say it.
    #[serde(skip)]
    pub placeholder: &'static str,
    /// Work that it belongs to, and that the other work refuses it; `None` for both.
    #[serde(skip)]
    pub work: Option<WorkOption>,
    /// Option without which it is refused.
    #[serde(skip)]
    pub needs: Option<Need>,
    /// Options that contradict it.
    #[serde(skip)]
    pub contradicts: &'static [&'static str],
    #[serde(skip)]
    formats: &'static [Format],
    #[serde(skip)]
    usual_for: &'static [Format],
    #[serde(skip)]
    changes: &'static [(&'static [Format], Change)],
}

/// Option without which another one is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Need {
    /// Name of the option.
    pub name: &'static str,
    /// Values that are enough; if empty, any value is.
    pub values: &'static [&'static str],
}

impl Need {
    /// True if this value of the option is enough.
    pub(super) fn is_met_by(&self, value: &Value) -> bool {
        let is_named = |text| self.values.is_empty() || self.values.contains(&text);
        value.as_str().is_some_and(is_named)
    }
}

/// Kind of the value of an option, and its form in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum OptionKind {
    /// Word out of a few.
    Choice,
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// x and y: an array of two numbers.
    Point,
    /// x, y and z: an array of three numbers.
    Place,
    /// From the left, from the top, width and height: an array of four whole numbers.
    Area,
    /// True or false.
    Switch,
    /// Text.
    Text,
    /// An array of texts.
    List,
    /// An array of objects as [`PenOptions`](super::PenOptions).
    Pens,
}

impl OptionKind {
    /// All of them, by their names in interfaces.
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
    /// Way of the pen, and lines of drawings.
    Pen,
    /// The rest.
    More,
}

impl OptionGroup {
    /// All of them, by their names in interfaces.
    pub const NAMES: [&'static str; 8] = [
        "place", "fill", "text", "parts", "image", "laser", "pen", "more",
    ];
}

/// Value of an option that is not given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum DefaultValue {
    /// A number.
    Number(f64),
    /// Word out of the choices.
    Word(&'static str),
    /// On or off.
    Switch(bool),
}

/// Difference of an option for some formats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    /// Switch without which it does not count.
    With(&'static str),
    /// Another default.
    Default(DefaultValue),
}

impl OptionSpec {
    /// True if it counts for files of this format.
    #[must_use]
    pub fn counts_for(&self, format: Format) -> bool {
        self.formats.contains(&format)
    }

    /// True if it is seldom left out for files of some format.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        !self.usual_for.is_empty()
    }

    /// True if it is a switch whose default depends on the format: both of its positions may have to
    /// be given.
    #[must_use]
    pub fn has_both_positions(&self) -> bool {
        let is_default = |(_, change): &(_, Change)| matches!(change, Change::Default(_));
        self.kind == OptionKind::Switch && self.changes.iter().any(is_default)
    }

    /// True if it is a switch that is off by default.
    #[must_use]
    pub fn is_off(&self) -> bool {
        self.default == Some(DefaultValue::Switch(false))
    }

    /// Returns the same row as it is for files of this format.
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
            // Any of its values is enough; a switch is on.
            row.when = partner.choices;
        }
        // A test grid is burnt with any tool: there is one kind of work.
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
    /// Returns the options that count for files of this format, those that are seldom left out
    /// first.
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
