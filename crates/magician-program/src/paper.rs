//! Paper sizes by name or dimensions.

use std::fmt;
use std::str::FromStr;

/// Named sizes (ISO 216, and US Letter): width and height, mm.
const NAMED_SIZES: [(&str, [f64; 2]); 10] = [
    ("a3", [297.0, 420.0]),
    ("a3-landscape", [420.0, 297.0]),
    ("a4", [210.0, 297.0]),
    ("a4-landscape", [297.0, 210.0]),
    ("a5", [148.0, 210.0]),
    ("a5-landscape", [210.0, 148.0]),
    ("a6", [105.0, 148.0]),
    ("a6-landscape", [148.0, 105.0]),
    ("letter", [215.9, 279.4]),
    ("letter-landscape", [279.4, 215.9]),
];
/// Longest side, mm.
const MAX_SIDE: f64 = 10_000.0;

/// Paper size: `a4` is portrait, `a4-landscape` is landscape, `200x150` is 200 mm wide and 150 mm
/// high.
///
/// ```
/// use magician_program::Paper;
///
/// let paper: Paper = "a4-landscape".parse()?;
/// assert_eq!(paper.size(), [297.0, 210.0]);
/// assert_eq!("200x150.5".parse::<Paper>()?.size(), [200.0, 150.5]);
/// assert_eq!(paper.to_string(), "a4-landscape");
/// assert!("b7".parse::<Paper>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paper {
    size: [f64; 2],
}

impl Paper {
    /// Names of the named sizes.
    pub const NAMES: &'static [&'static str] = &{
        let mut names = [""; NAMED_SIZES.len()];
        let mut nth = 0;
        while nth < NAMED_SIZES.len() {
            names[nth] = NAMED_SIZES[nth].0;
            nth += 1;
        }
        names
    };

    /// Width and height, mm.
    #[must_use]
    pub fn size(self) -> [f64; 2] {
        self.size
    }
}

impl FromStr for Paper {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim().to_ascii_lowercase();
        let side = |text: &str| {
            let side = text.trim().parse().ok();
            side.filter(|side: &f64| *side > 0.0 && *side <= MAX_SIDE)
        };
        let sides = || {
            let (width, height) = text.split_once('x')?;
            Some([side(width)?, side(height)?])
        };
        let named = NAMED_SIZES.iter().find(|(name, _)| *name == text);
        let size = named.map(|(_, size)| *size).or_else(sides);
        size.map(|size| Self { size }).ok_or_else(|| {
            "expected a3, a4, a5, a6 or letter, each also with -landscape, or WIDTHxHEIGHT in mm, such as 200x150".to_owned()
        })
    }
}

impl fmt::Display for Paper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        match NAMED_SIZES.iter().find(|(_, size)| *size == self.size) {
            Some((name, _)) => f.write_str(name),
            None => write!(f, "{width}x{height}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_has_a_name_or_a_size() {
        for (text, size) in [
            ("a3", [297.0, 420.0]),
            ("A4", [210.0, 297.0]),
            ("a5-landscape", [210.0, 148.0]),
            ("letter", [215.9, 279.4]),
            ("Letter-Landscape", [279.4, 215.9]),
            ("200x150", [200.0, 150.0]),
            ("100.5 x 80", [100.5, 80.0]),
        ] {
            assert_eq!(text.parse::<Paper>().map(Paper::size), Ok(size), "{text}");
        }
        for wrong in [
            "",
            "a2",
            "b5",
            "x",
            "200",
            "200x",
            "0x100",
            "-20x30",
            "nanx10",
            "infx10",
            "10x1e9",
            "200x150-landscape",
            "200x150x2",
            "a4-portrait",
        ] {
            let error = wrong.parse::<Paper>().unwrap_err();
            assert!(error.contains("such as 200x150"), "{wrong}: {error}");
        }
    }

    #[test]
    fn paper_is_written_as_it_is_read() {
        for text in [
            "a3",
            "a4-landscape",
            "a6",
            "letter-landscape",
            "200x150",
            "0.5x20.25",
        ] {
            assert_eq!(text.parse::<Paper>().unwrap().to_string(), text);
        }
        // A named size prints its name.
        assert_eq!(
            "297x210".parse::<Paper>().unwrap().to_string(),
            "a4-landscape"
        );
    }
}
