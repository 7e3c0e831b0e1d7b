//! The carriage on the rail (model sections 10 and 12): it moves with the arm, alone, or is jogged.

use magician_motion::{Braking, Profile, Rates, Trajectory};
use magician_protocol::commands::JogCmd;
use magician_protocol::{Alarm, Writable};

use super::{Jogged, Outputs, Purpose};
use crate::Micros;
use crate::device::Device;
use crate::device::dispatch::Step;
use crate::event::Refusal;

/// A way on the rail shorter than this takes no time, mm; the arm's moves have the same.
const SHORTEST: f64 = 1e-4;

/// The carriage when nothing moves it, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rail {
    /// Where it is commanded to be.
    pub(super) rest: f64,
    /// By how much it really stands elsewhere: it is 0 wherever power found it (model section 12).
    pub(crate) slip: f64,
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
    pub(super) fn really(&self, commanded: f64) -> f64 {
        (commanded + self.slip).clamp(0.0, self.length)
    }
}

/// A way of the carriage as a function of time: what speed it has falls to rest, then it goes on from rest to rest.
/// Either part may be missing. Times are from the start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RailCourse {
    from: f64,
    slowing: Braking,
    /// Where it turns from slowing to going.
    turn: f64,
    sign: f64,
    going: Profile,
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

impl RailCourse {
    /// No way: the carriage stays where it is.
    pub(crate) fn standing(at: f64) -> Self {
        Self {
            from: at,
            slowing: Braking::default(),
            turn: at,
            sign: 1.0,
            going: Profile::default(),
            end: at,
            duration: 0,
        }
    }

    /// From rest to rest in no less than `least`.
    fn going(from: f64, to: f64, rates: &Rates, least: Micros) -> Self {
        let length = (to - from).abs();
        if length < SHORTEST {
            return Self::standing(to);
        }
        let duration = microseconds(rates.least_time(length)).max(least);
        Self {
            sign: f64::copysign(1.0, to - from),
            going: Profile::lasting(length, rates, seconds(duration)),
            end: to,
            duration,
            ..Self::standing(from)
        }
    }

    /// To rest at a deceleration, or harder where the rail ends before; at no deceleration it stops dead.
    fn slowing(from: f64, velocity: f64, deceleration: f64, length: f64) -> Self {
        let room = if velocity < 0.0 { from } else { length - from };
        let speed = velocity.abs();
        let lasting = (speed / deceleration).min(2.0 * room.max(0.0) / speed);
        if !(lasting > 0.0 && lasting.is_finite()) {
            return Self::standing(from);
        }
        let slowing = Braking::lasting(velocity, lasting);
        let end = (from + slowing.position(lasting)).clamp(0.0, length);
        Self {
            slowing,
            turn: end,
            end,
            duration: microseconds(lasting),
            ..Self::standing(from)
        }
    }

    /// The same, and then on to `to`.
    fn then_going(self, to: f64, rates: &Rates) -> Self {
        let on = Self::going(self.end, to, rates, 0);
        Self {
            sign: on.sign,
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
        if t >= self.duration {
            return self.end;
        }
        match self.going_since(t) {
            Some(since) => self.turn + self.sign * self.going.position(since),
            None => self.from + self.slowing.position(seconds(t)),
        }
    }

    /// How fast it moves at a time, mm/s, with its sign.
    fn velocity(&self, t: Micros) -> f64 {
        if t >= self.duration {
            return 0.0;
        }
        match self.going_since(t) {
            Some(since) => self.sign * self.going.velocity(since),
            None => self.slowing.velocity(seconds(t)),
        }
    }

    /// The direction that it goes in or will, once it has slowed down; 0 if it only comes to rest.
    fn heading(&self) -> f64 {
        if self.going.length() > 0.0 {
            self.sign
        } else {
            0.0
        }
    }

    /// When a share of the way is done, of one from rest; never if it ends before.
    pub(super) fn time_at_progress(&self, share: f64) -> Option<Micros> {
        let distance = share.clamp(0.0, 1.0) * self.going.length();
        let at = microseconds(self.going.time_at(distance));
        (at <= self.duration).then_some(at)
    }
}

/// Velocity and acceleration that are set, with their ratios in percent up to 100; `None` for what is no speed.
fn rates([velocity, acceleration]: [f32; 2], ratios: [f32; 2]) -> Option<Rates> {
    let [velocity_ratio, acceleration_ratio] =
        ratios.map(|ratio| f64::from(ratio).min(100.0) / 100.0);
    let (velocity, acceleration) = (f64::from(velocity), f64::from(acceleration));
    let parts = [velocity, velocity_ratio, acceleration, acceleration_ratio];
    // NaN is not above 0; f64::min would hide one.
    let sensible =
        parts.iter().all(|part| *part > 0.0) && !ratios.iter().any(|ratio| ratio.is_nan());
    sensible.then_some(Rates {
        velocity: velocity * velocity_ratio,
        acceleration: acceleration * acceleration_ratio,
    })
}

impl Device {
    /// Whether the arm stands on a rail, as far as the controller was told.
    pub(crate) fn has_rail(&self) -> bool {
        self.settings.with_rail.with_l.is_on()
    }

    /// Where the carriage is commanded to be at the present instant, mm.
    pub(crate) fn rail(&self) -> f64 {
        self.motion.rail_at(self.now)
    }

    /// Speeds of moves on the rail.
    fn rail_rates(&self) -> Option<Rates> {
        let (speeds, ratios) = (&self.settings.ptp_rail, &self.settings.ptp_common);
        rates(
            [speeds.velocity, speeds.acceleration],
            [ratios.velocity_ratio, ratios.acceleration_ratio],
        )
    }

