//! The velocity profile of one axis: distance as a function of time (model section 7).

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

/// A symmetric trapezoid of velocity, from rest to rest: ramp up, cruise, ramp down, without a jerk limit.
///
/// Everything is a closed form of time; nothing is accumulated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trapezoid {
    length: f64,
    duration: f64,
    ramp: f64,
    peak: f64,
}

impl Trapezoid {
    /// The fastest profile over `length`.
    #[must_use]
    pub fn fastest(length: f64, rates: &KinematicLimits) -> Self {
        Self::lasting(length, rates, rates.least_time(length))
    }

    /// The profile over `length` that takes `duration` seconds, no less than the fastest: a triangle where the velocity
    /// allows, else a trapezoid at full velocity with the ramps that are left.
    #[must_use]
    pub fn lasting(length: f64, rates: &KinematicLimits, duration: f64) -> Self {
        if 2.0 * length <= rates.velocity * duration {
            return Self::triangle(length, duration);
        }
        let cruise = length / rates.velocity;
        Self {
            length,
            duration,
            // Rounding alone may ask for a steeper ramp than is allowed, or for none.
            ramp: (duration - cruise).clamp(0.0, 0.5 * duration),
            peak: rates.velocity,
        }
    }

    /// The same way in `duration` seconds, no less than this profile takes: what [`lasting`](Self::lasting) gives for the
    /// rates that this profile was made for.
    ///
    /// A profile that cruises does so at the velocity allowed, and one that does not will not when given longer.
    pub(crate) fn stretched(&self, duration: f64) -> Self {
        let rates = KinematicLimits {
            velocity: self.peak,
            acceleration: self.slope(),
        };
        Self::lasting(self.length, &rates, duration.max(self.duration))
    }

    /// The profile over `length` in `duration` seconds that never cruises; it has the least acceleration.
    pub(crate) fn triangle(length: f64, duration: f64) -> Self {
        Self {
            length,
            duration,
            ramp: 0.5 * duration,
            peak: if duration > 0.0 {
                2.0 * length / duration
            } else {
                0.0
            },
        }
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

    /// The times in seconds at which the acceleration changes between start and end.
    #[must_use]
    pub fn corners(&self) -> [f64; 2] {
        [self.ramp, self.duration - self.ramp]
    }

    /// The highest velocity and acceleration on the way.
    pub(crate) fn extremes(&self) -> (f64, f64) {
        (self.peak, self.slope())
    }

    fn slope(&self) -> f64 {
        if self.ramp > 0.0 {
            self.peak / self.ramp
        } else {
            0.0
        }
    }

    /// The distance covered after `t` seconds: 0 before the start, exactly the length from the end on.
    #[must_use]
    pub fn position(&self, t: f64) -> f64 {
        let left = self.duration - t;
        let position = if left <= 0.0 {
            return self.length;
        } else if t <= 0.0 {
            return 0.0;
        } else if t < self.ramp {
            0.5 * self.slope() * t * t
        } else if left < self.ramp {
            self.length - 0.5 * self.slope() * left * left
        } else {
            self.peak * (t - 0.5 * self.ramp)
        };
        position.clamp(0.0, self.length)
    }

    /// The velocity after `t` seconds.
    #[must_use]
    pub fn velocity(&self, t: f64) -> f64 {
        let left = self.duration - t;
        if t <= 0.0 || left <= 0.0 {
            0.0
        } else if t < self.ramp {
            self.slope() * t
        } else if left < self.ramp {
            self.slope() * left
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
        } else if t < self.ramp {
            self.slope()
        } else if left <= self.ramp {
            -self.slope()
        } else {
            0.0
        }
    }

    /// When the axis has covered `distance`, seconds: the inverse of [`position`](Self::position).
    #[must_use]
    pub fn time_at(&self, distance: f64) -> f64 {
        let ramped = 0.5 * self.peak * self.ramp;
        let left = self.length - distance;
        if distance <= 0.0 {
            0.0
        } else if left <= 0.0 {
            self.duration
        } else if distance < ramped {
            libm::sqrt(2.0 * distance / self.slope())
        } else if left < ramped {
            self.duration - libm::sqrt(2.0 * left / self.slope())
        } else {
            0.5 * self.ramp + distance / self.peak
        }
    }
}

/// A velocity that falls to zero at a steady rate, never below: the profile of an emergency stop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Braking {
    velocity: f64,
    duration: f64,
}

impl Braking {
    /// From `velocity`, of either sign, to rest in `duration` seconds.
    #[must_use]
    pub fn lasting(velocity: f64, duration: f64) -> Self {
        Self { velocity, duration }
    }

    /// The time it takes, seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The way gone after `t` seconds, with the sign of the velocity.
    #[must_use]
    pub fn position(&self, t: f64) -> f64 {
        if self.duration > 0.0 {
            let t = t.clamp(0.0, self.duration);
            self.velocity * t * (1.0 - 0.5 * t / self.duration)
        } else {
            0.0
        }
    }

    /// The velocity after `t` seconds.
    #[must_use]
    pub fn velocity(&self, t: f64) -> f64 {
        if t < self.duration {
            self.velocity * (1.0 - t.max(0.0) / self.duration)
        } else {
            0.0
        }
    }

    /// The acceleration after `t` seconds; where it jumps, the value that follows.
    #[must_use]
    pub fn acceleration(&self, t: f64) -> f64 {
        if (0.0..self.duration).contains(&t) {
            -self.velocity / self.duration
        } else {
            0.0
        }
    }
}
