//! State of the arm at rest or in motion, and the transitions between the two.
//!
//! In periods the commanded pose changes every 20 ms, but motors move smoothly. `sample` is the
//! pose that the controller reports; `motor_position` is the position of the motors between two
//! periods, which the world sees. A command that arrives within a period acts with its end, so for
//! the rest of that period the motors move from where they are onto the new trajectory.

use magician_motion::{ArmModel, ArmState, Geometry, JointAngles, MotionLaw, Trajectory};
use magician_protocol::PoCmd;

use super::outputs::Outputs;
use super::rail::Rail;
use super::{MotionKind, RailPath, Segment};
use crate::{ArmInstant, Micros, World};

/// The arm, at rest or in motion: its commanded state, and its offset from the true one.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    pub(super) rest: ArmState,
    /// Geometry for which `rest.pose` holds. Another tool bias gives another pose of the same
    /// joints.
    pub(super) measured: Geometry,
    pub(super) under_way: Option<RunningMotion>,
    /// Offset of the true joints from the commanded ones: lost steps, and the base angle before
    /// homing.
    pub(super) slip: [f64; 4],
    /// Part of the offset of J1 that its encoder cannot see: the base angle at power-up.
    pub(super) base: f64,
    /// Carriage of the rail, if the arm stands on one.
    pub(super) rail: Rail,
    /// Exit speed of a path segment that ended at this very instant, mm/s.
    pub(super) junction_speed: f64,
    /// True if the arm has been homed since power-up.
    pub(super) homed: bool,
    /// Instant and position at which a motion was taken away: a motion that begins in the same
    /// instant continues from there.
    left: Option<(ArmInstant, JointAngles, f64)>,
}

/// A motion planned from where the arm stands.
#[derive(Clone, Debug)]
pub(crate) struct PlannedMotion {
    pub(crate) kind: MotionKind,
    pub(crate) trajectory: Trajectory,
    /// Path of the carriage; the motion lasts until both rest.
    pub(crate) rail: RailPath,
    /// Alarm to raise at the end, if a limit stops it before its target.
    pub(crate) alarm: Option<u8>,
    /// Outputs that it switches on its way.
    pub(crate) outputs: Outputs,
}

impl PlannedMotion {
    /// Duration of the motion of arm and carriage.
    pub(crate) fn duration(&self) -> Micros {
        self.trajectory.duration_us().max(self.rail.duration())
    }
}

/// Kind, alarm and speed of a motion that has ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionEnd {
    pub(crate) kind: MotionKind,
    pub(crate) alarm: Option<u8>,
    /// Speed at its end, mm/s.
    pub(crate) speed: f64,
}

/// A running motion and its start.
#[derive(Clone, Debug)]
pub(super) struct RunningMotion {
    pub(super) kind: MotionKind,
    pub(super) trajectory: Trajectory,
    /// Path of the carriage.
    pub(super) rail: RailPath,
    pub(super) started: ArmInstant,
    /// Instant within the first period at which the motors start, and their position then.
    begun: ArmInstant,
    from: (JointAngles, f64),
    /// Distance of the motors ahead of the start of a segment at that instant, mm.
    ahead: f64,
    /// End of the first period, by which the motors are on the trajectory.
    first_end: ArmInstant,
    pub(super) ends: ArmInstant,
    /// Alarm to raise at the end, if a limit stops it before its target.
    pub(super) alarm: Option<u8>,
    /// Outputs that it switches on its way.
    pub(super) outputs: Outputs,
    /// Instant at which a limit alarm drops because its joint is back inside.
    pub(super) leaves_limit: Option<ArmInstant>,
    /// Instant since which the world has seen the present prediction.
    pub(super) shown: ArmInstant,
    /// Instant since which J2 and J3 stall, and their true angles.
    pub(super) stalled: Option<(ArmInstant, [f64; 2])>,
}

impl RunningMotion {
    pub(super) fn elapsed(&self, now: ArmInstant) -> Micros {
        now.micros_since(self.started)
    }

    /// Commanded state at an instant.
    fn sample(&self, now: ArmInstant) -> ArmState {
        if now >= self.ends {
            return *self.trajectory.end();
        }
        self.trajectory.sample(self.elapsed(now))
    }

