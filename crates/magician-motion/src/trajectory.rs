//! A planned motion as a function of time.

use crate::axis_motion::AxisMotion;
use crate::joint_segment::JointSegment;
use crate::move_segment::MoveSegment;
use crate::{ArmState, Geometry, MotionError, MotionLaw};

/// A planned motion: up to three segments, and where it ends. Where two segments meet, the arm is at rest.
///
/// Every question is answered from the start of the motion, in closed form; nothing is stepped or remembered, so
/// the order and the number of questions do not matter. Time is in whole microseconds from the start, which in periods is
/// the end of one: what holds then holds until the next one ends.
///
/// ```
/// use magician_motion::{ArmModel, ArmState, JointAngles, Move, MoveKind, Pose, Target, ToolBias};
///
/// let model = ArmModel::MAGICIAN;
/// let planner = model.planner(ToolBias::NONE, model.power_up.speeds());
/// let home = ArmState::at_joints(&planner.geometry, &JointAngles::HOME);
/// let ahead = Move { target: Target::PoseIncrement(Pose::new(40.0, 0.0, 0.0, 0.0)), kind: MoveKind::Line };
/// let motion = planner.plan(&home, &ahead)?.trajectory;
///
/// let half = motion.time_at_progress(0.5).expect("nothing ends it before");
/// let gone = motion.sample(half).pose.x - home.pose.x;
/// assert!((20.0..22.0).contains(&gone) && half < motion.duration_us());
/// # Ok::<(), magician_motion::MotionError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory {
    geometry: Geometry,
    law: MotionLaw,
    segments: [Option<TimedSegment>; 3],
    start: ArmState,
    end: ArmState,
    duration_us: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct TimedSegment {
    segment: MoveSegment,
    start_us: u64,
}

/// Whole microseconds that hold so many seconds; a rounding error does not cost one.
pub(crate) fn microseconds(seconds: f64) -> u64 {
    libm::ceil(seconds * 1e6 - 1e-3) as u64
}

fn seconds(microseconds: u64) -> f64 {
    microseconds as f64 / 1e6
}

impl Trajectory {
    /// No motion: the arm stays where it is.
    #[must_use]
    pub fn at_rest(geometry: &Geometry, state: &ArmState) -> Self {
        Self {
            geometry: *geometry,
            law: MotionLaw::CONTINUOUS,
            segments: [None; 3],
            start: *state,
            end: *state,
            duration_us: 0,
        }
    }

    /// The segments in turn, each beginning when the one before has come to rest.
    pub(crate) fn of_segments(
        geometry: &Geometry,
        law: MotionLaw,
        start: &ArmState,
        segments: impl IntoIterator<Item = MoveSegment>,
    ) -> Self {
        let mut trajectory = Self::at_rest(geometry, start);
        trajectory.law = law;
        for (slot, segment) in trajectory.segments.iter_mut().zip(segments) {
            *slot = Some(TimedSegment {
                segment,
                start_us: trajectory.duration_us,
            });
            trajectory.end = segment.end();
            let lasting = microseconds(segment.duration());
            trajectory.duration_us = trajectory.duration_us.saturating_add(lasting);
        }
        trajectory
    }

    /// One segment that sets off from `start`.
    pub(crate) fn of_segment(
        geometry: &Geometry,
        law: MotionLaw,
        start: &ArmState,
        segment: MoveSegment,
    ) -> Self {
        Self {
            geometry: *geometry,
            law,
            start: *start,
            end: segment.end(),
            duration_us: microseconds(segment.duration()),
            segments: [
                Some(TimedSegment {
                    segment,
                    start_us: 0,
                }),
                None,
                None,
            ],
        }
    }

    /// The same motion in `least_us`, if it takes less: every segment longer by the same factor, in periods by whole ones.
    /// No motion stays none.
    pub(crate) fn lasting(mut self, least_us: u64) -> Self {
        let (law, total) = (self.law, self.duration_us);
        let least_us = law.period_end(least_us);
        if total == 0 || total >= least_us {
            return self;
        }
        let later = |at_us: u64| {
            let product = u128::from(at_us) * u128::from(least_us);
            let later_us = u64::try_from(product / u128::from(total)).unwrap_or(least_us);
            law.period_start(later_us)
        };
        // The last segment ends where the motion does, each other where the next begins.
        let mut end_us = total;
        for timed in self.segments.iter_mut().rev().flatten() {
            let start_us = later(timed.start_us);
            timed.segment = timed.segment.lasting(seconds(later(end_us) - start_us));
            end_us = timed.start_us;
            timed.start_us = start_us;
        }
        self.duration_us = least_us;
        self
    }

