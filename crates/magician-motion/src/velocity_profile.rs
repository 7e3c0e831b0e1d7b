//! Velocity profiles of one axis: rest to rest, between two speeds, or braking to rest (model
//! sections 7, 8, 10 and 14).
//!
//! In continuous time a profile is a trapezoid of velocity, and the position is its integral. A
//! real controller computes in periods instead: in each period it moves by the speed at the end of
//! that period times the period, and the last period ends exactly on the target. The position after
//! `n` periods is then a sum of speeds, which is quadratic in `n` on a ramp and linear elsewhere.
//!
//! So one continuous function of time, the position curve, passes through all reported positions.
//! It has at most seven pieces. Searches for limits and fences run on that curve, because it has
//! closed-form roots; reported positions are its values at the ends of periods. Nothing is
//! accumulated from period to period.

mod periods;

use periods::PeriodBreaks;

use crate::law::ended_periods;

/// Highest velocity and acceleration of an axis, in its own unit per second and per second squared.
/// Both are positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KinematicLimits {
    /// Highest velocity.
    pub velocity: f64,
    /// Highest acceleration.
    pub acceleration: f64,
}

impl KinematicLimits {
    /// Shortest time for `length` from rest to rest, seconds.
    #[must_use]
    pub fn least_time(&self, length: f64) -> f64 {
        let Self {
            velocity,
            acceleration,
        } = *self;
        // Longer than both full ramps together: there is a cruise in between.
        if length * acceleration > velocity * velocity {
            length / velocity + velocity / acceleration
        } else {
            2.0 * libm::sqrt(length / acceleration)
        }
    }
}

/// A trapezoid of velocity: ramp from the entry speed to the peak, cruise, ramp to the exit speed.
///
/// There is no jerk limit, the velocity is never negative, and every value is a closed form of
/// time. A motion that reverses needs a second profile for the way back.
/// [`MotionLaw`](crate::MotionLaw) makes the profiles of a controller that computes in periods.
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
    /// Period of the controller, seconds; 0 in continuous time.
    period: f64,
    /// End of the ramp to the exit speed in continuous time, seconds. In periods `duration` is up
    /// to one period later.
    ends: f64,
}

/// A piece of the position curve with constant acceleration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Start time of the piece, seconds.
    from: f64,
    place: f64,
    velocity: f64,
    acceleration: f64,
}

impl Piece {
    pub(crate) fn position(&self, t: f64) -> f64 {
        let t = t - self.from;
        self.place + t * (self.velocity + 0.5 * self.acceleration * t)
    }

    pub(crate) fn velocity(&self, t: f64) -> f64 {
        self.velocity + self.acceleration * (t - self.from)
    }

    pub(crate) fn acceleration(&self) -> f64 {
        self.acceleration
    }
}

impl VelocityProfile {
    /// Returns the fastest profile over `length` from rest to rest.
    #[must_use]
    pub fn trapezoid(length: f64, limits: &KinematicLimits) -> Self {
        Self::trapezoid_in(length, limits, limits.least_time(length))
    }

    /// Returns the profile over `length` from rest to rest in `duration` seconds, which must not be
    /// shorter than the fastest.
    ///
    /// The profile is a triangle if that stays below the velocity limit, else a trapezoid at full
    /// velocity with the ramps that fit.
    #[must_use]
    pub(crate) fn trapezoid_in(length: f64, limits: &KinematicLimits, duration: f64) -> Self {
        if 2.0 * length <= limits.velocity * duration {
            return Self::triangle(length, duration);
        }
        let cruise = length / limits.velocity;
        // Rounding may yield a ramp slightly longer than half the duration, or slightly below 0.
        let ramp = (duration - cruise).clamp(0.0, 0.5 * duration);
        Self::symmetric(length, duration, ramp, limits.velocity)
    }

