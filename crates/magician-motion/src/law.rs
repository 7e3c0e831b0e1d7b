//! The controller's law of motion: whole periods of 20 ms, or continuous time (model section 7).

use crate::velocity_profile::{KinematicLimits, VelocityProfile};

/// Law of motion of a controller.
///
/// A Magician computes in periods of 20 ms. In each it first changes the speed, by at most the
/// acceleration times the period, then moves by the speed times the period; between two periods the
/// pose stands still, and the last period of a motion ends exactly on its target. Without periods
/// the same profiles are functions of continuous time.
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
    /// Periods of 20 ms, as seen in two recordings of real arms (model section 7).
    pub const MAGICIAN: Self = Self { period_us: 20_000 };

    /// Continuous time: the position changes at every instant.
    pub const CONTINUOUS: Self = Self { period_us: 0 };

    /// Creates a law with a period in microseconds; 0 means continuous time.
    #[must_use]
    pub const fn with_period_us(period_us: u32) -> Self {
        Self { period_us }
    }

    /// Period, microseconds; 0 in continuous time.
    #[must_use]
    pub const fn period_us(self) -> u32 {
        self.period_us
    }

    /// True in continuous time.
    #[must_use]
    pub const fn is_continuous(self) -> bool {
        self.period_us == 0
    }

    /// End of the last period at or before a time, microseconds. The pose reported at that time
    /// dates from then.
    #[must_use]
    pub const fn period_start(self, at_us: u64) -> u64 {
        match self.period_us {
            0 => at_us,
            period => at_us - at_us % period as u64,
        }
    }

    /// End of the first period at or after a time, microseconds.
    #[must_use]
    pub const fn period_end(self, at_us: u64) -> u64 {
        match self.period_us {
            0 => at_us,
            period => at_us.div_ceil(period as u64).saturating_mul(period as u64),
        }
    }

    /// Period, seconds.
    pub(crate) fn period(self) -> f64 {
        f64::from(self.period_us) / 1e6
    }

    /// Returns the fastest profile over `length` from rest to rest.
    #[must_use]
    pub fn rest_to_rest(self, length: f64, limits: &KinematicLimits) -> VelocityProfile {
        self.rest_to_rest_in(length, limits, limits.least_time(length))
    }

    /// Returns the profile over `length` from rest to rest with the ramps of `duration` seconds,
    /// which must not be shorter than the fastest.
    ///
    /// The profile is a triangle if that stays below the velocity limit, else a trapezoid at full
    /// velocity. In periods the profile ends with the period in which `duration` ends.
    #[must_use]
    pub fn rest_to_rest_in(
        self,
        length: f64,
        limits: &KinematicLimits,
        duration: f64,
    ) -> VelocityProfile {
        VelocityProfile::trapezoid_in(length, limits, duration).in_periods(self.period())
    }

    /// Like [`rest_to_rest_in`](Self::rest_to_rest_in), but never cruises.
    pub(crate) fn triangle(self, length: f64, duration: f64) -> VelocityProfile {
        VelocityProfile::triangle(length, duration).in_periods(self.period())
    }

    /// Returns a ramp from `entry` to the velocity limit, which is held until `length` is covered.
    ///
    /// In periods the entry may be negative by less than one period gains: a jog that reverses
    /// crosses standstill within a period.
    #[must_use]
    pub fn run(self, length: f64, entry: f64, limits: &KinematicLimits) -> VelocityProfile {
        if self.is_continuous() {
            VelocityProfile::between(length, entry.max(0.0), limits.velocity, limits)
        } else {
            VelocityProfile::run_in_periods(length, entry, limits, self.period())
        }
    }

    /// Returns the profile from a speed to rest at a constant deceleration.
    #[must_use]
    pub fn stop(self, entry: f64, deceleration: f64) -> VelocityProfile {
        VelocityProfile::stopping(entry, deceleration).stop_in_periods(self.period())
    }

    /// Returns the profile from a speed to rest in `duration` seconds.
    #[must_use]
    pub(crate) fn stop_in(self, entry: f64, duration: f64) -> VelocityProfile {
        VelocityProfile::stopping_in(entry, duration).stop_in_periods(self.period())
    }

    /// Returns the part of a stop before the speed changes its sign, and the speed left at its end.
    ///
    /// That speed is 0 in continuous time. In periods it is less than one period's change of speed.
    pub(crate) fn reversal(self, entry: f64, deceleration: f64) -> (VelocityProfile, f64) {
        if self.is_continuous() {
            (VelocityProfile::stopping(entry, deceleration), 0.0)
        } else {
            VelocityProfile::turn_in_periods(entry, deceleration, self.period())
        }
    }

    /// Returns the profile of a path segment between two speeds, limited as in
    /// [`VelocityProfile::between`].
    ///
    /// In periods it takes the nearest whole number of them, at least one, and ends on its target.
    /// The speed in between is lowered or raised to fit, and its positions are those of a
    /// continuous profile (choice `CpTimes`). A tie counts as the longer time.
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
            // Without this allowance the rounding of a binary32 target would decide a tie: a
            // segment of exactly 1.5 periods would take 1 or 2 depending on where it lies.
            let rounding = LENGTH_ROUNDING / limits.velocity;
            let periods = libm::floor((profile.duration() + rounding) / period + 0.5);
            profile.lasting(periods.max(1.0) * period, limits.acceleration)
        }
    }
}

impl Default for MotionLaw {
    /// Law of a Magician.
    fn default() -> Self {
        Self::MAGICIAN
    }
}

/// Number of periods that a duration needs. A rounding error does not add one.
pub(crate) fn whole_periods(duration: f64, period: f64) -> f64 {
    libm::ceil(duration / period - ROUNDING)
}

/// Number of periods that have ended by a time.
pub(crate) fn ended_periods(t: f64, period: f64) -> f64 {
    libm::floor(t / period + ROUNDING)
}

/// Rounding error in the length of a path segment, mm. Targets arrive in binary32, which between
/// 256 and 512 mm is off by up to 2^-16 mm on each axis. Over both ends of a diagonal that adds up
/// to `2 * sqrt(3) * 2^-16 = 5.3e-5`.
const LENGTH_ROUNDING: f64 = 6e-5;
/// Rounding error allowed in a number of periods: 2 ns of 20 ms. It is far above the rounding of
/// `f64` and far below the microsecond in which times are given.
const ROUNDING: f64 = 1e-7;
