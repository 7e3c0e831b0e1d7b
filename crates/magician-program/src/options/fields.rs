//! Options as members of an object: each is read by itself, so that what is wrong has the name of its member.

use std::fmt;

use serde_json::{Map, Value};

use super::asked::{OF_WORK, OfWork};
use super::{SetupOptions, WorkOption};
use crate::Framing;
use crate::fill::{FillMode, LEAST_SPACING};
use crate::raster::ImageStyle;

/// Largest width and height of a drawing, mm: far beyond every sheet, and numbers of this size are still exact
/// to the micrometre in the `f32` of the arm.
const LARGEST_SIZE: f64 = 10_000.0;
/// Least speed, mm/s: a slower arm cannot be told from one that stands.
const LEAST_SPEED: f64 = 0.01;

/// Why an option is not taken.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct OptionError {
    /// The name of the option.
    pub key: String,
    /// What is wrong, in a sentence that names the option.
    pub message: String,
}

impl OptionError {
    fn new(key: &str, message: impl Into<String>) -> Self {
        Self {
            key: key.to_owned(),
            message: message.into(),
        }
    }
}

impl fmt::Display for OptionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for OptionError {}

impl SetupOptions {
    /// The names of all options, as members of an object.
    #[must_use]
    pub fn keys() -> Vec<String> {
        let all = serde_json::to_value(Self::default());
        let Ok(Value::Object(all)) = all else {
            return Vec::new();
        };
        all.into_iter().map(|(key, _)| key).collect()
    }

    /// Reads the members of an object.
    ///
    /// # Errors
    /// The first that is no option, has no such value, or contradicts another.
    pub fn from_fields(fields: &Map<String, Value>) -> Result<Self, OptionError> {
        let options = Self::from_fields_of_some(fields)?;
        options.contradictions()?;
        Ok(options)
    }

    /// The same, of fields that others come under ([`or`](Self::or)): whether they agree shows only then
    /// ([`check`](Self::check)).
    ///
    /// # Errors
    /// The first that is no option, or has no such value.
    pub fn from_fields_of_some(fields: &Map<String, Value>) -> Result<Self, OptionError> {
        for (key, value) in fields {
            let shown: String = key.chars().take(40).collect();
            if value.is_null() {
                return Err(OptionError::new(&shown, format!("{shown} has no value")));
            }
            let alone = Map::from_iter([(key.clone(), value.clone())]);
            serde_json::from_value::<Self>(Value::Object(alone)).map_err(|error| {
                let message = match Self::keys().contains(key) {
                    true => format!("{shown}: {error}"),
                    false => format!(
                        "unknown option {shown}; known are {}",
                        Self::keys().join(", ")
                    ),
                };
                OptionError::new(&shown, message)
            })?;
        }
        let whole = serde_json::from_value::<Self>(Value::Object(fields.clone()));
        let options = whole.map_err(|error| OptionError::new("", error.to_string()))?;
        options.check_values()?;
        Ok(options)
    }

    /// These, and where they are left open what others say.
    ///
    /// ```
    /// use magician_program::SetupOptions;
    ///
    /// let (mut said, mut preset) = (SetupOptions::default(), SetupOptions::default());
    /// (said.speed, preset.speed, preset.lift) = (Some(20.0), Some(50.0), Some(5.0));
    /// let both = said.or(&preset);
    /// assert_eq!((both.speed, both.lift), (Some(20.0), Some(5.0)));
    /// ```
    #[must_use]
    pub fn or(&self, under: &Self) -> Self {
        let members = |options: &Self| match serde_json::to_value(options) {
            Ok(Value::Object(members)) => members,
            _ => Map::new(),
        };
        let (mut all, open) = (members(self), members(&Self::default()));
        for (key, value) in members(under) {
            if all.get(&key) == open.get(&key) {
                all.insert(key, value);
            }
        }
        // Of a font of a file its name would be left.
        all.remove("font");
        let both = serde_json::from_value::<Self>(Value::Object(all));
        let font = self.font.clone().or_else(|| under.font.clone());
        both.map_or_else(|_| self.clone(), |both| Self { font, ..both })
    }

    /// Checks values, and that none contradicts another.
    ///
    /// # Errors
    /// The first that is out of its range, or contradicts another.
    pub fn check(&self) -> Result<(), OptionError> {
        self.check_values()?;
        self.contradictions()
    }

