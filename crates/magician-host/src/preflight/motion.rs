//! Target, path and duration of each command.

use magician_model::PtpMove;
use magician_motion::{
    ArmState, CpSegment, JointAngles, KinematicLimits, LookAhead, MotionError, Move, MoveKind,
    Plan, Planner, Pose, Speeds, Target,
};
use magician_protocol::commands::{CircleCmd, EMotorS};
use magician_protocol::{CpMode, Effect, JogCommand, Set};

use super::guards::refuse;
use super::{FOREVER, Preflight};
use crate::error::of_motion;
use crate::{Error, ErrorKind, Result};
use crate::{Message, message};

/// Largest pulse rate that any stepper follows, pulses/s.
const FASTEST_PULSES: f64 = 1e6;

/// True if the tool bias decides whether the arm can execute a command. False for targets in joint
/// angles.
pub(super) fn depends_on_tool(command: &Set) -> bool {
    PtpMove::from_command(command).is_none_or(|ptp| !ptp.mode.is_joint())
}

impl Preflight {
    /// Advances the state by a command. Returns its duration, us.
    pub(super) fn follow(&mut self, command: &Set) -> Result<u64> {
        if let Some(ptp) = PtpMove::from_command(command) {
            return self.ptp(&ptp);
        }
        match command {
            Set::CpCmd(cp) => self.segment(cp.cp_mode, [cp.x, cp.y, cp.z]),
            Set::CpLeCmd(cp) => self.segment(cp.cp_mode, [cp.x, cp.y, cp.z]),
            Set::ArcCmd(arc) => self.arc(arc.cir_point, arc.to_point),
            Set::CircleCmd(circle) => self.circle(circle),
            Set::WaitCmd(wait) => Ok(u64::from(wait.timeout) * 1000),
            Set::TrigCmd(_) => Ok(FOREVER),
            Set::EMotorS(motor) => Ok(turning(motor)),
            Set::HomeCmd(_) => self.homing(),
            Set::JogCmd(jog) if jog.cmd != JogCommand::Stop => self.jog(jog.cmd),
            Set::ResetPose(_) => {
                // The arm corrects its own angles: where it is afterwards is not known here.
                self.at = None;
                Ok(0)
            }
            Set::EndEffectorParams(_) => {
                let mut then = self.now;
                then.note(command, &self.model.ceilings);
                let geometry = self.model.geometry(then.settings.tool());
                if let Some(before) = self.at {
                    let after = ArmState::at_joints(&geometry, &before.joints);
                    self.tool_within_fence(&before, &after)?;
                    self.at = Some(after);
                }
                self.now = then;
                // A home point that was never set stays at its joints, so its position changes with
                // the tool. Whether it was set cannot be read.
                let home = self.now.home.filter(|_| self.home_is_set);
                self.home = home.map(|home| [home.x, home.y, home.z, home.r].map(f64::from).into());
                Ok(0)
            }
            Set::HomeParams(home) => {
                self.check_points([[home.x, home.y, home.z, home.r]])?;
                self.now.note(command, &self.model.ceilings);
                self.home = Some([home.x, home.y, home.z, home.r].map(f64::from).into());
                self.home_is_set = true;
                Ok(0)
            }
            // Motions by other rules, to an unknown position.
            other if other.row().effect == Effect::Motion => {
                self.known_way(other)?;
                self.at = None;
                Ok(FOREVER)
            }
            // A setting or an output.
            _ => {
                self.now.note(command, &self.model.ceilings);
                Ok(0)
            }
        }
    }

    pub(super) fn planner(&self, speeds: Speeds) -> Planner {
        self.model.planner(self.now.settings.tool(), speeds)
    }

    /// Notes a motion within this arm's limits but beyond the limits common to all arms.
    fn note_doubt(&mut self, plan: &Result<Plan, MotionError>) {
        let certain = self.model.certain;
        if self.model.limits != certain
            && let Ok(Plan {
                trajectory,
                crossing: None,
                ..
            }) = plan
        {
            self.doubt = trajectory.first_beyond(&certain);
        }
    }