    fn segments(&self) -> impl Iterator<Item = &TimedSegment> {
        self.segments.iter().flatten()
    }

    /// When the motion first leaves the limits or the reach, and how, with the state it would stop in.
    pub(crate) fn first_crossing(
        &self,
        limits: &crate::Limits,
    ) -> Option<(u64, MotionError, ArmState)> {
        self.segments().find_map(|timed| {
            let (t, error) = timed.segment.first_crossing(&self.geometry, limits)?;
            let state = timed.segment.state_stopped_by(&self.geometry, t, &error);
            // A motion that begins on a bound and leads out of it is one of no time.
            let at_us = timed.start_us.saturating_add(libm::floor(t * 1e6) as u64);
            Some((at_us, error, state))
        })
    }

    /// Bound that the motion leaves first, of other limits than those that it was planned within; `None` if it keeps to them.
    #[must_use]
    pub fn first_beyond(&self, limits: &crate::Limits) -> Option<MotionError> {
        self.first_crossing(limits).map(|(_, cause, _)| cause)
    }

    /// This motion cut short at `at_us`, where it stops at once in the given state; in periods at the end of that one.
    pub(crate) fn cut(self, at_us: u64, end: ArmState) -> Self {
        Self {
            end,
            duration_us: self.law.period_end(at_us).min(self.duration_us),
            ..self
        }
    }

    /// How long the motion takes.
    #[must_use]
    pub fn duration_us(&self) -> u64 {
        self.duration_us
    }

    /// How long it would take if nothing cut it short.
    #[must_use]
    pub fn uncut_us(&self) -> u64 {
        if self.last_segment().is_some() {
            return self.duration_us;
        }
        let lasts = |timed: &TimedSegment| {
            let lasting = microseconds(timed.segment.duration());
            timed.start_us.saturating_add(lasting)
        };
        self.segments().last().map_or(0, lasts)
    }

    /// Where it starts.
    #[must_use]
    pub fn start(&self) -> &ArmState {
        &self.start
    }

    /// Where it ends: for a target that is reached, exactly the target as it was given.
    #[must_use]
    pub fn end(&self) -> &ArmState {
        &self.end
    }

    /// The segment under way at a time within the motion, and the seconds since it began.
    fn segment_at(&self, t_us: u64) -> Option<(&TimedSegment, f64)> {
        let timed = self
            .segments()
            .filter(|timed| timed.start_us <= t_us)
            .last()?;
        Some((timed, seconds(t_us - timed.start_us)))
    }

    /// The segment under way at a time and the seconds that its state is of; nothing from the end of the motion on.
    pub(crate) fn under_way(&self, t_us: u64) -> Option<(&MoveSegment, f64)> {
        let ended_us = self.law.period_start(t_us);
        let (timed, t) = self
            .segment_at(ended_us)
            .filter(|_| t_us < self.duration_us)?;
        Some((&timed.segment, t))
    }

    /// Each segment with the moments between which it is under way, as far as the motion goes.
    pub(crate) fn timed_segments(&self) -> impl Iterator<Item = (&MoveSegment, u64, u64)> {
        let ends = self.segments().skip(1).map(|next| next.start_us);
        let ends = ends.chain([self.duration_us]);
        self.segments()
            .zip(ends)
            .filter(|(timed, _)| timed.start_us < self.duration_us)
            .map(|(timed, end)| (&timed.segment, timed.start_us, end.min(self.duration_us)))
    }

    /// The segment with which the motion ends; nothing if it is cut short.
    pub(crate) fn last_segment(&self) -> Option<&MoveSegment> {
        let timed = self.segments().last()?;
        (timed.segment.end() == self.end).then_some(&timed.segment)
    }

