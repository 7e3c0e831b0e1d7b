//! Repeating a plan at each position of a pallet.

use super::Plan;
use crate::Diagnostic;
use crate::plan::transform::finite;
use magician_host::message;

/// Positions in rows and columns. The plan as it stands is for the first; the others follow row by
/// row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pallet {
    rows: usize,
    columns: usize,
    /// Distance to the next position in a row, and to the next row, mm.
    steps: [[f64; 3]; 2],
}

impl Pallet {
    /// Creates a grid along the arm's axes, columns in x and rows in y, with these distances, mm.
    #[must_use]
    pub fn grid(rows: usize, columns: usize, [x, y]: [f64; 2]) -> Self {
        Self {
            rows,
            columns,
            steps: [[x, 0.0, 0.0], [0.0, y, 0.0]],
        }
    }

    /// Creates a pallet in any orientation from three of its positions (x, y, z; mm), as in the
    /// vendor's software: the first, the last of its row, and the first of the last row.
    ///
    /// The others are spaced evenly between them.
    #[must_use]
    pub fn corners(
        rows: usize,
        columns: usize,
        [first, end_of_row, last_row]: [[f64; 3]; 3],
    ) -> Self {
        let step = |to: [f64; 3], count: usize| {
            // A single row or column has no distance to the next.
            let gaps = count.saturating_sub(1).max(1) as f64;
            let [x, y, z] = to;
            let [a, b, c] = first;
            match count {
                0 | 1 => [0.0; 3],
                _ => [x - a, y - b, z - c].map(|way| way / gaps),
            }
        };
        Self {
            rows,
            columns,
            steps: [step(end_of_row, columns), step(last_row, rows)],
        }
    }

    /// Number of positions, or `None` if it overflows.
    #[must_use]
    pub fn places(&self) -> Option<usize> {
        self.rows.checked_mul(self.columns)
    }

    /// Offset from the first position to another, counted from 0, mm.
    #[must_use]
    pub fn offset_of(&self, place: usize) -> [f64; 3] {
        let columns = self.columns.max(1);
        let (row, column) = ((place / columns) as f64, (place % columns) as f64);
        let [[a, b, c], [d, e, f]] = self.steps;
        [
            column * a + row * d,
            column * b + row * e,
            column * c + row * f,
        ]
    }
}

impl Plan {
    /// Repeats the plan at each position of a pallet. If its surface is tilted, the offsets follow
    /// it.
    ///
    /// ```
    /// use magician_formats::{Action, Origin, Pallet, Plan, Travel};
    ///
    /// let mut plan = Plan::new("drop");
    /// plan.push(Action::Move { to: [200.0, 0.0, -20.0, 0.0], by: Travel::Jump }, Origin::NONE);
    /// plan.push(Action::Suction(false), Origin::NONE);
    ///
    /// let all = plan.placed_on(&Pallet::grid(2, 3, [25.0, 30.0]))?;
    /// assert_eq!(all.steps.len(), 12);
    /// assert_eq!(all.steps[10].action.target(), Some([250.0, 30.0, -20.0]));
    /// # Ok::<(), magician_formats::Diagnostic>(())
    /// ```
    ///
    /// # Errors
    /// Same as [`moved`](Self::moved), and a [`Diagnostic`] if the pallet has no positions or too
    /// many.
    pub fn placed_on(&self, pallet: &Pallet) -> Result<Self, Diagnostic> {
        let Pallet {
            rows,
            columns,
            steps,
        } = pallet;
        finite(steps.as_flattened(), || message!("a corner of the pallet"))?;
        let places = pallet
            .places()
            .and_then(|places| u32::try_from(places).ok());
        match places {
            Some(places) if places > 0 => {
                let slope = self.surface.map_or([0.0; 2], |surface| surface.slope);
                let way = |place: u32| {
                    let [x, y, z] = pallet.offset_of(place as usize);
                    [x, y, z + slope[0] * x + slope[1] * y]
                };
                self.repeated_at(places as usize, (0..places).map(way))
            }
            Some(_) => Err(Diagnostic::of_file(message!(
                "a pallet of {rows} rows and {columns} columns has no positions",
                rows,
                columns
            ))),
            None => Err(Diagnostic::of_file(message!(
                "a pallet of {rows} rows and {columns} columns has too many positions",
                rows,
                columns
            ))),
        }
    }
}
