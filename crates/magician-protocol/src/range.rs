use core::fmt;

/// What values a field may have.
///
/// ```
/// use magician_protocol::commands::{PtpCommonParams, TrigCmd};
/// use magician_protocol::{Layout, Range};
///
/// let field = &PtpCommonParams::INFO.fields[0];
/// assert_eq!((field.name, field.range), ("velocity_ratio", Range::Capped(1, 100)));
/// assert_eq!(field.range.to_string(), "1 to 100, more counts as 100");
/// let threshold = &TrigCmd::INFO.fields[3];
/// assert_eq!(threshold.range.to_string(), "0 or 1 in level mode, 0 to 4095 counts in analog mode");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Range {
    /// Every value of its type.
    Any,
    /// From the first to the second.
    Within(i32, i32),
    /// Larger than this.
    Above(i32),
    /// From the first to the second; the arm takes larger ones for the second.
    Capped(i32, i32),
    /// From the first to the second where the command's mode is absolute; where it is a way, both ends of it count.
    Absolute(i32, i32),
    /// At most so many of these (bytes of a text, elements of a list).
    AtMost(u8, &'static str),
    /// What another field says.
    By(&'static [Case]),
}

/// What values a field may have when another one has a certain value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// The other field.
    pub field: &'static str,
    /// Its value.
    pub is: u8,
    /// Name of the mode that this is.
    pub name: &'static str,
    /// The least.
    pub least: i32,
    /// The most.
    pub most: i32,
    /// Unit of the two; empty if there is none.
    pub unit: &'static str,
}

/// The least and the most of a number, as far as they do not depend on other fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounds {
    /// It is this or more.
    pub minimum: Option<i32>,
    /// It is more than this.
    pub exclusive_minimum: Option<i32>,
    /// It is this or less. A range that is capped has none: the arm takes more for the most.
    pub maximum: Option<i32>,
}

impl Range {
    /// The bounds of a number, as a JSON schema has them; of what depends on another field the widest, none of anything else.
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

    /// Whether every value will do.
    #[must_use]
    pub fn is_any(&self) -> bool {
        *self == Self::Any
    }
}

/// In words; empty for every value of the type.
impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => Ok(()),
            Self::Within(least, most) => span(f, *least, *most),
            Self::Above(limit) => write!(f, "above {limit}"),
            Self::Absolute(least, most) => {
                span(f, *least, *most)?;
                f.write_str(" in absolute modes")
            }
            Self::Capped(least, most) => {
                span(f, *least, *most)?;
                write!(f, ", more counts as {most}")
            }
            Self::AtMost(count, of) => write!(f, "at most {count} {of}"),
            Self::By(cases) => {
                for (at, case) in cases.iter().enumerate() {
                    f.write_str(if at == 0 { "" } else { ", " })?;
                    span(f, case.least, case.most)?;
                    let space = if case.unit.is_empty() { "" } else { " " };
                    write!(f, "{space}{} in {}", case.unit, case.name)?;
                }
                Ok(())
            }
        }
    }
}

fn span(f: &mut fmt::Formatter<'_>, least: i32, most: i32) -> fmt::Result {
    match most.wrapping_sub(least) {
        0 => write!(f, "{least}"),
        1 => write!(f, "{least} or {most}"),
        _ => write!(f, "{least} to {most}"),
    }
}
