//! Jogging: one axis at a time, until it is told to stop or a limit stops it (model section 10).

use magician_motion::{Jog, JogAxis, MotionError, Plan, Rates};
use magician_protocol::commands::JogCmd;
use magician_protocol::{JogCommand, Writable};

use super::plan::{alarm_at_limit, alarm_on_a_path};
use super::{Outputs, Purpose};
use crate::convert::capped;
use crate::core::Core;
use crate::dispatch::Step;

/// The axis and direction of a command; `None` for what is no axis of the arm.
fn jog_of(is_joint: bool, command: JogCommand) -> Option<Jog> {
    let (number, positive) = match command {
        JogCommand::Axis1Plus => (0, true),
        JogCommand::Axis1Minus => (0, false),
        JogCommand::Axis2Plus => (1, true),
        JogCommand::Axis2Minus => (1, false),
        JogCommand::Axis3Plus => (2, true),
        JogCommand::Axis3Minus => (2, false),
        JogCommand::Axis4Plus => (3, true),
        JogCommand::Axis4Minus => (3, false),
        _ => return None,
    };
    const JOINTS: [JogAxis; 4] = [JogAxis::J1, JogAxis::J2, JogAxis::J3, JogAxis::J4];
    const COORDINATES: [JogAxis; 4] = [JogAxis::X, JogAxis::Y, JogAxis::Z, JogAxis::R];
    let axes = if is_joint { JOINTS } else { COORDINATES };
    let axis = *axes.get(number)?;
    Some(Jog { axis, positive })
}

impl Core {
    /// Begins to jog, or turns a jog round, or slows it down to a stop.
    pub(crate) fn jog(&mut self, is_joint: bool, command: JogCommand) -> Step {
        match jog_of(is_joint, command) {
            Some(jog) => self.jog_along(jog),
            None => self.stop_jog(None),
        }
    }

    /// A jog of another axis slows down to a stop first; on the same axis the speed passes through zero.
    fn jog_along(&mut self, jog: Jog) -> Step {
        match self.motion.under_way().map(|motion| motion.purpose) {
            Some(Purpose::Jog(running)) if running.axis == jog.axis => {
                let entry = self.jog_velocity(jog.axis);
                self.begin_jog(jog, entry)
            }
            Some(Purpose::Jog(_) | Purpose::JogStop { .. }) => self.stop_jog(Some(jog)),
            _ => {
                self.halt();
                self.begin_jog(jog, 0.0)
            }
        }
    }

    /// Whether a command jogs another axis than the one under way.
    pub(crate) fn jogs_another(&self, is_joint: bool, command: JogCommand) -> bool {
        let purpose = self.motion.under_way().map(|motion| motion.purpose);
        let axis = match purpose {
            Some(Purpose::Jog(jog)) => jog.axis,
            Some(Purpose::JogStop { axis, .. }) => axis,
            _ => return false,
        };
        jog_of(is_joint, command).is_some_and(|jog| jog.axis != axis)
    }

    fn jog_velocity(&self, axis: JogAxis) -> f64 {
        let motion = self.motion.under_way();
        motion.map_or(0.0, |motion| {
            motion
                .trajectory
                .velocity_along(axis, motion.elapsed(self.now))
        })
    }

    /// Jogs from a speed on the same axis.
    pub(super) fn begin_jog(&mut self, jog: Jog, entry: f64) -> Step {
        let planner = self.planner(self.ptp_speeds());
        let rates = self.jog_rates(jog.axis);
        match planner.jog(&self.arm(), jog, rates, entry) {
            Ok(plan) => {
                self.rest_here();
                self.drive(Purpose::Jog(jog), &plan, jog.axis)
            }
            Err(error) => self.unplannable(JogCmd::ROW.id, &error),
        }
    }

    /// Slows a jog down with the acceleration of jogging; `then` follows when it stands.
    fn stop_jog(&mut self, then: Option<Jog>) -> Step {
        let (axis, trajectory, elapsed) = match self.motion.under_way() {
            Some(motion) => match motion.purpose {
                Purpose::Jog(jog) => (jog.axis, motion.trajectory, motion.elapsed(self.now)),
                // It slows down already: only what follows may change.
                Purpose::JogStop { axis, .. } => {
                    self.motion.repurpose(Purpose::JogStop { axis, then });
                    return Step::Done;
                }
                _ => return Step::Done,
            },
            None => return Step::Done,
        };
        let planner = self.planner(self.ptp_speeds());
        let plan = planner.jog_stop(&trajectory, elapsed, self.jog_rates(axis).acceleration);
        self.rest_here();
        self.drive(Purpose::JogStop { axis, then }, &plan, axis)
    }

    /// Whatever happens on the way, the command has finished: the queue does not wait for a jog.
    fn drive(&mut self, purpose: Purpose, plan: &Plan, axis: JogAxis) -> Step {
        let alarm = plan.crossing.map(|crossing| {
            if matches!(axis, JogAxis::X | JogAxis::Y | JogAxis::Z)
                || !matches!(crossing.cause, MotionError::Limit { .. })
            {
                alarm_on_a_path(&crossing)
            } else {
                alarm_at_limit(&crossing)
            }
        });
        self.begin(purpose, plan.trajectory, alarm, Outputs::default());
        Step::Done
    }

    /// The speeds of jogging an axis: the ratio scales the velocity and not the acceleration.
    fn jog_rates(&self, axis: JogAxis) -> Rates {
        let (joint, space) = (&self.settings.jog_joint, &self.settings.jog_coordinate);
        let ([v1, v2, v3, v4], [a1, a2, a3, a4]) = (joint.velocity, joint.acceleration);
        let ([vx, vy, vz, vr], [ax, ay, az, ar]) = (space.velocity, space.acceleration);
        let (velocity, acceleration) = match axis {
            JogAxis::J1 => (v1, a1),
            JogAxis::J2 => (v2, a2),
            JogAxis::J3 => (v3, a3),
            JogAxis::J4 => (v4, a4),
            JogAxis::X => (vx, ax),
            JogAxis::Y => (vy, ay),
            JogAxis::Z => (vz, az),
            JogAxis::R => (vr, ar),
        };
        let ratio = capped(self.settings.jog_common.velocity_ratio.into(), 100.0);
        Rates {
            velocity: f64::from(velocity) * ratio / 100.0,
            acceleration: acceleration.into(),
        }
    }
}