    fn ptp(&mut self, ptp: &PtpMove) -> Result<u64> {
        let request = self.request(ptp)?;
        let rail = self.rail_move(ptp)?;
        let Some(from) = self.at else {
            self.known_start()?;
            self.arrive(&request)?;
            self.rail = rail.to;
            return Ok(FOREVER);
        };
        let planner = self.planner(self.now.settings.speeds());
        // Arm and rail start and end together, so the faster one is slowed down.
        let least = rail.time.unwrap_or(0);
        let plan = planner.plan_with_min_duration(&from, &request, least);
        self.note_doubt(&plan);
        if let Ok(Plan {
            crossing: Some(_), ..
        }) = plan
        {
            // A target beyond a joint limit is the better error than the point where the path
            // crosses it.
            self.say_end(&from, &request)?;
        }
        let arm = self.arrive_in_time(plan)?;
        self.rail = rail.to;
        Ok(rail.time.map_or(FOREVER, |time| arm.max(time)))
    }

    /// Request for the planner (errata E28).
    pub(super) fn request(&self, ptp: &PtpMove) -> Result<Move> {
        ptp.request(self.now.settings.jump()).ok_or_else(|| {
            let mode = u8::from(ptp.mode);
            let message = message!("unknown point-to-point mode {mode}; modes are 0 to 9", mode);
            Error::invalid(message).with_limit(mode.into(), 9.0, "mode")
        })
    }

    /// Reports joint angles beyond their limit as such, rather than the crossing on the path to
    /// them.
    fn say_end(&self, from: &ArmState, request: &Move) -> Result<()> {
        let end = match request.target {
            Target::Joints(joints) => joints,
            Target::JointIncrement(by) => from.joints.offset_by(&by),
            Target::Pose(_) | Target::PoseIncrement(_) => return Ok(()),
        };
        self.reached(self.model.limits.check(&end)).map(drop)
    }

    /// Completes a motion, unless its path is blocked. Returns its duration, us.
    fn arrive_by(&mut self, plan: Result<Plan, MotionError>) -> Result<u64> {
        let Some(plan) = self.reached(plan)? else {
            // The arm would refuse it and stay where it is.
            return Ok(0);
        };
        if let Some(crossing) = plan.crossing.filter(|_| self.guards.reach) {
            let done = 100.0 * crossing.progress;
            return Err(Error::from(crossing.cause).on_the_way(done));
        }
        self.within_fence(&plan.trajectory)?;
        self.at = Some(*plan.trajectory.end());
        Ok(plan.trajectory.duration_us())
    }

    /// Completes a motion as [`arrive_by`](Self::arrive_by), and checks its planned speed.
    fn arrive_in_time(&mut self, plan: Result<Plan, MotionError>) -> Result<u64> {
        if let Ok(plan) = &plan {
            self.slow_enough(&plan.trajectory)?;
        }
        self.arrive_by(plan)
    }

