//! The arm at rest or on its way, and how it comes from one to the other.

use magician_motion::{ArmModel, ArmState, Geometry, JointAngles, MotionLaw, Trajectory};
use magician_protocol::PoCmd;

use super::outputs::Outputs;
use super::rail::Rail;
use super::{MotionKind, RailPath, Segment};
use crate::{ArmInstant, Micros, World};

/// The arm, at rest or on its way: where it is commanded to be, and where it really is.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    pub(super) rest: ArmState,
    /// The arm's measures under which `rest.pose` holds; another tool bias makes another pose of
    /// the same joints.
    pub(super) measured: Geometry,
    pub(super) under_way: Option<UnderWay>,
    /// By how much the joints really stand elsewhere than commanded: lost steps, and before homing
    /// the base angle.
    pub(super) slip: [f64; 4],
    /// Part of the slip of J1 that its encoder cannot know: the angle of the base at power-up.
    pub(super) base: f64,
    /// The carriage that the arm stands on, if it does.
    pub(super) rail: Rail,
    /// The speed with which a segment of a continuous path has ended at this very instant, mm/s.
    pub(super) junction_speed: f64,
    /// True if the arm has been homed since power-up.
    pub(super) homed: bool,
    /// Instant and place at which a motion was taken away before its end: a motion that begins by
    /// then begins there.
    left: Option<(ArmInstant, JointAngles, f64)>,
}

/// A motion that has been planned from where the arm stands.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) kind: MotionKind,
    pub(crate) trajectory: Trajectory,
    /// The way of the carriage on the rail: the motion lasts until both rest.
    pub(crate) rail: RailPath,
    /// Alarm to raise at its end, if something stops it before its target.
    pub(crate) alarm: Option<u8>,
    /// Outputs that it switches on its way.
    pub(crate) outputs: Outputs,
}

impl Start {
    /// Time for which arm or carriage moves.
    pub(crate) fn duration(&self) -> Micros {
        self.trajectory.duration_us().max(self.rail.duration())
    }
}

/// Kind, alarm and speed of a motion that has ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ended {
    pub(crate) kind: MotionKind,
    pub(crate) alarm: Option<u8>,
    /// The speed of its end, mm/s.
    pub(crate) speed: f64,
}

/// A motion and when it began.
#[derive(Clone, Debug)]
pub(super) struct UnderWay {
    pub(super) kind: MotionKind,
    pub(super) trajectory: Trajectory,
    /// The way of the carriage that goes with it.
    pub(super) rail: RailPath,
    pub(super) started: ArmInstant,
    /// Instant within its first period at which the motors begin with it, and where they are then.
    begun: ArmInstant,
    from: (JointAngles, f64),
    /// Distance of the motors ahead of the start of a segment by then, mm.
    ahead: f64,
    /// The end of its first period, by which they have come onto its way.
    first_end: ArmInstant,
    pub(super) ends: ArmInstant,
    /// Alarm to raise at its end, if something stops it before its target.
    pub(super) alarm: Option<u8>,
    /// Outputs that it switches on its way.
    pub(super) outputs: Outputs,
    /// Instant at which a limit alarm drops because the joint has come back inside.
    pub(super) leaves_limit: Option<ArmInstant>,
    /// Since when the world sees what it was shown last.
    pub(super) shown: ArmInstant,
    /// Since when J2 and J3 stall, and where they really stand.
    pub(super) stalled: Option<(ArmInstant, [f64; 2])>,
}

impl UnderWay {
    pub(super) fn elapsed(&self, now: ArmInstant) -> Micros {
        now.micros_since(self.started)
    }

    /// Commanded state of the motion.
    fn sample(&self, now: ArmInstant) -> ArmState {
        if now >= self.ends {
            return *self.trajectory.end();
        }
        self.trajectory.sample(self.elapsed(now))
    }

    /// Joint angles and place of the carriage to which the motors have come, between the ends of
    /// two periods as well.
    fn on_the_way(&self, now: ArmInstant) -> (JointAngles, f64) {
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
        // A segment that is planned anew, and slower, does not bring the motors back: they wait for
        // it.
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
            // From where it stood: the whole first period of its way in the time that is left of
            // it.
            let first = self.elapsed(self.first_end);
            let elapsed = since * first / whole;
            return (
                self.trajectory.curve(elapsed).joints,
                self.rail.curve(elapsed),
            );
        }
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

    /// True if the motors began ahead of where the segment leads at this time.
    fn is_behind_motors(&self, now: ArmInstant) -> bool {
        self.ahead > 0.0 && {
            let pose = self.trajectory.curve(self.elapsed(now)).pose;
            pose.distance_to(&self.trajectory.start().pose) < self.ahead
        }
    }

    /// Commanded place of the carriage, mm.
    fn sample_rail(&self, now: ArmInstant) -> f64 {
        if now >= self.ends {
            return self.rail.end();
        }
        self.rail.sample(self.elapsed(now))
    }
}

