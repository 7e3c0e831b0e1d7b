//! Profiles of a controller that computes in periods: positions are sums of the speeds at the ends
//! of periods.

use super::{KinematicLimits, Piece, VelocityProfile, ramp_time};
use crate::law::{ended_periods, whole_periods};

/// Period numbers, counted from the start, at which the position curve changes its formula.
#[derive(Clone, Copy)]
pub(super) struct PeriodBreaks {
    /// 1 if the curve of the first ramp would start backwards (entry below 0), else 0.
    pub(super) started: f64,
    /// Last period of the first ramp, and the last period before its curve would run backwards.
    pub(super) ramped: [f64; 2],
    /// Last period of the cruise.
    pub(super) cruised: f64,
    /// Last period but one, and the last period before the curve of the second ramp would run
    /// backwards. In the very last period the axis goes straight to its target.
    pub(super) last: [f64; 2],
}

/// Profiles of a controller that computes in periods.
impl VelocityProfile {
    /// Converts a rest-to-rest profile to periods. It ends with the period in which the continuous
    /// one ends.
    pub(crate) fn in_periods(mut self, period: f64) -> Self {
        if period > 0.0 {
            self.period = period;
            self.duration = whole_periods(self.ends, period) * period;
        }
        self
    }

    /// Converts a stop to periods. Its length becomes the sum of the speeds.
    pub(crate) fn stop_in_periods(self, period: f64) -> Self {
        let mut stop = self.in_periods(period);
        if period > 0.0 {
            let PeriodBreaks {
                last: [last, _], ..
            } = stop.breaks();
            stop.length = stop.place(last).max(0.0);
        }
        stop
    }

    /// Returns the part of a stop that consists of whole periods without a change of sign, and the
    /// speed left after it.
    pub(crate) fn turn_in_periods(entry: f64, deceleration: f64, period: f64) -> (Self, f64) {
        let step = deceleration * period;
        let count = ended_periods(entry / deceleration, period);
        let left = (entry - step * count).max(0.0);
        let duration = count * period;
        let mut turn = Self {
            length: 0.0,
            duration,
            entry,
            peak: left,
            exit: left,
            ramp_in: duration,
            ramp_out: 0.0,
            period,
            ends: duration,
        };
        turn.length = period * count * (entry - 0.5 * step * (count + 1.0));
        turn.length = turn.length.max(0.0);
        (turn, left)
    }

    /// Returns a ramp from `entry` to the velocity limit, which is held until `length` is covered.
    pub(crate) fn run_in_periods(
        length: f64,
        entry: f64,
        limits: &KinematicLimits,
        period: f64,
    ) -> Self {
        let KinematicLimits {
            velocity,
            acceleration,
        } = *limits;
        let ramp_in = libm::fabs(velocity - entry) / acceleration;
        let mut run = Self {
            length,
            duration: f64::INFINITY,
            entry,
            peak: velocity,
            exit: velocity,
            ramp_in,
            ramp_out: 0.0,
            period,
            ends: f64::INFINITY,
        };
        let duration = whole_periods(run.summed_time_at(length), period) * period;
        run.duration = duration;
        run.ends = duration;
        run
    }

    pub(super) fn breaks(&self) -> PeriodBreaks {
        let last = whole_periods(self.duration, self.period) - 1.0;
        let cruised = ended_periods(self.ends - self.ramp_out, self.period).min(last);
        let ramped = ended_periods(self.ramp_in, self.period).min(cruised);
        let [gain_in, gain_out] = self.gains();
        // The curve runs half a gain ahead of the speed. Close to standstill it would therefore run
        // backwards, so the last period of such a ramp becomes a straight line.
        let curve_end = |is_slow: bool, step: f64, since: f64| {
            if is_slow {
                (step - 1.0).max(since)
            } else {
                step
            }
        };
        let slow_in = self.entry + gain_in * (ramped + 0.5) < 0.0;
        let slow_out = self.ramp_out_entry(cruised) - gain_out * (last - cruised + 0.5) < 0.0;
        PeriodBreaks {
            started: if self.entry < 0.0 { 1.0 } else { 0.0 },
            ramped: [ramped, curve_end(slow_in, ramped, 0.0)],
            cruised,
            last: [last, curve_end(slow_out, last, cruised)],
        }
    }

    /// Change of speed per period on the first ramp and on the second.
    fn gains(&self) -> [f64; 2] {
        [
            self.slope_in() * self.period,
            self.slope_out() * self.period,
        ]
    }

    /// Speed of the second ramp, extrapolated to the end of the cruise.
    fn ramp_out_entry(&self, cruised: f64) -> f64 {
        self.exit + self.slope_out() * (self.ends - cruised * self.period)
    }

    /// Speed during period number `step`.
    pub(super) fn step_velocity(&self, step: f64) -> f64 {
        let PeriodBreaks {
            ramped: [ramped, _],
            cruised,
            ..
        } = self.breaks();
        let [gain_in, gain_out] = self.gains();
        if step <= 0.0 {
            self.entry
        } else if step <= ramped {
            self.entry + gain_in * step
        } else if step <= cruised {
            self.peak
        } else {
            (self.ramp_out_entry(cruised) - gain_out * (step - cruised)).max(self.exit)
        }
    }

    /// Position at the end of period `step`, which must not be the last one.
    pub(super) fn place(&self, step: f64) -> f64 {
        let PeriodBreaks {
            ramped: [ramped, _],
            cruised,
            ..
        } = self.breaks();
        let [gain_in, gain_out] = self.gains();
        let on_ramp_in = |n: f64| n * (self.entry + 0.5 * gain_in * (n + 1.0));
        let on_ramp_out = |n: f64| n * (self.ramp_out_entry(cruised) - 0.5 * gain_out * (n + 1.0));
        let sum = if step <= ramped {
            on_ramp_in(step)
        } else if step <= cruised {
            on_ramp_in(ramped) + self.peak * (step - ramped)
        } else {
            on_ramp_in(ramped) + self.peak * (cruised - ramped) + on_ramp_out(step - cruised)
        };
        self.period * sum
    }

