//! The carriage on the rail (model sections 10 and 12): it moves with the arm, alone, or is jogged.

use magician_model::MotionSettings;
use magician_motion::{AxisMotion, KinematicLimits, MotionLaw};

use crate::Micros;

/// A way on the rail shorter than this takes no time, mm; the arm's moves have the same.
const SHORTEST: f64 = 1e-4;

/// The carriage when nothing moves it, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rail {
    /// Where it is commanded to be.
    pub(super) rest: f64,
    /// By how much it really stands elsewhere: it is 0 wherever power found it (model section 12).
    pub(super) slip: f64,
    /// How long the rail is.
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

    /// Where the carriage really is when it is commanded to be there; the ends of the rail hold it.
    pub(super) fn true_place(&self, commanded: f64) -> f64 {
        (commanded + self.slip).clamp(0.0, self.length)
    }
}

/// A way of the carriage as a function of time: what speed it has falls to rest, then it goes on
/// from rest to rest. Either part may be missing. Times are from the start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RailPath {
    law: MotionLaw,
    from: f64,
    slowing: AxisMotion,
    /// Where it turns from slowing to going.
    turn: f64,
    going: AxisMotion,
    end: f64,
    duration: Micros,
}

/// Whole microseconds that hold so many seconds; a rounding error does not cost one.
fn microseconds(seconds: f64) -> Micros {
    (seconds * 1e6 - 1e-3).ceil() as Micros
}

fn seconds(microseconds: Micros) -> f64 {
    microseconds as f64 / 1e6
}

impl RailPath {
    /// No way: the carriage stays where it is.
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

    /// From rest to rest at the rates; a way shorter than [`SHORTEST`] takes no time.
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

    /// From rest to rest in no less than `least`.
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

    /// To rest at a deceleration, or harder where the rail ends before; at no deceleration it stops
    /// dead.
    pub(super) fn slowing(
        law: MotionLaw,
        from: f64,
        velocity: f64,
        deceleration: f64,
        length: f64,
    ) -> Self {
        let room = if velocity < 0.0 { from } else { length - from };
        let speed = velocity.abs();
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

    /// The same, and then on to `to`.
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

    /// The same, stopped dead at a time.
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

    /// Time since it goes, and whether it does.
    fn going_since(&self, t: Micros) -> Option<f64> {
        let slowing = microseconds(self.slowing.duration());
        t.checked_sub(slowing).map(seconds)
    }

    /// Where the carriage is at a time; from the end on exactly where it was to go.
    pub(super) fn sample(&self, t: Micros) -> f64 {
        self.curve(self.law.period_start(t))
    }

    /// Where its motor takes it between the ends of two periods.
    pub(super) fn curve(&self, t: Micros) -> f64 {
        if t >= self.duration {
            return self.end;
        }
        match self.going_since(t) {
            Some(since) => self.turn + self.going.offset(since),
            None => self.from + self.slowing.offset(seconds(t)),
        }
    }

    /// How fast it moves at a time, mm/s, with its sign.
    pub(super) fn velocity(&self, t: Micros) -> f64 {
        if t >= self.duration {
            return 0.0;
        }
        match self.going_since(t) {
            Some(since) => self.going.velocity(since),
            None => self.slowing.velocity(seconds(t)),
        }
    }

    /// The direction that it goes in or will, once it has slowed down; 0 if it only comes to rest.
    pub(super) fn heading(&self) -> f64 {
        if self.going.profile().length() > 0.0 {
            self.going.sign()
        } else {
            0.0
        }
    }

    /// When a share of the way is done, of one from rest; never if it ends before.
    pub(super) fn time_at_progress(&self, share: f64) -> Option<Micros> {
        let going = self.going.profile();
        let at = microseconds(going.time_at(share.clamp(0.0, 1.0) * going.length()));
        let at = self.law.period_end(at);
        (at <= self.duration).then_some(at)
    }
}

impl RailPath {
    /// Home, to the end of the rail where it is 0.
    pub(super) fn home(law: MotionLaw, from: f64, rules: &magician_motion::Rail) -> Self {
        let rates = KinematicLimits {
            velocity: rules.home_velocity,
            acceleration: rules.home_acceleration,
        };
        Self::going(law, from, 0.0, &rates, 0)
    }

    /// The same way together with a motion of the arm that takes so long (model section 7: T is the
    /// maximum of both).
    pub(super) fn along(self, arm: Micros, settings: &MotionSettings) -> Self {
        match settings.rail() {
            Some(rates) if self.duration > 0 && arm > self.duration => {
                Self::going(self.law, self.from, self.end, &rates, arm)
            }
            _ => self,
        }
    }

    /// Where the arm is stopped on its way the carriage stops with it.
    pub(super) fn stopped_with(self, arm: Option<Micros>) -> Self {
        arm.map_or(self, |at| self.cut(at))
    }
}
