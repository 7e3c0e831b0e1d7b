//! How fast a continuous path may be where one segment meets the next (model section 8).
//!
//! A path ends at rest, and so does the last segment that is known. Every earlier speed is bounded by what braking
//! leaves time for, and by the corners. The square of the speed that may be had at the end of a segment is the
//! least, over everything ahead, of the square allowed there plus twice the acceleration times the way to it. So one
//! pass forwards finds it without a root, and ends where the way is long enough for whatever comes.

use crate::move_segment::SHORTEST_MOVE;
use crate::speeds::positive;
use crate::trajectory::microseconds;
use crate::velocity_profile::{KinematicLimits, VelocityProfile};
use crate::{ArmModel, Ceilings, MotionError, MotionLaw, SpeedQuantity};

/// The settings of a continuous path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CpSpeeds {
    /// Acceleration along the path (`planAcc`), mm/s2.
    pub plan_acceleration: f64,
    /// Speed along the path (`junctionVel`), mm/s; whatever its name says, the corners have limits of their own.
    pub junction_velocity: f64,
    /// The period that the limit of the corners goes by, and by which the host clocks the path in real time, seconds.
    pub period_s: f64,
    /// Whether every segment is to take a period, without a limit at the corners (`realTimeTrack`).
    pub real_time: bool,
}

impl Default for CpSpeeds {
    /// The settings at power-up of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.cp_speeds()
    }
}

/// A straight segment of a continuous path, as far as its speed goes: a direction and a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CpSegment {
    direction: [f64; 3],
    length: f64,
}

impl CpSegment {
    /// The segment from one point (x, y, z; mm) to another.
    #[must_use]
    pub fn between(from: [f64; 3], to: [f64; 3]) -> Self {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| match (from.get(axis), to.get(axis)) {
            (Some(from), Some(to)) => to - from,
            _ => 0.0,
        });
        let length = libm::sqrt(x * x + y * y + z * z);
        Self {
            direction: [x, y, z].map(|step| step / length),
            length,
        }
    }

    /// Its length, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Whether it is too short to count: under 0.0001 mm, and no corner of the path.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.length < SHORTEST_MOVE
    }

    /// The cosine of the angle by which the path turns where the next segment begins.
    fn turn_cosine(&self, next: &Self) -> f64 {
        let [ax, ay, az] = self.direction;
        let [bx, by, bz] = next.direction;
        ax * bx + ay * by + az * bz
    }
}

/// The speeds of a continuous path, given the segments that are known.
///
/// ```
/// use magician_motion::{ArmModel, CpSegment, LookAhead};
///
/// let model = ArmModel::MAGICIAN;
/// let look_ahead = LookAhead::new(&model.cp_speeds(), &model.ceilings, model.law)?;
/// let side = CpSegment::between([0.0; 3], [50.0, 0.0, 0.0]);
/// let on = CpSegment::between([50.0, 0.0, 0.0], [100.0, 0.0, 0.0]);
/// let round_the_corner = CpSegment::between([50.0, 0.0, 0.0], [50.0, 50.0, 0.0]);
/// // A square corner costs speed, and what is not known yet counts as rest.
/// assert!(look_ahead.exit_speed(&side, [&round_the_corner]) < look_ahead.exit_speed(&side, [&on]));
/// assert_eq!(look_ahead.exit_speed(&side, []), 0.0);
/// # Ok::<(), magician_motion::MotionError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAhead {
    law: MotionLaw,
    rates: KinematicLimits,
    cruise_squared: f64,
    /// Twice the acceleration, mm/s2.
    braking: f64,
    /// What the square of a corner's speed is, times one less the cosine of its turn.
    corner: f64,
    /// The most segments a second, if there is such a bound.
    clock: Option<f64>,
}

