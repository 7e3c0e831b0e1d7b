use serde::{Deserialize, Serialize};

/// The surface that the tool works on: paper, wood, a table. Level, or tilted as it was measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// The z that the arm reports where the tool touches it, at x = y = 0 (extrapolated there if it is tilted), mm.
    pub height: f64,
    /// How much higher it is for each mm in x and in y.
    #[serde(default)]
    pub slope: [f64; 2],
}

impl Surface {
    /// The table of a virtual arm if its height is not given.
    pub const VIRTUAL: Self = Self::level(-60.0);

    /// A level one at this height, mm.
    #[must_use]
    pub const fn level(height: f64) -> Self {
        Self {
            height,
            slope: [0.0, 0.0],
        }
    }

    /// The same so much higher, mm.
    #[must_use]
    pub fn raised(self, by: f64) -> Self {
        Self {
            height: self.height + by,
            ..self
        }
    }

    /// Its height at a point, mm.
    #[must_use]
    pub fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.height + self.slope[0] * x + self.slope[1] * y
    }
}
