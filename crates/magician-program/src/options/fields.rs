//! Options as members of a JSON object: the common entry for all front ends.

use magician_host::{Message, OptionName, message};
use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use serde_json::{Map, Value};

use super::spec::join_with_or;
use super::{Need, OptionKind, OptionSpec, SetupOptions, WorkOption};
use crate::FontChoice;

/// Characters shown of an unknown option's name: the name may come from a network and be of any
/// length.
const MAX_SHOWN_NAME: usize = 40;

/// Error of an option.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct OptionError {
    /// Name of the option.
    pub key: String,
    /// Reason, in a sentence that names the option.
    pub message: Message,
    /// Option that is needed and missing, if that is the reason.
    pub needs: Option<Need>,
}

impl OptionError {
    fn new(key: &str, message: impl Into<Message>) -> Self {
        Self {
            key: key.to_owned(),
            message: message.into(),
            needs: None,
        }
    }
}

impl fmt::Display for OptionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for OptionError {}

impl Need {
    /// Same text as `Display`, as part of a message.
    fn to_message(self) -> Message {
        let name = OptionName(self.name);
        match self.values {
            [] => message!("{name}", name),
            values => message!("{name}: {choices}", name, choices = join_with_or(values)),
        }
    }
}

/// `fill: hatch, cross or contour`, or the name alone if any value will do.
impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.values {
            [] => f.write_str(self.name),
            values => write!(f, "{}: {}", self.name, join_with_or(values)),
        }
    }
}

impl SetupOptions {
    /// Names of all options.
    #[must_use]
    pub fn keys() -> Vec<String> {
        let names = Self::OPTIONS.iter().map(|row| row.name.to_owned());
        names.collect()
    }

    /// Reads options from the members of an object.
    ///
    /// # Errors
    /// The first unknown option, invalid value, or contradiction between options.
    pub fn from_fields(fields: &Map<String, Value>) -> Result<Self, OptionError> {
        let options = Self::from_partial_fields(fields)?;
        options.check_agreement()?;
        Ok(options)
    }

    /// Like [`from_fields`](Self::from_fields), for options that are completed later by
    /// [`or`](Self::or). Contradictions are not checked yet; [`check`](Self::check) does that
    /// later.
    ///
    /// # Errors
    /// The first unknown option or invalid value.
    pub fn from_partial_fields(fields: &Map<String, Value>) -> Result<Self, OptionError> {
        let mut options = Self::default();
        for (key, value) in fields {
            let Some(row) = Self::option(key) else {
                let shown: String = key.chars().take(MAX_SHOWN_NAME).collect();
                let known = Self::keys().join(", ");
                let message = message!("unknown option {shown}; known are {known}", shown, known);
                return Err(OptionError::new(&shown, message));
            };
            options.take(row, value)?;
        }
        Ok(options)
    }

    /// Reads the value of an option and checks its range.
    fn take(&mut self, row: &OptionSpec, value: &Value) -> Result<(), OptionError> {
        let name = row.name;
        if value.is_null() {
            return Err(OptionError::new(
                name,
                message!("{name} has no value", name = OptionName(name)),
            ));
        }
        // The range comes from the table, so every option is checked in the same way.
        let read = if row.is_within(value) {
            self.set(name, value)
        } else {
            Err(None)
        };
        read.map_err(|why| {
            let message = match why {
                Some(why) => message!("{name}: {why}", name = OptionName(name), why),
                None => row.refusal(value),
            };
            OptionError::new(name, message)
        })
    }

    /// Returns the options that are set, as members of an object. [`WorkOption::ByFile`] is left
    /// out, and a font from a file is reduced to its name.
    #[must_use]
    pub fn to_fields(&self) -> Map<String, Value> {
        let values = self.values().into_iter();
        let given = values.filter_map(|(row, value)| Some((row.name.to_owned(), value?)));
        given.filter(|(_, value)| !value.is_null()).collect()
    }