    /// Piece of the position curve at `step` periods after the start.
    pub(super) fn summed_piece(&self, step: f64) -> Piece {
        let PeriodBreaks {
            started,
            ramped: [ramped, curve_end_in],
            cruised,
            last: [last, curve_end_out],
        } = self.breaks();
        let period = self.period;
        let [gain_in, gain_out] = self.gains();
        let straight = |from: f64, to: f64, count: f64| Piece {
            from: from * period,
            place: self.place(from),
            velocity: (to - self.place(from)) / (count * period),
            acceleration: 0.0,
        };
        if step >= last {
            straight(last, self.length, 1.0)
        } else if step < started {
            straight(0.0, self.place(1.0), 1.0)
        } else if step < curve_end_in {
            Piece {
                from: 0.0,
                place: 0.0,
                velocity: self.entry + 0.5 * gain_in,
                acceleration: self.slope_in(),
            }
        } else if step < ramped {
            straight(curve_end_in, self.place(ramped), 1.0)
        } else if step < cruised {
            straight(ramped, self.place(ramped) + self.peak * period, 1.0)
        } else if step < curve_end_out {
            Piece {
                from: cruised * period,
                place: self.place(cruised),
                velocity: self.ramp_out_entry(cruised) - 0.5 * gain_out,
                acceleration: -self.slope_out(),
            }
        } else {
            straight(curve_end_out, self.place(last), last - curve_end_out)
        }
    }

    /// Time at which the curve reaches a distance between 0 and the length, both exclusive.
    pub(super) fn summed_time_at(&self, distance: f64) -> f64 {
        let PeriodBreaks {
            started,
            ramped: [ramped, curve_end_in],
            cruised,
            last: [last, curve_end_out],
        } = self.breaks();
        // Ends of the pieces in order. A piece is looked up by the period number in its middle.
        let ends = [started, curve_end_in, ramped, cruised, curve_end_out, last];
        let mut from = 0.0;
        let mut within = last;
        for to in ends {
            if to > from && distance <= self.place(to) {
                within = if to.is_finite() {
                    0.5 * (from + to)
                } else {
                    from
                };
                break;
            }
            from = to.max(from);
        }
        let piece = self.summed_piece(within);
        piece.from + ramp_time(distance - piece.place, piece.velocity, piece.acceleration)
    }

    /// Changes the duration of a path segment and keeps its entry and exit speeds.
    ///
    /// A longer duration lowers the peak, if necessary below the speeds at the ends; a shorter one
    /// raises the peak.
    pub(crate) fn lasting(self, duration: f64, acceleration: f64) -> Self {
        if duration < self.duration {
            self.shortened_to(duration)
        } else {
            self.slowed_to(duration, acceleration)
        }
    }

    /// Shortens the profile. All parts shrink by the same factor, and the peak rises to cover the
    /// length.
    fn shortened_to(self, duration: f64) -> Self {
        let factor = duration / self.duration;
        let (ramp_in, ramp_out) = (factor * self.ramp_in, factor * self.ramp_out);
        let at_peak = duration - 0.5 * (ramp_in + ramp_out);
        let on_ramps = 0.5 * (self.entry * ramp_in + self.exit * ramp_out);
        Self {
            duration,
            peak: (self.length - on_ramps) / at_peak,
            ramp_in,
            ramp_out,
            ends: duration,
            ..self
        }
    }

    fn slowed_to(self, duration: f64, acceleration: f64) -> Self {
        let (length, entry, exit) = (self.length, self.entry, self.exit);
        if duration <= self.duration {
            return self;
        }
        let (high, low) = (entry.max(exit), entry.min(exit));
        let squares = entry * entry + exit * exit;
        let rise = acceleration * duration + entry + exit;
        let root = |b: f64, c: f64| b - libm::sqrt((b * b - c).max(0.0));
        // Up to a peak p and down again, with acceleration a and length L:
        // p^2 - rise p + (a L + squares / 2) = 0.
        let mut peak = root(0.5 * rise, acceleration * length + 0.5 * squares);
        if peak < high {
            // A single ramp with a stretch of constant speed.
            let ramp = (high - low) / acceleration;
            if ramp >= duration {
                return self.at_constant_speed(duration);
            }
            peak = (length - 0.5 * (high + low) * ramp) / (duration - ramp);
        }
        if peak < low {
            // Down to a speed p below both, with duration D:
            // p^2 + (a D - entry - exit) p - (a L - squares / 2) = 0.
            let fall = 0.5 * (acceleration * duration - entry - exit);
            let rest = acceleration * length - 0.5 * squares;
            // NaN if the acceleration is too low for this shape.
            peak = libm::sqrt(fall * fall + rest) - fall;
            if !(0.0..=low).contains(&peak) || peak == 0.0 {
                return self.at_constant_speed(duration);
            }
        }
        Self {
            duration,
            peak,
            ramp_in: libm::fabs(peak - entry) / acceleration,
            ramp_out: libm::fabs(peak - exit) / acceleration,
            ends: duration,
            ..self
        }
    }

    /// Returns a profile of constant speed over the same length.
    fn at_constant_speed(self, duration: f64) -> Self {
        Self {
            duration,
            peak: self.length / duration,
            ramp_in: 0.0,
            ramp_out: 0.0,
            ends: duration,
            ..self
        }
    }
}
