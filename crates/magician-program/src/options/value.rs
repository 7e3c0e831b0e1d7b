//! Values of options, and their forms in JSON.

use magician_host::{Message, message};
use serde_json::{Value, json};

use super::{Grid, ModeOption, PenOptions, WorkOption};
use crate::fill::FillMode;
use crate::formats::Dialect;
use crate::lettering::{Align, FontChoice};
use crate::raster::ImageStyle;
use crate::{Depths, FrameShape, Paper, PartMode, Power, SystemFonts, TextLines, Tool, White};

/// Largest number of characters of a text.
const MAX_TEXT_LENGTH: usize = 1000;

/// Type of an option's value.
///
/// Messages about wrong values come from the row of the option. A type returns its own message only
/// for composite values, such as lists.
pub(super) trait OptionValue: Sized {
    /// Parses a JSON value.
    ///
    /// # Errors
    /// The mistake; `None` if the row's description is enough.
    fn from_json(value: &Value) -> Result<Self, Option<Message>>;

    /// Returns the value as JSON.
    fn to_json(&self) -> Value;
}

/// Member of [`SetupOptions`](super::SetupOptions), which may be unset.
pub(super) trait OptionMember: Sized {
    /// Parses a JSON value.
    ///
    /// # Errors
    /// Same as [`OptionValue::from_json`].
    fn read(value: &Value) -> Result<Self, Option<Message>>;

    /// Returns the value as JSON; `None` if it is unset.
    fn to_json_if_set(&self) -> Option<Value>;

    /// True if it is unset.
    fn is_unset(&self) -> bool;
}

impl<T: OptionValue> OptionMember for Option<T> {
    fn read(value: &Value) -> Result<Self, Option<Message>> {
        T::from_json(value).map(Some)
    }

    fn to_json_if_set(&self) -> Option<Value> {
        self.as_ref().map(T::to_json)
    }

    fn is_unset(&self) -> bool {
        self.is_none()
    }
}

/// A switch is off if it is unset.
impl OptionMember for bool {
    fn read(value: &Value) -> Result<Self, Option<Message>> {
        value.as_bool().ok_or(None)
    }

    fn to_json_if_set(&self) -> Option<Value> {
        self.then_some(Value::Bool(true))
    }

    fn is_unset(&self) -> bool {
        !self
    }
}

impl<T: OptionValue> OptionMember for Vec<T>
where
    Self: ListItems,
{
    fn read(value: &Value) -> Result<Self, Option<Message>> {
        let items = value.as_array().ok_or(None)?;
        let read = (1..).zip(items).map(|(n, item)| {
            T::from_json(item).map_err(|why| {
                why.map(|why| {
                    let item = Self::ITEM;
                    message!("{item} {n}: {why}", item, n, why)
                })
            })
        });
        read.collect()
    }

    fn to_json_if_set(&self) -> Option<Value> {
        let items = || self.iter().map(T::to_json).collect();
        (!self.is_empty()).then(|| Value::Array(items()))
    }

    fn is_unset(&self) -> bool {
        self.is_empty()
    }
}

/// List whose items have a name in messages.
pub(super) trait ListItems {
    /// Name of an item.
    const ITEM: &'static str;
}

impl ListItems for Vec<String> {
    const ITEM: &'static str = "text";
}

impl ListItems for Vec<PenOptions> {
    const ITEM: &'static str = "pen";
}

impl OptionValue for f64 {
    fn from_json(value: &Value) -> Result<Self, Option<Message>> {
        value.as_f64().ok_or(None)
    }

    fn to_json(&self) -> Value {
        // NaN becomes null here; the range check works on JSON and refuses null.
        Value::from(*self)
    }
}

impl OptionValue for bool {
    fn from_json(value: &Value) -> Result<Self, Option<Message>> {
        value.as_bool().ok_or(None)
    }

    fn to_json(&self) -> Value {
        Value::Bool(*self)
    }
}

impl OptionValue for String {
    fn from_json(value: &Value) -> Result<Self, Option<Message>> {
        let text = value.as_str().ok_or(None)?;
        match text.chars().nth(MAX_TEXT_LENGTH) {
            Some(_) => Err(None),
            None => Ok(text.to_owned()),
        }
    }

    fn to_json(&self) -> Value {
        Value::from(self.as_str())
    }
}

