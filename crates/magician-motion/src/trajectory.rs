//! A planned motion as a function of time.

use crate::axis_motion::AxisMotion;
use crate::joint_segment::JointSegment;
use crate::move_segment::MoveSegment;
use crate::{ArmState, Geometry, MotionError, MotionLaw};

/// A planned motion: up to three segments with rest in between, and the state at its end.
///
/// Every query is answered in closed form from the start of the motion. Nothing is stepped or
/// remembered, so the order and number of queries do not matter. Time is in whole microseconds from
/// the start. In periods the start coincides with the end of a period, and a state holds until the
/// next period ends.
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

/// Converts seconds to whole microseconds, rounded up. A rounding error does not add one.
pub(crate) fn microseconds(seconds: f64) -> u64 {
    libm::ceil(seconds * 1e6 - 1e-3) as u64
}

fn seconds(microseconds: u64) -> f64 {
    microseconds as f64 / 1e6
}

impl Trajectory {
    /// Returns a motion of no time: the arm stays where it is.
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

    /// Joins segments. Each begins when the one before has come to rest.
    pub(crate) fn of_segments(
        geometry: &Geometry,
        law: MotionLaw,
        start: &ArmState,
        segments: impl IntoIterator<Item = MoveSegment>,
    ) -> Self {
        let mut trajectory = Self::at_rest(geometry, start);
        trajectory.law = law;
        // Three slots suffice: a jump has the most segments.
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

    /// Returns a trajectory of one segment that begins in the state `start`.
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

    /// Stretches the motion to `least_us` if it takes less: every segment by the same factor, in
    /// periods by whole ones. A motion of no time stays one.
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
        // Each segment ends where the next begins, the last one where the motion does.
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

    /// Returns the time at which the motion first leaves the limits or the reach, the cause, and
    /// the state in which it stops there.
    pub(crate) fn first_crossing(
        &self,
        limits: &crate::Limits,
    ) -> Option<(u64, MotionError, ArmState)> {
        self.segments().find_map(|timed| {
            let (t, error) = timed.segment.first_crossing(&self.geometry, limits)?;
            let state = timed.segment.state_stopped_by(&self.geometry, t, &error);
            // Rounded down, so that a motion that starts on a bound and leads outwards takes no
            // time.
            let at_us = timed.start_us.saturating_add(libm::floor(t * 1e6) as u64);
            Some((at_us, error, state))
        })
    }

    /// Returns the bound that the motion leaves first, for limits other than those of its plan;
    /// `None` if it stays within them.
    #[must_use]
    pub fn first_beyond(&self, limits: &crate::Limits) -> Option<MotionError> {
        self.first_crossing(limits).map(|(_, cause, _)| cause)
    }

    /// Cuts the motion at `at_us`, where it stops at once in the given state. In periods it ends
    /// with the current period.
    pub(crate) fn cut(self, at_us: u64, end: ArmState) -> Self {
        Self {
            end,
            duration_us: self.law.period_end(at_us).min(self.duration_us),
            ..self
        }
    }

    /// Duration, microseconds.
    #[must_use]
    pub fn duration_us(&self) -> u64 {
        self.duration_us
    }

    /// Duration without the cut, microseconds.
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

    /// State at the start.
    #[must_use]
    pub fn start(&self) -> &ArmState {
        &self.start
    }

    /// State at the end. A target that is reached is there bit for bit.
    #[must_use]
    pub fn end(&self) -> &ArmState {
        &self.end
    }

    /// Returns the segment at a time within the motion, and the seconds since it began.
    fn segment_at(&self, t_us: u64) -> Option<(&TimedSegment, f64)> {
        let timed = self
            .segments()
            .filter(|timed| timed.start_us <= t_us)
            .last()?;
        Some((timed, seconds(t_us - timed.start_us)))
    }

    /// Returns the segment under way, and the time within it at which its state was last computed,
    /// seconds. `None` from the end of the motion on.
    pub(crate) fn under_way(&self, t_us: u64) -> Option<(&MoveSegment, f64)> {
        let ended_us = self.law.period_start(t_us);
        let (timed, t) = self
            .segment_at(ended_us)
            .filter(|_| t_us < self.duration_us)?;
        Some((&timed.segment, t))
    }

    /// Returns each segment with its start and end, microseconds, as far as the motion goes.
    pub(crate) fn timed_segments(&self) -> impl Iterator<Item = (&MoveSegment, u64, u64)> {
        let ends = self.segments().skip(1).map(|next| next.start_us);
        let ends = ends.chain([self.duration_us]);
        self.segments()
            .zip(ends)
            .filter(|(timed, _)| timed.start_us < self.duration_us)
            .map(|(timed, end)| (&timed.segment, timed.start_us, end.min(self.duration_us)))
    }

    /// Returns the last segment; `None` if the motion is cut before its end.
    pub(crate) fn last_segment(&self) -> Option<&MoveSegment> {
        let timed = self.segments().last()?;
        (timed.segment.end() == self.end).then_some(&timed.segment)
    }

    /// Geometry with which the motion was planned, and for which its poses hold. Later changes of
    /// the tool bias do not apply.
    #[must_use]
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Joints and pose at a time; in periods, those of the last period that ended by then. From the
    /// end of the motion on it is exactly [`end`](Self::end).
    #[must_use]
    pub fn sample(&self, t_us: u64) -> ArmState {
        self.curve(self.law.period_start(t_us))
    }

    /// Joints and pose on the curve through all samples: the actual position between the ends of
    /// two periods. In continuous time it equals the sample.
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

    /// Velocities of the joints at a time, deg/s; zero from the end of the motion on.
    #[must_use]
    pub fn joint_velocities(&self, t_us: u64) -> [f64; 4] {
        match self.under_way(t_us) {
            Some((segment, t)) => segment.joint_velocities(&self.geometry, t),
            None => [0.0; 4],
        }
    }

    /// Share of the planned motion done at a time, 0 to 1, measured along the path.
    ///
    /// The legs of a jump count by the distance between their ends. A motion that a limit cuts does
    /// not reach 1.
    #[must_use]
    pub fn progress(&self, t_us: u64) -> f64 {
        self.curve_progress(self.law.period_start(t_us))
    }

    /// Like [`progress`](Self::progress), but on the curve between the ends of periods.
    pub(crate) fn curve_progress(&self, t_us: u64) -> f64 {
        let t_us = t_us.min(self.duration_us);
        if t_us == self.duration_us && self.last_segment().is_some() {
            // `duration_us` is rounded up to microseconds, so the last profile may be just short of
            // its end.
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

    /// Time at which a share of the planned motion is done, microseconds. `None` if a limit ends
    /// the motion before.
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
            // The remainder is the rounding error of the sum.
            if left <= 1e-12 * whole {
                break;
            }
        }
        let at_us = self.law.period_end(at_us);
        (at_us <= self.duration_us).then_some(at_us)
    }

    /// Plans the forced stop at a time within this motion. J1 to J3 come to rest together, each on
    /// its own axis, in the longest time that one of them needs at the given decelerations
    /// (deg/s2). J4 stops at once.
    pub(crate) fn braked(&self, law: MotionLaw, at_us: u64, decelerations: [f64; 3]) -> Self {
        let from = self.sample(at_us);
        let velocities = self.joint_velocities(at_us);
        if !velocities.iter().all(|velocity| velocity.is_finite()) {
            // The tool passes through the base axis, where joint velocities are infinite.
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
