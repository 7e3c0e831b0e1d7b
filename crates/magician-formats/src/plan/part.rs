use std::fmt;
use std::str::FromStr;

/// A colour whose red, green and blue are no less is as good as white.
const PALE: u8 = 230;

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
    /// True if it can hardly be seen on paper.
    #[must_use]
    pub fn is_pale(self) -> bool {
        self.0.iter().all(|channel| *channel >= PALE)
    }
}

impl fmt::Display for Color {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [red, green, blue] = self.0;
        write!(f, "#{red:02x}{green:02x}{blue:02x}")
    }
}

/// `#rgb`, `#rrggbb`, or a name of CSS.
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

/// The part of a plan that begins: what is drawn with one pen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// Its number, from 1.
    pub n: u64,
    /// Its layer, pen or tool, if that has a name.
    pub name: Option<String>,
    /// Its colour, if it has one.
    pub color: Option<Color>,
    /// Which pass over it this is, from 1, where there are several.
    pub pass: Option<u64>,
}

/// What a person calls it: `2, outline (#ff0000)`.
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

/// A place where a plan waits for a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pause {
    /// What the person is told.
    pub text: String,
    /// Why it pauses.
    pub cause: PauseCause,
}

/// Why a plan pauses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PauseCause {
    /// The next part begins, which may want another pen.
    Part,
    /// The program says so.
    Program,
}

impl PauseCause {
    /// All of them, by [`name`](Self::name).
    pub const ALL: [Self; 2] = [Self::Part, Self::Program];

    /// Its name in files and interfaces.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Part => "part",
            Self::Program => "program",
        }
    }
}
