//! Look-ahead of a continuous path: the highest speed at the junction of two segments (model
//! section 8).
//!
//! A path ends at rest, so the last known segment does too. Every earlier speed is bounded by the
//! corners, and by the distance left for braking. Squares of speeds add up with distance, so the
//! highest squared speed at the end of a segment is the minimum, over all later junctions, of the
//! squared speed allowed there plus twice the acceleration times the distance to it. One pass
//! forwards finds that minimum without a square root, and stops as soon as the distance is long
//! enough for any later junction.

use crate::move_segment::SHORTEST_MOVE;
use crate::speeds::positive;
use crate::trajectory::microseconds;
use crate::velocity_profile::{KinematicLimits, VelocityProfile};
use crate::{ArmModel, Ceilings, MotionError, MotionLaw, SpeedQuantity};

/// Settings of a continuous path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CpSpeeds {
    /// Acceleration along the path (`planAcc`), mm/s2.
    pub plan_acceleration: f64,
    /// Speed along the path (`junctionVel`), mm/s. Despite its name it does not limit the speed at
    /// corners.
    pub junction_velocity: f64,
    /// Period in the limit of the corner speed; in real-time mode also the period of the host's
    /// clock, seconds.
    pub period_s: f64,
    /// True if every segment takes one period, without a limit at corners (`realTimeTrack`).
    pub real_time: bool,
}

impl Default for CpSpeeds {
    /// The settings at power-up of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.cp_speeds()
    }
}

/// Direction and length of a straight segment of a continuous path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CpSegment {
    direction: [f64; 3],
    length: f64,
}

impl CpSegment {
    /// Creates the segment between two points (x, y, z; mm).
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

    /// Length, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// True if the segment is shorter than 0.0001 mm. It then counts neither as a motion nor as a
    /// corner.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.length < SHORTEST_MOVE
    }

    /// Cosine of the angle by which the path turns at the start of the next segment.
    fn turn_cosine(&self, next: &Self) -> f64 {
        let [ax, ay, az] = self.direction;
        let [bx, by, bz] = next.direction;
        ax * bx + ay * by + az * bz
    }
}

/// Speeds of a continuous path, given the segments known so far.
///
/// ```
/// use magician_motion::{ArmModel, CpSegment, LookAhead};
///
/// let model = ArmModel::MAGICIAN;
/// let look_ahead = LookAhead::new(&model.cp_speeds(), &model.ceilings, model.law)?;
/// let side = CpSegment::between([0.0; 3], [50.0, 0.0, 0.0]);
/// let on = CpSegment::between([50.0, 0.0, 0.0], [100.0, 0.0, 0.0]);
/// let round_the_corner = CpSegment::between([50.0, 0.0, 0.0], [50.0, 50.0, 0.0]);
/// // A square corner costs speed; with no further segment the path ends at rest.
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
    /// Squared speed at a corner, times one minus the cosine of its turn.
    corner: f64,
    /// Most segments per second; `None` if there is no bound.
    clock: Option<f64>,
}

impl LookAhead {
    /// Creates the look-ahead with these settings, each limited to its ceiling.
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
        // v = a T / (2 sin(t / 2)), squared, with 2 sin2(t / 2) = 1 - cos(t).
        let straight = rates.acceleration * period;
        let clocks = [
            // No segment takes less than a period of the host's clock, or of the controller.
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

    /// Highest velocity and acceleration with which to plan a segment.
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

    /// Returns the profile of a segment between two speeds.
    #[must_use]
    pub fn profile(&self, segment: &CpSegment, entry: f64, exit: f64) -> VelocityProfile {
        self.law
            .segment(segment.length, entry, exit, &self.rates(segment))
    }

    /// Highest speed at the end of `running`, mm/s, given the segments queued behind it, the next
    /// one first.
    ///
    /// The last queued segment ends at rest; if none is queued, `running` does.
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
            // The runway already exceeds every bound seen: later corners cannot lower the result.
            if runway >= allowed {
                return libm::sqrt(allowed);
            }
            previous = next;
        }
        libm::sqrt(allowed.min(runway))
    }

    /// Square of the highest speed at the junction of two segments.
    fn junction_squared(&self, previous: &CpSegment, next: &CpSegment) -> f64 {
        let fastest = match self.clock {
            Some(clock) => {
                let velocity = previous.length.min(next.length) * clock;
                (velocity * velocity).min(self.cruise_squared)
            }
            None => self.cruise_squared,
        };
        // Turns above 90 degrees count as 90 (model section 8). Most corners limit nothing; the
        // comparison avoids a division for them.
        let bend = (1.0 - previous.turn_cosine(next)).min(1.0);
        if self.corner < fastest * bend {
            self.corner / bend
        } else {
            fastest
        }
    }

    /// Duration of each segment of a whole path from rest to rest, microseconds: the time of an arm
    /// whose queue never runs short.
    ///
    /// `room` is scratch space with one number per segment. A shorter `room` shortens the path.
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

    /// Computes the square of the highest speed at the end of each segment, in one pass backwards.
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
