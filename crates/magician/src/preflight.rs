use magician_motion::{
    ArmState, Geometry, JointAngles, JumpHeights, Limits, Move, MoveKind, Plan, Planner, Target,
    ToolBias, Transfer,
};
use magician_protocol::commands::{CircleCmd, EndEffectorParams, Pose, PtpJump2Params};
use magician_protocol::{CpMode, Ctrl, Field, FieldValue, FrameBuf, PtpMode, Set};

use crate::{Error, ErrorKind, Result};

/// Checks commands before a byte of them is sent: numbers that are none, speeds that are none,
/// targets out of reach, lines and jumps that leave it on the way.
///
/// It follows the arm: each command is checked from where the one before ends. Where that cannot be
/// known (after homing to a point of the arm's own, or a jog) targets are checked and ways are not.
///
/// ```
/// use magician::words::{self, Preflight};
/// use magician::{ErrorKind, JointAngles, ToolBias};
///
/// let mut check = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
/// check.check(&words::line_to(250.0, 50.0, 20.0, 0.0))?;
///
/// let error = check.check(&words::line_to(400.0, 0.0, 0.0, 0.0)).unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::Unreachable);
/// assert!(error.value() > error.limit());
/// # Ok::<(), magician::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Preflight {
    planner: Planner,
    heights: JumpHeights,
    /// Where the arm is by then, when that is known.
    at: Option<ArmState>,
    /// Where homing leads, when this run has said so.
    home: Option<magician_motion::Pose>,
}

impl Preflight {
    /// Starts from what the arm reports.
    #[must_use]
    pub fn new(pose: &Pose, tool: &EndEffectorParams, jump: &PtpJump2Params) -> Self {
        let joints = JointAngles::from(pose.joint_angle.map(f64::from));
        let mut check = Self::at(joints, bias(tool));
        check.at = Some(ArmState {
            joints,
            pose: [pose.x, pose.y, pose.z, pose.r].map(f64::from).into(),
        });
        check.heights = heights(jump);
        check
    }

    /// Starts from joint angles, with power-up settings.
    #[must_use]
    pub fn at(joints: JointAngles, tool: ToolBias) -> Self {
        let geometry = Geometry::magician(tool);
        Self {
            planner: Planner {
                geometry,
                ..Planner::default()
            },
            heights: JumpHeights::POWER_UP,
            at: Some(ArmState::at_joints(&geometry, &joints)),
            home: None,
        }
    }