    /// The arm's measures that its poses hold for: those it was planned with, and none that came later.
    #[must_use]
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Joints and pose at a time, in periods at the end of the last one by then. From the end of the motion on, exactly
    /// its [`end`](Self::end).
    #[must_use]
    pub fn sample(&self, t_us: u64) -> ArmState {
        self.curve(self.law.period_start(t_us))
    }

    /// Joints and pose at a time on the curve through all samples: where the motors take the arm between the ends of two
    /// periods. In continuous time it is the sample.
    #[must_use]
    pub fn curve(&self, t_us: u64) -> ArmState {
        if t_us >= self.duration_us {
            return self.end;
        }
        match self.segment_at(t_us) {
            Some((timed, t)) => timed.segment.state_at(&self.geometry, t),
            None => self.start,
        }
    }

    /// The joints' velocities at a time, deg/s; zero from the end of the motion on.
    #[must_use]
    pub fn joint_velocities(&self, t_us: u64) -> [f64; 4] {
        match self.under_way(t_us) {
            Some((segment, t)) => segment.joint_velocities(&self.geometry, t),
            None => [0.0; 4],
        }
    }

    /// The share of the planned motion that is done at a time, 0 to 1, measured along the path.
    ///
    /// Legs count by the distance between their ends. A motion that a limit cuts short does not get to 1.
    #[must_use]
    pub fn progress(&self, t_us: u64) -> f64 {
        self.curve_progress(self.law.period_start(t_us))
    }

    /// The same on the curve through all that is ever sampled.
    pub(crate) fn curve_progress(&self, t_us: u64) -> f64 {
        let t_us = t_us.min(self.duration_us);
        if t_us == self.duration_us && self.last_segment().is_some() {
            // The last microsecond may be a rounding error short of the end.
            return 1.0;
        }
        let (mut done, mut whole) = (0.0, 0.0);
        for timed in self.segments() {
            let arc_length = timed.segment.arc_length();
            whole += arc_length;
            if timed.start_us <= t_us {
                done += arc_length * timed.segment.progress(seconds(t_us - timed.start_us));
            }
        }
        if whole > 0.0 { done / whole } else { 1.0 }
    }

    /// When a share of the planned motion is done, in microseconds, or never if a limit ends it before.
    #[must_use]
    pub fn time_at_progress(&self, progress: f64) -> Option<u64> {
        let whole: f64 = self
            .segments()
            .map(|timed| timed.segment.arc_length())
            .sum();
        let mut left = progress.clamp(0.0, 1.0) * whole;
        let mut at_us = 0;
        for timed in self.segments() {
            let arc_length = timed.segment.arc_length();
            let share = if arc_length > 0.0 {
                (left / arc_length).min(1.0)
            } else {
                1.0
            };
            at_us = timed
                .start_us
                .saturating_add(microseconds(timed.segment.time_at(share)));
            left -= arc_length;
            // Less than that is the rounding of the sum.
            if left <= 1e-12 * whole {
                break;
            }
        }
        let at_us = self.law.period_end(at_us);
        (at_us <= self.duration_us).then_some(at_us)
    }

    /// The emergency stop from a time within this motion: J1 to J3 come to rest together, each along its own way,
    /// in the longest time that one of them needs at the given decelerations (deg/s2); J4 stops at once.
    pub(crate) fn braked(&self, law: MotionLaw, at_us: u64, decelerations: [f64; 3]) -> Self {
        let from = self.sample(at_us);
        let velocities = self.joint_velocities(at_us);
        if !velocities.iter().all(|velocity| velocity.is_finite()) {
            // The tool passes the base axis: no speed there is any joint's.
            return Self::at_rest(&self.geometry, &from);
        }
        let duration = velocities
            .iter()
            .zip(decelerations)
            .map(|(velocity, deceleration)| libm::fabs(*velocity) / deceleration)
            .fold(0.0, f64::max);
        let [v1, v2, v3, _] = velocities;
        let [a1, a2, a3] =
            [v1, v2, v3].map(|velocity| AxisMotion::stopping_in(law, velocity, duration));
        let axes = [a1, a2, a3, AxisMotion::at_rest()];
        let segment = JointSegment::following(&self.geometry, &from, axes);
        if duration > 0.0 {
            Self::of_segments(&self.geometry, law, &from, [MoveSegment::Joints(segment)])
        } else {
            Self::at_rest(&self.geometry, &from)
        }
    }
}
