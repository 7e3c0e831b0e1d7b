//! Transformations of plans: move, scale, mirror, rotate, repeat.
//!
//! A plan is a list of commands, and not every command can be transformed: joint angles, homing
//! points and moves relative to an unknown position cannot. [`Outcome`] classifies the effect of a
//! transformation on each command; the first command that would end up elsewhere refuses the whole
//! transformation.

use magician_host::{Message, message};
use magician_protocol::{CpMode, PtpMode, Set};

use super::{Action, Plan};
use crate::{Diagnostic, Step, Surface, Tool};

/// An affine map of positions: `p' = scale R M (p - about) + about + by`.
#[derive(Clone, Copy, Debug)]
struct Map {
    /// Factor of x and y.
    scale: f64,
    /// Factor of z.
    scale_z: f64,
    /// Mirrors left to right: x becomes -x.
    mirror: bool,
    degrees: f64,
    /// True if the rotation of the tool matters.
    turns_tool: bool,
    /// Cosine and sine of the rotation.
    turn: [f64; 2],
    about: [f64; 3],
    by: [f64; 3],
    /// Participle for messages: `moved`.
    done: fn() -> Message,
}

/// Effect of a transformation on a command.
enum Outcome {
    /// Transformed, or independent of position.
    Done,
    /// Ends at a transformed position.
    Placed,
    /// Relative move from the current position, with a transformed offset.
    Relative,
    /// Curve from the current position through transformed points. Its shape is right only if the
    /// arm starts from a transformed position too.
    FromCurrent,
    /// Ends at the arm's own homing point.
    Home,
    /// Cannot be transformed, with the reason.
    Refused(Message),
}

impl Plan {
    /// Moves the plan by `[x, y, z]` mm. Relative moves stay as they are, provided that an earlier
    /// step has led to a position of the plan.
    ///
    /// # Errors
    /// A [`Diagnostic`] for the first step that cannot be moved (joint angles, homing points, a
    /// start from an unknown position), or if an offset is not finite.
    pub fn moved(&self, by: [f64; 3]) -> Result<Self, Diagnostic> {
        finite(&by, || message!("the offset"))?;
        self.mapped(&Map {
            by,
            ..Map::identity(|| message!("moved"))
        })
    }

    /// Scales all lengths by `factor` about a fixed point. Jump heights are lengths; speeds and
    /// rotations stay.
    ///
    /// # Errors
    /// Same as [`moved`](Self::moved); also a factor not above 0.
    pub fn scaled(&self, factor: f64, about: [f64; 3]) -> Result<Self, Diagnostic> {
        self.resized(factor, factor, about)
    }

    /// Scales x and y by `factor` about the fixed point `[x, y]`. Lifts, depths, jump heights,
    /// speeds and rotations stay.
    ///
    /// # Errors
    /// Same as [`scaled`](Self::scaled).
    pub fn scaled_xy(&self, factor: f64, [x, y]: [f64; 2]) -> Result<Self, Diagnostic> {
        self.resized(factor, 1.0, [x, y, 0.0])
    }

    /// Scales x and y by one factor and z by another about a fixed point.
    fn resized(&self, factor: f64, scale_z: f64, about: [f64; 3]) -> Result<Self, Diagnostic> {
        finite(&[factor], || message!("the factor"))?;
        finite(&about, || message!("the point that stays"))?;
        if factor <= 0.0 {
            return Err(Diagnostic::of_file(message!(
                "the scale is {scale}, it must be above 0",
                scale = factor
            )));
        }
        self.mapped(&Map {
            scale: factor,
            scale_z,
            about,
            ..Map::identity(|| message!("scaled"))
        })
    }

    /// Mirrors the plan left to right at the line with this x. A rotation r becomes -r, so a
    /// gripper with two jaws holds from the other side.
    ///
    /// # Errors
    /// Same as [`moved`](Self::moved).
    pub fn mirrored(&self, x: f64) -> Result<Self, Diagnostic> {
        finite(&[x], || message!("the line to mirror about"))?;
        self.mapped(&Map {
            mirror: true,
            about: [x, 0.0, 0.0],
            ..Map::identity(|| message!("mirrored"))
        })
    }

