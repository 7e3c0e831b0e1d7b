//! The same program at each place of a pallet.

use super::Plan;
use crate::Diagnostic;
use crate::plan::transform::finite;
use magician_host::message;

/// Places in rows and columns. The first is where a program is as it stands; the others follow row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pallet {
    rows: usize,
    columns: usize,
    /// From a place to the next in its row, and from a row to the next, mm.
    steps: [[f64; 3]; 2],
}

impl Pallet {
    /// A grid along the arm's axes: columns in x, rows in y, so far apart, mm.
    #[must_use]
    pub fn grid(rows: usize, columns: usize, [x, y]: [f64; 2]) -> Self {
        Self {
            rows,
            columns,
            steps: [[x, 0.0, 0.0], [0.0, y, 0.0]],
        }
    }

    /// A pallet as it stands, by three of its places (x, y, z; mm) as the vendor's software has it: the first, the last of
    /// its row, and the first of the last row. The others are in between, in even distances, on any slope.
    #[must_use]
    pub fn corners(
        rows: usize,
        columns: usize,
        [first, end_of_row, last_row]: [[f64; 3]; 3],
    ) -> Self {
        let step = |to: [f64; 3], count: usize| {
            // A single one has no next.
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

    /// How many positions it has; `None` if they are too many to count.
    #[must_use]
    pub fn places(&self) -> Option<usize> {
        self.rows.checked_mul(self.columns)
    }

    /// The way from the first place to another, by its number from 0, mm.
    #[must_use]
    pub fn way_to(&self, place: usize) -> [f64; 3] {
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
    /// The plan at each place of a pallet, one after the other. As it stands it is for the first. One whose surface is
    /// tilted follows it from place to place.
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
    /// As [`moved`](Self::moved), and for a pallet without a place or with more than any arm will ever fill.
    pub fn placed_on(&self, pallet: &Pallet) -> Result<Self, Diagnostic> {
        let Pallet {
            rows,
            columns,
            steps,
        } = pallet;
        finite(steps.as_flattened(), "a corner of the pallet")?;
        let places = pallet
            .places()
            .and_then(|places| u32::try_from(places).ok());
        match places {
            Some(places) if places > 0 => {
                let slope = self.surface.map_or([0.0; 2], |surface| surface.slope);
                let way = |place: u32| {
                    let [x, y, z] = pallet.way_to(place as usize);
                    [x, y, z + slope[0] * x + slope[1] * y]
                };
                self.at_each(places as usize, (0..places).map(way))
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
