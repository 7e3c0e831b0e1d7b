//! Jogging: one axis at a time, until it is told to stop or a limit stops it (model section 10).

use magician_motion::{Jog, JogAxis, MotionError, Plan, Trajectory};
use magician_protocol::JogCommand;

use super::plan::{NoPlan, alarm_at_limit, alarm_on_a_path};
use super::{ArmView, Jogged, MotionKind, Outputs, RailPath, Start};
use crate::Micros;
use crate::profile::JogAxisChange;

/// What becomes of a jog. Nothing waits for one: its command has finished at once.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "it lives for a call")]
pub(crate) enum JogPlan {
    /// It goes on as it does.
    Unchanged,
    /// It begins in place of what moves.
    Begin(Start),
    /// What moves goes on as this.
    Continue(Start),
    /// It slows down already: only what follows changes.
    Then(MotionKind),
    /// It cannot be planned.
    Refused(NoPlan),
}

impl From<Result<Start, NoPlan>> for JogPlan {
    fn from(planned: Result<Start, NoPlan>) -> Self {
        planned.map_or_else(Self::Refused, Self::Begin)
    }
}

/// The axis and direction of a command; `None` for what is no axis of the arm.
fn jog_of(is_joint: bool, command: JogCommand) -> Option<Jog> {
    let (number, positive) = command.axis()?;
    Jog::numbered(is_joint, number, positive)
}

impl ArmView<'_> {
    /// Begins to jog, or turns a jog round, or slows it down to a stop. Without a rail its jogs are
    /// ignored.
    pub(crate) fn jog(&self, is_joint: bool, command: JogCommand) -> JogPlan {
        let on_rail = |positive| Some(Jogged::Rail { positive });
        let jogged = match command {
            JogCommand::RailPlus | JogCommand::RailMinus if !self.settings.motion.has_rail() => {
                return JogPlan::Unchanged;
            }
            JogCommand::RailPlus => on_rail(true),
            JogCommand::RailMinus => on_rail(false),
            _ => jog_of(is_joint, command).map(Jogged::Arm),
        };
        match jogged {
            Some(jogged) => self.jog_along(jogged),
            None => self.stop_jog(None),
        }
    }

    /// On the same axis the speed passes through zero; another axis takes over the speed with its
    /// sign, or waits until the one under way rests.
    fn jog_along(&self, jogged: Jogged) -> JogPlan {
        match (jogged, self.motion.kind()) {
            (Jogged::Arm(jog), Some(MotionKind::Jog(running))) if running.axis == jog.axis => {
                self.plan_jog(jog, self.jog_velocity(jog.axis)).into()
            }
            (Jogged::Rail { positive }, Some(MotionKind::RailJog { .. })) => {
                self.rail_jog(positive)
            }
            (
                Jogged::Arm(jog),
                Some(MotionKind::Jog(Jog { axis, .. }) | MotionKind::JogStop { axis, .. }),
            ) if self.firmware.profile.motion.jog_axis_change == JogAxisChange::Carries => {
                self.plan_jog(jog, self.jog_velocity(axis)).into()
            }
            (
                _,
                Some(MotionKind::Jog(_) | MotionKind::JogStop { .. } | MotionKind::RailJog { .. }),
            ) => self.stop_jog(Some(jogged)),
            _ => self.jog_from_rest(jogged),
        }
    }

    /// Whether a command jogs another axis than the one under way.
    pub(crate) fn jogs_another(&self, is_joint: bool, command: JogCommand) -> bool {
        let asked = jog_of(is_joint, command).map(|jog| jog.axis);
        match self.motion.kind() {
            Some(MotionKind::Jog(jog)) => asked != Some(jog.axis),
            Some(MotionKind::JogStop { axis, .. }) => asked != Some(axis),
            Some(MotionKind::RailJog { .. }) => asked.is_some(),
            _ => false,
        }
    }

    /// Jogs from rest. What else moves is replaced, unless there are no speeds to jog with.
    pub(crate) fn jog_from_rest(&self, jogged: Jogged) -> JogPlan {
        match jogged {
            Jogged::Arm(jog) => self.plan_jog(jog, 0.0).into(),
            Jogged::Rail { positive } => self.rail_jog(positive),
        }
    }

    fn jog_velocity(&self, axis: JogAxis) -> f64 {
        (self.motion.under_way.as_ref()).map_or(0.0, |motion| {
            let elapsed = motion.elapsed(self.now);
            motion.trajectory.velocity_along(axis, elapsed)
        })
    }

    /// Jogs from a speed on the same axis.
    fn plan_jog(&self, jog: Jog, entry: f64) -> Result<Start, NoPlan> {
        let ceilings = &self.firmware.model.ceilings;
        let rates = self.settings.motion.jog(jog.axis, ceilings)?;
        let planner = self.planner_given_rates();
        let plan = planner.jog(&self.arm(), jog, rates, entry)?;
        Ok(self.start_jog(MotionKind::Jog(jog), &plan, jog.axis))
    }

    /// Slows a jog down with the acceleration of jogging; `then` follows when it stands.
    fn stop_jog(&self, then: Option<Jogged>) -> JogPlan {
        let Some(motion) = &self.motion.under_way else {
            return JogPlan::Unchanged;
        };
        let axis = match motion.kind {
            MotionKind::Jog(jog) => jog.axis,
            MotionKind::JogStop { axis, .. } => {
                return JogPlan::Then(MotionKind::JogStop { axis, then });
            }
            MotionKind::RailJog { .. } => return self.rail_jog_stop(then),
            _ => return JogPlan::Unchanged,
        };
        let ceilings = &self.firmware.model.ceilings;
        let deceleration = self.settings.motion.jog_deceleration(axis, ceilings);
        let planner = self.planner_given_rates();
        let elapsed = motion.elapsed(self.now);
        let plan = planner.jog_stop(&motion.trajectory, elapsed, deceleration);
        JogPlan::Continue(self.start_jog(MotionKind::JogStop { axis, then }, &plan, axis))
    }

    fn start_jog(&self, kind: MotionKind, plan: &Plan, axis: JogAxis) -> Start {
        let alarm = plan.crossing.map(|crossing| {
            if matches!(axis, JogAxis::X | JogAxis::Y | JogAxis::Z)
                || !matches!(crossing.cause, MotionError::Limit { .. })
            {
                alarm_on_a_path(&crossing)
            } else {
                alarm_at_limit(&crossing)
            }
        });
        Start::of_arm(self, kind, plan.trajectory, alarm)
    }
}

