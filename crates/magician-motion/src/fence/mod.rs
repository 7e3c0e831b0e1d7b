//! The fence: the user's bounds for the tool tip, its speed and the power of the laser.
//!
//! A fence has a floor, a box to stay in, boxes to keep out of, a top speed and a laser limit; each
//! is optional. It differs from the joint limits in two ways: the user sets it for one arm, and a
//! motion that would break it is refused as a whole instead of cut. `way.rs` checks the path of a
//! motion.

mod breach;
mod way;

pub use breach::{Breach, FenceError, FencePart};

use core::fmt;

use crate::Pose;

/// Distance from a bound within which the tip counts as inside, mm. It covers the rounding of
/// binary32 coordinates and the accuracy of the search along curves.
pub(crate) const TOLERANCE: f64 = 0.01;
/// Most keep-outs of a fence. A choice: enough for a table, and a fence stays a small `Copy` value.
const MOST_KEEP_OUTS: usize = 8;

/// A box with sides parallel to the arm's axes, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cuboid {
    /// Lowest corner.
    pub min: [f64; 3],
    /// Highest corner.
    pub max: [f64; 3],
}

/// Bounds for the tool tip, in the arm's coordinates. Each bound is optional.
///
/// A motion must not take the tip across a bound on any part of its path. A tip that is beyond a
/// bound already may come back, but not go further out.
///
/// ```
/// use magician_motion::{Cuboid, Fence, FencePart, Pose};
///
/// let fence = Fence::default()
///     .with_floor(-60.0)?
///     .with_keep_out(Cuboid { min: [150.0, 80.0, -200.0], max: [250.0, 150.0, 40.0] })?;
/// assert_eq!(fence.breach(&Pose::new(200.0, 0.0, -60.0, 0.0)), None);
///
/// let breach = fence.breach(&Pose::new(200.0, 0.0, -71.2, 0.0)).unwrap();
/// assert_eq!((breach.part, breach.value, breach.limit), (FencePart::Floor, -71.2, -60.0));
/// assert_eq!(
///     breach.to_string(),
///     "the tool tip would be at z -71.2 mm, the fence's floor is -60.0 mm"
/// );
/// # Ok::<(), magician_motion::FenceError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fence {
    floor: Option<f64>,
    within: Option<Cuboid>,
    keep_outs: [Cuboid; MOST_KEEP_OUTS],
    count: usize,
    top_speed: Option<f64>,
    strongest_laser: Option<f64>,
}

impl Cuboid {
    fn check(&self, part: FencePart) -> Result<(), FenceError> {
        for (axis, (min, max)) in self.min.into_iter().zip(self.max).enumerate() {
            if !min.is_finite() || !max.is_finite() {
                return Err(FenceError::NotFinite(part));
            }
            if min >= max {
                return Err(FenceError::Inverted { part, axis });
            }
        }
        Ok(())
    }
}

/// Construction.
impl Fence {
    /// Most keep-outs of a fence.
    pub(crate) const MOST_KEEP_OUTS: usize = MOST_KEEP_OUTS;

    /// Sets the lowest z of the tip, mm.
    ///
    /// # Errors
    /// [`FenceError::NotFinite`] if the number is NaN or infinite.
    pub fn with_floor(mut self, z: f64) -> Result<Self, FenceError> {
        if !z.is_finite() {
            return Err(FenceError::NotFinite(FencePart::Floor));
        }
        self.floor = Some(z);
        Ok(self)
    }

    /// Sets the box that the tip stays in.
    ///
    /// # Errors
    /// [`FenceError::NotFinite`] for NaN or infinity; [`FenceError::Inverted`] if the first corner
    /// is not below the second.
    pub fn with_box(mut self, within: Cuboid) -> Result<Self, FenceError> {
        within.check(FencePart::BOX)?;
        self.within = Some(within);
        Ok(self)
    }

    /// Adds a box that the tip stays out of.
    ///
    /// # Errors
    /// As for [`with_box`](Self::with_box); [`FenceError::TooMany`] if there is no room.
    pub fn with_keep_out(mut self, keep_out: Cuboid) -> Result<Self, FenceError> {
        keep_out.check(FencePart::KeepOut(self.count))?;
        let slot = self.keep_outs.get_mut(self.count);
        *slot.ok_or(FenceError::TooMany)? = keep_out;
        self.count += 1;
        Ok(self)
    }

