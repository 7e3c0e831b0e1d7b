//! The carriage on the rail (model sections 10 and 12): it moves with the arm, alone, or by jogs.

use magician_model::MotionSettings;
use magician_motion::{AxisMotion, KinematicLimits, MotionLaw};

use crate::Micros;

/// Shortest way on the rail, mm. A shorter one takes no time, as for moves of the arm.
const SHORTEST: f64 = 1e-4;

/// The carriage at rest, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rail {
    /// Commanded position.
    pub(super) rest: f64,
    /// Offset of the true position: the controller reads 0 wherever the carriage was at power-up
    /// (model section 12).
    pub(super) slip: f64,
    /// Length of the rail.
    pub(super) length: f64,
}

impl Rail {
    pub(super) fn new(length: f64) -> Self {
        Self {
            rest: 0.0,
            slip: 0.0,
            length,
        }
    }

    /// True position for a commanded one. The ends of the rail stop the carriage.
    pub(super) fn true_place(&self, commanded: f64) -> f64 {
        (commanded + self.slip).clamp(0.0, self.length)
    }
}

/// Path of the carriage as a function of time: it slows down from its present speed, then goes from
/// rest to rest. Either part may be empty. Times are from the start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RailPath {
    law: MotionLaw,
    from: f64,
    slowing: AxisMotion,
    /// Position between the two parts.
    turn: f64,
    going: AxisMotion,
    end: f64,
    duration: Micros,
}

/// Converts seconds to whole microseconds, rounded up. A rounding error does not add one.
fn microseconds(seconds: f64) -> Micros {
    (seconds * 1e6 - 1e-3).ceil() as Micros
}

fn seconds(microseconds: Micros) -> f64 {
    microseconds as f64 / 1e6
}

impl RailPath {
    /// A path of no length: the carriage stays.
    pub(crate) fn standing(at: f64) -> Self {
        Self {
            law: MotionLaw::CONTINUOUS,
            from: at,
            slowing: AxisMotion::at_rest(),
            turn: at,
            going: AxisMotion::at_rest(),
            end: at,
            duration: 0,
        }
    }

    /// Path from rest to rest at these rates; a way shorter than [`SHORTEST`] takes no time. `None`
    /// if the rates are needed and invalid.
    pub(super) fn to_place(
        law: MotionLaw,
        from: f64,
        to: f64,
        rates: Option<KinematicLimits>,
    ) -> Option<Self> {
        if (to - from).abs() < SHORTEST {
            return Some(Self::standing(to));
        }
        Some(Self::going(law, from, to, &rates?, 0))
    }

    /// Path from rest to rest in at least `least`.
    fn going(law: MotionLaw, from: f64, to: f64, rates: &KinematicLimits, least: Micros) -> Self {
        let length = (to - from).abs();
        if length < SHORTEST {
            return Self::standing(to);
        }
        let lasting = microseconds(rates.least_time(length)).max(least);
        let profile = law.rest_to_rest_in(length, rates, seconds(lasting));
        Self {
            law,
            going: AxisMotion::new(to - from, profile),
            end: to,
            duration: microseconds(profile.duration()),
            ..Self::standing(from)
        }
    }

    /// Path to rest at a deceleration, or harder if the rail ends before. An infinite
    /// deceleration stops at once.
    pub(super) fn slowing(
        law: MotionLaw,
        from: f64,
        velocity: f64,
        deceleration: f64,
        length: f64,
    ) -> Self {
        let room = if velocity < 0.0 { from } else { length - from };
        let speed = velocity.abs();
        // At most the time in which a ramp to rest covers `room`.
        let lasting = (speed / deceleration).min(2.0 * room.max(0.0) / speed);
        if !(lasting > 0.0 && lasting.is_finite()) {
            return Self::standing(from);
        }
        let slowing = AxisMotion::stopping_in(law, velocity, lasting);
        let end = (from + slowing.offset(slowing.duration())).clamp(0.0, length);
        Self {
            law,
            slowing,
            turn: end,
            end,
            duration: microseconds(slowing.duration()),
            ..Self::standing(from)
        }
    }

    /// Appends a way to `to`.
    pub(super) fn then_going(self, law: MotionLaw, to: f64, rates: &KinematicLimits) -> Self {
        let on = Self::going(law, self.end, to, rates, 0);
        Self {
            law,
            going: on.going,
            end: on.end,
            duration: self.duration.saturating_add(on.duration),
            ..self
        }
    }

    /// Cuts the path at a time.
    fn cut(self, at: Micros) -> Self {
        Self {
            end: self.sample(at),
            duration: self.duration.min(at),
            ..self
        }
    }

    pub(super) fn duration(&self) -> Micros {
        self.duration
    }

    pub(super) fn end(&self) -> f64 {
        self.end
    }

    /// Time since the second part began; `None` during the first.
    fn going_since(&self, t: Micros) -> Option<f64> {
        let slowing = microseconds(self.slowing.duration());
        t.checked_sub(slowing).map(seconds)
    }

    /// Position at a time, as of the last period. From the end on exactly the target.
    pub(super) fn sample(&self, t: Micros) -> f64 {
        self.curve(self.law.period_start(t))
    }

    /// Position of the motor between the ends of two periods.
    pub(super) fn curve(&self, t: Micros) -> f64 {
        if t >= self.duration {
            return self.end;
        }
        match self.going_since(t) {
            Some(since) => self.turn + self.going.offset(since),
            None => self.from + self.slowing.offset(seconds(t)),
        }
    }

    /// Velocity at a time, mm/s, signed.
    pub(super) fn velocity(&self, t: Micros) -> f64 {
        if t >= self.duration {
            return 0.0;
        }
        match self.going_since(t) {
            Some(since) => self.going.velocity(since),
            None => self.slowing.velocity(seconds(t)),
        }
    }

    /// Direction of the second part; 0 if the carriage only comes to rest.
    pub(super) fn heading(&self) -> f64 {
        if self.going.profile().length() > 0.0 {
            self.going.sign()
        } else {
            0.0
        }
    }

    /// Time at which a share of a path from rest is done; `None` if the path is cut before.
    pub(super) fn time_at_progress(&self, share: f64) -> Option<Micros> {
        let going = self.going.profile();
        let at = microseconds(going.time_at(share.clamp(0.0, 1.0) * going.length()));
        let at = self.law.period_end(at);
        (at <= self.duration).then_some(at)
    }
}

impl RailPath {
    /// Path home, to the end of the rail at 0.
    pub(super) fn home(law: MotionLaw, from: f64, rules: &magician_motion::Rail) -> Self {
        let rates = KinematicLimits {
            velocity: rules.home_velocity,
            acceleration: rules.home_acceleration,
        };
        Self::going(law, from, 0.0, &rates, 0)
    }

    /// Stretches the path to the duration of the arm's motion (model section 7: the longer of both
    /// counts).
    pub(super) fn along(self, arm: Micros, settings: &MotionSettings) -> Self {
        match settings.rail() {
            Some(rates) if self.duration > 0 && arm > self.duration => {
                Self::going(self.law, self.from, self.end, &rates, arm)
            }
            // The carriage stands or is the slower one: the arm was stretched to it instead.
            _ => self,
        }
    }

    /// Stops the carriage together with the arm.
    pub(super) fn stopped_with(self, arm: Option<Micros>) -> Self {
        arm.map_or(self, |at| self.cut(at))
    }
}
