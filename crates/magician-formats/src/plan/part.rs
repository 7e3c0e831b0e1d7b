//! Parts of a plan, their colours, and pauses.

use std::fmt;
use std::str::FromStr;

/// Smallest channel value of a pale colour, 0 to 255. A choice: brighter lines are hardly visible
/// on white paper.
const MIN_PALE_CHANNEL: u8 = 230;

/// A colour of a drawing.
///
/// ```
/// use magician_formats::Color;
///
/// let red: Color = "red".parse()?;
/// assert_eq!((red, red.to_string()), ("#f00".parse()?, "#ff0000".to_owned()));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Color(
    /// Red, green, blue.
    pub [u8; 3],
);

impl Color {
    /// True if the colour is hardly visible on white paper.
    #[must_use]
    pub fn is_pale(self) -> bool {
        self.0.iter().all(|channel| *channel >= MIN_PALE_CHANNEL)
    }
}

impl fmt::Display for Color {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [red, green, blue] = self.0;
        write!(f, "#{red:02x}{green:02x}{blue:02x}")
    }
}

/// Parses `#rgb`, `#rrggbb`, or a CSS colour name.
impl FromStr for Color {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match svgtypes::Color::from_str(text.trim()) {
            Ok(color) => Ok(Self([color.red, color.green, color.blue])),
            Err(_) => Err(format!(
                "'{text}' is not a colour: expected #rrggbb or a name of CSS"
            )),
        }
    }
}

/// Start of a part of a plan: everything drawn with one pen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// Number, from 1.
    pub n: u64,
    /// Name of the layer, pen or tool, if it has one.
    pub name: Option<String>,
    /// Colour, if it has one.
    pub color: Option<Color>,
    /// Pass over the part, from 1; `None` if there is only one.
    pub pass: Option<u64>,
}

/// Prints number, name and colour: `2, outline (#ff0000)`.
impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.n)?;
        match (&self.name, self.color) {
            (Some(name), Some(color)) => write!(f, ", {name} ({color})"),
            (Some(name), None) => write!(f, ", {name}"),
            (None, Some(color)) => write!(f, ", {color}"),
            (None, None) => Ok(()),
        }
    }
}

/// A point where a plan waits for a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pause {
    /// Message for the person.
    pub text: String,
    /// Cause.
    pub cause: PauseCause,
}

/// Cause of a pause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PauseCause {
    /// The next part begins, which may need another pen.
    Part,
    /// The program contains a pause.
    Program,
}

impl PauseCause {
    /// All causes.
    pub const ALL: [Self; 2] = [Self::Part, Self::Program];

    /// Name in files and interfaces.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Part => "part",
            Self::Program => "program",
        }
    }
}