    /// Position of the motors at an instant, between the ends of two periods, too.
    fn motor_position(&self, now: ArmInstant) -> (JointAngles, f64) {
        if now >= self.ends {
            return (self.trajectory.end().joints, self.rail.end());
        }
        let on_its_way = |at| {
            let elapsed = self.elapsed(at);
            (
                self.trajectory.curve(elapsed).joints,
                self.rail.curve(elapsed),
            )
        };
        // A replanned segment may be slower than before. The motors do not go back onto it, they
        // wait: going back would draw up to 0.3 mm of a line twice.
        if self.is_behind_motors(now) && self.is_behind_motors(self.first_end) {
            return self.from;
        }
        if now >= self.first_end {
            return on_its_way(now);
        }
        let whole = self.first_end.micros_since(self.begun).max(1);
        let since = now.micros_since(self.begun);
        let (from, rail_from) = self.from;
        if from == self.trajectory.start().joints && rail_from == self.rail.sample(0) {
            // Started from rest within a period: the whole first period is compressed into the time
            // left of it.
            let first = self.elapsed(self.first_end);
            let elapsed = since * first / whole;
            return (
                self.trajectory.curve(elapsed).joints,
                self.rail.curve(elapsed),
            );
        }
        // Started from a motion: move straight from the present position to that at the end of the
        // period.
        let share = since as f64 / whole as f64;
        let (to, rail_to) = on_its_way(self.first_end);
        let between = |from: f64, to: f64| from + share * (to - from);
        let pairs = from.to_array().into_iter().zip(to.to_array());
        let mut joints = [0.0; 4];
        for (joint, (from, to)) in joints.iter_mut().zip(pairs) {
            *joint = between(from, to);
        }
        (joints.into(), between(rail_from, rail_to))
    }

    /// True if the segment at this instant is still behind the position where the motors began.
    fn is_behind_motors(&self, now: ArmInstant) -> bool {
        self.ahead > 0.0 && {
            let pose = self.trajectory.curve(self.elapsed(now)).pose;
            pose.distance_to(&self.trajectory.start().pose) < self.ahead
        }
    }

    /// Commanded position of the carriage, mm.
    fn sample_rail(&self, now: ArmInstant) -> f64 {
        if now >= self.ends {
            return self.rail.end();
        }
        self.rail.sample(self.elapsed(now))
    }
}

impl Motion {
    /// Creates the arm at power-up, at rest.
    pub(crate) fn at(model: &ArmModel) -> Self {
        // Any geometry will do: a pose is computed again when the bias in force differs.
        let measured = Geometry::default();
        Self {
            rest: ArmState::at_joints(&measured, &model.power_up.joints),
            measured,
            under_way: None,
            slip: [0.0; 4],
            base: 0.0,
            rail: Rail::new(model.rail.length),
            junction_speed: 0.0,
            homed: false,
            left: None,
        }
    }

    pub(crate) fn is_homed(&self) -> bool {
        self.homed
    }

    pub(crate) fn set_homed(&mut self, homed: bool) {
        self.homed = homed;
    }

    /// True if anything moves; the search of homing counts.
    pub(crate) fn is_moving(&self) -> bool {
        self.under_way.is_some()
    }

    /// Kind of the running motion.
    pub(crate) fn kind(&self) -> Option<MotionKind> {
        self.under_way.as_ref().map(|motion| motion.kind)
    }

    /// True during a jog and its stop ramp: the queue does not wait for it.
    pub(crate) fn is_jogging(&self) -> bool {
        matches!(
            self.kind(),
            Some(MotionKind::Jog(_) | MotionKind::JogStop { .. } | MotionKind::RailJog { .. })
        )
    }

    /// True if a Clear or a start of the queue ends the running motion: it is neither a jog nor the
    /// ramp of a forced stop (model section 14).
    pub(crate) fn can_be_dropped(&self) -> bool {
        let kind = self.kind();
        !self.is_jogging() && kind.is_some_and(|kind| kind != MotionKind::Brake)
    }

    /// True during the stop ramp of a jog.
    pub(crate) fn ends_jog(&self) -> bool {
        matches!(self.kind(), Some(MotionKind::JogStop { .. }))
    }

    /// True during a segment of a continuous path.
    pub(crate) fn follows_path(&self) -> bool {
        matches!(self.kind(), Some(MotionKind::Segment(_)))
    }

    /// Changes the kind of the running motion.
    pub(crate) fn set_kind(&mut self, kind: MotionKind) {
        if let Some(motion) = &mut self.under_way {
            motion.kind = kind;
        }
    }

    /// Speed left from a segment that ended at this very instant, mm/s.
    pub(crate) fn junction_speed(&self) -> f64 {
        self.junction_speed
    }

    pub(crate) fn set_junction_speed(&mut self, speed: f64) {
        self.junction_speed = speed;
    }

    /// Next instant at which the motion ends, switches an output or drops a limit alarm.
    pub(crate) fn next_event(&self) -> Option<ArmInstant> {
        let motion = self.under_way.as_ref()?;
        let switches = motion.outputs.next_due();
        let motor_position = [
            motion.leaves_limit,
            switches.map(|at| motion.started.after_micros(at)),
        ];
        let first = motor_position.into_iter().flatten().min();
        Some(first.map_or(motion.ends, |at| at.min(motion.ends)))
    }

    /// Commanded joints.
    pub(crate) fn joints(&self, now: ArmInstant) -> JointAngles {
        self.commanded(now).joints
    }

    /// Position of the motors at an instant, between the ends of two periods, too.
    pub(super) fn motor_position(&self, now: ArmInstant) -> (JointAngles, f64) {
        match &self.under_way {
            Some(motion) => motion.motor_position(now),
            None => (self.rest.joints, self.rail.rest),
        }
    }

    /// Commanded state for the geometry at the start of the motion.
    fn commanded(&self, now: ArmInstant) -> ArmState {
        match &self.under_way {
            Some(motion) => motion.sample(now),
            None => self.rest,
        }
    }

