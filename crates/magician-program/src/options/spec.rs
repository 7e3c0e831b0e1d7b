//! A row of the table of options: the facts about an option that every door needs.

use serde::Serialize;
use serde_json::Value;

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
    /// Work that it belongs to; `None` for both.
    #[serde(skip)]
    pub work: Option<WorkOption>,
    /// True if the other work refuses it.
    #[serde(skip)]
    pub only: bool,
    /// True if it is refused without the option that it counts with.
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

/// Kind of the value of an option, and its form in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
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
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
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

/// A row without anything but its kind, group and unit.
const fn row(kind: OptionKind, group: OptionGroup, unit: &'static str) -> OptionSpec {
    OptionSpec {
        name: "",
        kind,
        unit,
        choices: &[],
        default: None,
        least: None,
        above: None,
        most: None,
        with: None,
        when: &[],
        group,
        usual: false,
        about: "",
        detail: "",
        off: "",
        usually: "",
        expects: "",
        placeholder: "",
        work: None,
        only: false,
        needs: None,
        contradicts: &[],
        formats: &[],
        usual_for: &[],
        changes: &[],
    }
}

pub(super) const fn number(group: OptionGroup, unit: &'static str) -> OptionSpec {
    row(OptionKind::Number, group, unit)
}

pub(super) const fn integer(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Integer, group, "")
}

pub(super) const fn point(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Point, group, "mm")
}

pub(super) const fn place(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Place, group, "mm")
}

pub(super) const fn area(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Area, group, "px")
}

/// A switch that is off by default.
pub(super) const fn switch(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Switch, group, "").or(DefaultValue::Switch(false))
}

/// A switch that is on by default, and the purpose of switching it off.
pub(super) const fn switch_off(group: OptionGroup, off: &'static str) -> OptionSpec {
    OptionSpec {
        off,
        ..row(OptionKind::Switch, group, "").or(DefaultValue::Switch(true))
    }
}

pub(super) const fn text(group: OptionGroup, unit: &'static str) -> OptionSpec {
    row(OptionKind::Text, group, unit)
}

pub(super) const fn list(group: OptionGroup) -> OptionSpec {
    row(OptionKind::List, group, "")
}

pub(super) const fn pens(group: OptionGroup) -> OptionSpec {
    row(OptionKind::Pens, group, "")
}

pub(super) const fn choice(group: OptionGroup, choices: &'static [&'static str]) -> OptionSpec {
    OptionSpec {
        choices,
        ..row(OptionKind::Choice, group, "")
    }
}

/// A choice whose default is the first word.
pub(super) const fn first_of(group: OptionGroup, choices: &'static [&'static str]) -> OptionSpec {
    match choices {
        [first, ..] => choice(group, choices).or(DefaultValue::Word(first)),
        [] => choice(group, choices),
    }
}

/// Building a row.
impl OptionSpec {
    pub(super) const fn named(
        self,
        name: &'static str,
        about: &'static str,
        detail: &'static str,
    ) -> Self {
        Self {
            name,
            about,
            detail,
            ..self
        }
    }

    pub(super) const fn or(self, default: DefaultValue) -> Self {
        Self {
            default: Some(default),
            ..self
        }
    }

    pub(super) const fn usually(self, usually: &'static str) -> Self {
        Self { usually, ..self }
    }

    pub(super) const fn above(self, number: f64) -> Self {
        Self {
            above: Some(number),
            ..self
        }
    }

    pub(super) const fn from(self, least: f64) -> Self {
        Self {
            least: Some(least),
            ..self
        }
    }

    pub(super) const fn to(self, most: f64) -> Self {
        Self {
            most: Some(most),
            ..self
        }
    }

    pub(super) const fn expects(self, expects: &'static str, placeholder: &'static str) -> Self {
        Self {
            expects,
            placeholder,
            ..self
        }
    }

    /// Refuses it without another option.
    pub(super) const fn needs(self, name: &'static str, values: &'static [&'static str]) -> Self {
        Self {
            needs: Some(Need { name, values }),
            ..self.with(name, values)
        }
    }

    /// Binds it to another option, without which it does not count.
    pub(super) const fn with(self, name: &'static str, when: &'static [&'static str]) -> Self {
        Self {
            with: Some(name),
            when,
            ..self
        }
    }

    pub(super) const fn contradicts(self, names: &'static [&'static str]) -> Self {
        Self {
            contradicts: names,
            ..self
        }
    }

    /// Assigns it to a work.
    pub(super) const fn of_work(self, work: WorkOption) -> Self {
        Self {
            work: Some(work),
            ..self
        }
    }

    /// Assigns it to a work, and has the other one refuse it.
    pub(super) const fn only_of(self, work: WorkOption) -> Self {
        Self {
            only: true,
            ..self.of_work(work)
        }
    }

    pub(super) const fn for_formats(self, formats: &'static [Format]) -> Self {
        Self { formats, ..self }
    }

    pub(super) const fn usual_for(self, usual_for: &'static [Format]) -> Self {
        Self { usual_for, ..self }
    }

    pub(super) const fn changes(self, changes: &'static [(&'static [Format], Change)]) -> Self {
        Self { changes, ..self }
    }
}

/// Words in a sentence: `a, b or c`.
pub(super) fn either(words: &[&str]) -> String {
    match words.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => words.concat(),
    }
}

