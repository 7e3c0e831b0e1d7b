//! Corners of a jump (model section 7).

use crate::{ArmModel, Geometry, MotionError, Pose, Unreachable};

/// Heights of a jump, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpHeights {
    /// Rise above the start.
    pub start: f64,
    /// Descent to the end.
    pub end: f64,
    /// Highest z of a jump. The start or the end may lie above it, and so may a jump whose joints
    /// leave no room.
    pub z_limit: f64,
}

impl JumpHeights {
    /// Creates equal heights: both corners are that much above the higher end.
    #[must_use]
    pub const fn even(height: f64, z_limit: f64) -> Self {
        Self {
            start: height,
            end: height,
            z_limit,
        }
    }

    /// Z of the corner above the start, and of the corner above the end.
    fn corners(&self, from: f64, to: f64) -> (f64, f64) {
        if self.start == self.end {
            let highest = from.max(to);
            let z = self.capped(highest, self.start);
            (z, z)
        } else {
            (self.capped(from, self.start), self.capped(to, self.end))
        }
    }

    // An end above the limit is its own corner: zm = max(z0, z1), without an alarm (model section
    // 15a).
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

/// Path of a jump between its corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// All joints together. This swings the tool up by millimetres between the corners. Where the
    /// swing would exceed the z limit, both corners are lowered.
    Joint,
    /// On a straight line.
    Line,
}

/// The corners of one jump.
#[derive(Clone, Copy)]
pub(crate) struct Corners {
    pub(crate) lift: Pose,
    pub(crate) descent: Pose,
    /// Highest z of the jump: the limit, or the higher end if that is above it.
    pub(crate) ceiling: f64,
    /// Lowest z of each corner: its end of the jump.
    floors: [f64; 2],
    pub(crate) lift_is_straight: bool,
    pub(crate) descent_is_straight: bool,
}

impl Corners {
    /// Returns the corners of a jump between two poses; r turns between the corners.
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
    /// Returns these corners with straight legs up and down.
    pub(crate) fn straight(&self) -> Self {
        Self {
            lift_is_straight: true,
            descent_is_straight: true,
            ..*self
        }
    }

    /// Returns these corners lowered by `by` mm, but not below the ends of the jump. `None` if
    /// neither can go lower.
    pub(crate) fn lowered(&self, by: f64) -> Option<Self> {
        let [first, second] = self.floors;
        let mut lowered = *self;
        lowered.lift.z = (self.lift.z - by).max(first.min(self.lift.z));
        lowered.descent.z = (self.descent.z - by).max(second.min(self.descent.z));
        (lowered.lift.z < self.lift.z || lowered.descent.z < self.descent.z).then_some(lowered)
    }
}

/// True if the tool is further out than the forearm plus the bias. There the vendor's code lifts on
/// a straight line, elsewhere by joints (model section 7).
fn is_outstretched(geometry: &Geometry, pose: &Pose) -> bool {
    libm::sqrt(pose.x * pose.x + pose.y * pose.y) > geometry.forearm + geometry.tool.x
}
