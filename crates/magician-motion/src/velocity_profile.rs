//! The velocity of one axis as a function of time: from rest to rest, between any two speeds, or to rest (model sections 7, 8,
//! 10 and 14).

/// The fastest that an axis may go, in its own unit: per second, and per second squared. Both are positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KinematicLimits {
    /// Highest velocity.
    pub velocity: f64,
    /// Highest acceleration.
    pub acceleration: f64,
}

impl KinematicLimits {
    /// The least time in seconds for `length` from rest to rest.
    #[must_use]
    pub fn least_time(&self, length: f64) -> f64 {
        let Self {
            velocity,
            acceleration,
        } = *self;
        if length * acceleration > velocity * velocity {
            length / velocity + velocity / acceleration
        } else {
            2.0 * libm::sqrt(length / acceleration)
        }
    }
}

/// A trapezoid of velocity without a jerk limit: it ramps from its entry to a peak, holds it, and ramps to its exit; it is never
/// negative.
///
/// Everything is a closed form of time; nothing is accumulated. The way back from a reversal is a profile of its own.
///
/// ```
/// use magician_motion::{KinematicLimits, VelocityProfile};
///
/// let limits = KinematicLimits { velocity: 100.0, acceleration: 200.0 };
/// let profile = VelocityProfile::trapezoid(100.0, &limits);
/// assert_eq!(profile.duration(), 1.5); // half a second up, half a second at 100, half a second down
/// assert_eq!((profile.position(0.5), profile.velocity(1.0)), (25.0, 100.0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VelocityProfile {
    length: f64,
    duration: f64,
    entry: f64,
    peak: f64,
    exit: f64,
    ramp_in: f64,
    ramp_out: f64,
}

impl VelocityProfile {
    /// The fastest profile over `length` from rest to rest.
    #[must_use]
    pub fn trapezoid(length: f64, limits: &KinematicLimits) -> Self {
        Self::trapezoid_in(length, limits, limits.least_time(length))
    }

    /// The profile over `length` from rest to rest that takes `duration` seconds, no less than the fastest: a triangle where the
    /// velocity allows, else a trapezoid at full velocity with the ramps that are left.
    #[must_use]
    pub fn trapezoid_in(length: f64, limits: &KinematicLimits, duration: f64) -> Self {
        if 2.0 * length <= limits.velocity * duration {
            return Self::triangle(length, duration);
        }
        let cruise = length / limits.velocity;
        // Rounding alone may ask for a steeper ramp than is allowed, or for none.
        let ramp = (duration - cruise).clamp(0.0, 0.5 * duration);
        Self::symmetric(length, duration, ramp, limits.velocity)
    }

    /// The profile over `length` in `duration` seconds that never cruises; it has the least acceleration.
    pub(crate) fn triangle(length: f64, duration: f64) -> Self {
        let peak = if duration > 0.0 {
            2.0 * length / duration
        } else {
            0.0
        };
        Self::symmetric(length, duration, 0.5 * duration, peak)
    }

    fn symmetric(length: f64, duration: f64, ramp: f64, peak: f64) -> Self {
        Self {
            length,
            duration,
            entry: 0.0,
            peak,
            exit: 0.0,
            ramp_in: ramp,
            ramp_out: ramp,
        }
    }

    /// The fastest profile over `length` from one speed to another, neither of them negative.
    ///
    /// It cruises no faster than the limits allow, and slows down to that if it enters faster. Where `length` is too
    /// short to gain the exit speed, it exits with what it has gained; where it is too short to lose the excess, it
    /// brakes harder than the limits allow and still exits as asked.
    #[must_use]
    pub fn between(length: f64, entry: f64, exit: f64, limits: &KinematicLimits) -> Self {
        let KinematicLimits {
            velocity: cruise,
            acceleration,
        } = *limits;
        let gained = entry * entry + 2.0 * acceleration * length;
        let mut exit = exit.min(cruise);
        if exit * exit > gained {
            exit = libm::sqrt(gained);
        } else if entry * entry - exit * exit >= 2.0 * acceleration * length {
            return Self::braking(length, entry, exit);
        }
        let highest = libm::sqrt(acceleration * length + 0.5 * (entry * entry + exit * exit));
        let peak = highest.min(cruise);
        let ramp_in = libm::fabs(peak - entry) / acceleration;
        let ramp_out = (peak - exit).max(0.0) / acceleration;
        let ramped = 0.5 * ((entry + peak) * ramp_in + (peak + exit) * ramp_out);
        let cruising = if peak < highest {
            (length - ramped).max(0.0) / peak
        } else {
            0.0
        };
        Self {
            length,
            duration: ramp_in + cruising + ramp_out,
            entry,
            peak,
            exit,
            ramp_in,
            ramp_out,
        }
    }

    /// From a speed to rest at a steady deceleration.
    #[must_use]
    pub fn stopping(entry: f64, deceleration: f64) -> Self {
        Self::braking(0.5 * entry * entry / deceleration, entry, 0.0)
    }