    /// Rotates the plan counter-clockwise, seen from above, about the vertical through `[x, y]`.
    ///
    /// The rotation r of poses changes with it, within -180 to 180 degrees, except for a pen and a
    /// laser, which are round. Relative moves rotate too.
    ///
    /// # Errors
    /// Same as [`moved`](Self::moved).
    pub fn rotated(&self, degrees: f64, [x, y]: [f64; 2]) -> Result<Self, Diagnostic> {
        finite(&[degrees, x, y], || message!("the turn"))?;
        self.mapped(&Map {
            degrees,
            turns_tool: !matches!(self.tool, Some(Tool::Pen | Tool::Laser)),
            turn: cos_sin(degrees),
            about: [x, y, 0.0],
            ..Map::identity(|| message!("turned"))
        })
    }

    /// Repeats the steps.
    ///
    /// # Errors
    /// A [`Diagnostic`] if the result would have more steps than an arm can reasonably do.
    pub fn repeated(&self, times: usize) -> Result<Self, Diagnostic> {
        let count = check_size(self, times)?;
        Ok(Self {
            steps: self.steps.iter().cycle().take(count).cloned().collect(),
            ..self.clone()
        })
    }

    fn mapped(&self, map: &Map) -> Result<Self, Diagnostic> {
        let mut plan = self.clone();
        plan.surface = self.surface.map(|surface| map.surface(surface));
        plan.steps.clear();
        plan.steps.reserve_exact(self.steps.len());
        self.map_steps(map, &mut plan.steps)?;
        Ok(plan)
    }

    /// Appends the transformed steps of this plan.
    fn map_steps(&self, map: &Map, steps: &mut Vec<Step>) -> Result<(), Diagnostic> {
        // True once a step of the plan has defined the arm's position.
        let mut placed = false;
        for (at, step) in self.steps.iter().enumerate() {
            let mut changed = step.clone();
            match map.action(&mut changed.action) {
                Outcome::Done => {}
                Outcome::Placed => placed = true,
                Outcome::Relative if placed || map.by == [0.0; 3] => {}
                Outcome::FromCurrent if placed => {}
                Outcome::Relative | Outcome::FromCurrent => {
                    let why = message!("starts at the arm's position, which no earlier step gives");
                    return Err(self.refusal(at, map.done, why));
                }
                Outcome::Home => placed = false,
                Outcome::Refused(why) => return Err(self.refusal(at, map.done, why)),
            }
            steps.push(changed);
        }
        Ok(())
    }

    fn refusal(&self, at: usize, done: fn() -> Message, why: Message) -> Diagnostic {
        let origin = self
            .steps
            .get(at)
            .map_or_else(Default::default, |step| step.origin);
        let message = message!(
            "step {step} cannot be {done}: it {why}",
            step = at + 1,
            done = done(),
            why
        );
        let diagnostic = Diagnostic::new(origin, message);
        match self.name_of(&origin) {
            Some(name) => diagnostic.named(name),
            None => diagnostic,
        }
    }

    /// Repeats the steps with a different offset each time.
    pub(super) fn repeated_at(
        &self,
        count: usize,
        ways: impl Iterator<Item = [f64; 3]>,
    ) -> Result<Self, Diagnostic> {
        check_size(self, count)?;
        let mut plan = self.clone();
        plan.steps.clear();
        for by in ways {
            finite(&by, || message!("the offset of a position"))?;
            let map = Map {
                by,
                ..Map::identity(|| message!("moved"))
            };
            self.map_steps(&map, &mut plan.steps)?;
        }
        Ok(plan)
    }
}

/// Largest number of steps. More are a mistake: at 20 ms each they take half a day. All of them are
/// in memory.
const MAX_STEPS: usize = 2_000_000;

/// Returns the number of steps after repeating.
fn check_size(plan: &Plan, times: usize) -> Result<usize, Diagnostic> {
    let count = plan.steps.len();
    let all = count
        .checked_mul(times)
        .filter(|all| times <= 1 || times.max(*all) <= MAX_STEPS);
    all.ok_or_else(|| {
        Diagnostic::of_file(message!(
            "{count} steps repeated {times} times are too many, limit {limit}",
            count,
            times,
            limit = MAX_STEPS
        ))
    })
}