    /// Checks that sizes and speeds are such as an arm can have.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check_extremes(&self) -> Result<(), OptionError> {
        for (key, value) in [("width", self.width), ("height", self.height)] {
            if let Some(value) = value.filter(|value| *value > LARGEST_SIZE) {
                let message = format!("{key} is at most {LARGEST_SIZE} mm, not {value:e}");
                return Err(OptionError::new(key, message));
            }
        }
        for (key, value) in [("speed", self.speed), ("travel_speed", self.travel_speed)] {
            if let Some(value) = value.filter(|value| *value < LEAST_SPEED) {
                let message = format!("{key} is {LEAST_SPEED} mm/s or more, not {value:e}");
                return Err(OptionError::new(key, message));
            }
        }
        Ok(())
    }

    /// Checks values alone.
    ///
    /// # Errors
    /// The first that is out of its range.
    pub fn check_values(&self) -> Result<(), OptionError> {
        let above_0 = [
            ("s_max", self.s_max),
            ("resample", self.resample),
            ("scale", self.scale),
            ("speed", self.speed),
            ("lift", self.lift),
            ("hop", self.hop),
            ("travel_speed", self.travel_speed),
            ("tolerance", self.tolerance),
            ("width", self.width),
            ("height", self.height),
            ("spacing", self.spacing),
            ("overscan", self.overscan),
            ("gamma", self.gamma),
            ("pen_width", self.pen_width),
            ("size", self.size),
            ("wrap", self.wrap),
            ("line_height", self.line_height),
        ];
        for (key, value) in above_0 {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                let message = format!("{key} is a number above 0, not {value}");
                return Err(OptionError::new(key, message));
            }
        }
        self.check_extremes()?;
        for (key, value) in [
            ("merge", self.merge),
            ("simplify", self.simplify),
            ("despeckle", self.despeckle),
            ("margin", self.margin),
        ] {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value >= 0.0)) {
                let message = format!("{key} is a number from 0, not {value}");
                return Err(OptionError::new(key, message));
            }
        }
        let finite: [(&str, &[f64]); 8] = [
            ("fill_angle", self.fill_angle.as_slice()),
            ("surface", self.surface.as_slice()),
            ("pen_z", self.pen_z.as_slice()),
            ("rotate", self.rotate.as_slice()),
            ("at", self.at.as_ref().map_or(&[], |at| at)),
            ("start", self.start.as_ref().map_or(&[], |at| at)),
            ("move", self.by.as_ref().map_or(&[], |by| by)),
            ("park", self.park.as_ref().map_or(&[], |at| at)),
        ];
        for (key, values) in finite {
            if values.iter().any(|value| !value.is_finite()) {
                return Err(OptionError::new(key, format!("{key} is of finite numbers")));
            }
        }
        if let Some(ratio) = self
            .speed_ratio
            .filter(|ratio| !(1.0..=100.0).contains(ratio))
        {
            let message = format!("speed_ratio is 1 to 100 percent, not {ratio}");
            return Err(OptionError::new("speed_ratio", message));
        }
        let fine = |spacing: &f64| !(spacing.is_finite() && *spacing >= LEAST_SPACING);
        if let Some(spacing) = self.fill_spacing.filter(fine) {
            let message = format!("fill_spacing is {LEAST_SPACING} mm or more, not {spacing}");
            return Err(OptionError::new("fill_spacing", message));
        }
        if let Some(inset) = self
            .fill_inset
            .filter(|inset| !(inset.is_finite() && *inset >= 0.0))
        {
            let message = format!("fill_inset is a number from 0 on, not {inset}");
            return Err(OptionError::new("fill_inset", message));
        }
        if let Some(message) = super::pens::passes_problem(self.passes) {
            return Err(OptionError::new("passes", message));
        }
        for (n, pen) in (1..).zip(&self.pens) {
            if let Some(problem) = pen.problem() {
                return Err(OptionError::new(
                    "pens",
                    format!("pens: pen {n}: {problem}"),
                ));
            }
        }
        if let Some(power) = self
            .frame_power
            .filter(|power| !(*power > 0.0 && *power <= Framing::MOST_POWER))
        {
            let most = Framing::MOST_POWER;
            let message = format!("frame_power is above 0 and at most {most} percent, not {power}");
            return Err(OptionError::new("frame_power", message));
        }
        for (key, value) in [("brightness", self.brightness), ("contrast", self.contrast)] {
            if let Some(value) = value.filter(|value| !(-100.0..=100.0).contains(value)) {
                let message = format!("{key} is -100 to 100, not {value}");
                return Err(OptionError::new(key, message));
            }
        }
        if let Some(levels) = self.levels.filter(|levels| !(1..=64).contains(levels)) {
            let message = format!("levels is 1 to 64, not {levels}");
            return Err(OptionError::new("levels", message));
        }
        if let Some([_, _, width, height]) = self.crop
            && (width == 0 || height == 0)
        {
            let message = "crop is X,Y,W,H in pixels, with a width and a height above 0";
            return Err(OptionError::new("crop", message));
        }
        if self.threshold == Some(0) {
            let message = "threshold is a grey from 1 to 255, not 0";
            return Err(OptionError::new("threshold", message));
        }
        if self.power.is_some_and(|power| power.range()[1] <= 0.0) {
            let message = "power is percent above 0, such as 80 or 5..80";
            return Err(OptionError::new("power", message));
        }
        Ok(())
    }

    fn contradictions(&self) -> Result<(), OptionError> {
        let both = [
            ("raw", self.raw, "place", self.place),
            ("raw", self.raw, "at", self.at.is_some()),
            ("raw", self.raw, "page", self.page.is_some()),
            ("raw", self.raw, "fit", self.fit),
            ("raw", self.raw, "surface", self.surface.is_some()),
            ("raw", self.raw, "pen_z", self.pen_z.is_some()),
            (
                "height",
                self.height.is_some(),
                "width",
                self.width.is_some(),
            ),
            ("stay", self.stay, "park", self.park.is_some()),
        ];
        for (key, given, other, too) in both {
            if given && too {
                let message = format!("{key} and {other} contradict each other");
                return Err(OptionError::new(key, message));
            }
        }
        let filling = [
            ("fill_spacing", self.fill_spacing),
            ("fill_angle", self.fill_angle),
            ("fill_inset", self.fill_inset),
        ];
        let unfilled = matches!(self.fill, None | Some(FillMode::None));
        if let Some((key, _)) = filling
            .iter()
            .find(|(_, value)| unfilled && value.is_some())
        {
            let message = format!("{key} needs fill: hatch, cross or contour");
            return Err(OptionError::new(key, message));
        }
        if self.margin.is_some() && self.page.is_none() {
            let message = "margin needs page, such as a4 or 200x150";
            return Err(OptionError::new("margin", message));
        }
        if let Some(problem) = self.placed_page().and_then(|page| page.problem()) {
            let key = if self.margin.is_some() {
                "margin"
            } else {
                "page"
            };
            return Err(OptionError::new(key, format!("{key}: {problem}")));
        }
        if self.frame_power.is_some() && self.frame.is_none() {
            let message = "frame_power needs frame: box, hull or outline";
            return Err(OptionError::new("frame_power", message));
        }
        for OfWork { key, work, given } in OF_WORK {
            let said = match (self.work, work) {
                (Some(WorkOption::Draw), WorkOption::Engrave) => "the laser engraves: work is draw",
                (Some(WorkOption::Engrave), WorkOption::Draw) => "the pen draws: work is engrave",
                _ => continue,
            };
            if given(self) {
                return Err(OptionError::new(key, format!("{key} counts where {said}")));
            }
        }
        if self.levels.is_some() && !self.image.is_some_and(ImageStyle::has_levels) {
            let message = "levels needs image: halftone or hatch";
            return Err(OptionError::new("levels", message));
        }
        Ok(())
    }
}

