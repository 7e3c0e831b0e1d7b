//! Where the tool's tip may be, how fast it may go, and how strong the laser may burn: bounds that a person gives an arm.

mod breach;
mod way;

pub use breach::{Breach, FenceError, FencePart};

use core::fmt;

use crate::Pose;

/// A tip so near to a bound is on it, mm: what 32 bits and the search along a curve cost.
pub(crate) const TOLERANCE: f64 = 0.01;
/// Most keep-outs of a fence.
const MOST_KEEP_OUTS: usize = 8;

/// A box with its sides along the arm's axes, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cuboid {
    /// Its lowest corner.
    pub min: [f64; 3],
    /// Its highest corner.
    pub max: [f64; 3],
}

/// Bounds for the tip of an arm's tool, in the arm's coordinates. What is not given is not bounded.
///
/// A motion may not lead the tip across a bound on any part of its way. A tip that is beyond one already may come back, and
/// go no further out.
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

/// Making one.
impl Fence {
    /// How many keep-outs one may have.
    pub(crate) const MOST_KEEP_OUTS: usize = MOST_KEEP_OUTS;

    /// The lowest z of the tip, mm.
    ///
    /// # Errors
    /// [`FenceError::NotFinite`].
    pub fn with_floor(mut self, z: f64) -> Result<Self, FenceError> {
        if !z.is_finite() {
            return Err(FenceError::NotFinite(FencePart::Floor));
        }
        self.floor = Some(z);
        Ok(self)
    }

    /// The box that the tip stays in.
    ///
    /// # Errors
    /// [`FenceError::NotFinite`]; [`FenceError::Inverted`] for a first corner that is not below the second one.
    pub fn with_box(mut self, within: Cuboid) -> Result<Self, FenceError> {
        within.check(FencePart::BOX)?;
        self.within = Some(within);
        Ok(self)
    }

    /// One more box that the tip stays out of.
    ///
    /// # Errors
    /// As [`with_box`](Self::with_box); [`FenceError::TooMany`].
    pub fn with_keep_out(mut self, keep_out: Cuboid) -> Result<Self, FenceError> {
        keep_out.check(FencePart::KeepOut(self.count))?;
        let slot = self.keep_outs.get_mut(self.count);
        *slot.ok_or(FenceError::TooMany)? = keep_out;
        self.count += 1;
        Ok(self)
    }

    /// The highest speed of the tip, mm/s.
    ///
    /// # Errors
    /// [`FenceError::NotFinite`]; [`FenceError::OutOfRange`] for a speed that is not above 0.
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

    /// The strongest that the laser may burn, percent.
    ///
    /// # Errors
    /// [`FenceError::NotFinite`]; [`FenceError::OutOfRange`] for what is not 0 to 100.
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

/// Looking at one.
impl Fence {
    /// The lowest z of the tip, mm.
    #[must_use]
    pub fn floor(&self) -> Option<f64> {
        self.floor
    }

    /// The box that the tip stays in.
    #[must_use]
    pub fn within(&self) -> Option<Cuboid> {
        self.within
    }

    /// The boxes that the tip stays out of.
    #[must_use]
    pub fn keep_outs(&self) -> &[Cuboid] {
        self.keep_outs.get(..self.count).unwrap_or_default()
    }

    /// The highest speed of the tip, mm/s.
    #[must_use]
    pub fn top_speed(&self) -> Option<f64> {
        self.top_speed
    }

    /// The strongest that the laser may burn, percent.
    #[must_use]
    pub fn strongest_laser(&self) -> Option<f64> {
        self.strongest_laser
    }

    /// Whether it bounds nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Its bounds of where the tip may be alone.
    #[must_use]
    pub fn in_space(self) -> Self {
        Self {
            top_speed: None,
            strongest_laser: None,
            ..self
        }
    }

    /// Whether it bounds where the tip may be.
    #[must_use]
    pub fn bounds_space(&self) -> bool {
        self.floor.is_some() || self.within.is_some() || self.count > 0
    }

    /// Whether it bounds motions: where the tip may be, or how fast it may go.
    #[must_use]
    pub fn bounds_motion(&self) -> bool {
        self.bounds_space() || self.top_speed.is_some()
    }

    /// What a tip at this place breaks, the worst of it.
    #[must_use]
    pub fn breach(&self, at: &Pose) -> Option<Breach> {
        let tip = [at.x, at.y, at.z];
        self.parts()
            .map(|part| (self.depth(part, tip), part))
            .filter(|(depth, _)| *depth > TOLERANCE || depth.is_nan())
            .max_by(|(a, _), (b, _)| a.total_cmp(b))
            .map(|(_, part)| self.told(part, tip))
    }

    /// Whether a tip that goes from one place to another in no time, as when the tool is said to be another one, gets
    /// across a bound, or further out of one.
    ///
    /// # Errors
    /// What is crossed.
    pub fn check_leap(&self, from: &Pose, to: &Pose) -> Result<(), Breach> {
        let [from, to] = [from, to].map(|at| [at.x, at.y, at.z]);
        for part in self.parts() {
            let (before, after) = (self.depth(part, from), self.depth(part, to));
            if after.is_nan() || after > way::end_limit(before) {
                return Err(self.told(part, to));
            }
        }
        Ok(())
    }

    /// Whether the tip may go at this speed, mm/s.
    ///
    /// # Errors
    /// [`FencePart::TopSpeed`].
    pub fn check_speed(&self, speed: f64) -> Result<(), Breach> {
        match self.top_speed {
            // A speed that was set in 32 bits is that speed.
            Some(limit) if speed.is_nan() || speed > limit * (1.0 + 1e-6) => Err(Breach {
                part: FencePart::TopSpeed,
                value: speed,
                limit,
                at: None,
            }),
            _ => Ok(()),
        }
    }

    /// Whether the laser may burn at this power, percent.
    ///
    /// # Errors
    /// [`FencePart::Laser`].
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

    /// The parts that bound where the tip may be.
    fn parts(&self) -> impl Iterator<Item = FencePart> {
        let floor = self.floor.map(|_| FencePart::Floor);
        let sides = self.within.is_some().then_some(FencePart::SIDES);
        let keep_outs = (0..self.count).map(FencePart::KeepOut);
        floor
            .into_iter()
            .chain(sides.into_iter().flatten())
            .chain(keep_outs)
    }

    /// By how much a place is beyond a part, mm; below 0 where it is not.
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

    fn told(&self, part: FencePart, tip: [f64; 3]) -> Breach {
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

/// In a line: `floor z -60.0 mm, 2 keep-outs, at most 100.0 mm/s`.
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