/// The carriage.
impl ArmView<'_> {
    /// Jogs the carriage towards the end of the rail, where it comes to rest without an alarm.
    /// Against the way that it moves it first comes to rest; told again the direction that it has,
    /// it goes on as it does.
    fn rail_jog(&self, positive: bool) -> JogPlan {
        let Some(rates) = self.settings.motion.rail_jog() else {
            return JogPlan::Refused(NoPlan::RailSpeed);
        };
        let (length, sign) = (self.motion.rail.length, if positive { 1.0 } else { -1.0 });
        let (from, velocity) = match self.rail_jogging() {
            Some((path, _)) if path.heading() == sign => return JogPlan::Unchanged,
            Some((path, elapsed)) => (path.sample(elapsed), path.velocity(elapsed)),
            None => (self.rail(), 0.0),
        };
        let to = if positive { length } else { 0.0 };
        let path = RailPath::slowing(self.law(), from, velocity, rates.acceleration, length);
        self.start_rail_jog(path.then_going(self.law(), to, &rates), None)
    }

    /// Ends a jog of the carriage: it comes to rest at the acceleration of the jog, and `then`
    /// follows.
    fn rail_jog_stop(&self, then: Option<Jogged>) -> JogPlan {
        let rates = self.settings.motion.rail_jog();
        let deceleration = rates.map_or(f64::INFINITY, |rates| rates.acceleration);
        let Some((path, elapsed)) = self.rail_jogging() else {
            return JogPlan::Unchanged;
        };
        if path.heading() == 0.0 {
            return JogPlan::Then(MotionKind::RailJog { then });
        }
        let (from, velocity) = (path.sample(elapsed), path.velocity(elapsed));
        let length = self.motion.rail.length;
        let path = RailPath::slowing(self.law(), from, velocity, deceleration, length);
        self.start_rail_jog(path, then)
    }

    /// The jog of the carriage that is under way, and how long it has been.
    fn rail_jogging(&self) -> Option<(RailPath, Micros)> {
        let motion = self.motion.under_way.as_ref()?;
        let jogs = matches!(motion.kind, MotionKind::RailJog { .. });
        jogs.then(|| (motion.rail, motion.elapsed(self.now)))
    }

    fn start_rail_jog(&self, rail: RailPath, then: Option<Jogged>) -> JogPlan {
        JogPlan::Begin(Start {
            kind: MotionKind::RailJog { then },
            trajectory: Trajectory::at_rest(&self.geometry(), &self.arm()),
            rail,
            alarm: None,
            outputs: Outputs::default(),
        })
    }
}
