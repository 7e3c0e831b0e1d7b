//! Accepted values of an option: their description, parsing from a command line, and the refusal of
//! others.

use magician_host::{Message, OptionName, message};
use serde_json::Value;

use super::{OptionKind, OptionSpec};

/// Joins words for a sentence: `a, b or c`.
pub(in crate::options) fn join_with_or(words: &[&str]) -> String {
    match words.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => words.concat(),
    }
}

/// Number as text; very large and small ones in scientific notation, since `Display` would print
/// all digits.
fn format_number(number: f64) -> String {
    if number == 0.0 || (1e-4..1e15).contains(&number.abs()) {
        number.to_string()
    } else if number.is_finite() {
        format!("{number:e}")
    } else {
        number.to_string().to_lowercase()
    }
}

/// Value as shown in a message.
pub(in crate::options) fn shortened(value: &Value) -> String {
    /// Characters shown of a value: enough to recognise it.
    const MAX_SHOWN_VALUE: usize = 60;
    let text = match value {
        // JSON stores NaN as null.
        Value::Null => "nan".to_owned(),
        Value::Number(number) => number
            .as_f64()
            .map_or_else(|| number.to_string(), format_number),
        Value::String(text) => match text.parse::<f64>() {
            Ok(number) if !number.is_finite() => format_number(number),
            _ => format!("{text:?}"),
        },
        Value::Array(items) => {
            let items: Vec<_> = items.iter().map(shortened).collect();
            format!("[{}]", items.join(", "))
        }
        other => other.to_string(),
    };
    match text.chars().nth(MAX_SHOWN_VALUE) {
        Some(_) => text
            .chars()
            .take(MAX_SHOWN_VALUE)
            .chain("..".chars())
            .collect(),
        None => text,
    }
}

impl OptionSpec {
    /// Describes the accepted values as part of a sentence.
    #[must_use]
    pub fn accepted(&self) -> String {
        self.accepted_message().into()
    }

    fn accepted_message(&self) -> Message {
        let unit = match self.unit {
            "" => "".into(),
            "%" => Message::word(" percent"),
            "deg" => Message::word(" degrees"),
            "px" => Message::word(" pixels"),
            "mm" => " mm".into(),
            other => return self.range_message(format!(" {other}").into()),
        };
        self.range_message(unit)
    }

    fn range_message(&self, unit: Message) -> Message {
        let bounds = [self.least, self.above, self.most].map(|bound| bound.map(format_number));
        let range = match &bounds {
            [Some(least), _, Some(most)] => {
                message!("from {least} to {most}{unit}", least, most, unit)
            }
            [Some(least), _, None] => message!("from {least}{unit} on", least, unit),
            [None, Some(above), Some(most)] => {
                message!("above {above} and at most {most}{unit}", above, most, unit)
            }
            [None, Some(above), None] => message!("above {above}{unit}", above, unit),
            [None, None, Some(most)] => message!("at most {most}{unit}", most, unit),
            [None, None, None] => String::new().into(),
        };
        match self.kind {
            _ if !self.expects.is_empty() => Message::word(self.expects),
            OptionKind::Choice => join_with_or(self.choices).into(),
            OptionKind::Number => message!("a number {range}", range),
            OptionKind::Integer => message!("a whole number {range}", range),
            OptionKind::Point => message!("two numbers, X and Y, each {range}", range),
            OptionKind::Place => message!("three numbers, X, Y and Z, each {range}", range),
            OptionKind::Area => {
                message!(
                    "four whole numbers of{unit}, X, Y, W and H, the last two above 0",
                    unit
                )
            }
            OptionKind::Switch => message!("true or false"),
            OptionKind::Text => message!("a text"),
            OptionKind::List => message!("a list of texts"),
            OptionKind::Pens => message!("a list of pens"),
        }
    }

    /// True if a number is in range. False for NaN.
    fn admits(&self, number: f64) -> bool {
        number.is_finite()
            && self.least.is_none_or(|least| number >= least)
            && self.above.is_none_or(|above| number > above)
            && self.most.is_none_or(|most| number <= most)
    }

    /// True if the numbers of a value are in range. Always true for values of other kinds.
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

    /// Returns the message that refuses a value.
    #[must_use]
    pub fn refusal(&self, value: &Value) -> Message {
        message!(
            "{name} is {accepted}, not {value}",
            name = OptionName(self.name),
            accepted = self.accepted_message(),
            value = shortened(value)
        )
    }

    /// Parses a value from the text of a command line. Text that does not parse is returned
    /// unchanged, and the option then refuses it like any other wrong value.
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
            // A text option with a unit may also take a number.
            OptionKind::Text if !self.unit.is_empty() => number(text),
            _ => None,
        };
        read.unwrap_or_else(|| text.into())
    }
}