    /// Checks ranges and contradictions.
    ///
    /// # Errors
    /// The first option that is out of its range or contradicts another.
    pub fn check(&self) -> Result<(), OptionError> {
        let from_file = matches!(self.font, Some(FontChoice::File { .. }));
        let by_file = self.work == Some(WorkOption::ByFile);
        let problems = (1..).zip(&self.pens);
        let mut problems = problems.filter_map(|(n, pen)| Some((n, pen.problem()?)));
        if let Some((n, problem)) = problems.next() {
            return Err(OptionError::new(
                "pens",
                message!("pens: pen {n}: {problem}", n, problem),
            ));
        }
        let mut read = Self::default();
        for (row, value) in self.values() {
            match value {
                // The value has no JSON form, but only our own code sets it, so it is valid.
                Some(_) if from_file && row.name == "font" => {}
                Some(_) if by_file && row.name == "work" => {}
                // JSON has no form for NaN and infinity.
                Some(Value::Null) => {
                    return Err(OptionError::new(row.name, row.refusal(&Value::Null)));
                }
                Some(value) => read.take(row, &value)?,
                None => {}
            }
        }
        self.check_agreement()
    }

    /// Returns the options that are set but do not apply to `work`.
    #[must_use]
    pub fn not_applicable_to(&self, work: Option<WorkOption>) -> Vec<&'static OptionSpec> {
        let given = self.to_fields();
        let rows = Self::OPTIONS.iter();
        rows.filter(|row| given.contains_key(row.name))
            .filter(|row| row.work.and_then(|own| own.excluded_by(work)).is_some())
            .collect()
    }

    /// Returns these options without those that `over` replaces: options of the other kind of work,
    /// options that contradict one in `over`, and options whose required partner `over` changes or
    /// drops.
    pub(super) fn without_replaced_by(&self, over: &Self) -> Self {
        let mut left = self.clone();
        let (given, work) = (over.to_fields(), over.work);
        let contradict = |one: &OptionSpec, other: &OptionSpec| {
            one.contradicts.contains(&other.name) || other.contradicts.contains(&one.name)
        };
        let over = given.keys().filter_map(|name| Self::option(name));
        let over: Vec<_> = over.collect();
        let mut gone: Vec<&str> = Vec::new();
        // Dropping one option can leave another without its partner: repeat until nothing changes.
        loop {
            let fields = left.to_fields();
            let rows = Self::OPTIONS.iter();
            let mut own =
                rows.filter(|row| fields.contains_key(row.name) && !given.contains_key(row.name));
            let replaced = own.find(|row| {
                let partner = row.needs.is_some_and(|need| match given.get(need.name) {
                    Some(value) => !need.is_met_by(value),
                    None => gone.contains(&need.name),
                });
                let other_work = row.work.and_then(|own| own.excluded_by(work)).is_some();
                other_work || partner || over.iter().any(|other| contradict(row, other))
            });
            let Some(row) = replaced else {
                return left;
            };
            left.clear(row.name);
            gone.push(row.name);
        }
    }

    /// Checks that each option has the options it needs, and contradicts none.
    fn check_agreement(&self) -> Result<(), OptionError> {
        let given = self.to_fields();
        for row in Self::OPTIONS
            .iter()
            .filter(|row| given.contains_key(row.name))
        {
            let name = row.name;
            let mut others = row.contradicts.iter();
            if let Some(other) = others.find(|other| given.contains_key(**other)) {
                let message = message!(
                    "{name} and {other} contradict each other",
                    name = OptionName(name),
                    other = OptionName(other)
                );
                return Err(OptionError::new(name, message));
            }
            let is_enough = |need: &Need| given.get(need.name).is_some_and(|it| need.is_met_by(it));
            if let Some(need) = row.needs.filter(|need| !is_enough(need)) {
                return Err(OptionError {
                    needs: Some(need),
                    ..OptionError::new(
                        name,
                        message!(
                            "{name} needs {need}",
                            name = OptionName(name),
                            need = need.to_message()
                        ),
                    )
                });
            }
            if let Some(why) = row.work.and_then(|work| work.excluded_by(self.work)) {
                return Err(OptionError::new(
                    name,
                    message!("{name} counts where {why}", name = OptionName(name), why),
                ));
            }
        }
        // Page and margin may each be valid and yet leave no room together.
        if let Some(problem) = self.page_with_margin().and_then(|page| page.problem()) {
            let key = match self.margin {
                Some(_) => "margin",
                None => "page",
            };
            return Err(OptionError::new(
                key,
                message!("{key}: {problem}", key = OptionName(key), problem),
            ));
        }
        Ok(())
    }
}