impl Motion {
    /// The arm at power-up: at rest where it wakes.
    pub(crate) fn at(model: &ArmModel) -> Self {
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

    /// Kind of the motion under way.
    pub(crate) fn kind(&self) -> Option<MotionKind> {
        self.under_way.as_ref().map(|motion| motion.kind)
    }

    /// True if a jog is under way, its end included: the queue does not wait for it.
    pub(crate) fn is_jogging(&self) -> bool {
        matches!(
            self.kind(),
            Some(MotionKind::Jog(_) | MotionKind::JogStop { .. } | MotionKind::RailJog { .. })
        )
    }

    /// True if a Clear or a start of the queue ends the motion under way: it is neither a jog nor
    /// the ramp of a forced stop.
    pub(crate) fn can_be_dropped(&self) -> bool {
        let kind = self.kind();
        !self.is_jogging() && kind.is_some_and(|kind| kind != MotionKind::Brake)
    }

    /// True if it brakes at the end of a jog.
    pub(crate) fn ends_jog(&self) -> bool {
        matches!(self.kind(), Some(MotionKind::JogStop { .. }))
    }

    /// True if a segment of a continuous path is under way.
    pub(crate) fn follows_path(&self) -> bool {
        matches!(self.kind(), Some(MotionKind::Segment(_)))
    }

    /// Gives what is under way another kind.
    pub(crate) fn set_kind(&mut self, kind: MotionKind) {
        if let Some(motion) = &mut self.under_way {
            motion.kind = kind;
        }
    }

    /// The speed that is left of a segment which has ended at this very instant, mm/s.
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
        let on_the_way = [
            motion.leaves_limit,
            switches.map(|at| motion.started.after_micros(at)),
        ];
        let first = on_the_way.into_iter().flatten().min();
        Some(first.map_or(motion.ends, |at| at.min(motion.ends)))
    }

    /// The joints that are commanded.
    pub(crate) fn joints(&self, now: ArmInstant) -> JointAngles {
        self.commanded(now).joints
    }

    /// Joint angles and place of the carriage to which the motors have come, between the ends of
    /// two periods as well.
    pub(super) fn on_the_way(&self, now: ArmInstant) -> (JointAngles, f64) {
        match &self.under_way {
            Some(motion) => motion.on_the_way(now),
            None => (self.rest.joints, self.rail.rest),
        }
    }

    /// Commanded state under the measures in force when the arm began to move.
    fn commanded(&self, now: ArmInstant) -> ArmState {
        match &self.under_way {
            Some(motion) => motion.sample(now),
            None => self.rest,
        }
    }

    /// Commanded place of the carriage on the rail, mm.
    pub(crate) fn rail_at(&self, now: ArmInstant) -> f64 {
        match &self.under_way {
            Some(motion) => motion.sample_rail(now),
            None => self.rail.rest,
        }
    }

    /// Where the arm is commanded to be, for the tool bias in force. A target that has been reached
    /// reads back as it was given.
    pub(super) fn state(&self, now: ArmInstant, geometry: &Geometry) -> ArmState {
        let state = self.commanded(now);
        if *geometry == self.measured {
            state
        } else {
            ArmState::at_joints(geometry, &state.joints)
        }
    }

    /// Takes up a motion. What moved before must have ended.
    pub(crate) fn begin(&mut self, now: ArmInstant, law: MotionLaw, start: Start) {
        let lasting = start.duration();
        // In periods it begins with the one under way: the pose of its end is the first that
        // differs.
        let started = match lasting {
            0 => now,
            _ => ArmInstant::from_micros(law.period_start(now.as_micros())),
        };
        let Start {
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
        let from = { self.left.take() }.filter(|(at, ..)| *at == now);
        let from = from.map_or(stood, |(_, joints, rail)| (joints, rail));
        let ahead = match kind {
            MotionKind::Segment(_) if from != stood => {
                let motors = trajectory.geometry().forward(&from.0);
                motors.distance_to(&trajectory.start().pose)
            }
            _ => 0.0,
        };
        // What is left of a motion keeps the tool that it began with.
        self.measured = *trajectory.geometry();
        self.rest = *trajectory.start();
        self.under_way = Some(UnderWay {
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

    /// The next output that the motion has come to by now; it counts as switched.
    pub(crate) fn take_output(&mut self, now: ArmInstant) -> Option<PoCmd> {
        let motion = self.under_way.as_mut()?;
        let elapsed = motion.elapsed(now);
        let way = (&motion.trajectory, &motion.rail);
        motion.outputs.take_due(elapsed, way)
    }

    /// True if the motion is at its end by now.
    pub(crate) fn is_over(&self, now: ArmInstant) -> bool {
        (self.under_way.as_ref()).is_some_and(|motion| motion.ends <= now)
    }

    /// End of the motion under way.
    pub(crate) fn end(&self) -> Option<Ended> {
        let motion = self.under_way.as_ref()?;
        Some(Ended {
            kind: motion.kind,
            alarm: motion.alarm,
            speed: match motion.alarm {
                None => motion.trajectory.exit_speed(),
                Some(_) => 0.0,
            },
        })
    }

    /// Takes the motion away, at its end or before: the arm rests where it is. Whether there was
    /// one.
    pub(crate) fn rest(&mut self, now: ArmInstant, world: &mut World) -> bool {
        let Some(motion) = &self.under_way else {
            return false;
        };
        let (state, rail) = (motion.sample(now), motion.sample_rail(now));
        let stalled = motion.stalled.map(|_| self.true_pose(now).joints);
        self.end_path(now, world);
        let (joints, on_rail) = motion.on_the_way(now);
        self.left = Some((now, joints, on_rail));
        self.under_way = None;
        self.rest = state;
        self.rail.rest = rail;
        if let Some(joints) = stalled {
            self.stand_at(joints);
        }
        true
    }

    /// Puts the commanded joints somewhere without a motion, and the arm with them.
    pub(crate) fn place_at(&mut self, geometry: &Geometry, joints: JointAngles) {
        self.rest = ArmState::at_joints(geometry, &joints);
        self.measured = *geometry;
        self.under_way = None;
    }
}

/// Continuous paths.
impl Motion {
    /// Where the segment of the queue that is under way leads, if it was planned with the arm's
    /// present measures.
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