    /// Commanded position of the carriage, mm.
    pub(crate) fn rail_at(&self, now: ArmInstant) -> f64 {
        match &self.under_way {
            Some(motion) => motion.sample_rail(now),
            None => self.rail.rest,
        }
    }

    /// Commanded state for the tool bias in force. A reached target reads back as it was given.
    pub(super) fn state(&self, now: ArmInstant, geometry: &Geometry) -> ArmState {
        let state = self.commanded(now);
        if *geometry == self.measured {
            state
        } else {
            ArmState::at_joints(geometry, &state.joints)
        }
    }

    /// Starts a motion. The previous one must have ended.
    pub(crate) fn begin(&mut self, now: ArmInstant, law: MotionLaw, start: PlannedMotion) {
        let lasting = start.duration();
        // In periods a motion begins with the current period, and the pose at its end is the first
        // that differs (model section 7).
        let started = match lasting {
            0 => now,
            _ => ArmInstant::from_micros(law.period_start(now.as_micros())),
        };
        let PlannedMotion {
            kind,
            trajectory,
            rail,
            alarm,
            outputs,
        } = start;
        let first_end = match lasting {
            0 => now,
            _ => started.after_micros(law.period_us().into()),
        };
        let ends = started.after_micros(lasting);
        let stood = (trajectory.start().joints, rail.sample(0));
        // Position of the motors, if another motion was taken away in this instant.
        let from = { self.left.take() }.filter(|(at, ..)| *at == now);
        let from = from.map_or(stood, |(_, joints, rail)| (joints, rail));
        // Only a replanned segment can lie behind its motors; see `is_behind_motors`.
        let ahead = match kind {
            MotionKind::Segment(_) if from != stood => {
                let motors = trajectory.geometry().forward(&from.0);
                motors.distance_to(&trajectory.start().pose)
            }
            _ => 0.0,
        };
        // The rest of a motion keeps the tool bias with which it began.
        self.measured = *trajectory.geometry();
        self.rest = *trajectory.start();
        self.under_way = Some(RunningMotion {
            kind,
            trajectory,
            rail,
            started,
            begun: now,
            from,
            ahead,
            first_end: first_end.min(ends),
            ends,
            alarm,
            outputs,
            leaves_limit: None,
            shown: now,
            stalled: None,
        });
    }

    /// Returns the next output that is due, and marks it as switched.
    pub(crate) fn take_output(&mut self, now: ArmInstant) -> Option<PoCmd> {
        let motion = self.under_way.as_mut()?;
        let elapsed = motion.elapsed(now);
        let way = (&motion.trajectory, &motion.rail);
        motion.outputs.take_due(elapsed, way)
    }

    /// True if the motion has ended.
    pub(crate) fn is_over(&self, now: ArmInstant) -> bool {
        (self.under_way.as_ref()).is_some_and(|motion| motion.ends <= now)
    }

    /// End of the running motion.
    pub(crate) fn end(&self) -> Option<MotionEnd> {
        let motion = self.under_way.as_ref()?;
        Some(MotionEnd {
            kind: motion.kind,
            alarm: motion.alarm,
            speed: match motion.alarm {
                None => motion.trajectory.exit_speed(),
                // A motion that a limit has ended stands still.
                Some(_) => 0.0,
            },
        })
    }

    /// Removes the running motion, at its end or before; the arm rests where it is. Returns true if
    /// there was one.
    pub(crate) fn rest(&mut self, now: ArmInstant, world: &mut World) -> bool {
        let Some(motion) = &self.under_way else {
            return false;
        };
        let (state, rail) = (motion.sample(now), motion.sample_rail(now));
        // A stalled arm keeps its true position: read it before the motion goes.
        let stalled = motion.stalled.map(|_| self.true_pose(now).joints);
        self.end_path(now, world);
        let (joints, on_rail) = motion.motor_position(now);
        self.left = Some((now, joints, on_rail));
        self.under_way = None;
        self.rest = state;
        self.rail.rest = rail;
        if let Some(joints) = stalled {
            self.stand_at(joints);
        }
        true
    }

    /// Sets the commanded joints without a motion; the true ones move along.
    pub(crate) fn place_at(&mut self, geometry: &Geometry, joints: JointAngles) {
        self.rest = ArmState::at_joints(geometry, &joints);
        self.measured = *geometry;
        self.under_way = None;
    }
}

/// Continuous paths.
impl Motion {
    /// End of the running queued segment, if it was planned with the present geometry.
    pub(crate) fn queued_segment_end(&self, geometry: &Geometry) -> Option<[f64; 3]> {
        match self.kind() {
            Some(MotionKind::Segment(segment))
                if segment.is_queued() && self.measured == *geometry =>
            {
                Some(segment.to())
            }
            _ => None,
        }
    }

    /// The segment under way.
    pub(crate) fn segment(&self) -> Option<Segment> {
        match self.kind() {
            Some(MotionKind::Segment(segment)) => Some(segment),
            _ => None,
        }
    }
}
