//! Where the arm is and how it moves (model sections 4, 7, 11 and 14).
//!
//! All that moves is a [`Trajectory`]: it has a beginning and an end, and is asked where it is. What it is for, and what
//! follows it, is its [`Purpose`].

mod homing;
mod jog;
mod limits;
mod outputs;
mod path;
mod plan;
mod rail;
mod really;
mod watch;

use magician_motion::{ArmState, Geometry, Jog, JogAxis, JointAngles, Trajectory};

use crate::Micros;
use crate::device::Device;
use crate::device::dispatch::Step;
use crate::fidelity::Assumption;

pub(crate) use homing::Stage;
pub(crate) use jog::Jogged;
pub(crate) use outputs::Outputs;
pub(crate) use path::{Segment, Way};
use rail::Rail;
pub(crate) use rail::RailCourse;

/// The arm, at rest or on its way: where it is commanded to be, and where it really is.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    rest: ArmState,
    /// The arm's measures under which `rest.pose` holds; another tool bias makes another pose of the same joints.
    measured: Geometry,
    under_way: Option<UnderWay>,
    /// By how much the joints really stand elsewhere than commanded: lost steps, and before homing the base angle.
    slip: [f64; 4],
    /// What of the slip of J1 its encoder cannot know: where the base stood at power-up.
    base: f64,
    /// The carriage that the arm stands on, if it does.
    pub(crate) rail: Rail,
    /// The speed with which a segment of a continuous path has ended at this very instant, mm/s.
    pub(crate) carried: f64,
}

/// A motion and when it began.
#[derive(Clone, Debug)]
pub(crate) struct UnderWay {
    pub(crate) purpose: Purpose,
    pub(crate) trajectory: Trajectory,
    /// The way of the carriage that goes with it.
    pub(crate) rail: RailCourse,
    pub(crate) started: Micros,
    pub(crate) ends: Micros,
    /// What to raise when it has ended: something stops it before its target.
    alarm: Option<u8>,
    /// What it switches on its way.
    outputs: Outputs,
    /// When a limit alarm drops because the joint has come back inside.
    leaves_limit: Option<Micros>,
    /// Since when the world sees what it was shown last.
    shown: Micros,
    /// Since when J2 and J3 stall, and where they really stand.
    stalled: Option<(Micros, [f64; 2])>,
}

/// What a motion is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Purpose {
    /// A move to a target.
    Move,
    /// A segment of a continuous path.
    Segment(Segment),
    /// A jog: it runs until a limit or a command stops it.
    Jog(Jog),
    /// The end of a jog, and the jog that follows it.
    JogStop { axis: JogAxis, then: Option<Jogged> },
    /// Homing, while it looks for the switch of J1.
    Search(Stage),
    /// The end of a motion that was force-stopped.
    Brake,
    /// A jog of the carriage on the rail, or its end and the jog that follows it.
    RailJog { then: Option<Jogged> },
}

impl UnderWay {
    pub(crate) fn elapsed(&self, now: Micros) -> Micros {
        now.saturating_sub(self.started)
    }

    /// Where the motion is commanded to be.
    fn sample(&self, now: Micros) -> ArmState {
        if now >= self.ends {
            return *self.trajectory.end();
        }
        self.trajectory.sample(self.elapsed(now))
    }

    /// Where the carriage is commanded to be.
    fn sample_rail(&self, now: Micros) -> f64 {
        if now >= self.ends {
            return self.rail.end();
        }
        self.rail.sample(self.elapsed(now))
    }
}

impl Motion {
    pub(crate) fn at(joints: JointAngles, rail_length: f64) -> Self {
        let measured = Geometry::default();
        Self {
            rest: ArmState::at_joints(&measured, &joints),
            measured,
            under_way: None,
            slip: [0.0; 4],
            base: 0.0,
            rail: Rail::new(rail_length),
            carried: 0.0,
        }
    }

    /// Whether anything moves; the search of homing counts.
    pub(crate) fn is_moving(&self) -> bool {
        self.under_way.is_some()
    }

    /// Whether a jog is under way, its end included: the queue does not wait for it.
    pub(crate) fn is_jogging(&self) -> bool {
        let purpose = self.under_way.as_ref().map(|motion| motion.purpose);
        matches!(
            purpose,
            Some(Purpose::Jog(_) | Purpose::JogStop { .. } | Purpose::RailJog { .. })
        )
    }

    /// Whether it brakes at the end of a jog.
    pub(crate) fn ends_jog(&self) -> bool {
        let purpose = self.under_way.as_ref().map(|motion| motion.purpose);
        matches!(purpose, Some(Purpose::JogStop { .. }))
    }

    /// Gives what is under way another purpose.
    fn repurpose(&mut self, purpose: Purpose) {
        if let Some(motion) = &mut self.under_way {
            motion.purpose = purpose;
        }
    }

    /// What moves.
    pub(crate) fn under_way(&self) -> Option<&UnderWay> {
        self.under_way.as_ref()
    }

    /// When the motion ends, or on its way switches an output or drops a limit alarm.
    pub(crate) fn next_event(&self) -> Option<Micros> {
        let motion = self.under_way.as_ref()?;
        let switches = motion.outputs.next_due();
        let on_the_way = [
            motion.leaves_limit,
            switches.map(|at| motion.started.saturating_add(at)),
        ];
        let first = on_the_way.into_iter().flatten().min();
        Some(first.map_or(motion.ends, |at| at.min(motion.ends)))
    }

    /// Where the arm is commanded to be under the measures in force when it began to move.
    fn commanded(&self, now: Micros) -> ArmState {
        match &self.under_way {
            Some(motion) => motion.sample(now),
            None => self.rest,
        }
    }

