//! The corners of a jump (model section 7).

use crate::{ArmModel, Geometry, MotionError, Pose, Unreachable};

/// How high a jump goes, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpHeights {
    /// Rise above the start.
    pub start: f64,
    /// Descent to the end.
    pub end: f64,
    /// The z that a jump does not rise above, unless its start or end does or leaves the joints no room.
    pub z_limit: f64,
}

impl JumpHeights {
    /// The same height at start and end: both corners are as high above the higher of the two.
    #[must_use]
    pub const fn even(height: f64, z_limit: f64) -> Self {
        Self {
            start: height,
            end: height,
            z_limit,
        }
    }

    /// The z of the corner above the start and of the one above the end.
    fn corners(&self, from: f64, to: f64) -> (f64, f64) {
        if self.start == self.end {
            let highest = from.max(to);
            let z = self.capped(highest, self.start);
            (z, z)
        } else {
            (self.capped(from, self.start), self.capped(to, self.end))
        }
    }

    fn capped(&self, z: f64, height: f64) -> f64 {
        if z > self.z_limit {
            z
        } else {
            (z + height).min(self.z_limit)
        }
    }

    fn is_valid(&self) -> bool {
        self.start.is_finite() && self.end.is_finite() && !self.z_limit.is_nan()
    }
}

impl Default for JumpHeights {
    /// The settings at power-up of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.power_up.jump()
    }
}

/// How a jump gets from one corner to the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// All joints together. This swings the tool up between the corners, by millimetres; where that would break the
    /// jump's z limit, both corners are lowered until it does not.
    Joint,
    /// On a straight line.
    Line,
}

/// The corners of one jump.
#[derive(Clone, Copy)]
pub(crate) struct Corners {
    pub(crate) lift: Pose,
    pub(crate) descent: Pose,
    /// The z that no part of the jump rises above: the limit, or the higher end if that is above it.
    pub(crate) ceiling: f64,
    /// The z below which each corner is not taken.
    floors: [f64; 2],
    pub(crate) lift_is_straight: bool,
    pub(crate) descent_is_straight: bool,
}

impl Corners {
    /// The corners of the jump from one pose to another; r turns between them.
    pub(crate) fn between(
        geometry: &Geometry,
        from: &Pose,
        to: &Pose,
        heights: &JumpHeights,
    ) -> Result<Self, MotionError> {
        if !heights.is_valid() {
            return Err(Unreachable::NotFinite.into());
        }
        let (lift, descent) = heights.corners(from.z, to.z);
        Ok(Self {
            lift: Pose { z: lift, ..*from },
            descent: Pose { z: descent, ..*to },
            ceiling: heights.z_limit.max(from.z).max(to.z),
            floors: [from.z, to.z],
            lift_is_straight: is_outstretched(geometry, from),
            descent_is_straight: is_outstretched(geometry, to),
        })
    }
}

impl Corners {
    /// These corners with straight ways up and down.
    pub(crate) fn straight(&self) -> Self {
        Self {
            lift_is_straight: true,
            descent_is_straight: true,
            ..*self
        }
    }

    /// These corners taken down by so many mm, as far as the ends of the jump allow; nothing if they are down already.
    pub(crate) fn lowered(&self, by: f64) -> Option<Self> {
        let [first, second] = self.floors;
        let mut lowered = *self;
        lowered.lift.z = (self.lift.z - by).max(first.min(self.lift.z));
        lowered.descent.z = (self.descent.z - by).max(second.min(self.descent.z));
        (lowered.lift.z < self.lift.z || lowered.descent.z < self.descent.z).then_some(lowered)
    }
}

/// Near the base the joints go straight up and down better than the tool does: the vendor's rule.
fn is_outstretched(geometry: &Geometry, pose: &Pose) -> bool {
    libm::sqrt(pose.x * pose.x + pose.y * pose.y) > geometry.forearm + geometry.tool.x
}
