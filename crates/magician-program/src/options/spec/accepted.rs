//! The accepted values of an option: in a sentence, from the text of a command line, and the refusal
//! of others.

use serde_json::Value;

use super::{OptionKind, OptionSpec};

/// Words in a sentence: `a, b or c`.
pub(in crate::options) fn either(words: &[&str]) -> String {
    match words.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => words.concat(),
    }
}

/// A number as people write it: not with three hundred digits.
fn figure(number: f64) -> String {
    if number == 0.0 || (1e-4..1e15).contains(&number.abs()) {
        number.to_string()
    } else if number.is_finite() {
        format!("{number:e}")
    } else {
        number.to_string().to_lowercase()
    }
}

/// A value in a message.
pub(in crate::options) fn shown(value: &Value) -> String {
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
    pub(in crate::options) fn is_within(&self, value: &Value) -> bool {
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