impl OptionValue for PenOptions {
    fn from_json(value: &Value) -> Result<Self, Option<Message>> {
        let pen: Self = serde_json::from_value(value.clone())
            .map_err(|error| Message::from(error.to_string()))?;
        match pen.problem() {
            Some(problem) => Err(Some(problem)),
            None => Ok(pen),
        }
    }

    fn to_json(&self) -> Value {
        json!(self)
    }
}

/// Implements whole numbers.
macro_rules! whole {
    ($($type:ty),*) => {$(
        impl OptionValue for $type {
            fn from_json(value: &Value) -> Result<Self, Option<Message>> {
                let number = value.as_u64().and_then(|number| number.try_into().ok());
                number.ok_or(None)
            }

            fn to_json(&self) -> Value {
                Value::from(*self)
            }
        }
    )*};
}

whole!(u8, u32);

/// Implements arrays of numbers.
macro_rules! numbers {
    ($($count:literal),*) => {$(
        impl OptionValue for [f64; $count] {
            fn from_json(value: &Value) -> Result<Self, Option<Message>> {
                let items = value.as_array().ok_or(None)?;
                let numbers: Option<Vec<f64>> = items.iter().map(Value::as_f64).collect();
                numbers.and_then(|numbers| numbers.try_into().ok()).ok_or(None)
            }

            fn to_json(&self) -> Value {
                json!(self)
            }
        }
    )*};
}

numbers!(2, 3);

/// Rectangle of pixels, which must not be empty.
impl OptionValue for [u32; 4] {
    fn from_json(value: &Value) -> Result<Self, Option<Message>> {
        let items = value.as_array().ok_or(None)?;
        let items: Result<Vec<u32>, _> = items.iter().map(u32::from_json).collect();
        let area = <[u32; 4]>::try_from(items?).map_err(|_| None)?;
        let [_, _, width, height] = area;
        if width == 0 || height == 0 {
            return Err(None);
        }
        Ok(area)
    }

    fn to_json(&self) -> Value {
        json!(self)
    }
}

/// Implements types whose JSON form is their text.
macro_rules! texts {
    ($($type:ty),* $(,)?) => {$(
        impl OptionValue for $type {
            fn from_json(value: &Value) -> Result<Self, Option<Message>> {
                let text = value.as_str().ok_or(None)?;
                text.parse().map_err(|_| None)
            }

            fn to_json(&self) -> Value {
                Value::from(self.to_string())
            }
        }
    )*};
}

texts!(
    Align,
    Depths,
    Dialect,
    FillMode,
    FontChoice,
    FrameShape,
    Grid,
    ImageStyle,
    ModeOption,
    Paper,
    PartMode,
    SystemFonts,
    TextLines,
    White,
);

impl OptionValue for WorkOption {
    fn from_json(value: &Value) -> Result<Self, Option<Message>> {
        match value.as_str() {
            Some("draw") => Ok(Self::Draw),
            Some("engrave") => Ok(Self::Engrave),
            _ => Err(None),
        }
    }

    fn to_json(&self) -> Value {
        match self {
            Self::Draw => "draw".into(),
            Self::Engrave => "engrave".into(),
            // No front end accepts this value: it is set internally.
            Self::ByFile => Value::Null,
        }
    }
}

/// Full power as a number, or a range as text.
impl OptionValue for Power {
    fn from_json(value: &Value) -> Result<Self, Option<Message>> {
        let power = match (value.as_f64(), value.as_str()) {
            (Some(most), _) => Self::new(0.0, most).ok(),
            (None, Some(text)) => text.parse().ok(),
            (None, None) => None,
        };
        power
            .filter(|power: &Self| power.range()[1] > 0.0)
            .ok_or(None)
    }

    fn to_json(&self) -> Value {
        match self.range() {
            [0.0, most] => Value::from(most),
            _ => Value::from(self.to_string()),
        }
    }
}

/// Tool by its name, or a bias as three numbers.
impl OptionValue for Tool {
    fn from_json(value: &Value) -> Result<Self, Option<Message>> {
        if let Some(name) = value.as_str() {
            return name.parse().map_err(|_| None);
        }
        let bias = <[f64; 3]>::from_json(value)?.map(|part| part as f32);
        if bias.iter().all(|part| part.is_finite()) {
            Ok(Self::Bias(bias))
        } else {
            Err(None)
        }
    }

    fn to_json(&self) -> Value {
        match self {
            Self::Bias(bias) => json!(bias),
            named => Value::from(named.to_string()),
        }
    }
}
