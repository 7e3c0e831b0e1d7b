//! The work surface as a plane.

use serde::{Deserialize, Serialize};

/// Surface that the tool works on (paper, wood, a table), level or tilted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Height of the pose when the tool touches the surface at x = y = 0, mm. Extrapolated to that
    /// point if the surface is tilted.
    pub height: f64,
    /// Slope in x and in y, mm per mm.
    #[serde(default)]
    pub slope: [f64; 2],
}

impl Surface {
    /// Table of a virtual arm if no height is given.
    pub const VIRTUAL: Self = Self::level(-60.0);

    /// Creates a level surface at a height, mm.
    #[must_use]
    pub const fn level(height: f64) -> Self {
        Self {
            height,
            slope: [0.0, 0.0],
        }
    }

    /// Returns the surface raised by `by` mm.
    #[must_use]
    pub fn raised(self, by: f64) -> Self {
        Self {
            height: self.height + by,
            ..self
        }
    }

    /// Height at a point, mm.
    #[must_use]
    pub fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.height + self.slope[0] * x + self.slope[1] * y
    }
}