pub(super) fn finite(numbers: &[f64], what: fn() -> Message) -> Result<(), Diagnostic> {
    if numbers.iter().all(|number| number.is_finite()) {
        Ok(())
    } else {
        Err(Diagnostic::of_file(message!(
            "{what} is not a number",
            what = what()
        )))
    }
}

/// Exact for quarter turns, so that these do not add rounding errors.
fn cos_sin(degrees: f64) -> [f64; 2] {
    match degrees.rem_euclid(360.0) {
        0.0 => [1.0, 0.0],
        90.0 => [0.0, 1.0],
        180.0 => [-1.0, 0.0],
        270.0 => [0.0, -1.0],
        other => {
            let (sin, cos) = libm::sincos(other.to_radians());
            [cos, sin]
        }
    }
}

impl Map {
    fn identity(done: fn() -> Message) -> Self {
        Self {
            scale: 1.0,
            scale_z: 1.0,
            mirror: false,
            degrees: 0.0,
            turns_tool: true,
            turn: [1.0, 0.0],
            about: [0.0; 3],
            by: [0.0; 3],
            done,
        }
    }

    fn rotated_offset(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [cos, sin] = self.turn;
        let x = if self.mirror { -x } else { x };
        let [x, y] = [x * cos - y * sin, x * sin + y * cos].map(|value| self.scale * value);
        [x, y, self.scale_z * z]
    }

    fn place(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let ([ax, ay, az], [bx, by, bz]) = (self.about, self.by);
        let [x, y, z] = self.rotated_offset([x - ax, y - ay, z - az]);
        [x + ax + bx, y + ay + by, z + az + bz]
    }

    /// Transforms a height without a position.
    fn height(&self, z: &mut f32) {
        let [_, _, about] = self.about;
        let [_, _, by] = self.by;
        *z = (self.scale_z * (f64::from(*z) - about) + about + by) as f32;
    }

    fn length(&self, length: &mut f32) {
        *length = (self.scale_z * f64::from(*length)) as f32;
    }

    fn surface(&self, surface: Surface) -> Surface {
        let [x, y] = surface.slope;
        let x = if self.mirror { -x } else { x };
        let [cos, sin] = self.turn;
        let steeper = self.scale_z / self.scale;
        let slope = [x * cos - y * sin, x * sin + y * cos].map(|value| steeper * value);
        let [x, y, z] = self.place([0.0, 0.0, surface.height]);
        let [sx, sy] = slope;
        Surface {
            height: z - sx * x - sy * y,
            slope,
        }
    }

    fn point(&self, [x, y, z]: [&mut f32; 3]) -> Outcome {
        let place = self.place([f64::from(*x), f64::from(*y), f64::from(*z)]);
        [*x, *y, *z] = place.map(|value| value as f32);
        Outcome::Placed
    }

    fn pose(&self, [x, y, z, r]: &mut [f32; 4]) -> Outcome {
        self.rotation(r);
        self.point([x, y, z])
    }

    /// Transforms the rotation r of a pose.
    fn rotation(&self, r: &mut f32) {
        self.relative_rotation(r);
        if self.degrees != 0.0 && self.turns_tool {
            // Normalise to half a turn either way, the range of the servo.
            let turned = (f64::from(*r) + self.degrees).rem_euclid(360.0);
            let nearest = if turned > 180.0 {
                turned - 360.0
            } else {
                turned
            };
            *r = nearest as f32;
        }
    }

    /// Transforms a rotation relative to the current one. Only mirroring changes it.
    fn relative_rotation(&self, r: &mut f32) {
        if self.mirror {
            *r = -*r;
        }
    }

    fn through(&self, via: &mut [f32; 4], to: &mut [f32; 4]) -> Outcome {
        self.pose(via);
        self.pose(to);
        Outcome::FromCurrent
    }

    /// Transforms an offset.
    fn map_offset(&self, [x, y, z]: [&mut f32; 3]) -> Outcome {
        let way = self.rotated_offset([f64::from(*x), f64::from(*y), f64::from(*z)]);
        [*x, *y, *z] = way.map(|value| value as f32);
        Outcome::Relative
    }