/// Serialises one member for each option; null or false if the option is not set.
impl Serialize for SetupOptions {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let values = self.values().into_iter().map(|(row, value)| {
            let open = match row.kind {
                OptionKind::Switch if row.is_off() => Value::Bool(false),
                OptionKind::List | OptionKind::Pens => Value::Array(Vec::new()),
                _ => Value::Null,
            };
            (row.name, value.unwrap_or(open))
        });
        serializer.collect_map(values)
    }
}

/// Reads what [`Serialize`] writes. Does not check if the options agree.
impl<'de> Deserialize<'de> for SetupOptions {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut fields = Map::<String, Value>::deserialize(deserializer)?;
        fields.retain(|_, value| !value.is_null());
        Self::from_partial_fields(&fields).map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn read(fields: Value) -> Result<SetupOptions, OptionError> {
        let Value::Object(fields) = fields else {
            panic!("{fields}");
        };
        SetupOptions::from_fields(&fields)
    }

    #[test]
    fn errors_name_their_option() {
        for (fields, key) in [
            (json!({"colour": "red"}), "colour"),
            (json!({"by_file": true}), "by_file"),
            (json!({"work": "by_file"}), "work"),
            (json!({"scale": 0}), "scale"),
            (json!({"scale": "2"}), "scale"),
            (json!({"scale": null}), "scale"),
            (json!({"at": [1, 2, 3]}), "at"),
            (json!({"at": "1,2"}), "at"),
            (json!({"fit": 1}), "fit"),
            (json!({"speed_ratio": 0.5}), "speed_ratio"),
            (json!({"speed": 1e-9}), "speed"),
            (json!({"travel_speed": 0.001}), "travel_speed"),
            (json!({"width": 1e300}), "width"),
            (json!({"height": 10001}), "height"),
            (json!({"speed_ratio": 101}), "speed_ratio"),
            (json!({"threshold": 0}), "threshold"),
            (json!({"threshold": 256}), "threshold"),
            (json!({"power": 0}), "power"),
            (json!({"power": "80..5"}), "power"),
            (json!({"tool": "spoon"}), "tool"),
            (json!({"tool": [1, 2]}), "tool"),
            (json!({"grid": "0x1:1x1"}), "grid"),
            (json!({"white": "grey"}), "white"),
            (json!({"dialect": "mill"}), "dialect"),
            (json!({"mode": "shiny"}), "mode"),
            (json!({"font": "serif"}), "font"),
            (json!({"merge": -0.1}), "merge"),
            (json!({"simplify": -1}), "simplify"),
            (json!({"dedupe": 1}), "dedupe"),
            (json!({"font": "fonts/serif.ttf"}), "font"),
            (json!({"size": 0}), "size"),
            (json!({"wrap": -1}), "wrap"),
            (json!({"align": "middle"}), "align"),
            (json!({"line_height": 0}), "line_height"),
            (json!({"fill": "solid"}), "fill"),
            (json!({"fill_spacing": 0}), "fill_spacing"),
            (json!({"fill_inset": -1}), "fill_inset"),
            (json!({"frame": "circle"}), "frame"),
            (json!({"frame": "box", "frame_power": 6}), "frame_power"),
            (json!({"frame": "box", "frame_power": 0}), "frame_power"),
            (json!({"frame_power": 2}), "frame_power"),
            (json!({"raw": true, "at": [1, 2]}), "raw"),
            (json!({"raw": true, "page": "a4"}), "raw"),
            (json!({"page": "b7"}), "page"),
            (json!({"page": "0x100"}), "page"),
            (json!({"page": "20x100"}), "page"),
            (json!({"margin": 5}), "margin"),
            (json!({"page": "a4", "margin": -1}), "margin"),
            (json!({"page": "a4", "margin": 105}), "margin"),
            (json!({"stay": true, "park": [1, 2, 3]}), "stay"),
            (json!({"width": 1, "height": 1}), "height"),
            (json!({"work": "draw", "one_way": true}), "one_way"),
            (json!({"work": "engrave", "image": "hatch"}), "image"),
            (json!({"work": "draw", "power": 50}), "power"),
            (json!({"work": "engrave", "lift": 5}), "lift"),
            (json!({"work": "engrave", "hop": 5}), "hop"),
            (
                json!({"work": "engrave", "travel_speed": 50}),
                "travel_speed",
            ),
            (json!({"work": "engrave", "order": false}), "order"),
            (json!({"image": "photo"}), "image"),
            (json!({"image": "squiggle", "levels": 4}), "levels"),
            (json!({"image": "hatch", "levels": 0}), "levels"),
            (json!({"image": "hatch", "levels": 65}), "levels"),
            (json!({"despeckle": -1}), "despeckle"),
            (json!({"pen_width": 0}), "pen_width"),
            (json!({"crop": [0, 0, 10]}), "crop"),
            (json!({"crop": [0, -1, 10, 10]}), "crop"),
            (json!({"crop": [0, 0, 0, 10]}), "crop"),
            (json!({"brightness": 101}), "brightness"),
            (json!({"contrast": -101}), "contrast"),
        ] {
            let error = read(fields.clone()).expect_err(&fields.to_string());
            assert_eq!(error.key, key, "{fields}: {error}");
            assert!(error.message.contains(key), "{error}");
        }
    }

