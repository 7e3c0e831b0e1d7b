//! A grid of squares that are burnt with many powers and speeds, to find those for a material.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// As many powers or speeds, at most.
const MOST: u32 = 50;
/// How powers and speeds are written that are rounded: no finer than this.
const FINEST: f64 = 1e-3;

/// Numbers from one to another in even steps: `10:100:5` is 10, 32.5, 55, 77.5, 100.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    first: f64,
    last: f64,
    count: u32,
}

impl Series {
    /// From one number to another in so many.
    ///
    /// # Errors
    /// What is no number above 0, and counts that are none.
    pub fn new(first: f64, last: f64, count: u32) -> Result<Self, String> {
        let good = |value: f64| value.is_finite() && value > 0.0;
        if !good(first) || !good(last) {
            return Err(format!("{first}:{last}: expected numbers above 0"));
        }
        if count == 0 || count > MOST {
            return Err(format!("{count} of them: expected 1 to {MOST}"));
        }
        if count == 1 && first != last {
            return Err(format!("{first} and {last} are two numbers, not 1"));
        }
        Ok(Self { first, last, count })
    }

    /// The numbers.
    ///
    /// ```
    /// use magician_formats::Series;
    ///
    /// let powers: Series = "10:100:5".parse()?;
    /// assert_eq!(powers.numbers(), [10.0, 32.5, 55.0, 77.5, 100.0]);
    /// # Ok::<(), String>(())
    /// ```
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        let gaps = f64::from(self.count.saturating_sub(1).max(1));
        let number = |nth: u32| match nth {
            0 => self.first,
            nth if nth + 1 == self.count => self.last,
            nth => {
                let exact = self.first + f64::from(nth) * (self.last - self.first) / gaps;
                (exact / FINEST).round() * FINEST
            }
        };
        (0..self.count).map(number).collect()
    }

    fn ends(&self) -> [f64; 2] {
        [self.first.min(self.last), self.first.max(self.last)]
    }
}

impl fmt::Display for Series {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.first, self.last, self.count)
    }
}

impl FromStr for Series {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("expected FROM:TO:COUNT, such as 10:100:5, not '{text}'");
        let mut parts = text.split(':').map(str::trim);
        let (Some(first), Some(last), Some(count), None) =
            (parts.next(), parts.next(), parts.next(), parts.next())
        else {
            return Err(wrong());
        };
        let number = |text: &str| text.parse::<f64>().map_err(|_| wrong());
        let count = count.parse().map_err(|_| wrong())?;
        Self::new(number(first)?, number(last)?, count)
    }
}

impl Serialize for Series {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Series {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(de::Error::custom)
    }
}

/// What a test grid is to have: a file of this format ([`Format::TestGrid`](crate::Format::TestGrid)) is this as JSON.
///
/// ```
/// use magician_formats::TestGridOptions;
///
/// let file = r#"{"format": "magician-testgrid", "power": "20:80:4", "cell": 6}"#;
/// let options: TestGridOptions = serde_json::from_str(file).unwrap();
/// assert_eq!(options.power.numbers(), [20.0, 40.0, 60.0, 80.0]);
/// assert_eq!(options.speed.numbers().len(), 5);
/// assert!(options.check().is_ok());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct TestGridOptions {
    /// What the file is known by.
    format: TestGridName,
    /// Powers of the columns, percent.
    pub power: Series,
    /// Speeds of the rows, mm/s.
    pub speed: Series,
    /// Side of a cell, mm.
    pub cell: f64,
    /// Distance between the lines of a cell, mm.
    pub spacing: f64,
    /// Whether each column and each row is labelled.
    pub labels: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum TestGridName {
    #[default]
    #[serde(rename = "magician-testgrid")]
    Name,
}

impl Default for TestGridOptions {
    fn default() -> Self {
        Self {
            format: TestGridName::Name,
            power: Series {
                first: 10.0,
                last: 100.0,
                count: 5,
            },
            speed: Series {
                first: 5.0,
                last: 40.0,
                count: 5,
            },
            cell: 8.0,
            spacing: 0.2,
            labels: true,
        }
    }
}

