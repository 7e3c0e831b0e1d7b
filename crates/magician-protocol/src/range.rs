//! Ranges of fields as data, for checks, help, documentation and JSON schemas.

use core::fmt;

/// Accepted values of a field.
///
/// ```
/// use magician_protocol::commands::{PtpCommonParams, TrigCmd};
/// use magician_protocol::{Layout, Range};
///
/// let field = &PtpCommonParams::INFO.fields[0];
/// assert_eq!((field.name, field.range), ("velocity_ratio", Range::Capped(1, 100)));
/// assert_eq!(field.range.to_string(), "1 to 100, larger values clamped to 100");
/// let threshold = &TrigCmd::INFO.fields[3];
/// assert_eq!(threshold.range.to_string(), "0 or 1 in level mode, 0 to 4095 counts in analog mode");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Range {
    /// Every value of the type.
    Any,
    /// From the first to the second, both included.
    Within(i32, i32),
    /// Greater than this.
    Above(i32),
    /// From the first to the second; the arm clamps larger values to the second.
    Capped(i32, i32),
    /// From the first to the second in absolute modes. In relative modes, start and end of the
    /// displacement must be in range.
    Absolute(i32, i32),
    /// At most this many (bytes of a text, elements of a list).
    AtMost(u8, &'static str),
    /// Depends on another field.
    By(&'static [Case]),
}

/// Range of a field for one value of another field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// Name of the other field.
    pub field: &'static str,
    /// Value of the other field.
    pub is: u8,
    /// Name of that value's mode.
    pub name: &'static str,
    /// Inclusive lower bound.
    pub least: i32,
    /// Inclusive upper bound.
    pub most: i32,
    /// Unit of both bounds; empty if they have none.
    pub unit: &'static str,
}

/// Bounds of a number, as far as they do not depend on other fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounds {
    /// Inclusive lower bound.
    pub minimum: Option<i32>,
    /// Exclusive lower bound.
    pub exclusive_minimum: Option<i32>,
    /// Inclusive upper bound. `None` for [`Range::Capped`], as the arm clamps larger values.
    pub maximum: Option<i32>,
}

impl Range {
    /// Returns the bounds as in a JSON schema: the widest ones for [`Range::By`], and none for
    /// texts and lists ([`Range::AtMost`]) or rail positions ([`Range::Absolute`]).
    ///
    /// ```
    /// use magician_protocol::Range;
    ///
    /// let bounds = Range::Capped(1, 100).bounds();
    /// assert_eq!((bounds.minimum, bounds.maximum), (Some(1), None));
    /// assert_eq!(Range::Above(0).bounds().exclusive_minimum, Some(0));
    /// ```
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let none = Bounds::default();
        match *self {
            // `AtMost` limits a count, and a displacement of a relative mode may be outside of an
            // absolute range.
            Self::Any | Self::AtMost(..) | Self::Absolute(..) => none,
            Self::Within(least, most) => Bounds {
                minimum: Some(least),
                maximum: Some(most),
                ..none
            },
            Self::Above(limit) => Bounds {
                exclusive_minimum: Some(limit),
                ..none
            },
            Self::Capped(least, _) => Bounds {
                minimum: Some(least),
                ..none
            },
            Self::By(cases) => Bounds {
                minimum: cases.iter().map(|case| case.least).min(),
                maximum: cases.iter().map(|case| case.most).max(),
                ..none
            },
        }
    }

    /// True if the range accepts every value of the type.
    #[must_use]
    pub fn is_any(&self) -> bool {
        *self == Self::Any
    }
}

/// Formats the range in words; empty for [`Range::Any`].
impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => Ok(()),
            Self::Within(least, most) => fmt_interval(f, *least, *most),
            Self::Above(limit) => write!(f, "above {limit}"),
            Self::Absolute(least, most) => {
                fmt_interval(f, *least, *most)?;
                f.write_str(" in absolute modes")
            }
            Self::Capped(least, most) => {
                fmt_interval(f, *least, *most)?;
                write!(f, ", larger values clamped to {most}")
            }
            Self::AtMost(count, of) => write!(f, "at most {count} {of}"),
            Self::By(cases) => {
                for (at, case) in cases.iter().enumerate() {
                    f.write_str(if at == 0 { "" } else { ", " })?;
                    fmt_interval(f, case.least, case.most)?;
                    let space = if case.unit.is_empty() { "" } else { " " };
                    write!(f, "{space}{} in {}", case.unit, case.name)?;
                }
                Ok(())
            }
        }
    }
}

fn fmt_interval(f: &mut fmt::Formatter<'_>, least: i32, most: i32) -> fmt::Result {
    match most.wrapping_sub(least) {
        0 => write!(f, "{least}"),
        1 => write!(f, "{least} or {most}"),
        _ => write!(f, "{least} to {most}"),
    }
}