    /// Result of a plan. `None` if the target is out of reach and the guard for it is off.
    fn reached<T>(&self, planned: Result<T, MotionError>) -> Result<Option<T>> {
        match planned.map_err(Error::from) {
            Ok(value) => Ok(Some(value)),
            Err(error) if error.kind() == ErrorKind::Unreachable && !self.guards.reach => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Refuses a motion whose start is unknown, if the guard is on.
    pub(super) fn unknown_way(&self, what: Message) -> Result<()> {
        let why = message!(
            "the arm's position by then is unknown, and therefore {what}; first move it to a pose \
                or to joint angles with all joints together",
            what
        );
        refuse(self.guards.unknown_start, "unknown_start", why)
    }

    /// Completes a motion of which only the end is known.
    ///
    /// If all joints move together between two points within their limits, they stay within them.
    /// Only J2 - J3 could briefly leave its range, if one of them is much slower.
    fn arrive(&mut self, request: &Move) -> Result<()> {
        // Only a move of all joints stays within the limits from any start.
        if request.kind != MoveKind::Joint {
            self.unknown_way(message!("its path"))?;
        }
        let end = match &request.target {
            Target::Pose(pose) => ArmState::at_pose(&self.geometry(), pose, &self.model.limits),
            Target::Joints(joints) => {
                let state = ArmState::at_joints(&self.geometry(), joints);
                self.model.limits.check(joints).map(|()| state)
            }
            Target::PoseIncrement(_) | Target::JointIncrement(_) => {
                self.unknown_way(message!("its end"))?;
                self.at = None;
                return Ok(());
            }
        };
        self.at = self.reached(end)?;
        Ok(())
    }

    /// Follows a segment of a continuous path: straight, with J4 at rest.
    fn segment(&mut self, mode: CpMode, point: [f32; 3]) -> Result<u64> {
        let look_ahead = LookAhead::new(
            &self.now.settings.cp(&self.model),
            &self.model.ceilings,
            self.model.law,
        )?;
        let to = point.map(f64::from);
        let Some(from) = self.at else {
            self.known_start()?;
            self.unknown_way(message!("the begin of the path"))?;
            let [x, y, z] = to;
            if mode == CpMode::Absolute {
                let target = Target::Pose([x, y, z, 0.0].into());
                let kind = MoveKind::Joint;
                self.arrive(&Move { target, kind })?;
            }
            return Ok(FOREVER);
        };
        let start = [from.pose.x, from.pose.y, from.pose.z];
        let [x, y, z] = to;
        let to = match (mode, start) {
            (CpMode::Relative, [a, b, c]) => [a + x, b + y, c + z],
            _ => to,
        };
        let way = CpSegment::between(start, to);
        if way.is_empty() {
            return Ok(0);
        }
        self.path_slow_enough(look_ahead.rates(&way).velocity)?;
        // The path does not depend on the speed, so any rates serve to plan it.
        let rates = KinematicLimits {
            velocity: 100.0,
            acceleration: 100.0,
        };
        let planner = self.planner(self.model.power_up.speeds());
        let plan = planner.segment(&from, to, 0.0, 0.0, rates);
        self.arrive_by(plan)?;
        // Checking the end of each segment is enough, at a fraction of the work.
        let certain = self.model.certain;
        if self.model.limits != certain {
            let end = self.at.map(|at| certain.check(&at.joints));
            self.doubt = end.and_then(Result::err);
        }
        Ok(self.path.add(look_ahead, way))
    }

    fn arc(&mut self, via: [f32; 4], to: [f32; 4]) -> Result<u64> {
        let Some(from) = self.at else {
            self.known_start()?;
            self.unknown_way(message!("the arc"))?;
            let (target, kind) = (Target::Pose(to.map(f64::from).into()), MoveKind::Joint);
            self.arrive(&Move { target, kind })?;
            return Ok(FOREVER);
        };
        let [via, to] = [via, to].map(|point| point.map(f64::from).into());
        let planner = self.planner(self.now.settings.arc_speeds());
        let plan = planner.arc(&from, &via, &to);
        self.note_doubt(&plan);
        self.arrive_in_time(plan)
    }

    fn circle(&mut self, circle: &CircleCmd) -> Result<u64> {
        let points = [circle.cir_point, circle.to_point];
        let Some(from) = self.at else {
            self.known_start()?;
            self.unknown_way(message!("the circle"))?;
            self.check_points(points)?;
            return Ok(FOREVER);
        };
        let [via, to] = points.map(|point| point.map(f64::from).into());
        let planner = self.planner(self.now.settings.arc_speeds());
        let plan = planner.circle(&from, &via, &to, circle.count);
        self.note_doubt(&plan);
        self.arrive_in_time(plan)
    }

    /// Checks that points are in reach, but not the path to them.
    fn check_points<const N: usize>(&self, points: [[f32; 4]; N]) -> Result<()> {
        let geometry = self.geometry();
        for point in points {
            let pose = point.map(f64::from).into();
            self.reached(geometry.inverse_within(&pose, &self.model.limits))?;
        }
        Ok(())
    }

    /// Follows homing: from the switch of J1 to the home point, all joints together (model section
    /// 11). The duration of the search depends on where the base really is, so it is unknown.
    fn homing(&mut self) -> Result<u64> {
        let Some(home) = self.home_point() else {
            self.at = None;
            return Ok(self.homed());
        };
        // An arm that cannot reach its home point ends at the joints of homing without one (model
        // section 15a).
        let reached = self.geometry().inverse_within(&home, &self.model.limits);
        let request = Move {
            target: match reached {
                Ok(_) => Target::Pose(home),
                Err(_) => Target::Joints(self.model.homing.joints),
            },
            kind: MoveKind::Joint,
        };
        match self.at {
            None => {
                self.known_start()?;
                self.arrive(&request)?;
            }
            Some(at) => {
                self.search_within_fence(&at)?;
                let joints = JointAngles {
                    j1: self.model.homing.switch,
                    ..at.joints
                };
                let planner = self.planner(self.model.homing.speeds());
                let from = ArmState::at_joints(&planner.geometry, &joints);
                let plan = planner.plan(&from, &request);
                self.note_doubt(&plan);
                self.arrive_by(plan)?;
            }
        }
        Ok(self.homed())
    }

    /// Home point. `None` if unknown, unless a fence needs one: then the usual point is assumed.
    fn home_point(&self) -> Option<Pose> {
        let usual = || self.geometry().forward(&self.model.homing.joints);
        self.home
            .or_else(|| self.held_fence().is_some().then(usual))
    }

    fn homed(&mut self) -> u64 {
        // Homing moves the carriage to its end.
        if self.now.settings.has_rail() {
            self.rail = Some(0.0);
        }
        FOREVER
    }

    /// Follows a jog, which continues until a limit ends it.
    fn jog(&mut self, command: JogCommand) -> Result<u64> {
        let why = message!(
            "a queued jog only ends at a limit, with an alarm: jog at once instead, and \
            stop it"
        );
        refuse(self.guards.jog, "jog", why)?;
        match command {
            JogCommand::RailPlus | JogCommand::RailMinus if !self.now.settings.has_rail() => {
                return Ok(0);
            }
            JogCommand::RailPlus | JogCommand::RailMinus => self.rail = None,
            _ => self.at = None,
        }
        Ok(FOREVER)
    }
}

/// Words for a motion beyond the limits that every arm keeps ([`Step::doubt`](super::Step::doubt)):
/// the end of a sentence that begins with the motion and "where".
#[must_use]
pub fn doubt_in_words(cause: &MotionError) -> Message {
    match *cause {
        MotionError::Limit {
            bound,
            value,
            limit,
        } => {
            let joint = Message::word(bound.subject());
            if bound.is_upper() {
                message!(
                    "{joint} is at {value:.1} degrees: arms were seen there, but not every arm is known to go above {limit:.1}",
                    joint,
                    value,
                    limit
                )
            } else {
                message!(
                    "{joint} is at {value:.1} degrees: arms were seen there, but not every arm is known to go below {limit:.1}",
                    joint,
                    value,
                    limit
                )
            }
        }
        ref other => message!(
            "not every arm is known to go ({cause})",
            cause = of_motion(other)
        ),
    }
}

/// Time that a motor counts its pulses, us.
fn turning(motor: &EMotorS) -> u64 {
    let rate = motor.pulses_per_second().abs().min(FASTEST_PULSES);
    if !motor.is_enabled.is_on() || rate == 0.0 {
        return 0;
    }
    (f64::from(motor.distance) / rate * 1e6).round() as u64
}