impl LookAhead {
    /// The look-ahead with these settings, each up to its ceiling.
    ///
    /// # Errors
    ///
    /// [`MotionError::Speed`] for a setting that is NaN, zero or negative.
    pub fn new(
        speeds: &CpSpeeds,
        ceilings: &Ceilings,
        law: MotionLaw,
    ) -> Result<Self, MotionError> {
        let rates = ceilings.linear(KinematicLimits {
            velocity: speeds.junction_velocity,
            acceleration: speeds.plan_acceleration,
        })?;
        let period = positive(SpeedQuantity::Period, speeds.period_s)?;
        // v = a period / (2 sin(t / 2)), squared, with 2 sin2(t / 2) = 1 - cos(t).
        let straight = rates.acceleration * period;
        let clocks = [
            speeds.real_time.then_some(1.0 / period),
            (!law.is_continuous()).then_some(1.0 / law.period()),
        ];
        Ok(Self {
            law,
            rates,
            cruise_squared: rates.velocity * rates.velocity,
            braking: 2.0 * rates.acceleration,
            corner: if speeds.real_time {
                f64::INFINITY
            } else {
                0.5 * straight * straight
            },
            clock: clocks.into_iter().flatten().reduce(f64::min),
        })
    }

    /// The fastest that a segment itself may be travelled: what to plan it with.
    #[must_use]
    pub fn rates(&self, segment: &CpSegment) -> KinematicLimits {
        let velocity = match self.clock {
            Some(clock) => self.rates.velocity.min(segment.length * clock),
            None => self.rates.velocity,
        };
        KinematicLimits {
            velocity,
            ..self.rates
        }
    }

    /// The profile of a segment between two speeds.
    #[must_use]
    pub fn profile(&self, segment: &CpSegment, entry: f64, exit: f64) -> VelocityProfile {
        self.law
            .segment(segment.length, entry, exit, &self.rates(segment))
    }

    /// The highest speed with which `running` may end, mm/s, given the segments queued behind it, the next one first:
    /// the last of them is to end at rest, and without any so is the running one.
    #[must_use]
    pub fn exit_speed<'a>(
        &self,
        running: &'a CpSegment,
        queued: impl IntoIterator<Item = &'a CpSegment>,
    ) -> f64 {
        let mut allowed = f64::INFINITY;
        let mut runway = 0.0;
        let mut previous = running;
        for next in queued {
            if next.is_empty() {
                continue;
            }
            allowed = allowed.min(self.junction_squared(previous, next) + runway);
            runway += self.braking * next.length;
            if runway >= allowed {
                return libm::sqrt(allowed);
            }
            previous = next;
        }
        libm::sqrt(allowed.min(runway))
    }

    /// The square of the highest speed where two segments meet.
    fn junction_squared(&self, previous: &CpSegment, next: &CpSegment) -> f64 {
        let fastest = match self.clock {
            Some(clock) => {
                let velocity = previous.length.min(next.length) * clock;
                (velocity * velocity).min(self.cruise_squared)
            }
            None => self.cruise_squared,
        };
        // Turns above 90 degrees count as 90. Most corners, and straight ones, limit nothing: found without a division.
        let bend = (1.0 - previous.turn_cosine(next)).min(1.0);
        if self.corner < fastest * bend {
            self.corner / bend
        } else {
            fastest
        }
    }

    /// How long each segment of a whole path takes from rest to rest, in microseconds, all of it being known
    /// beforehand: what the arm takes whose queue never runs short.
    ///
    /// `room` is for as many numbers as there are segments, whatever they are; the path ends where it does.
    pub fn times<'a>(
        &self,
        segments: &'a [CpSegment],
        room: &'a mut [f64],
    ) -> impl Iterator<Item = u64> + 'a {
        self.limit_exits(segments, room);
        let look_ahead = *self;
        let mut speed = 0.0;
        segments.iter().zip(room).map(move |(segment, exit)| {
            if segment.is_empty() {
                return 0;
            }
            let exit = libm::sqrt(*exit);
            let profile = look_ahead.profile(segment, speed, exit);
            speed = profile.exit();
            microseconds(profile.duration())
        })
    }

    /// The squares of the highest speeds at the end of every segment, by one pass backwards.
    fn limit_exits(&self, segments: &[CpSegment], exits: &mut [f64]) {
        let mut next: Option<&CpSegment> = None;
        let mut allowed = 0.0;
        let known = segments.len().min(exits.len());
        for (segment, exit) in segments.iter().zip(exits).take(known).rev() {
            if segment.is_empty() {
                continue;
            }
            if let Some(next) = next {
                let braked: f64 = allowed + self.braking * next.length;
                allowed = braked.min(self.junction_squared(segment, next));
            }
            *exit = allowed;
            next = Some(segment);
        }
    }
}
