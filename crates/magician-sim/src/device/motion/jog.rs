//! Jogging: one axis moves until a command or a limit stops it (model section 10).
//!
//! What a jog command does depends on what is under way: the same axis passes through standstill,
//! another axis takes over the signed speed (as recorded from a real arm), and a stop ramp is only
//! given a new continuation. The rail never takes over a speed: it waits until the arm rests, and
//! the arm waits for the rail.

use magician_motion::{Jog, JogAxis, MotionError, Plan, Trajectory};
use magician_protocol::JogCommand;

use super::plan::{PlanError, alarm_at_limit, alarm_on_a_path};
use super::{ArmView, JogTarget, MotionKind, Outputs, PlannedMotion, RailPath};
use crate::Micros;
use crate::profile::JogAxisChange;

/// Result of a jog command. No queued command waits for it: it has finished at once.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "it lives for a call")]
pub(crate) enum JogPlan {
    /// The command changes nothing.
    Unchanged,
    /// A motion starts and replaces the running one.
    Begin(PlannedMotion),
    /// The running motion continues as this one.
    Continue(PlannedMotion),
    /// The running stop ramp gets another continuation.
    Then(MotionKind),
    /// The jog cannot be planned.
    Refused(PlanError),
}

impl From<Result<PlannedMotion, PlanError>> for JogPlan {
    fn from(planned: Result<PlannedMotion, PlanError>) -> Self {
        planned.map_or_else(Self::Refused, Self::Begin)
    }
}

/// Axis and direction of a command; `None` if it is not an axis of the arm.
fn jog_of(is_joint: bool, command: JogCommand) -> Option<Jog> {
    let (number, positive) = command.axis()?;
    Jog::numbered(is_joint, number, positive)
}

impl ArmView<'_> {
    /// Plans the effect of a jog command: start, reversal or stop. Jogs of a disabled rail are
    /// ignored.
    pub(crate) fn jog(&self, is_joint: bool, command: JogCommand) -> JogPlan {
        let on_rail = |positive| Some(JogTarget::Rail { positive });
        let jogged = match command {
            // Without a rail its commands are accepted and do nothing (model section 12).
            JogCommand::RailPlus | JogCommand::RailMinus if !self.settings.motion.has_rail() => {
                return JogPlan::Unchanged;
            }
            JogCommand::RailPlus => on_rail(true),
            JogCommand::RailMinus => on_rail(false),
            _ => jog_of(is_joint, command).map(JogTarget::Arm),
        };
        match jogged {
            Some(jogged) => self.jog_along(jogged),
            // Command 0, and anything undefined, stops the jog (assumption `UnknownJog`).
            None => self.stop_jog(None),
        }
    }

    /// Plans a jog in place of the running motion.
    ///
    /// The same axis passes through standstill. Another axis takes over the signed speed, or waits
    /// until the running jog rests, depending on the profile.
    fn jog_along(&self, jogged: JogTarget) -> JogPlan {
        match (jogged, self.motion.kind()) {
            // The same axis: its own speed is the entry speed, also against the new direction.
            (JogTarget::Arm(jog), Some(MotionKind::Jog(running))) if running.axis == jog.axis => {
                self.plan_jog(jog, self.jog_velocity(jog.axis)).into()
            }
            (JogTarget::Rail { positive }, Some(MotionKind::RailJog { .. })) => {
                self.rail_jog(positive)
            }
            (
                JogTarget::Arm(jog),
                Some(MotionKind::Jog(Jog { axis, .. }) | MotionKind::JogStop { axis, .. }),
            ) if self.firmware.profile.motion.jog_axis_change == JogAxisChange::Carries => {
                self.plan_jog(jog, self.jog_velocity(axis)).into()
            }
            (
                _,
                Some(MotionKind::Jog(_) | MotionKind::JogStop { .. } | MotionKind::RailJog { .. }),
            ) => self.stop_jog(Some(jogged)),
            // Not a jog: it is replaced, as by any immediate motion (model section 14).
            _ => self.jog_from_rest(jogged),
        }
    }

    /// True if a command jogs another axis than the running jog.
    pub(crate) fn jogs_another(&self, is_joint: bool, command: JogCommand) -> bool {
        let asked = jog_of(is_joint, command).map(|jog| jog.axis);
        match self.motion.kind() {
            Some(MotionKind::Jog(jog)) => asked != Some(jog.axis),
            Some(MotionKind::JogStop { axis, .. }) => asked != Some(axis),
            Some(MotionKind::RailJog { .. }) => asked.is_some(),
            _ => false,
        }
    }

    /// Plans a jog from rest. Any other motion is replaced, unless the speeds are invalid.
    pub(crate) fn jog_from_rest(&self, jogged: JogTarget) -> JogPlan {
        match jogged {
            JogTarget::Arm(jog) => self.plan_jog(jog, 0.0).into(),
            JogTarget::Rail { positive } => self.rail_jog(positive),
        }
    }

    fn jog_velocity(&self, axis: JogAxis) -> f64 {
        // At rest the entry speed is 0.
        (self.motion.under_way.as_ref()).map_or(0.0, |motion| {
            let elapsed = motion.elapsed(self.now);
            motion.trajectory.velocity_along(axis, elapsed)
        })
    }

    /// Plans a jog from an entry speed on the same axis.
    fn plan_jog(&self, jog: Jog, entry: f64) -> Result<PlannedMotion, PlanError> {
        let ceilings = &self.firmware.model.ceilings;
        let rates = self.settings.motion.jog(jog.axis, ceilings)?;
        let planner = self.planner_given_rates();
        let plan = planner.jog(&self.arm(), jog, rates, entry)?;
        Ok(self.start_jog(MotionKind::Jog(jog), &plan, jog.axis))
    }

    /// Plans the stop of a jog at the jog acceleration; `then` follows when it rests.
    fn stop_jog(&self, then: Option<JogTarget>) -> JogPlan {
        let Some(motion) = &self.motion.under_way else {
            return JogPlan::Unchanged;
        };
        let axis = match motion.kind {
            MotionKind::Jog(jog) => jog.axis,
            MotionKind::JogStop { axis, .. } => {
                // Already braking: only the continuation changes.
                return JogPlan::Then(MotionKind::JogStop { axis, then });
            }
            MotionKind::RailJog { .. } => return self.rail_jog_stop(then),
            // A stop affects jogs only.
            _ => return JogPlan::Unchanged,
        };
        let ceilings = &self.firmware.model.ceilings;
        let deceleration = self.settings.motion.jog_deceleration(axis, ceilings);
        let planner = self.planner_given_rates();
        let elapsed = motion.elapsed(self.now);
        let plan = planner.jog_stop(&motion.trajectory, elapsed, deceleration);
        JogPlan::Continue(self.start_jog(MotionKind::JogStop { axis, then }, &plan, axis))
    }

    fn start_jog(&self, kind: MotionKind, plan: &Plan, axis: JogAxis) -> PlannedMotion {
        let alarm = plan.crossing.map(|crossing| {
            // A straight jog raises the alarm of a path, a joint jog that of its bound.
            if matches!(axis, JogAxis::X | JogAxis::Y | JogAxis::Z)
                || !matches!(crossing.cause, MotionError::Limit { .. })
            {
                alarm_on_a_path(&crossing)
            } else {
                alarm_at_limit(&crossing)
            }
        });
        PlannedMotion::of_arm(self, kind, plan.trajectory, alarm)
    }
}