    #[test]
    fn given_options_override_the_preset() {
        let said = read(json!({"order": false, "fit": true, "at": [200, 0]})).unwrap();
        let under = read(json!({"order": true, "mirror": true, "at": [1, 2], "font": "script", "power": "5..80", "tool": [1, 2, 3]})).unwrap();
        let both = said.or(&under);
        assert_eq!(
            (both.order, both.fit, both.mirror),
            (Some(false), true, true)
        );
        assert_eq!((both.at, both.font), (said.at, under.font.clone()));
        assert_eq!((both.power, both.tool), (under.power, under.tool));
        let with_file = SetupOptions {
            font: Some(crate::FontChoice::file("a.ttf", vec![1, 2])),
            ..SetupOptions::default()
        };
        assert_eq!(with_file.or(&under).font, with_file.font);
        assert_eq!(SetupOptions::default().or(&with_file).font, with_file.font);
    }

    #[test]
    fn options_are_written_and_read_back() {
        let fields = json!({
            "work": "engrave", "tool": [10, 0, -5.5], "power": "5..80", "white": "draw",
            "dialect": "servo", "grid": "2x3:40x30", "move": [1, 2, 3],
            "mode": "threshold", "threshold": 100, "fit": true, "turn": false,
            "font": "script", "size": 12.5, "align": "center", "strict_text": true, "fill": "hatch", "fill_angle": -30.0,
        });
        let options = read(fields.clone()).unwrap();
        let Ok(Value::Object(mut written)) = serde_json::to_value(&options) else {
            panic!("no object");
        };
        assert_eq!(
            serde_json::from_value::<SetupOptions>(Value::Object(written.clone())).unwrap(),
            options
        );
        written.retain(|_, value| !value.is_null() && *value != json!(false));
        let mut expected = fields.as_object().unwrap().clone();
        expected.insert("tool".to_owned(), json!([10.0, 0.0, -5.5]));
        expected.insert("move".to_owned(), json!([1.0, 2.0, 3.0]));
        expected.retain(|_, value| *value != json!(false));
        written.retain(|key, _| expected.contains_key(key));
        assert_eq!(Value::Object(written), Value::Object(expected));
        assert!(SetupOptions::keys().contains(&"move".to_owned()));
    }
}
