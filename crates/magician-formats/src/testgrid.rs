//! Test grids: squares burnt with many powers and speeds, to find the right pair for a material.

use std::fmt;
use std::str::FromStr;

use magician_host::{Message, message};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// Largest number of powers or speeds.
const MAX_VALUES: u32 = 50;
/// Step to which the powers and speeds between both ends are rounded, so that labels stay short.
const VALUE_STEP: f64 = 1e-3;

/// Evenly spaced numbers: `10:100:5` is 10, 32.5, 55, 77.5, 100.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    first: f64,
    last: f64,
    count: u32,
}

impl Series {
    /// Creates a series of `count` numbers from `first` to `last`.
    ///
    /// # Errors
    /// A sentence about the fault if a number is not finite and positive, the count is outside 1 to
    /// 50, or the count is 1 for two different numbers.
    pub fn new(first: f64, last: f64, count: u32) -> Result<Self, String> {
        let good = |value: f64| value.is_finite() && value > 0.0;
        if !good(first) || !good(last) {
            return Err(format!("{first}:{last}: expected numbers above 0"));
        }
        if count == 0 || count > MAX_VALUES {
            return Err(format!("{count} of them: expected 1 to {MAX_VALUES}"));
        }
        if count == 1 && first != last {
            return Err(format!("{first} and {last} are two numbers, not 1"));
        }
        Ok(Self { first, last, count })
    }

    /// Returns the numbers.
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
                (exact / VALUE_STEP).round() * VALUE_STEP
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

/// Options of a test grid. A file of the format [`TestGrid`](crate::Format::TestGrid) is this as
/// JSON.
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
    /// Marks the file as a test grid.
    format: TestGridName,
    /// Powers of the columns, percent.
    pub power: Series,
    /// Speeds of the rows, mm/s.
    pub speed: Series,
    /// Side of a cell, mm.
    pub cell: f64,
    /// Distance between the lines of a cell, mm.
    pub spacing: f64,
    /// True if columns and rows are labelled.
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
    /// Smallest distance between lines, mm. The arm cannot resolve finer lines.
    pub const MIN_SPACING: f64 = 0.02;
    /// Smallest and largest side of a cell, mm.
    pub const CELL_RANGE: [f64; 2] = [1.0, 100.0];
    /// Highest speed, mm/s.
    pub const MAX_SPEED: f64 = 500.0;

    /// Checks the values.
    ///
    /// # Errors
    /// Name of the first field that is out of range, and a sentence about the fault.
    pub fn check(&self) -> Result<(), (&'static str, Message)> {
        let [_, strongest] = self.power.ends();
        if strongest > 100.0 {
            return Err((
                "power",
                message!("power is at most 100 percent, not {strongest}", strongest),
            ));
        }
        let [_, fastest] = self.speed.ends();
        if fastest > Self::MAX_SPEED {
            let most = Self::MAX_SPEED;
            return Err((
                "speed",
                message!("speed is at most {most} mm/s, not {fastest}", most, fastest),
            ));
        }
        let [least, most] = Self::CELL_RANGE;
        if !(least..=most).contains(&self.cell) {
            return Err((
                "cell",
                message!(
                    "cell is {least} to {most} mm, not {cell}",
                    least,
                    most,
                    cell = self.cell
                ),
            ));
        }
        if !(Self::MIN_SPACING..=self.cell).contains(&self.spacing) {
            let message = message!(
                "spacing is {least} mm to the side of a cell, not {spacing}",
                least = Self::MIN_SPACING,
                spacing = self.spacing
            );
            return Err(("spacing", message));
        }
        Ok(())
    }

    /// Lowest power, with which the labels are burnt, percent.
    #[must_use]
    pub fn weakest(&self) -> f64 {
        self.power.ends()[0]
    }

    /// Highest speed, at which the labels are burnt, mm/s.
    #[must_use]
    pub fn fastest(&self) -> f64 {
        self.speed.ends()[1]
    }

    /// Serialises the options as a file.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// A test grid in mm: x to the right, y down, from its upper left corner.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TestGrid {
    /// Title.
    pub title: String,
    /// Options it was made from.
    pub options: TestGridOptions,
    /// Width and height including the labels.
    pub size: [f64; 2],
    /// Upper left corner of the first cell.
    pub corner: [f64; 2],
    /// Polylines of the labels.
    pub labels: Vec<Vec<[f64; 2]>>,
}

/// A cell of a test grid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TestCell {
    /// Upper left corner, mm.
    pub corner: [f64; 2],
    /// Power, percent.
    pub power: f64,
    /// Speed, mm/s.
    pub speed: f64,
}

impl TestGrid {
    /// Distance from one cell to the next, in sides of a cell.
    pub(crate) const PITCH: f64 = 1.25;

    /// Returns the cells row by row from the top.
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
    fn series_has_both_ends_and_even_steps() {
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