/// A number as people write it: not with three hundred digits.
fn figure(number: f64) -> String {
    match number == 0.0 || (1e-4..1e15).contains(&number.abs()) {
        true => number.to_string(),
        false if number.is_finite() => format!("{number:e}"),
        false => number.to_string().to_lowercase(),
    }
}

/// A value in a message.
pub(super) fn shown(value: &Value) -> String {
    /// Characters of a value that are shown: enough to recognise it.
    const MOST: usize = 60;
    let text = match value {
        // JSON has no other form for what is no number.
        Value::Null => "nan".to_owned(),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), figure),
        Value::String(text) => match text.parse::<f64>() {
            Ok(number) if !number.is_finite() => figure(number),
            _ => format!("{text:?}"),
        },
        Value::Array(items) => {
            let items: Vec<_> = items.iter().map(shown).collect();
            format!("[{}]", items.join(", "))
        }
        other => other.to_string(),
    };
    match text.chars().nth(MOST) {
        Some(_) => text.chars().take(MOST).chain("..".chars()).collect(),
        None => text,
    }
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
        if self.only && row.with.is_none() && format != Format::TestGrid {
            row.with = Some("work");
            row.when = match self.work {
                Some(WorkOption::Engrave) => &["engrave"],
                _ => &["draw"],
            };
        }
        row
    }

    /// Returns the accepted values as part of a sentence.
    #[must_use]
    pub fn accepted(&self) -> String {
        let unit = match self.unit {
            "" => "",
            "%" => " percent",
            "deg" => " degrees",
            "px" => " pixels",
            "mm" => " mm",
            other => return self.within(&format!(" {other}")),
        };
        self.within(unit)
    }

    fn within(&self, unit: &str) -> String {
        let bounds = [self.least, self.above, self.most].map(|bound| bound.map(figure));
        let range = match &bounds {
            [Some(least), _, Some(most)] => format!("from {least} to {most}{unit}"),
            [Some(least), _, None] => format!("from {least}{unit} on"),
            [None, Some(above), Some(most)] => format!("above {above} and at most {most}{unit}"),
            [None, Some(above), None] => format!("above {above}{unit}"),
            [None, None, Some(most)] => format!("at most {most}{unit}"),
            [None, None, None] => String::new(),
        };
        match self.kind {
            _ if !self.expects.is_empty() => self.expects.to_owned(),
            OptionKind::Choice => either(self.choices),
            OptionKind::Number => format!("a number {range}"),
            OptionKind::Integer => format!("a whole number {range}"),
            OptionKind::Point => format!("two numbers, X and Y, each {range}"),
            OptionKind::Place => format!("three numbers, X, Y and Z, each {range}"),
            OptionKind::Area => {
                format!("four whole numbers of{unit}, X, Y, W and H, the last two above 0")
            }
            OptionKind::Switch => "true or false".to_owned(),
            OptionKind::Text => "a text".to_owned(),
            OptionKind::List => "a list of texts".to_owned(),
            OptionKind::Pens => "a list of pens".to_owned(),
        }
    }

    /// True if a number is in its range; NaN is not.
    fn admits(&self, number: f64) -> bool {
        number.is_finite()
            && self.least.is_none_or(|least| number >= least)
            && self.above.is_none_or(|above| number > above)
            && self.most.is_none_or(|most| number <= most)
    }

    /// True if the numbers of a value are in its range. Values of other kinds have none.
    pub(super) fn is_within(&self, value: &Value) -> bool {
        match (self.kind, value) {
            (OptionKind::Number | OptionKind::Integer, value) => {
                value.as_f64().is_some_and(|number| self.admits(number))
            }
            (OptionKind::Point | OptionKind::Place, Value::Array(items)) => {
                let numbers = items.iter().map(Value::as_f64);
                { numbers }.all(|number| number.is_some_and(|number| self.admits(number)))
            }
            _ => true,
        }
    }

    /// Returns the message that a value is not accepted.
    #[must_use]
    pub fn refusal(&self, value: &Value) -> String {
        format!("{} is {}, not {}", self.name, self.accepted(), shown(value))
    }

    /// Reads a value from the text of a command line. What cannot be a value of its kind becomes a
    /// text, which the option then refuses like any other.
    #[must_use]
    pub fn value_of(&self, text: &str) -> Value {
        let number = |text: &str| {
            let text = text.trim();
            let text = if self.unit == "%" {
                text.trim_end_matches('%')
            } else {
                text
            };
            let whole = text.parse::<i64>().ok().map(Value::from);
            whole.or_else(|| {
                text.parse::<f64>()
                    .ok()
                    .filter(|number| number.is_finite())
                    .map(Value::from)
            })
        };
        let read = match self.kind {
            OptionKind::Number | OptionKind::Integer => number(text),
            OptionKind::Point | OptionKind::Place | OptionKind::Area if text.contains(',') => {
                let parts = text
                    .split(',')
                    .map(|part| number(part).unwrap_or_else(|| part.into()));
                Some(parts.collect())
            }
            OptionKind::Switch => text.parse::<bool>().ok().map(Value::Bool),
            OptionKind::List => Some(Value::Array(vec![text.into()])),
            // A text with a unit may be a number.
            OptionKind::Text if !self.unit.is_empty() => number(text),
            _ => None,
        };
        read.unwrap_or_else(|| text.into())
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
