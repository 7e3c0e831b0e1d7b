//! Laser power as users give it: one percentage, or a range.

use std::fmt;
use std::str::FromStr;

/// Range of laser power, percent: the power of the darkest and of the lightest marks.
///
/// A file's own power (0 to 100 %) is mapped into the range. 0 % stays off.
///
/// ```
/// use magician_formats::Power;
///
/// let power: Power = "60".parse()?;
/// assert_eq!((power.of(50.0), power.of(0.0)), (30.0, 0.0));
/// let power: Power = "10..60".parse()?;
/// assert_eq!((power.of(100.0), power.of(50.0), power.of(0.0)), (60.0, 35.0, 0.0));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power {
    least: f64,
    most: f64,
}

impl Power {
    /// Full range, 0 to 100 %.
    pub const FULL: Self = Self {
        least: 0.0,
        most: 100.0,
    };

    /// Creates a range from two percentages, the first not above the second.
    ///
    /// # Errors
    /// A sentence about the fault if a bound is outside 0 to 100 %, not a number, or the bounds are
    /// swapped.
    pub fn new(least: f64, most: f64) -> Result<Self, String> {
        if 0.0 <= least && least <= most && most <= 100.0 {
            Ok(Self { least, most })
        } else {
            Err(format!(
                "power is percent from 0 to 100, the least before the most, not {least} and {most}"
            ))
        }
    }

    /// Lower and upper bound, percent.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        [self.least, self.most]
    }

    /// Maps a power of the file into the range, percent. 0 stays 0.
    #[must_use]
    pub fn of(&self, percent: f64) -> f64 {
        if percent > 0.0 {
            self.least + (self.most - self.least) * percent / 100.0
        } else {
            0.0
        }
    }
}

/// Prints `P` or `LEAST..MOST`.
impl fmt::Display for Power {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { least, most } = self;
        if *least > 0.0 {
            write!(f, "{least}..{most}")
        } else {
            write!(f, "{most}")
        }
    }
}

impl FromStr for Power {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().trim_end_matches('%').trim_end().parse().ok();
        let range = match text.split_once("..") {
            Some((least, most)) => number(least).zip(number(most)),
            None => number(text).map(|most| (0.0, most)),
        };
        let power = range.and_then(|(least, most)| Self::new(least, most).ok());
        power.ok_or_else(|| "expected percent from 0 to 100, such as 80 or 5..80".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_is_one_number_or_a_range() {
        for (text, range) in [
            ("80", [0.0, 80.0]),
            ("5..70%", [5.0, 70.0]),
            (" 5 % .. 70 % ", [5.0, 70.0]),
            ("0", [0.0, 0.0]),
        ] {
            let power: Power = text.parse().expect(text);
            assert_eq!(power.range(), range, "{text}");
            assert_eq!(power.to_string().parse(), Ok(power));
        }
        for wrong in [
            "", "101", "70..5", "a..b", "-5..20", "nan", "nan..80", "5..", "inf",
        ] {
            assert!(wrong.parse::<Power>().is_err(), "{wrong}");
        }
    }
}