impl TestGridOptions {
    /// Finer lines are of no use to any arm, mm.
    pub const LEAST_SPACING: f64 = 0.02;
    /// Least and largest side of a cell, mm.
    pub const CELL: [f64; 2] = [1.0, 100.0];
    /// The highest speed, mm/s.
    pub const FASTEST: f64 = 500.0;

    /// Checks the values.
    ///
    /// # Errors
    /// The name of the first that is out of its range, and what is wrong with it.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let [_, strongest] = self.power.ends();
        if strongest > 100.0 {
            return Err((
                "power",
                format!("power is at most 100 percent, not {strongest}"),
            ));
        }
        let [_, fastest] = self.speed.ends();
        if fastest > Self::FASTEST {
            let most = Self::FASTEST;
            return Err((
                "speed",
                format!("speed is at most {most} mm/s, not {fastest}"),
            ));
        }
        let [least, most] = Self::CELL;
        if !(least..=most).contains(&self.cell) {
            return Err((
                "cell",
                format!("cell is {least} to {most} mm, not {}", self.cell),
            ));
        }
        if !(Self::LEAST_SPACING..=self.cell).contains(&self.spacing) {
            let message = format!(
                "spacing is {} mm to the side of a cell, not {}",
                Self::LEAST_SPACING,
                self.spacing
            );
            return Err(("spacing", message));
        }
        Ok(())
    }

    /// The weakest power: what labels are burnt with, percent.
    #[must_use]
    pub fn weakest(&self) -> f64 {
        self.power.ends()[0]
    }

    /// The highest speed: that of labels, mm/s.
    #[must_use]
    pub fn fastest(&self) -> f64 {
        self.speed.ends()[1]
    }

    /// As a file.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// A test grid as it is burnt, mm: x to the right, y down, from the upper left corner of all of it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TestGrid {
    /// What it is called.
    pub title: String,
    /// What it is to have.
    pub options: TestGridOptions,
    /// Width and height of all of it.
    pub size: [f64; 2],
    /// Where the upper left corner of the first cell is.
    pub corner: [f64; 2],
    /// The lines of the labels.
    pub labels: Vec<Vec<[f64; 2]>>,
}

/// One of its cells.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TestCell {
    /// Its upper left corner, mm.
    pub corner: [f64; 2],
    /// Percent.
    pub power: f64,
    /// mm/s.
    pub speed: f64,
}

impl TestGrid {
    /// From a cell to the next, in sides of a cell.
    pub(crate) const PITCH: f64 = 1.25;

    /// Its cells, row by row from the top.
    #[must_use]
    pub fn cells(&self) -> Vec<TestCell> {
        let pitch = Self::PITCH * self.options.cell;
        let powers = self.options.power.numbers();
        let rows = self.options.speed.numbers().into_iter().enumerate();
        let cell = |(row, speed): (usize, f64), (column, power): (usize, f64)| TestCell {
            corner: [
                self.corner[0] + column as f64 * pitch,
                self.corner[1] + row as f64 * pitch,
            ],
            power,
            speed,
        };
        rows.flat_map(|row| {
            powers
                .iter()
                .copied()
                .enumerate()
                .map(move |column| cell(row, column))
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_has_both_ends_and_even_steps() {
        let numbers = |text: &str| text.parse::<Series>().map(|series| series.numbers());
        assert_eq!(numbers("5:40:5"), Ok(vec![5.0, 13.75, 22.5, 31.25, 40.0]));
        assert_eq!(numbers("40:5:2"), Ok(vec![40.0, 5.0]));
        assert_eq!(numbers("20:20:1"), Ok(vec![20.0]));
        assert_eq!(numbers("10:20:4"), Ok(vec![10.0, 13.333, 16.667, 20.0]));
        for wrong in [
            "",
            "10",
            "10:100",
            "10:100:0",
            "10:100:51",
            "0:1:2",
            "-1:1:2",
            "1:2:1",
            "1:2:3:4",
            "a:b:c",
            "1:inf:2",
            "1:2:2.5",
        ] {
            assert!(numbers(wrong).is_err(), "{wrong}");
        }
    }
}