    fn action(&self, action: &mut Action) -> Outcome {
        match action {
            Action::Move { to, .. } => self.pose(to),
            Action::Joints { .. } => refused_joints(),
            Action::Shift {
                by: [x, y, z, r], ..
            } => {
                self.relative_rotation(r);
                self.map_offset([x, y, z])
            }
            Action::Arc { via, to } => self.through(via, to),
            Action::Path { to: [x, y, z] } | Action::Burn { to: [x, y, z], .. } => {
                self.point([x, y, z])
            }
            Action::Suction(_)
            | Action::Gripper(_)
            | Action::Laser(_)
            | Action::Wait(_)
            | Action::Part(_)
            | Action::Pause(_) => Outcome::Done,
            Action::Home => Outcome::Home,
            Action::Command(command) => self.command(command),
        }
    }

    /// Transforms a command of the protocol.
    fn command(&self, command: &mut Set) -> Outcome {
        match command {
            Set::PtpCmd(ptp) => self.ptp(
                ptp.ptp_mode,
                [&mut ptp.x, &mut ptp.y, &mut ptp.z, &mut ptp.r],
            ),
            Set::PtpPoCmd(ptp) => self.ptp(
                ptp.ptp_mode,
                [&mut ptp.x, &mut ptp.y, &mut ptp.z, &mut ptp.r],
            ),
            Set::PtpWithLCmd(ptp) => self.ptp(
                ptp.ptp_mode,
                [&mut ptp.x, &mut ptp.y, &mut ptp.z, &mut ptp.r],
            ),
            Set::PtpPoWithLCmd(ptp) => self.ptp(
                ptp.ptp_mode,
                [&mut ptp.x, &mut ptp.y, &mut ptp.z, &mut ptp.r],
            ),
            Set::CpCmd(cp) => self.cp(cp.cp_mode, [&mut cp.x, &mut cp.y, &mut cp.z]),
            Set::CpLeCmd(cp) => self.cp(cp.cp_mode, [&mut cp.x, &mut cp.y, &mut cp.z]),
            Set::ArcCmd(arc) => self.through(&mut arc.cir_point, &mut arc.to_point),
            Set::CircleCmd(circle) => self.through(&mut circle.cir_point, &mut circle.to_point),
            Set::PtpJumpParams(jump) => {
                self.length(&mut jump.jump_height);
                self.height(&mut jump.z_limit);
                Outcome::Done
            }
            Set::PtpJump2Params(jump) => {
                self.length(&mut jump.start_jump_height);
                self.length(&mut jump.end_jump_height);
                self.height(&mut jump.z_limit);
                Outcome::Done
            }
            Set::HomeCmd(_) => Outcome::Home,
            Set::HomeParams(_) => Outcome::Refused(message!(
                "sets where homing ends, which belongs to the arm and not to the plan"
            )),
            Set::JogCmd(_) => {
                Outcome::Refused(message!("is a jog, which ends at an unknown place"))
            }
            Set::ResetPose(_) | Set::PulseMode(_) | Set::SetAutoLeveling(_) => {
                Outcome::Refused(message!("changes the arm's own position"))
            }
            // A command with an unknown motion must not be kept as it is.
            other if other.row().effect.moves_arm() => {
                Outcome::Refused(message!("moves the arm to an unknown position"))
            }
            // Commands that do not move the arm are independent of position.
            _ => Outcome::Done,
        }
    }

    fn ptp(&self, mode: PtpMode, [x, y, z, r]: [&mut f32; 4]) -> Outcome {
        match mode {
            mode if mode.is_absolute_pose() => {
                self.rotation(r);
                self.point([x, y, z])
            }
            mode if mode.is_pose() => {
                self.relative_rotation(r);
                self.map_offset([x, y, z])
            }
            mode if mode.is_joint() => refused_joints(),
            _ => Outcome::Refused(message!("has a mode that does not exist")),
        }
    }

    fn cp(&self, mode: CpMode, point: [&mut f32; 3]) -> Outcome {
        match mode {
            CpMode::Absolute => self.point(point),
            CpMode::Relative => self.map_offset(point),
            CpMode::Unknown(_) => Outcome::Refused(message!("has a reference that does not exist")),
        }
    }
}

fn refused_joints() -> Outcome {
    Outcome::Refused(message!("goes by joint angles; use a pose"))
}
