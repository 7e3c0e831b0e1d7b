//! The ten joint limits: minimum and maximum of four joints, and of the coupling J2 - J3.

use crate::{ArmModel, JointAngles, MotionError};

/// Tolerance for an angle beyond its bound, degrees. It absorbs rounding and is a ten-millionth of
/// a motor step.
pub const LIMIT_TOLERANCE: f64 = 1e-9;

/// Lower or upper bound of a joint limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Bound {
    /// Base, negative side.
    J1Min,
    /// Base, positive side.
    J1Max,
    /// Rear arm leaning back.
    J2Min,
    /// Rear arm leaning forward.
    J2Max,
    /// Forearm up.
    J3Min,
    /// Forearm down.
    J3Max,
    /// End servo, negative side.
    J4Min,
    /// End servo, positive side.
    J4Max,
    /// J2 - J3 too small: the parallelogram folded.
    J23Min,
    /// J2 - J3 too large: the parallelogram stretched.
    J23Max,
}

impl Bound {
    /// All ten bounds, in the order of the alarms 0x40 to 0x49; of each pair the negative side
    /// comes first.
    pub const ALL: [Self; 10] = [
        Self::J1Min,
        Self::J1Max,
        Self::J2Min,
        Self::J2Max,
        Self::J3Min,
        Self::J3Max,
        Self::J4Min,
        Self::J4Max,
        Self::J23Min,
        Self::J23Max,
    ];

    /// Angle limited by this bound, degrees: a joint, or J2 - J3.
    #[must_use]
    pub fn value(self, joints: &JointAngles) -> f64 {
        match self {
            Self::J1Min | Self::J1Max => joints.j1,
            Self::J2Min | Self::J2Max => joints.j2,
            Self::J3Min | Self::J3Max => joints.j3,
            Self::J4Min | Self::J4Max => joints.j4,
            Self::J23Min | Self::J23Max => joints.j2 - joints.j3,
        }
    }

    /// True if this is an upper bound.
    #[must_use]
    pub fn is_upper(self) -> bool {
        matches!(
            self,
            Self::J1Max | Self::J2Max | Self::J3Max | Self::J4Max | Self::J23Max
        )
    }

    /// Name of the limited angle in messages: `joint 2`, or `joint 2 minus joint 3`.
    #[must_use]
    pub fn subject(self) -> &'static str {
        match self {
            Self::J1Min | Self::J1Max => "joint 1",
            Self::J2Min | Self::J2Max => "joint 2",
            Self::J3Min | Self::J3Max => "joint 3",
            Self::J4Min | Self::J4Max => "joint 4",
            Self::J23Min | Self::J23Max => "joint 2 minus joint 3",
        }
    }
}

/// A range of angles, both ends included; degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(from = "[f64; 2]", into = "[f64; 2]")
)]
pub struct Range {
    /// Smallest allowed angle.
    pub min: f64,
    /// Largest allowed angle.
    pub max: f64,
}

impl Range {
    /// Creates the range from `min` to `max`, degrees.
    #[must_use]
    pub const fn new(min: f64, max: f64) -> Self {
        Self { min, max }
    }
}

impl From<[f64; 2]> for Range {
    fn from([min, max]: [f64; 2]) -> Self {
        Self::new(min, max)
    }
}

impl From<Range> for [f64; 2] {
    fn from(range: Range) -> Self {
        [range.min, range.max]
    }
}

/// Ranges of the joints, degrees (model section 4).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Limits {
    /// Base.
    pub j1: Range,
    /// Rear arm.
    pub j2: Range,
    /// Forearm.
    pub j3: Range,
    /// End servo.
    pub j4: Range,
    /// The coupling of rear arm and forearm: J2 - J3.
    pub j2_minus_j3: Range,
}

impl Limits {
    /// No limits. During homing the commanded angle of the base is unrelated to its true angle, so
    /// limits cannot be checked.
    pub const NONE: Self = {
        // Finite, so that differences of limits stay numbers.
        const ANY: Range = Range::new(-1e9, 1e9);
        Self {
            j1: ANY,
            j2: ANY,
            j3: ANY,
            j4: ANY,
            j2_minus_j3: ANY,
        }
    };