    /// Sets the highest speed of the tip, mm/s.
    ///
    /// # Errors
    /// [`FenceError::NotFinite`] for NaN or infinity; [`FenceError::OutOfRange`] for a speed that
    /// is not above 0.
    pub fn with_top_speed(mut self, speed: f64) -> Result<Self, FenceError> {
        if !speed.is_finite() {
            return Err(FenceError::NotFinite(FencePart::TopSpeed));
        }
        if speed <= 0.0 {
            return Err(FenceError::OutOfRange(FencePart::TopSpeed, speed));
        }
        self.top_speed = Some(speed);
        Ok(self)
    }

    /// Sets the highest power of the laser, percent.
    ///
    /// # Errors
    /// [`FenceError::NotFinite`] for NaN or infinity; [`FenceError::OutOfRange`] for a power
    /// outside 0 to 100.
    pub fn with_strongest_laser(mut self, percent: f64) -> Result<Self, FenceError> {
        if !percent.is_finite() {
            return Err(FenceError::NotFinite(FencePart::Laser));
        }
        if !(0.0..=100.0).contains(&percent) {
            return Err(FenceError::OutOfRange(FencePart::Laser, percent));
        }
        self.strongest_laser = Some(percent);
        Ok(self)
    }
}

/// Queries and checks.
impl Fence {
    /// Lowest z of the tip, mm; `None` if not bounded.
    #[must_use]
    pub fn floor(&self) -> Option<f64> {
        self.floor
    }

    /// Box that the tip stays in; `None` if not bounded.
    #[must_use]
    pub fn within(&self) -> Option<Cuboid> {
        self.within
    }

    /// Boxes that the tip stays out of.
    #[must_use]
    pub fn keep_outs(&self) -> &[Cuboid] {
        self.keep_outs.get(..self.count).unwrap_or_default()
    }

    /// Highest speed of the tip, mm/s; `None` if not bounded.
    #[must_use]
    pub fn top_speed(&self) -> Option<f64> {
        self.top_speed
    }

    /// Highest power of the laser, percent; `None` if not bounded.
    #[must_use]
    pub fn strongest_laser(&self) -> Option<f64> {
        self.strongest_laser
    }

    /// True if the fence bounds nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns this fence with its bounds in space only.
    #[must_use]
    pub fn in_space(self) -> Self {
        Self {
            top_speed: None,
            strongest_laser: None,
            ..self
        }
    }

    /// True if the fence bounds the position of the tip.
    #[must_use]
    pub fn bounds_space(&self) -> bool {
        self.floor.is_some() || self.within.is_some() || self.count > 0
    }

    /// True if the fence bounds motions: position or speed of the tip.
    #[must_use]
    pub fn bounds_motion(&self) -> bool {
        self.bounds_space() || self.top_speed.is_some()
    }

    /// Returns the deepest breach of a tip at this position; `None` if it is within all bounds.
    #[must_use]
    pub fn breach(&self, at: &Pose) -> Option<Breach> {
        let tip = [at.x, at.y, at.z];
        self.parts()
            .map(|part| (self.depth(part, tip), part))
            .filter(|(depth, _)| *depth > TOLERANCE || depth.is_nan())
            .max_by(|(a, _), (b, _)| a.total_cmp(b))
            .map(|(_, part)| self.breach_at(part, tip))
    }

    /// Checks a jump of the tip from one position to another in no time, as when the tool bias
    /// changes. It must not cross a bound, nor lead further out of one.
    ///
    /// # Errors
    /// The bound that is crossed.
    pub fn check_tool_change(&self, from: &Pose, to: &Pose) -> Result<(), Breach> {
        let [from, to] = [from, to].map(|at| [at.x, at.y, at.z]);
        for part in self.parts() {
            let (before, after) = (self.depth(part, from), self.depth(part, to));
            if after.is_nan() || after > way::end_limit(before) {
                return Err(self.breach_at(part, to));
            }
        }
        Ok(())
    }

