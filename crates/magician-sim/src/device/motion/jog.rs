//! Jogging: one axis at a time, until it is told to stop or a limit stops it (model section 10).

use magician_motion::{Jog, JogAxis, MotionError, Plan, Rates};
use magician_protocol::commands::JogCmd;
use magician_protocol::{JogCommand, Writable};

use super::plan::{alarm_at_limit, alarm_on_a_path};
use super::{Outputs, Purpose};
use crate::convert::capped;
use crate::device::Device;
use crate::device::dispatch::Step;

/// What a jog moves, and which way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Jogged {
    /// An axis of the arm.
    Arm(Jog),
    /// The carriage on the rail.
    Rail {
        /// Whether its place grows.
        positive: bool,
    },
}

/// The axis and direction of a command; `None` for what is no axis of the arm.
fn jog_of(is_joint: bool, command: JogCommand) -> Option<Jog> {
    let (number, positive) = command.axis()?;
    Jog::numbered(is_joint, number, positive)
}

impl Device {
    /// Begins to jog, or turns a jog round, or slows it down to a stop. Without a rail its jogs are ignored.
    pub(crate) fn jog(&mut self, is_joint: bool, command: JogCommand) -> Step {
        let on_rail = |positive| Some(Jogged::Rail { positive });
        let jogged = match command {
            JogCommand::RailPlus | JogCommand::RailMinus if !self.has_rail() => return Step::Done,
            JogCommand::RailPlus => on_rail(true),
            JogCommand::RailMinus => on_rail(false),
            _ => jog_of(is_joint, command).map(Jogged::Arm),
        };
        match jogged {
            Some(jogged) => self.jog_along(jogged),
            None => self.stop_jog(None),
        }
    }

    /// A jog of another axis slows down to a stop first; on the same axis the speed passes through zero.
    fn jog_along(&mut self, jogged: Jogged) -> Step {
        let purpose = self.motion.under_way().map(|motion| motion.purpose);
        match (jogged, purpose) {
            (Jogged::Arm(jog), Some(Purpose::Jog(running))) if running.axis == jog.axis => {
                let entry = self.jog_velocity(jog.axis);
                self.begin_jog(jog, entry)
            }
            (Jogged::Rail { positive }, Some(Purpose::RailJog { .. })) => self.rail_jog(positive),
            (_, Some(Purpose::Jog(_) | Purpose::JogStop { .. } | Purpose::RailJog { .. })) => {
                self.stop_jog(Some(jogged))
            }
            _ => self.begin_jogged(jogged),
        }
    }

    /// Whether a command jogs another axis than the one under way.
    pub(crate) fn jogs_another(&self, is_joint: bool, command: JogCommand) -> bool {
        let purpose = self.motion.under_way().map(|motion| motion.purpose);
        let asked = jog_of(is_joint, command).map(|jog| jog.axis);
        match purpose {
            Some(Purpose::Jog(jog)) => asked != Some(jog.axis),
            Some(Purpose::JogStop { axis, .. }) => asked != Some(axis),
            Some(Purpose::RailJog { .. }) => asked.is_some(),
            _ => false,
        }
    }

    /// Jogs from rest. What else moves is replaced, unless there are no speeds to jog with.
    pub(super) fn begin_jogged(&mut self, jogged: Jogged) -> Step {
        match jogged {
            Jogged::Arm(jog) => self.begin_jog(jog, 0.0),
            Jogged::Rail { positive } => self.rail_jog(positive),
        }
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
    fn begin_jog(&mut self, jog: Jog, entry: f64) -> Step {
        let planner = self.planner_told_rates();
        let rates = self.jog_rates(jog.axis);
        match planner.jog(&self.arm(), jog, rates, entry) {
            Ok(plan) => {
                self.halt();
                self.drive(Purpose::Jog(jog), &plan, jog.axis)
            }
            Err(error) => self.unplannable(JogCmd::ROW.id, &error),
        }
    }

    /// Slows a jog down with the acceleration of jogging; `then` follows when it stands.
    fn stop_jog(&mut self, then: Option<Jogged>) -> Step {
        let (axis, trajectory, elapsed) = match self.motion.under_way() {
            Some(motion) => match motion.purpose {
                Purpose::Jog(jog) => (jog.axis, motion.trajectory, motion.elapsed(self.now)),
                // It slows down already: only what follows may change.
                Purpose::JogStop { axis, .. } => {
                    self.motion.repurpose(Purpose::JogStop { axis, then });
                    return Step::Done;
                }
                Purpose::RailJog { .. } => return self.rail_jog_stop(then),
                _ => return Step::Done,
            },
            None => return Step::Done,
        };
        let planner = self.planner_told_rates();
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

    /// The speeds of jogging an axis, each up to its ceiling: the ratio scales the velocity and not the
    /// acceleration. A ratio that is none leaves no speed.
    fn jog_rates(&self, axis: JogAxis) -> Rates {
        let (joint, space) = (&self.settings.jog_joint, &self.settings.jog_coordinate);
        let ([v1, v2, v3, v4], [a1, a2, a3, a4]) = (joint.velocity, joint.acceleration);
        let ([vx, vy, vz, vr], [ax, ay, az, ar]) = (space.velocity, space.acceleration);
        let most = &self.model.ceilings;
        let ([m1, m2, m3, m4], [n1, n2, n3, n4]) = (most.joint_velocity, most.joint_acceleration);
        let (along, linear) = (most.linear_velocity, most.linear_acceleration);
        let (round, rotation) = (most.rotation_velocity, most.rotation_acceleration);
        let (velocity, fastest, acceleration, steepest) = match axis {
            JogAxis::J1 => (v1, m1, a1, n1),
            JogAxis::J2 => (v2, m2, a2, n2),
            JogAxis::J3 => (v3, m3, a3, n3),
            JogAxis::J4 => (v4, m4, a4, n4),
            JogAxis::X => (vx, along, ax, linear),
            JogAxis::Y => (vy, along, ay, linear),
            JogAxis::Z => (vz, along, az, linear),
            JogAxis::R => (vr, round, ar, rotation),
        };
        let ratio = capped(self.settings.jog_common.velocity_ratio.into(), 100.0) / 100.0;
        let ratio = if ratio > 0.0 { ratio } else { f64::NAN };
        Rates {
            velocity: capped(velocity.into(), fastest) * ratio,
            acceleration: capped(acceleration.into(), steepest),
        }
    }
}