    /// From a speed to rest in `duration` seconds.
    #[must_use]
    pub fn stopping_in(entry: f64, duration: f64) -> Self {
        Self {
            length: 0.5 * entry * duration,
            duration,
            entry,
            peak: entry,
            exit: 0.0,
            ramp_in: 0.0,
            ramp_out: duration,
        }
    }

    /// One ramp down over the whole length.
    fn braking(length: f64, entry: f64, exit: f64) -> Self {
        let duration = if entry > 0.0 {
            2.0 * length / (entry + exit)
        } else {
            0.0
        };
        Self {
            length,
            duration,
            entry,
            peak: entry,
            exit,
            ramp_in: 0.0,
            ramp_out: duration,
        }
    }

    /// The same way in `duration` seconds, no less than this profile takes, if it is from rest to rest; else this profile.
    ///
    /// A profile that cruises does so at the velocity allowed, and one that does not will not when given longer: so this is what
    /// [`trapezoid_in`](Self::trapezoid_in) gives for the limits that this one was made for.
    pub(crate) fn stretched(&self, duration: f64) -> Self {
        if self.entry > 0.0 || self.exit > 0.0 {
            return *self;
        }
        let limits = KinematicLimits {
            velocity: self.peak,
            acceleration: self.slope_out(),
        };
        Self::trapezoid_in(self.length, &limits, duration.max(self.duration))
    }

    /// The distance covered in all.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The time it takes, seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The speed at the end.
    #[must_use]
    pub fn exit(&self) -> f64 {
        self.exit
    }

    /// The times in seconds at which the acceleration changes between start and end.
    #[must_use]
    pub fn corners(&self) -> [f64; 2] {
        [self.ramp_in, self.duration - self.ramp_out]
    }

    /// The highest velocity and acceleration on the way.
    pub(crate) fn extremes(&self) -> (f64, f64) {
        let steepest = libm::fabs(self.slope_in()).max(self.slope_out());
        (self.entry.max(self.peak), steepest)
    }

    fn slope_in(&self) -> f64 {
        slope(self.peak - self.entry, self.ramp_in)
    }

    /// The deceleration towards the exit, positive.
    fn slope_out(&self) -> f64 {
        slope(self.peak - self.exit, self.ramp_out)
    }

    /// The distance covered after `t` seconds: 0 before the start, exactly the length from the end on.
    #[must_use]
    pub fn position(&self, t: f64) -> f64 {
        let left = self.duration - t;
        let position = if left <= 0.0 {
            return self.length;
        } else if t <= 0.0 {
            return 0.0;
        } else if t < self.ramp_in {
            t * (self.entry + 0.5 * self.slope_in() * t)
        } else if left < self.ramp_out {
            self.length - left * (self.exit + 0.5 * self.slope_out() * left)
        } else {
            0.5 * (self.entry + self.peak) * self.ramp_in + self.peak * (t - self.ramp_in)
        };
        position.clamp(0.0, self.length)
    }

    /// The velocity after `t` seconds: that of entry before the start, that of exit from the end on.
    #[must_use]
    pub fn velocity(&self, t: f64) -> f64 {
        let left = self.duration - t;
        if left <= 0.0 {
            self.exit
        } else if t <= 0.0 {
            self.entry
        } else if t < self.ramp_in {
            self.entry + self.slope_in() * t
        } else if left < self.ramp_out {
            self.exit + self.slope_out() * left
        } else {
            self.peak
        }
    }

    /// The acceleration after `t` seconds; where it jumps, the value that follows.
    #[must_use]
    pub fn acceleration(&self, t: f64) -> f64 {
        let left = self.duration - t;
        if t < 0.0 || left <= 0.0 {
            0.0
        } else if t < self.ramp_in {
            self.slope_in()
        } else if left <= self.ramp_out {
            -self.slope_out()
        } else {
            0.0
        }
    }

    /// When the axis has covered `distance`, seconds: the inverse of [`position`](Self::position).
    #[must_use]
    pub fn time_at(&self, distance: f64) -> f64 {
        let ramped_in = 0.5 * (self.entry + self.peak) * self.ramp_in;
        let ramped_out = 0.5 * (self.peak + self.exit) * self.ramp_out;
        let left = self.length - distance;
        if distance <= 0.0 {
            0.0
        } else if left <= 0.0 {
            self.duration
        } else if distance < ramped_in {
            ramp_time(distance, self.entry, self.slope_in())
        } else if left < ramped_out {
            self.duration - ramp_time(left, self.exit, self.slope_out())
        } else {
            self.ramp_in + (distance - ramped_in) / self.peak
        }
    }
}

fn slope(change: f64, ramp: f64) -> f64 {
    if ramp > 0.0 { change / ramp } else { 0.0 }
}

/// How long a ramp takes for a distance, by the root that loses no digits.
fn ramp_time(distance: f64, velocity: f64, acceleration: f64) -> f64 {
    let square = velocity * velocity + 2.0 * acceleration * distance;
    2.0 * distance / (velocity + libm::sqrt(square.max(0.0)))
}