    /// Returns the profile over `length` in `duration` seconds without a cruise: the lowest peak
    /// acceleration.
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
            period: 0.0,
            ends: duration,
        }
    }

    /// Returns the fastest profile over `length` between two speeds, neither of them negative.
    ///
    /// The profile slows down to the velocity limit if it enters faster. If `length` is too short
    /// to reach the exit speed, it exits with the speed that it has reached. If `length` is too
    /// short to brake, it brakes harder than the acceleration limit and still exits at the exit
    /// speed.
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
        // Too short to brake within the limit. A path that has just been shortened must still end
        // at its corner speed, so the acceleration limit gives way.
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
            period: 0.0,
            ends: ramp_in + cruising + ramp_out,
        }
    }

    /// Returns the profile from a speed to rest at a constant deceleration.
    #[must_use]
    pub fn stopping(entry: f64, deceleration: f64) -> Self {
        Self::braking(0.5 * entry * entry / deceleration, entry, 0.0)
    }

    /// Returns the profile from a speed to rest in `duration` seconds.
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
            period: 0.0,
            ends: duration,
        }
    }

    /// Returns a single ramp down over the whole length.
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
            period: 0.0,
            ends: duration,
        }
    }

    /// Stretches a rest-to-rest profile to `duration` seconds, at least its present duration. Any
    /// other profile is returned unchanged.
    ///
    /// The limits of the original need not be known: a profile that cruises does so at its velocity
    /// limit, and a profile without a cruise stays without one.
    pub(crate) fn stretched(&self, duration: f64) -> Self {
        if self.entry > 0.0 || self.exit > 0.0 {
            return *self;
        }
        let limits = KinematicLimits {
            velocity: self.peak,
            acceleration: self.slope_out(),
        };
        Self::trapezoid_in(self.length, &limits, duration.max(self.ends)).in_periods(self.period)
    }

    /// Distance covered by the whole profile.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Duration, seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Speed at the end.
    #[must_use]
    pub fn exit(&self) -> f64 {
        self.exit
    }

    /// Times at which the acceleration of the position curve changes, seconds, between start and
    /// end.
    ///
    /// In periods the velocity of the curve jumps there as well. Unused entries are NaN.
    #[must_use]
    pub fn corners(&self) -> [f64; CORNERS] {
        if self.period == 0.0 {
            let mut corners = [f64::NAN; CORNERS];
            let [first, second, ..] = &mut corners;
            (*first, *second) = (self.ramp_in, self.ends - self.ramp_out);
            return corners;
        }
        let PeriodBreaks {
            started,
            ramped: [ramped, curve_end_in],
            cruised,
            last: [last, curve_end_out],
        } = self.breaks();
        [started, curve_end_in, ramped, cruised, curve_end_out, last].map(|step| step * self.period)
    }

    /// Highest velocity and steepest acceleration of the profile.
    pub(crate) fn extremes(&self) -> (f64, f64) {
        let steepest = libm::fabs(self.slope_in()).max(self.slope_out());
        (self.entry.max(self.peak), steepest)
    }

    /// Highest speed in any period. The last period counts too: it may have to cover more than the
    /// ramp would.
    pub(crate) fn highest_speed(&self) -> f64 {
        if self.period == 0.0 {
            return self.extremes().0;
        }
        let PeriodBreaks {
            ramped: [ramped, _],
            cruised,
            last: [last, _],
            ..
        } = self.breaks();
        let ending = (self.length - self.place(last)) / self.period;
        [0.0, ramped, cruised, (cruised + 1.0).min(last)]
            .into_iter()
            .map(|step| self.step_velocity(step))
            .fold(ending, f64::max)
    }

    /// Highest velocity and acceleration of the position curve, whose ramps run half a period ahead
    /// of the speeds.
    pub(crate) fn curve_extremes(&self) -> (f64, f64) {
        let (velocity, acceleration) = self.extremes();
        (velocity + 0.5 * acceleration * self.period, acceleration)
    }

    fn slope_in(&self) -> f64 {
        slope(self.peak - self.entry, self.ramp_in)
    }

    /// The deceleration towards the exit, positive.
    fn slope_out(&self) -> f64 {
        slope(self.peak - self.exit, self.ramp_out)
    }

    /// Distance covered after `t` seconds: 0 before the start, exactly the length from the end on.
    #[must_use]
    pub fn position(&self, t: f64) -> f64 {
        let left = self.duration - t;
        let position = if left <= 0.0 {
            return self.length;
        } else if t <= 0.0 {
            return 0.0;
        } else if self.period > 0.0 {
            self.piece(t).position(t)
        } else if t < self.ramp_in {
            t * (self.entry + 0.5 * self.slope_in() * t)
        } else if left < self.ramp_out {
            self.length - left * (self.exit + 0.5 * self.slope_out() * left)
        } else {
            0.5 * (self.entry + self.peak) * self.ramp_in + self.peak * (t - self.ramp_in)
        };
        position.clamp(0.0, self.length)
    }

    /// Velocity after `t` seconds: the entry speed before the start, the exit speed from the end
    /// on. In periods it is the speed of the period that ended last.
    #[must_use]
    pub fn velocity(&self, t: f64) -> f64 {
        let left = self.duration - t;
        if left <= 0.0 {
            self.exit
        } else if t <= 0.0 {
            self.entry
        } else if self.period > 0.0 {
            self.step_velocity(ended_periods(t, self.period))
        } else if t < self.ramp_in {
            self.entry + self.slope_in() * t
        } else if left < self.ramp_out {
            self.exit + self.slope_out() * left
        } else {
            self.peak
        }
    }

    /// Acceleration of the position curve after `t` seconds. Where it jumps, the value after the
    /// jump.
    #[must_use]
    pub fn acceleration(&self, t: f64) -> f64 {
        self.piece(t).acceleration()
    }

    /// Piece of the position curve at `t` seconds, valid between the two neighbouring
    /// [`corners`](Self::corners). Outside of the profile nothing moves.
    pub(crate) fn piece(&self, t: f64) -> Piece {
        let resting = |place| Piece {
            from: t,
            place,
            velocity: 0.0,
            acceleration: 0.0,
        };
        if t < 0.0 {
            resting(0.0)
        } else if t >= self.duration {
            resting(self.length)
        } else if self.period > 0.0 {
            self.summed_piece(t / self.period)
        } else if t < self.ramp_in {
            Piece {
                from: 0.0,
                place: 0.0,
                velocity: self.entry,
                acceleration: self.slope_in(),
            }
        } else if self.duration - t <= self.ramp_out {
            Piece {
                from: self.duration,
                place: self.length,
                velocity: self.exit,
                acceleration: -self.slope_out(),
            }
        } else {
            Piece {
                from: self.ramp_in,
                place: 0.5 * (self.entry + self.peak) * self.ramp_in,
                velocity: self.peak,
                acceleration: 0.0,
            }
        }
    }

    /// Time at which the axis has covered `distance`, seconds: the inverse of
    /// [`position`](Self::position).
    #[must_use]
    pub fn time_at(&self, distance: f64) -> f64 {
        let left = self.length - distance;
        if distance <= 0.0 {
            return 0.0;
        } else if left <= 0.0 {
            return self.duration;
        } else if self.period > 0.0 {
            return self.summed_time_at(distance);
        }
        let ramped_in = 0.5 * (self.entry + self.peak) * self.ramp_in;
        let ramped_out = 0.5 * (self.peak + self.exit) * self.ramp_out;
        if distance < ramped_in {
            ramp_time(distance, self.entry, self.slope_in())
        } else if left < ramped_out {
            self.duration - ramp_time(left, self.exit, self.slope_out())
        } else {
            self.ramp_in + (distance - ramped_in) / self.peak
        }
    }
}

/// Number of corners of a profile in periods; continuous profiles use two of them.
pub(crate) const CORNERS: usize = 6;

fn slope(change: f64, ramp: f64) -> f64 {
    if ramp > 0.0 { change / ramp } else { 0.0 }
}

/// Time that a ramp needs for a distance. This form of the root does not cancel.
fn ramp_time(distance: f64, velocity: f64, acceleration: f64) -> f64 {
    let square = velocity * velocity + 2.0 * acceleration * distance;
    2.0 * distance / (velocity + libm::sqrt(square.max(0.0)))
}