    /// Where the carriage on the rail is commanded to be, mm.
    pub(crate) fn rail_at(&self, now: Micros) -> f64 {
        match &self.under_way {
            Some(motion) => motion.sample_rail(now),
            None => self.rail.rest,
        }
    }

    /// Where the arm is commanded to be, for the tool bias in force. A target that has been reached reads back as it
    /// was given.
    fn state(&self, now: Micros, geometry: &Geometry) -> ArmState {
        let state = self.commanded(now);
        if *geometry == self.measured {
            state
        } else {
            ArmState::at_joints(geometry, &state.joints)
        }
    }
}

impl Device {
    /// Where the arm is commanded to be at the present instant.
    pub(crate) fn arm(&self) -> ArmState {
        self.motion.state(self.now, &self.geometry())
    }

    /// Begins a motion from where the arm stands. What moved before must have ended.
    pub(crate) fn begin(
        &mut self,
        purpose: Purpose,
        trajectory: Trajectory,
        alarm: Option<u8>,
        outputs: Outputs,
    ) -> Step {
        let rail = RailCourse::standing(self.rail());
        self.begin_with_rail(purpose, trajectory, rail, alarm, outputs)
    }

    /// As [`begin`](Self::begin), together with a way of the carriage on the rail: the motion lasts until both rest.
    pub(crate) fn begin_with_rail(
        &mut self,
        purpose: Purpose,
        trajectory: Trajectory,
        rail: RailCourse,
        alarm: Option<u8>,
        outputs: Outputs,
    ) -> Step {
        let lasting = trajectory.duration_us().max(rail.duration());
        // What is left of a motion keeps the tool that it began with.
        self.motion.measured = *trajectory.geometry();
        self.motion.rest = *trajectory.start();
        self.motion.under_way = Some(UnderWay {
            purpose,
            trajectory,
            rail,
            started: self.now,
            ends: self.now.saturating_add(lasting),
            alarm,
            outputs,
            leaves_limit: None,
            shown: self.now,
            stalled: None,
        });
        self.watch_limits();
        if lasting > 0 {
            self.show_course();
            return Step::Moving;
        }
        self.switch_outputs();
        if purpose == Purpose::Move {
            self.assume(Assumption::ShortMove);
        }
        self.end_motion();
        if self.motion.is_moving() {
            Step::Moving
        } else {
            Step::Done
        }
    }

    /// Something is due in the motion: an output, the drop of a limit alarm, its end.
    pub(crate) fn motion_event(&mut self) {
        self.switch_outputs();
        let ended = self.motion.under_way.as_ref().map(|motion| motion.ends);
        if ended.is_some_and(|ends| ends <= self.now) {
            self.end_motion();
        } else {
            self.drop_limit_alarms();
            self.watch_limits();
        }
    }

    fn switch_outputs(&mut self) {
        while let Some(motion) = &mut self.motion.under_way {
            let elapsed = motion.elapsed(self.now);
            let way = (&motion.trajectory, &motion.rail);
            let Some(output) = motion.outputs.take_due(elapsed, way) else {
                return;
            };
            self.switch(output);
        }
    }

    fn end_motion(&mut self) {
        let Some(motion) = &self.motion.under_way else {
            return;
        };
        let (purpose, alarm) = (motion.purpose, motion.alarm);
        let speed = match alarm {
            None => motion.trajectory.exit_speed(),
            Some(_) => 0.0,
        };
        self.rest_here();
        if let Some(code) = alarm {
            self.assume(plan::ending_assumption(code));
            self.assume(Assumption::SoftLimits);
            self.raise(code);
            self.finishes_refused();
        }
        if self.follow_up(purpose, speed) == Step::Done {
            self.finish_moving();
        }
    }

    /// What a motion that came to its end with such a speed leads to.
    fn follow_up(&mut self, purpose: Purpose, speed: f64) -> Step {
        match purpose {
            Purpose::Search(stage) => self.search_on(stage),
            Purpose::Segment(_) => {
                self.segment_ended(speed);
                Step::Done
            }
            Purpose::JogStop { then, .. } | Purpose::RailJog { then } => match then {
                Some(jogged) => self.begin_jogged(jogged),
                None => Step::Done,
            },
            Purpose::Move | Purpose::Brake | Purpose::Jog(_) => Step::Done,
        }
    }

    /// Ends what moves on the spot, without a ramp and without what would follow it: a command of the queue that it
    /// belongs to has finished, and the laser of a path is off.
    pub(crate) fn halt(&mut self) {
        if self.rest_here() {
            self.actuators.burn(0.0);
            self.finish_moving();
        }
    }

    /// Takes the motion away, at its end or before: the arm rests where it is. Whether there was one.
    pub(crate) fn rest_here(&mut self) -> bool {
        let Some(motion) = &self.motion.under_way else {
            return false;
        };
        let (state, rail) = (motion.sample(self.now), motion.sample_rail(self.now));
        let really = motion.stalled.map(|_| self.posture().joints);
        self.end_course();
        self.motion.under_way = None;
        self.motion.rest = state;
        self.motion.rail.rest = rail;
        if let Some(really) = really {
            self.stand_at(really);
        }
        self.drop_limit_alarms();
        true
    }

    /// Puts the commanded joints somewhere without a motion, and the arm with them.
    pub(crate) fn place_at(&mut self, joints: JointAngles) {
        self.motion.rest = ArmState::at_joints(&self.geometry(), &joints);
        self.motion.measured = self.geometry();
        self.motion.under_way = None;
        self.drop_limit_alarms();
    }
}