    /// Speeds of jogs on the rail; the acceleration of a jog has no ratio (model section 6).
    fn rail_jog_rates(&self) -> Option<Rates> {
        let (speeds, ratios) = (&self.settings.jog_rail, &self.settings.jog_common);
        rates(
            [speeds.velocity, speeds.acceleration],
            [ratios.velocity_ratio, 100.0],
        )
    }

    /// The carriage's way to a place, which the ends of the rail bound without an alarm (model section 15a); else the
    /// alarm that it raises.
    pub(super) fn plan_rail(&self, to: f64) -> Result<RailCourse, u8> {
        if !to.is_finite() {
            return Err(Alarm::PlanInvCalc);
        }
        let (from, to) = (self.rail(), to.clamp(0.0, self.motion.rail.length));
        if (to - from).abs() < SHORTEST {
            return Ok(RailCourse::standing(to));
        }
        let rates = self.rail_rates().ok_or(Alarm::PlanSpeedInputParam)?;
        Ok(RailCourse::going(from, to, &rates, 0))
    }

    /// The carriage's end of an emergency stop: by itself, in the time that it needs (model section 14 says it of the
    /// arm's joints only).
    pub(super) fn brake_rail(&self, course: &RailCourse, elapsed: Micros) -> RailCourse {
        let deceleration = self.rail_rates().map_or(f64::INFINITY, |rates| {
            self.profile.stop.force_factor * rates.acceleration
        });
        RailCourse::slowing(
            course.sample(elapsed),
            course.velocity(elapsed),
            deceleration,
            self.motion.rail.length,
        )
    }

    /// The carriage's part of homing, for a motion that begins now: to the end of the rail where it is 0. From now on
    /// it knows where it really is.
    pub(crate) fn home_rail(&mut self) -> RailCourse {
        if !self.has_rail() {
            return RailCourse::standing(self.rail());
        }
        let really = self.posture().rail;
        let home = &self.profile.rail;
        let rates = Rates {
            velocity: home.home_velocity,
            acceleration: home.home_acceleration,
        };
        let course = RailCourse::going(really, 0.0, &rates, 0);
        (self.motion.rail.rest, self.motion.rail.slip) = (really, 0.0);
        course
    }
}

impl RailCourse {
    /// The same way together with a motion of the arm that takes so long (model section 7: T is the maximum of both).
    pub(super) fn along(self, arm: Micros, core: &Device) -> Self {
        match core.rail_rates() {
            Some(rates) if self.duration > 0 && arm > self.duration => {
                Self::going(self.from, self.end, &rates, arm)
            }
            _ => self,
        }
    }

    /// Where the arm is stopped on its way the carriage stops with it.
    pub(super) fn stopped_with(self, arm: Option<Micros>) -> Self {
        arm.map_or(self, |at| self.cut(at))
    }
}

impl Device {
    /// Jogs the carriage towards the end of the rail, where it comes to rest without an alarm. Against the way that it
    /// moves it first comes to rest; told again the direction that it has, it goes on as it does. Nothing waits for a
    /// jog: it has finished at once (model section 10).
    pub(super) fn rail_jog(&mut self, positive: bool) -> Step {
        let Some(rates) = self.rail_jog_rates() else {
            self.raise(Alarm::PlanSpeedInputParam);
            return self.refuse(JogCmd::ROW.id, Refusal::Unplannable);
        };
        let (length, sign) = (self.motion.rail.length, if positive { 1.0 } else { -1.0 });
        let (from, velocity) = match self.rail_jogging() {
            Some((course, _)) if course.heading() == sign => return Step::Done,
            Some((course, elapsed)) => (course.sample(elapsed), course.velocity(elapsed)),
            None => (self.rail(), 0.0),
        };
        let to = if positive { length } else { 0.0 };
        let course = RailCourse::slowing(from, velocity, rates.acceleration, length);
        self.begin_rail_jog(course.then_going(to, &rates), None)
    }

    /// Ends a jog of the carriage: it comes to rest at the acceleration of the jog, and `then` follows.
    pub(super) fn rail_jog_stop(&mut self, then: Option<Jogged>) -> Step {
        let rates = self.rail_jog_rates();
        let deceleration = rates.map_or(f64::INFINITY, |rates| rates.acceleration);
        let Some((course, elapsed)) = self.rail_jogging() else {
            return Step::Done;
        };
        if course.heading() == 0.0 {
            // It slows down already: only what follows may change.
            self.motion.repurpose(Purpose::RailJog { then });
            return Step::Done;
        }
        let (from, velocity) = (course.sample(elapsed), course.velocity(elapsed));
        let length = self.motion.rail.length;
        let course = RailCourse::slowing(from, velocity, deceleration, length);
        self.begin_rail_jog(course, then)
    }

    /// The jog of the carriage that is under way, and how long it has been.
    fn rail_jogging(&self) -> Option<(RailCourse, Micros)> {
        let motion = self.motion.under_way()?;
        let jogs = matches!(motion.purpose, Purpose::RailJog { .. });
        jogs.then(|| (motion.rail, motion.elapsed(self.now)))
    }

    fn begin_rail_jog(&mut self, course: RailCourse, then: Option<Jogged>) -> Step {
        self.halt();
        let arm = Trajectory::at_rest(&self.geometry(), &self.arm());
        let (purpose, none) = (Purpose::RailJog { then }, Outputs::default());
        self.begin_with_rail(purpose, arm, course, None, none);
        Step::Done
    }
}