/// What is text, such as a word of a few.
pub(super) mod text {
    use std::fmt::Display;
    use std::str::FromStr;

    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    #[expect(clippy::ref_option, reason = "serde gives a reference to the field")]
    pub(crate) fn serialize<T: Display, S: Serializer>(
        value: &Option<T>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let text = value.as_ref().map(ToString::to_string);
        text.serialize(serializer)
    }

    pub(crate) fn deserialize<'de, T: FromStr<Err = String>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<T>, D::Error> {
        let text = Option::<String>::deserialize(deserializer)?;
        text.map(|text| text.parse().map_err(de::Error::custom))
            .transpose()
    }
}

/// Full power as a number, or a range as text.
pub(super) mod power {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    use crate::Power;

    #[derive(Serialize, Deserialize)]
    #[serde(untagged, expecting = "expected percent, such as 80 or \"5..80\"")]
    enum Said {
        Most(f64),
        Range(String),
    }

    #[expect(clippy::ref_option, reason = "serde gives a reference to the field")]
    pub(crate) fn serialize<S: Serializer>(
        value: &Option<Power>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let said = value.map(|power| match power.range() {
            [0.0, most] => Said::Most(most),
            _ => Said::Range(power.to_string()),
        });
        said.serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<Power>, D::Error> {
        let said = Option::<Said>::deserialize(deserializer)?;
        let power = said.map(|said| match said {
            Said::Most(most) => Power::new(0.0, most),
            Said::Range(text) => text.parse(),
        });
        power.transpose().map_err(de::Error::custom)
    }
}

/// A tool by its name, or its bias as three numbers.
pub(super) mod tool {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    use crate::Tool;

    #[derive(Serialize, Deserialize)]
    #[serde(
        untagged,
        expecting = "expected none, suction, gripper, pen, laser, or three numbers in mm"
    )]
    enum Said {
        Bias([f32; 3]),
        Name(String),
    }

    #[expect(clippy::ref_option, reason = "serde gives a reference to the field")]
    pub(crate) fn serialize<S: Serializer>(
        value: &Option<Tool>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let said = value.map(|tool| match tool {
            Tool::Bias(bias) => Said::Bias(bias),
            named => Said::Name(named.to_string()),
        });
        said.serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<Tool>, D::Error> {
        let said = Option::<Said>::deserialize(deserializer)?;
        let tool = said.map(|said| match said {
            Said::Bias(bias) if bias.iter().all(|part| part.is_finite()) => Ok(Tool::Bias(bias)),
            Said::Bias(_) => Err("expected three finite numbers in mm".to_owned()),
            Said::Name(name) => name.parse(),
        });
        tool.transpose().map_err(de::Error::custom)
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
    fn what_is_wrong_has_the_name_of_its_option() {
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
    fn what_is_said_goes_before_what_lies_under_it() {
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
            "dialect": "servo", "grid": "2x3:40x30", "move": [1, 2, 3], "order": false,
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