/// Jogs of the rail.
impl ArmView<'_> {
    /// Plans a jog of the carriage towards an end of the rail, where it rests without an alarm.
    ///
    /// Against its present direction it first comes to rest. A repeated command in the same
    /// direction changes nothing.
    fn rail_jog(&self, positive: bool) -> JogPlan {
        let Some(rates) = self.settings.motion.rail_jog() else {
            return JogPlan::Refused(PlanError::RailSpeed);
        };
        let (length, sign) = (self.motion.rail.length, if positive { 1.0 } else { -1.0 });
        let (from, velocity) = match self.rail_jogging() {
            // Restarting the ramp would slow the carriage down.
            Some((path, _)) if path.heading() == sign => return JogPlan::Unchanged,
            Some((path, elapsed)) => (path.sample(elapsed), path.velocity(elapsed)),
            None => (self.rail(), 0.0),
        };
        // The ends of the rail stop a jog without an alarm (model section 15a).
        let to = if positive { length } else { 0.0 };
        let path = RailPath::slowing(self.law(), from, velocity, rates.acceleration, length);
        self.start_rail_jog(path.then_going(self.law(), to, &rates), None)
    }

    /// Plans the stop of a rail jog at the jog acceleration; `then` follows.
    fn rail_jog_stop(&self, then: Option<JogTarget>) -> JogPlan {
        let rates = self.settings.motion.rail_jog();
        // With invalid speeds it stops at once.
        let deceleration = rates.map_or(f64::INFINITY, |rates| rates.acceleration);
        let Some((path, elapsed)) = self.rail_jogging() else {
            return JogPlan::Unchanged;
        };
        // Already braking: only the continuation changes.
        if path.heading() == 0.0 {
            return JogPlan::Then(MotionKind::RailJog { then });
        }
        let (from, velocity) = (path.sample(elapsed), path.velocity(elapsed));
        let length = self.motion.rail.length;
        let path = RailPath::slowing(self.law(), from, velocity, deceleration, length);
        self.start_rail_jog(path, then)
    }

    /// Path of the running rail jog, and the time since its start.
    fn rail_jogging(&self) -> Option<(RailPath, Micros)> {
        let motion = self.motion.under_way.as_ref()?;
        let jogs = matches!(motion.kind, MotionKind::RailJog { .. });
        jogs.then(|| (motion.rail, motion.elapsed(self.now)))
    }

    fn start_rail_jog(&self, rail: RailPath, then: Option<JogTarget>) -> JogPlan {
        JogPlan::Begin(PlannedMotion {
            kind: MotionKind::RailJog { then },
            trajectory: Trajectory::at_rest(&self.geometry(), &self.arm()),
            rail,
            alarm: None,
            outputs: Outputs::default(),
        })
    }
}
