//! Grid of rows and columns in its text form.

use std::fmt;
use std::str::FromStr;

use crate::Pallet;

/// Grid of rows and columns: `2x3:40x30` is 2 rows of 3, 40 mm between columns (x) and 30 mm
/// between rows (y).
///
/// ```
/// use magician_program::Grid;
///
/// let grid: Grid = "2x3:40x-30.5".parse()?;
/// assert_eq!((grid.rows, grid.columns, grid.pitch), (2, 3, [40.0, -30.5]));
/// assert_eq!(grid.to_string(), "2x3:40x-30.5");
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Grid {
    /// Number of rows; not 0.
    pub rows: usize,
    /// Number of columns; not 0.
    pub columns: usize,
    /// Distance between columns in x and between rows in y, mm.
    pub pitch: [f64; 2],
}

impl Grid {
    pub(crate) fn pallet(self) -> Pallet {
        Pallet::grid(self.rows, self.columns, self.pitch)
    }
}

impl FromStr for Grid {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = (|| {
            let (counts, pitch) = text.split_once(':')?;
            let (rows, columns) = counts.split_once('x')?;
            let (dx, dy) = pitch.split_once('x')?;
            let grid = Self {
                rows: rows.trim().parse().ok().filter(|count| *count > 0)?,
                columns: columns.trim().parse().ok().filter(|count| *count > 0)?,
                pitch: [dx.trim().parse().ok()?, dy.trim().parse().ok()?],
            };
            let finite = grid.pitch.iter().all(|pitch: &f64| pitch.is_finite());
            finite.then_some(grid)
        })();
        parsed.ok_or_else(|| "expected ROWSxCOLUMNS:DXxDY, such as 2x3:40x30".to_owned())
    }
}

impl fmt::Display for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [dx, dy] = self.pitch;
        write!(f, "{}x{}:{dx}x{dy}", self.rows, self.columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_are_rows_columns_and_pitch() {
        let grid = Grid {
            rows: 2,
            columns: 3,
            pitch: [40.0, -30.5],
        };
        assert_eq!("2x3:40x-30.5".parse(), Ok(grid));
        for wrong in ["", "2x3", "0x3:1x1", "2x3:1", "axb:1x1", "2x3:nanx1"] {
            assert!(wrong.parse::<Grid>().is_err(), "{wrong}");
        }
    }
}