    /// Angle of this bound, degrees.
    #[must_use]
    pub fn at(&self, bound: Bound) -> f64 {
        match bound {
            Bound::J1Min => self.j1.min,
            Bound::J1Max => self.j1.max,
            Bound::J2Min => self.j2.min,
            Bound::J2Max => self.j2.max,
            Bound::J3Min => self.j3.min,
            Bound::J3Max => self.j3.max,
            Bound::J4Min => self.j4.min,
            Bound::J4Max => self.j4.max,
            Bound::J23Min => self.j2_minus_j3.min,
            Bound::J23Max => self.j2_minus_j3.max,
        }
    }

    fn at_mut(&mut self, bound: Bound) -> &mut f64 {
        match bound {
            Bound::J1Min => &mut self.j1.min,
            Bound::J1Max => &mut self.j1.max,
            Bound::J2Min => &mut self.j2.min,
            Bound::J2Max => &mut self.j2.max,
            Bound::J3Min => &mut self.j3.min,
            Bound::J3Max => &mut self.j3.max,
            Bound::J4Min => &mut self.j4.min,
            Bound::J4Max => &mut self.j4.max,
            Bound::J23Min => &mut self.j2_minus_j3.min,
            Bound::J23Max => &mut self.j2_minus_j3.max,
        }
    }

    /// Checks that the joints are within all ten bounds, with [`LIMIT_TOLERANCE`].
    ///
    /// # Errors
    ///
    /// [`MotionError::Limit`] for the first bound violated, in the order of [`Bound::ALL`];
    /// [`Unreachable::NotFinite`](crate::Unreachable::NotFinite) for NaN or infinite angles.
    pub fn check(&self, joints: &JointAngles) -> Result<(), MotionError> {
        if !joints.is_finite() {
            return Err(crate::Unreachable::NotFinite.into());
        }
        match self.violations(joints).next() {
            Some(bound) => Err(self.violation(bound, bound.value(joints))),
            None => Ok(()),
        }
    }

    /// Returns every violated bound, in the order of [`Bound::ALL`]. A controller shows each as an
    /// alarm bit.
    pub fn violations(&self, joints: &JointAngles) -> impl Iterator<Item = Bound> {
        let (limits, joints) = (*self, *joints);
        Bound::ALL
            .into_iter()
            .filter(move |bound| limits.is_violated(*bound, &joints))
    }

    /// True if the joints violate this bound by more than [`LIMIT_TOLERANCE`]. NaN violates every
    /// bound.
    #[must_use]
    pub(crate) fn is_violated(&self, bound: Bound, joints: &JointAngles) -> bool {
        let excess = if bound.is_upper() {
            bound.value(joints) - self.at(bound)
        } else {
            self.at(bound) - bound.value(joints)
        };
        excess > LIMIT_TOLERANCE || excess.is_nan()
    }

    /// Creates the error for `value` beyond `bound`.
    pub(crate) fn violation(&self, bound: Bound, value: f64) -> MotionError {
        MotionError::Limit {
            bound,
            value,
            limit: self.at(bound),
        }
    }

    /// Returns these limits without those of J4, which do not bound the positions of the tool.
    pub(crate) fn without_j4(&self) -> Self {
        Self {
            j4: Range::new(f64::NEG_INFINITY, f64::INFINITY),
            ..*self
        }
    }

    /// Returns these limits with every violated bound moved out to where `joints` are.
    pub(crate) fn widened_to(&self, joints: &JointAngles) -> Self {
        let mut wide = *self;
        for bound in self.violations(joints) {
            *wide.at_mut(bound) = bound.value(joints);
        }
        wide
    }

    /// Returns these limits with every bound that `joints` respect restored from `strict`.
    pub(crate) fn narrowed_at(&self, strict: &Self, joints: &JointAngles) -> Self {
        let mut narrow = *self;
        for bound in Bound::ALL {
            if !strict.is_violated(bound, joints) {
                *narrow.at_mut(bound) = strict.at(bound);
            }
        }
        narrow
    }
}

impl Default for Limits {
    /// Soft limits of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.limits
    }
}