    /// Checks against other limits than the controller's, [`Limits::GUARANTEED`] for one.
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.planner.limits = limits;
        self
    }

    /// Where the arm is after the commands checked so far, when it is known.
    #[must_use]
    pub fn arm(&self) -> Option<&ArmState> {
        self.at.as_ref()
    }

    /// Checks the next command.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] for a number that makes no sense, [`ErrorKind::Unreachable`]
    /// with value and limit.
    pub fn check(&mut self, command: &Set) -> Result<()> {
        let checked = check_numbers(command).and_then(|()| self.follow(command));
        checked.map_err(|error| error.with_command(command.row().set_name))
    }

    fn follow(&mut self, command: &Set) -> Result<()> {
        match command {
            Set::PtpCmd(ptp) => self.ptp(ptp.ptp_mode, [ptp.x, ptp.y, ptp.z, ptp.r]),
            Set::PtpPoCmd(ptp) => self.ptp(ptp.ptp_mode, [ptp.x, ptp.y, ptp.z, ptp.r]),
            Set::PtpWithLCmd(ptp) => {
                check_rail(ptp.ptp_mode, ptp.l)?;
                self.ptp(ptp.ptp_mode, [ptp.x, ptp.y, ptp.z, ptp.r])
            }
            Set::PtpPoWithLCmd(ptp) => {
                check_rail(ptp.ptp_mode, ptp.l)?;
                self.ptp(ptp.ptp_mode, [ptp.x, ptp.y, ptp.z, ptp.r])
            }
            Set::CpCmd(cp) => self.segment(cp.cp_mode, [cp.x, cp.y, cp.z]),
            Set::CpLeCmd(cp) => self.segment(cp.cp_mode, [cp.x, cp.y, cp.z]),
            Set::ArcCmd(arc) => self.arc(arc.cir_point, arc.to_point),
            Set::CircleCmd(circle) => self.circle(circle),
            Set::EndEffectorParams(tool) => {
                self.planner.geometry.tool = bias(tool);
                let joints = self.at.map(|at| at.joints);
                self.at = joints.map(|at| ArmState::at_joints(&self.planner.geometry, &at));
                Ok(())
            }
            Set::PtpJumpParams(jump) => {
                self.heights = JumpHeights::even(jump.jump_height.into(), jump.z_limit.into());
                Ok(())
            }
            Set::PtpJump2Params(jump) => {
                self.heights = heights(jump);
                Ok(())
            }
            Set::HomeParams(home) => {
                self.home = Some([home.x, home.y, home.z, home.r].map(f64::from).into());
                self.points([[home.x, home.y, home.z, home.r]])
            }
            Set::HomeCmd(_) => {
                let Planner {
                    geometry, limits, ..
                } = &self.planner;
                let home = self
                    .home
                    .map(|home| ArmState::at_pose(geometry, &home, limits));
                self.at = home.transpose()?;
                Ok(())
            }
            Set::JogCmd(_) | Set::ResetPose(_) => {
                self.at = None;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn ptp(&mut self, mode: PtpMode, numbers: [f32; 4]) -> Result<()> {
        let numbers = numbers.map(f64::from);
        let jump = |transfer| MoveKind::Jump(self.heights, transfer);
        let (target, kind) = match mode {
            PtpMode::JumpXyz => (Target::Pose(numbers.into()), jump(Transfer::Joint)),
            PtpMode::MovjXyz => (Target::Pose(numbers.into()), MoveKind::Joint),
            PtpMode::MovlXyz => (Target::Pose(numbers.into()), MoveKind::Line),
            PtpMode::JumpAngle => (Target::Joints(numbers.into()), jump(Transfer::Joint)),
            PtpMode::MovjAngle => (Target::Joints(numbers.into()), MoveKind::Joint),
            PtpMode::MovlAngle => (Target::Joints(numbers.into()), MoveKind::Line),
            PtpMode::MovjAngleInc => (Target::JointIncrement(numbers.into()), MoveKind::Joint),
            PtpMode::MovlXyzInc => (Target::PoseIncrement(numbers.into()), MoveKind::Line),
            PtpMode::MovjXyzInc => (Target::PoseIncrement(numbers.into()), MoveKind::Joint),
            PtpMode::JumpMovlXyz => (Target::Pose(numbers.into()), jump(Transfer::Line)),
            PtpMode::Unknown(mode) => {
                let message =
                    format!("point-to-point mode {mode} does not exist; there are 0 to 9");
                return Err(Error::invalid(message).with_limit(mode.into(), 9.0, "mode"));
            }
        };
        match self.at {
            Some(from) => self.travel(&from, &Move { target, kind }),
            None => self.arrive(&target),
        }
    }

    /// The whole way from a known start.
    fn travel(&mut self, from: &ArmState, request: &Move) -> Result<()> {
        let plan = self.planner.plan(from, request)?;
        if plan.crossing.is_some() {
            // Beyond the limit at its end says more than at the limit on its way.
            match request.target {
                Target::Joints(joints) => self.planner.limits.check(&joints)?,
                Target::JointIncrement(by) => {
                    self.planner.limits.check(&from.joints.offset_by(&by))?;
                }
                Target::Pose(_) | Target::PoseIncrement(_) => {}
            }
        }
        self.arrive_by(&plan)
    }

    /// The arm gets there, or something is in the way.
    fn arrive_by(&mut self, plan: &Plan) -> Result<()> {
        if let Some(crossing) = plan.crossing {
            let done = 100.0 * crossing.progress;
            return Err(Error::from(crossing.cause).on_the_way(done));
        }
        self.at = Some(*plan.trajectory.end());
        Ok(())
    }

    /// Only the end: nobody knows where the motion begins.
    fn arrive(&mut self, target: &Target) -> Result<()> {
        let Planner {
            geometry, limits, ..
        } = &self.planner;
        self.at = match target {
            Target::Pose(pose) => Some(ArmState::at_pose(geometry, pose, limits)?),
            Target::Joints(joints) => {
                limits.check(joints)?;
                Some(ArmState::at_joints(geometry, joints))
            }
            Target::PoseIncrement(_) | Target::JointIncrement(_) => None,
        };
        Ok(())
    }

    /// A segment of a continuous path: straight, with J4 at rest.
    fn segment(&mut self, mode: CpMode, point: [f32; 3]) -> Result<()> {
        let [x, y, z] = point.map(f64::from);
        let Some(from) = self.at else {
            return match mode {
                CpMode::Relative => Ok(()),
                _ => self.arrive(&Target::Pose([x, y, z, 0.0].into())),
            };
        };
        let (x, y, z) = match mode {
            CpMode::Relative => (from.pose.x + x, from.pose.y + y, from.pose.z + z),
            _ => (x, y, z),
        };
        // The way does not depend on the speed.
        let rates = magician_motion::Rates {
            velocity: 100.0,
            acceleration: 100.0,
        };
        let plan = self.planner.segment(&from, [x, y, z], 0.0, 0.0, rates)?;
        self.arrive_by(&plan)
    }

    fn arc(&mut self, via: [f32; 4], to: [f32; 4]) -> Result<()> {
        let [via, to] = [via, to].map(|point| magician_motion::Pose::from(point.map(f64::from)));
        let Some(from) = self.at else {
            return self.arrive(&Target::Pose(to));
        };
        let plan = self.planner.arc(&from, &via, &to)?;
        self.arrive_by(&plan)
    }

    fn circle(&mut self, circle: &CircleCmd) -> Result<()> {
        let points = [circle.cir_point, circle.to_point];
        let Some(from) = self.at else {
            return self.points(points);
        };
        let [via, to] = points.map(|point| magician_motion::Pose::from(point.map(f64::from)));
        let plan = self.planner.circle(&from, &via, &to, circle.count)?;
        self.arrive_by(&plan)
    }

    /// Points that the arm passes and does not stay at.
    fn points<const N: usize>(&self, points: [[f32; 4]; N]) -> Result<()> {
        let Planner {
            geometry, limits, ..
        } = &self.planner;
        for point in points {
            geometry.inverse_within(&point.map(f64::from).into(), limits)?;
        }
        Ok(())
    }
}

fn bias(tool: &EndEffectorParams) -> ToolBias {
    ToolBias::new(tool.x_bias.into(), tool.y_bias.into(), tool.z_bias.into())
}

fn heights(jump: &PtpJump2Params) -> JumpHeights {
    JumpHeights {
        start: jump.start_jump_height.into(),
        end: jump.end_jump_height.into(),
        z_limit: jump.z_limit.into(),
    }
}

fn check_rail(mode: PtpMode, l: f32) -> Result<()> {
    let relative = matches!(
        mode,
        PtpMode::MovjAngleInc | PtpMode::MovlXyzInc | PtpMode::MovjXyzInc
    );
    let limit = if l < 0.0 { 0.0 } else { 1000.0 };
    if relative || (0.0..=1000.0).contains(&l) {
        return Ok(());
    }
    let message = format!("the rail would be at {l} mm, limit {limit} mm");
    Err(Error::new(ErrorKind::Unreachable, message).with_limit(l.into(), limit, "mm"))
}

/// Every number of a command is one, and what must be above 0 is.
fn check_numbers(command: &Set) -> Result<()> {
    let frame = FrameBuf::set(command, Ctrl::SET)?;
    let Some(layout) = command.row().set else {
        return Ok(());
    };
    let values = layout.values(frame.frame().params())?;
    for (field, value) in values {
        check_number(field, value)?;
        value
            .items()
            .try_for_each(|item| check_number(field, item))?;
    }
    Ok(())
}

fn check_number(field: &Field, value: FieldValue<'_>) -> Result<()> {
    let FieldValue::Float(number) = value else {
        return Ok(());
    };
    let name = field.name;
    if !number.is_finite() {
        return Err(Error::invalid(format!(
            "{name} is {number}, which is no number"
        )));
    }
    let above_zero = field.range == "above 0" || field.range.starts_with("1 to");
    if above_zero && number <= 0.0 {
        let message = format!("{name} is {number} {}, it must be above 0", field.unit);
        return Err(Error::invalid(message).with_limit(number.into(), 0.0, field.unit));
    }
    Ok(())
}
