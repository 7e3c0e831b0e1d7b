//! How the controller turns speeds into places: in whole periods, or as if time were continuous (model section 7).

use crate::velocity_profile::{KinematicLimits, VelocityProfile};

/// The law of motion of a controller.
///
/// A Magician computes in periods of 20 ms. In each it first changes the speed, by at most the acceleration times the
/// period, then moves by the speed times the period; between two periods the pose stands still, and the last period of
/// a motion ends exactly on its target. Without periods the same profiles are functions of continuous time.
///
/// ```
/// use magician_motion::{KinematicLimits, MotionLaw};
///
/// // A jog from rest at 60 mm/s2: 0.024 mm times 1, 3, 6, 10 and so on.
/// let limits = KinematicLimits { velocity: 30.0, acceleration: 60.0 };
/// let jog = MotionLaw::MAGICIAN.run(1000.0, 0.0, &limits);
/// assert!((jog.position(0.04) - 0.072).abs() < 1e-12);
/// assert!((jog.position(0.44) - 6.072).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionLaw {
    period_us: u32,
}

impl MotionLaw {
    /// Periods of 20 ms, as two recordings of real arms show.
    pub const MAGICIAN: Self = Self { period_us: 20_000 };

    /// No periods: every time has a place of its own.
    pub const CONTINUOUS: Self = Self { period_us: 0 };

    /// Periods of so many microseconds; continuous for 0.
    #[must_use]
    pub const fn with_period_us(period_us: u32) -> Self {
        Self { period_us }
    }

    /// The period, microseconds; 0 for continuous time.
    #[must_use]
    pub const fn period_us(self) -> u32 {
        self.period_us
    }

    /// True without periods.
    #[must_use]
    pub const fn is_continuous(self) -> bool {
        self.period_us == 0
    }

    /// The end of the last period by a time, microseconds: what is reported then holds since.
    #[must_use]
    pub const fn period_start(self, at_us: u64) -> u64 {
        match self.period_us {
            0 => at_us,
            period => at_us - at_us % period as u64,
        }
    }

    /// The first end of a period from a time on, microseconds.
    #[must_use]
    pub const fn period_end(self, at_us: u64) -> u64 {
        match self.period_us {
            0 => at_us,
            period => at_us.div_ceil(period as u64).saturating_mul(period as u64),
        }
    }

    /// The period, seconds.
    pub(crate) fn period(self) -> f64 {
        f64::from(self.period_us) / 1e6
    }

    /// The fastest way over `length` from rest to rest.
    #[must_use]
    pub fn rest_to_rest(self, length: f64, limits: &KinematicLimits) -> VelocityProfile {
        self.rest_to_rest_in(length, limits, limits.least_time(length))
    }

    /// The way over `length` from rest to rest whose ramps are those of `duration` seconds, no less than the fastest: a
    /// triangle where the velocity allows, else a trapezoid at full velocity. In periods it ends with the period that
    /// `duration` ends in.
    #[must_use]
    pub fn rest_to_rest_in(
        self,
        length: f64,
        limits: &KinematicLimits,
        duration: f64,
    ) -> VelocityProfile {
        VelocityProfile::trapezoid_in(length, limits, duration).in_periods(self.period())
    }

    /// The way over `length` from rest to rest that never cruises, as [`rest_to_rest_in`](Self::rest_to_rest_in).
    pub(crate) fn triangle(self, length: f64, duration: f64) -> VelocityProfile {
        VelocityProfile::triangle(length, duration).in_periods(self.period())
    }

    /// A ramp from `entry` to the velocity of the limits, which is held until `length` is covered.
    ///
    /// In periods the entry may be below 0 by less than a period gains: what a jog that is turned round has left of
    /// its speed the other way.
    #[must_use]
    pub fn run(self, length: f64, entry: f64, limits: &KinematicLimits) -> VelocityProfile {
        if self.is_continuous() {
            VelocityProfile::between(length, entry.max(0.0), limits.velocity, limits)
        } else {
            VelocityProfile::run_in_periods(length, entry, limits, self.period())
        }
    }

    /// From a speed to rest at a steady deceleration.
    #[must_use]
    pub fn stop(self, entry: f64, deceleration: f64) -> VelocityProfile {
        VelocityProfile::stopping(entry, deceleration).stop_in_periods(self.period())
    }

    /// From a speed to rest in `duration` seconds.
    #[must_use]
    pub(crate) fn stop_in(self, entry: f64, duration: f64) -> VelocityProfile {
        VelocityProfile::stopping_in(entry, duration).stop_in_periods(self.period())
    }

    /// What of a stop passes before the speed changes its sign, and how much of the speed is left then: nothing in
    /// continuous time, less than a period takes off in periods.
    pub(crate) fn turn(self, entry: f64, deceleration: f64) -> (VelocityProfile, f64) {
        if self.is_continuous() {
            (VelocityProfile::stopping(entry, deceleration), 0.0)
        } else {
            VelocityProfile::turn_in_periods(entry, deceleration, self.period())
        }
    }

    /// A segment of a continuous path: from one speed to another over `length`, as
    /// [`VelocityProfile::between`] says.
    ///
    /// In periods it takes the nearest whole number of them, at least one, and ends on its target: its speed on the way
    /// is as much lower or higher as that asks for, and its places are those of a continuous profile (choice
    /// `CpTimes`). A tie counts as the slower of both, whatever binary32 makes of the ends of the segment.
    #[must_use]
    pub fn segment(
        self,
        length: f64,
        entry: f64,
        exit: f64,
        limits: &KinematicLimits,
    ) -> VelocityProfile {
        let profile = VelocityProfile::between(length, entry, exit, limits);
        if self.is_continuous() {
            profile
        } else {
            let period = self.period();
            let rounding = LENGTH_ROUNDING / limits.velocity;
            let periods = libm::floor((profile.duration() + rounding) / period + 0.5);
            profile.lasting(periods.max(1.0) * period, limits.acceleration)
        }
    }
}

impl Default for MotionLaw {
    /// That of a Magician.
    fn default() -> Self {
        Self::MAGICIAN
    }
}

/// How many periods a time needs; a rounding error does not cost one.
pub(crate) fn whole_periods(duration: f64, period: f64) -> f64 {
    libm::ceil(duration / period - ROUNDING)
}

/// How many periods have ended by a time.
pub(crate) fn ended_periods(t: f64, period: f64) -> f64 {
    libm::floor(t / period + ROUNDING)
}

/// Part of the length of a segment that is rounding, mm: a target comes in binary32, and is off by 2^-16 mm on each axis
/// from 256 to 512 mm. Of both ends of a diagonal that is `2 * sqrt(3) * 2^-16 = 5.3e-5`.
const LENGTH_ROUNDING: f64 = 6e-5;
/// A share of a period that is rounding.
const ROUNDING: f64 = 1e-7;