    /// Checks a speed of the tip, mm/s.
    ///
    /// # Errors
    /// A breach of [`FencePart::TopSpeed`].
    pub fn check_speed(&self, speed: f64) -> Result<(), Breach> {
        match self.top_speed {
            // The tolerance covers a speed that was rounded to binary32.
            Some(limit) if speed.is_nan() || speed > limit * (1.0 + 1e-6) => Err(Breach {
                part: FencePart::TopSpeed,
                value: speed,
                limit,
                at: None,
            }),
            _ => Ok(()),
        }
    }

    /// Checks a power of the laser, percent.
    ///
    /// # Errors
    /// A breach of [`FencePart::Laser`].
    pub fn check_laser(&self, percent: f64) -> Result<(), Breach> {
        match self.strongest_laser {
            Some(limit) if percent.is_nan() || percent > limit * (1.0 + 1e-6) => Err(Breach {
                part: FencePart::Laser,
                value: percent,
                limit,
                at: None,
            }),
            _ => Ok(()),
        }
    }

    /// The parts that bound the position of the tip.
    fn parts(&self) -> impl Iterator<Item = FencePart> {
        let floor = self.floor.map(|_| FencePart::Floor);
        let sides = self.within.is_some().then_some(FencePart::SIDES);
        let keep_outs = (0..self.count).map(FencePart::KeepOut);
        floor
            .into_iter()
            .chain(sides.into_iter().flatten())
            .chain(keep_outs)
    }

    /// Distance of a position beyond a part, mm; negative if it is within the bound.
    fn depth(&self, part: FencePart, tip: [f64; 3]) -> f64 {
        match part {
            FencePart::Floor => self.floor.map_or(f64::NEG_INFINITY, |floor| floor - tip[2]),
            FencePart::Box { axis, upper } => self.within.map_or(f64::NEG_INFINITY, |within| {
                let at = axis.min(2);
                if upper {
                    tip[at] - within.max[at]
                } else {
                    within.min[at] - tip[at]
                }
            }),
            FencePart::KeepOut(nth) => {
                let inside = |keep_out: &Cuboid| {
                    let sides = keep_out.min.into_iter().zip(keep_out.max).zip(tip);
                    sides
                        .map(|((min, max), at)| (at - min).min(max - at))
                        .fold(f64::INFINITY, f64::min)
                };
                self.keep_outs().get(nth).map_or(f64::NEG_INFINITY, inside)
            }
            FencePart::TopSpeed | FencePart::Laser => f64::NEG_INFINITY,
        }
    }

    fn breach_at(&self, part: FencePart, tip: [f64; 3]) -> Breach {
        let (value, limit) = match part {
            FencePart::Floor => (tip[2], self.floor.unwrap_or_default()),
            FencePart::Box { axis, upper } => {
                let (within, at) = (self.within.unwrap_or_default(), axis.min(2));
                let limit = if upper {
                    within.max[at]
                } else {
                    within.min[at]
                };
                (tip[at], limit)
            }
            _ => (self.depth(part, tip), 0.0),
        };
        Breach {
            part,
            value,
            limit,
            at: Some(tip),
        }
    }
}

/// Formats the fence as one line: `floor z -60.0 mm, 2 keep-outs, at most 100.0 mm/s`.
impl fmt::Display for Fence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut comma = "";
        if let Some(floor) = self.floor {
            write!(f, "floor z {floor:.1} mm")?;
            comma = ", ";
        }
        if let Some(Cuboid { min, max }) = self.within {
            let ([x, y, z], [u, v, w]) = (min, max);
            write!(
                f,
                "{comma}box x {x:.1} to {u:.1}, y {y:.1} to {v:.1}, z {z:.1} to {w:.1} mm"
            )?;
            comma = ", ";
        }
        if self.count > 0 {
            let keep_outs = if self.count == 1 {
                "keep-out"
            } else {
                "keep-outs"
            };
            write!(f, "{comma}{} {keep_outs}", self.count)?;
            comma = ", ";
        }
        if let Some(speed) = self.top_speed {
            write!(f, "{comma}at most {speed:.1} mm/s")?;
            comma = ", ";
        }
        if let Some(power) = self.strongest_laser {
            write!(f, "{comma}laser at most {power:.1} %")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
