//! Checks of values against the ranges of the command table, and the error that names the field.

use core::fmt;

use crate::{Field, Range};

/// Error of a field whose value is out of range; see [`Layout::check`](crate::Layout::check).
///
/// ```
/// use magician_protocol::commands::PtpCommonParams;
/// use magician_protocol::{Layout, Range};
///
/// let slow = PtpCommonParams { velocity_ratio: 0.001, acceleration_ratio: 50.0 };
/// let error = slow.check().unwrap_err();
/// assert_eq!((error.field, error.limit()), ("velocity_ratio", Some(1)));
/// assert_eq!(error.range, Range::Capped(1, 100));
/// assert_eq!(error.to_string(), "velocity_ratio 0.001 % is below the minimum of 1 %");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RangeError {
    /// Name of the field.
    pub field: &'static str,
    /// Index in an array or a list of outputs, from 0. `None` for a plain field.
    pub item: Option<usize>,
    /// Part of an output (`ratio`, `address`, `level`). `None` for other fields.
    pub part: Option<&'static str>,
    /// The value; for a text or list that is too long, its length.
    pub value: Number,
    /// Unit of the value, as in the command table.
    pub unit: &'static str,
    /// Range in force, given the other fields: for [`Range::By`], the matching case alone.
    /// [`Range::Any`] if the value is not a finite number.
    pub range: Range,
}

/// A number of a field, displayed as the caller wrote it.
///
/// Kept as `f32` because 0.001 widened to `f64` prints as 0.0010000000474974513.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// Value of an integer or enum field, or a length.
    Integer(i64),
    /// Value of a floating-point field.
    Float(f32),
}

impl Number {
    /// Converts to `f64`.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        match self {
            Self::Integer(number) => number as f64,
            Self::Float(number) => number.into(),
        }
    }

    const fn is_finite(self) -> bool {
        match self {
            Self::Integer(_) => true,
            Self::Float(number) => number.is_finite(),
        }
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(number) => number.fmt(f),
            Self::Float(number) => number.fmt(f),
        }
    }
}

impl RangeError {
    /// Bound that the value violates. `None` if the value is not a finite number.
    #[must_use]
    pub fn limit(&self) -> Option<i32> {
        self.range.violated_bound(self.value)
    }

    /// Adds the index of an item in an array or list.
    pub(crate) const fn with_item(mut self, item: usize) -> Self {
        self.item = Some(item);
        self
    }
}

impl Range {
    /// Bound that a number violates. `None` if it is in range.
    #[inline]
    fn violated_bound(&self, number: Number) -> Option<i32> {
        let number = number.to_f64();
        let below = |least: i32| (number < f64::from(least)).then_some(least);
        let above = |most: i32| (number > f64::from(most)).then_some(most);
        match *self {
            // The bounds of `Absolute` hold only in absolute modes; the planner checks them.
            Self::Any | Self::Absolute(..) => None,
            Self::Within(least, most) => below(least).or_else(|| above(most)),
            // The controller clamps larger values to the maximum, so they do no harm.
            Self::Capped(least, _) => below(least),
            Self::Above(limit) => (number <= f64::from(limit)).then_some(limit),
            Self::AtMost(count, _) => above(count.into()),
            Self::By(cases) => cases
                .iter()
                .find_map(|case| below(case.least).or_else(|| above(case.most))),
        }
    }
}

/// Checks a numeric field against `range`; NaN and infinities always fail.
#[inline]
pub(crate) fn check_number(
    value: Number,
    field: &'static Field,
    range: Range,
) -> Result<(), RangeError> {
    let range = if value.is_finite() { range } else { Range::Any };
    if value.is_finite() && range.violated_bound(value).is_none() {
        return Ok(());
    }
    Err(RangeError {
        field: field.name,
        item: None,
        part: None,
        value,
        unit: field.unit,
        range,
    })
}

/// Checks the length of a text or list. Ranges other than [`Range::AtMost`] do not limit it.
pub(crate) fn check_count(
    count: usize,
    field: &'static Field,
    range: Range,
) -> Result<(), RangeError> {
    let Range::AtMost(_, unit) = range else {
        return Ok(());
    };
    check_number(Number::Integer(count as i64), field, range)
        .map_err(|error| RangeError { unit, ..error })
}

impl fmt::Display for RangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, range, unit) = (self.value, self.range, Unit(self.unit));
        f.write_str(self.field)?;
        if let Some(item) = self.item {
            write!(f, "[{item}]")?;
        }
        if let Some(part) = self.part {
            write!(f, ".{part}")?;
        }
        match range {
            Range::Any => write!(f, " is {value}, not a finite number"),
            Range::AtMost(most, of) => write!(f, " has {value} {of}, limit {most}"),
            Range::Above(limit) => write!(f, " {value}{unit} must be above {limit}{unit}"),
            Range::Capped(least, _) => {
                write!(f, " {value}{unit} is below the minimum of {least}{unit}")
            }
            // Each case has its own unit and prints it.
            Range::By(_) => write!(f, " {value} is out of range: {range}"),
            Range::Within(..) | Range::Absolute(..) => {
                write!(f, " {value}{unit} is out of range: {range}{unit}")
            }
        }
    }
}

impl core::error::Error for RangeError {}

/// Unit printed after a number; empty if the table's unit is a description or depends on the mode.
struct Unit(&'static str);

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            "percent" => f.write_str(" %"),
            "mm" | "deg" | "mm/s" | "deg/s" | "mm/s^2" | "deg/s^2" | "Hz" | "turns" => {
                write!(f, " {}", self.0)
            }
            // "flag", "code", "pulses (unconfirmed)" and the like: text that would not read as a
            // unit.
            _ => Ok(()),
        }
    }
}
