//! Start in the middle of a plan: at a later step, or where an earlier run stopped.
//!
//! A step depends on the settings, outputs, tool and pose that the earlier steps leave. The host
//! therefore simulates these steps first, without sending them. Then the settings in force are
//! sent, and the tool approaches the step's start: straight up, across, straight down, with the
//! laser off until it arrives. `partial_step` finds the place within a step that was cut short,
//! `laser_off` the place where a burn ended.

pub(crate) mod laser_off;
pub(crate) mod partial_step;
mod settings;

use magician_host::build;
use magician_host::message;
use magician_host::preflight::Preflight;
use magician_host::{Error, JointAngles, MotionSettings, PtpMove, Set};
use magician_motion::Pose;

use crate::{Action, Diagnostic, Origin, Plan, Step, Travel};
use settings::Settings;

/// Step between the heights tried for the move across, mm, if the highest is out of reach.
const HEIGHT_STEP: f64 = 5.0;
/// Moves shorter than this are left out, mm.
const MIN_MOVE: f64 = 1e-3;
/// Height of the move across above both of its ends, mm, if within reach.
const CROSSING_CLEARANCE: f64 = 10.0;
/// Largest joint error caused by 32-bit coordinates, deg: no more than the arm's own resolution.
const JOINT_TOLERANCE: f64 = 0.01;
/// Largest height of any tool of the arm, mm.
const MAX_HEIGHT: f64 = 400.0;
/// Radial step, as a share of the distance from the base, between the points tried for the end of
/// the move across if the point above the start position is out of reach.
const RADIAL_STEP: f64 = 0.05;
/// Number of radial steps tried inwards, and outwards.
const MAX_RADIAL_STEPS: i32 = 8;
/// Largest number of heights tried: enough to go down from [`MAX_HEIGHT`] to about as far below the
/// base plane.
const MAX_HEIGHTS: u32 = 160;

/// Plan that begins at a step of another plan and can be run on its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Continuation {
    /// The plan to run.
    pub plan: Plan,
    /// For each step of `plan` the step (from 0) of the whole plan that it belongs to. The approach
    /// belongs to the first step: a run that is interrupted there resumes with that step.
    pub steps: Vec<usize>,
}

impl Continuation {
    /// Creates the plan from a step (from 0) on, for an arm in the state of `start`.
    ///
    /// The new plan first sends the settings that the earlier steps leave in force (speeds, tool,
    /// pins, pump, running motors). Then it moves straight up, across, and straight down to the
    /// start of the step, with the laser off, and continues as the original plan. A step of a
    /// continuous path begins at the start of its segment, from rest.
    ///
    /// The move across is at the largest height of the earlier steps, jumps included, and at least
    /// 10 mm above both of its ends, or as high as possible. Homing is not repeated: an arm that
    /// was switched off in between must be homed first.
    ///
    /// ```
    /// use magician_host::{JointAngles, ToolBias, preflight::Preflight};
    /// use magician_program::{Action, Continuation, Origin, Plan, Travel};
    ///
    /// let mut plan = Plan::new("two strokes");
    /// for (x, y, z) in [(220.0, 0.0, 20.0), (220.0, 0.0, 0.0), (220.0, 40.0, 0.0), (240.0, 40.0, 0.0)] {
    ///     plan.push(Action::Move { to: [x, y, z, 0.0], by: Travel::Line }, Origin::NONE);
    /// }
    /// let arm = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    /// let rest = Continuation::from_step(&plan, 3, &arm)?;
    /// let targets: Vec<_> = rest.plan.steps.iter().filter_map(|step| step.action.target()).collect();
    /// assert_eq!(targets[1..], [[220.0, 40.0, 20.0], [220.0, 40.0, 0.0], [240.0, 40.0, 0.0]]);
    /// assert_eq!(rest.steps, [3, 3, 3, 3]);
    /// # Ok::<(), magician_program::Diagnostic>(())
    /// ```
    ///
    /// # Errors
    /// [`Diagnostic`] if the step does not exist, an earlier step is refused, the start of the step
    /// is unknown (after homing to an unknown point, for example), or the arm cannot reach it.
    pub fn from_step(plan: &Plan, step: usize, start: &Preflight) -> Result<Self, Diagnostic> {
        Self::within_step(plan, step, None, start)
    }

    /// Like [`from_step`](Self::from_step). If the step moves straight through `at`, it continues
    /// from there.
    pub(crate) fn within_step(
        whole: &Plan,
        step: usize,
        at: Option<[f64; 3]>,
        start: &Preflight,
    ) -> Result<Self, Diagnostic> {
        if step >= whole.steps.len() && step > 0 {
            let message = message!(
                "there is no step {step}: the plan has {steps}",
                step = step + 1,
                steps = whole.steps.len()
            );
            return Err(Diagnostic::of_file(message));
        }
        // The whole plan is cloned for its names and settings; its steps are replaced below.
        let mut plan = whole.clone();
        let mut added = 0;
        if step > 0 || at.is_some() {
            let mut lead = LeadIn::up_to(whole, step, at, start)?;
            lead.emit_steps(start)?;
            added = lead.steps.len();
            plan.steps = lead.steps;
            plan.steps.extend(whole.steps.iter().skip(step).cloned());
            if let (Some(rest_action), Some(first)) = (lead.rest_action, plan.steps.get_mut(added))
            {
                first.action = rest_action;
            }
        }
        let steps = std::iter::repeat_n(step, added).chain(step..whole.steps.len());
        Ok(Self {
            plan,
            steps: steps.collect(),
        })
    }
}

fn diagnostic_at(plan: &Plan, step: usize, message: magician_host::Message) -> Diagnostic {
    let origin = plan
        .steps
        .get(step)
        .map_or(Origin::NONE, |step| step.origin);
    let diagnostic = Diagnostic::new(origin, message);
    match plan.name_of(&origin) {
        Some(name) => diagnostic.named(name),
        None => diagnostic,
    }
}

/// Largest height of the tool so far.
struct HeightTracker {
    most: f64,
    /// Settings so far, initially those at power-up.
    settings: MotionSettings,
}

impl Default for HeightTracker {
    fn default() -> Self {
        Self {
            most: f64::NEG_INFINITY,
            settings: MotionSettings::default(),
        }
    }
}

impl HeightTracker {
    fn note(&mut self, command: &Set, from: Option<f64>, to: Option<f64>) {
        self.settings.apply(command);
        let jumps = PtpMove::from_command(command).is_some_and(|to| to.mode.is_jump());
        let heights = self.settings.jump();
        let lift = heights.start.max(heights.end);
        for z in [from, to].into_iter().flatten() {
            let apex = if jumps {
                (z + lift).min(heights.z_limit)
            } else {
                z
            };
            self.most = self.most.max(z).max(apex);
        }
    }
}

/// Approach to a step.
struct LeadIn<'p> {
    plan: &'p Plan,
    step: usize,
    settings: Settings,
    /// Pose at the start of the step.
    target: Pose,
    /// Joints at that pose.
    joints: JointAngles,
    /// Largest z so far.
    height: f64,
    steps: Vec<Step>,
    /// Command for the rest of a step that resumes part-way. `None` if the step's own command fits,
    /// or the step starts at its beginning.
    rest_action: Option<Action>,
}

impl<'p> LeadIn<'p> {
    /// Simulates the plan up to the step, or up to a place within it.
    fn up_to(
        plan: &'p Plan,
        step: usize,
        within: Option<[f64; 3]>,
        start: &Preflight,
    ) -> Result<Self, Diagnostic> {
        let mut arm = start.clone().summing();
        let mut settings = Settings::default();
        let mut height = HeightTracker::default();
        if let Some(tool) = plan.preamble() {
            let checked = arm.check(&tool);
            checked.map_err(|error| Diagnostic::of_file(error.to_string()))?;
        }
        for (at, before) in plan.steps.iter().take(step).enumerate() {
            let Some(command) = before.action.command() else {
                continue;
            };
            let from = arm.arm().map(|at| at.pose.z);
            let checked = arm.check(&command).map_err(|error| {
                let message = message!(
                    "the earlier step {at} cannot be done: {error}",
                    at = at + 1,
                    error
                );
                diagnostic_at(plan, at, message)
            })?;
            settings.note(&command);
            height.note(&command, from, checked.end.map(|end| end.pose.z));
        }
        let Some(at) = arm.arm() else {
            let message = message!(
                "the position of the arm is unknown when step {step} begins",
                step = step + 1
            );
            return Err(diagnostic_at(plan, step, message).help(advice_on_known_steps(plan, step)));
        };
        if settings.is_rail_unknown() {
            let message = message!(
                "the position on the rail is unknown when step {step} begins",
                step = step + 1
            );
            let help = message!(
                "begin with a step that moves it to a position on the rail, or with the \
                first"
            );
            return Err(diagnostic_at(plan, step, message).help(help));
        }
        let step_start = at.pose;
        let action = plan.steps.get(step).map(|step| &step.action);
        let (at, rest_action) = action
            .zip(within)
            .and_then(|(action, place)| partial_step::continue_from(action, &arm, place))
            .unwrap_or((*at, None));
        height.most = height.most.max(step_start.z);
        Ok(Self {
            plan,
            step,
            settings,
            target: at.pose,
            joints: at.joints,
            rest_action,
            height: height.most.max(at.pose.z + CROSSING_CLEARANCE),
            steps: Vec::new(),
        })
    }

    /// Emits the settings, then the approach, then the laser if it was on.
    fn emit_steps(&mut self, start: &Preflight) -> Result<(), Diagnostic> {
        let mut arm = start.clone().summing();
        let refused = |error: Error| {
            let message = message!(
                "the arm cannot reach the begin of step {step}: {error}",
                step = self.step + 1,
                error
            );
            diagnostic_at(self.plan, self.step, message)
        };
        let mut steps: Vec<Action> = Vec::new();
        if let Some(tool) = self.plan.preamble() {
            arm.check(&tool).map_err(refused)?;
        }
        let burns = |step: &Step| step.action.is_of_a_laser();
        // The laser may still be on from an earlier run: switch it off before the arm moves.
        let laser_off_command = self
            .plan
            .steps
            .iter()
            .any(burns)
            .then_some(build::laser(false));
        for command in laser_off_command
            .into_iter()
            .chain(self.settings.in_force())
        {
            arm.check(&command).map_err(refused)?;
            steps.push(command.into());
        }
        self.approach(&mut arm, &mut steps).map_err(refused)?;
        // Targets are sent as 32-bit floats; huge coordinates lose the precision to meet the start.
        if !self.has_arrived(&arm) {
            return Err(refused(Error::invalid(message!(
                "its coordinates are too large for the precision of 32 bits"
            ))));
        }
        if self.settings.is_lit() {
            steps.push(Action::Laser(true));
        }
        let origin = Origin::NONE;
        self.steps = steps
            .into_iter()
            .map(|action| Step::new(action, origin))
            .collect();
        Ok(())
    }

    fn has_arrived(&self, arm: &Preflight) -> bool {
        let wanted_joints = self.joints.to_array();
        arm.arm().is_some_and(|at| {
            let mut pairs = at.joints.to_array().into_iter().zip(wanted_joints);
            pairs.all(|(is, wanted)| (is - wanted).abs() < JOINT_TOLERANCE)
        })
    }

    /// Goes up, across and down, as far as possible and needed.
    fn approach(&self, arm: &mut Preflight, steps: &mut Vec<Action>) -> Result<(), Error> {
        let rail = self.settings.rail();
        let start = arm.arm().map(|at| at.pose);
        if let Some(from) = start
            && rail.is_none()
            && from.distance_to(&self.target) < MIN_MOVE
            // A tool turned differently still needs a move, though its tip is in place.
            && (from.r - self.target.r).abs() < MIN_MOVE
        {
            return Ok(());
        }
        let height = start.map_or(self.height, |from| {
            self.height.max(from.z + CROSSING_CLEARANCE)
        });
        if let Some(from) = start {
            // Rising is optional: if the arm cannot rise, the move across starts at this height.
            let _ = rise(&from, height, |pose| {
                go(arm, steps, pose, &[Travel::Line], None)
            });
        }
        // From an unknown pose only a joint move can be planned.
        let across: &[Travel] = match start {
            Some(_) => &[Travel::Line, Travel::Joints],
            None => &[Travel::Joints],
        };
        if self.descend(height, across, arm, steps) {
            return Ok(());
        }
        let over = rise(&self.target, height, |pose| {
            go(arm, steps, pose, across, rail)
        });
        match over {
            Some(Ok(())) => go(arm, steps, self.target, &[Travel::Line], None),
            _ => go(arm, steps, self.target, across, rail),
        }
    }

    /// Moves across at `height` and straight down. If that height is out of reach above the start
    /// position, tries positions nearer to the base or farther away.
    fn descend(
        &self,
        height: f64,
        across: &[Travel],
        arm: &mut Preflight,
        steps: &mut Vec<Action>,
    ) -> bool {
        let z = height.min(MAX_HEIGHT);
        let radial_steps = (0..=MAX_RADIAL_STEPS).flat_map(|nth| [-nth, nth]);
        for share in radial_steps.map(|nth| 1.0 + RADIAL_STEP * f64::from(nth)) {
            let [x, y] = [self.target.x, self.target.y].map(|at| share * at);
            let over = Pose {
                x,
                y,
                z,
                ..self.target
            };
            // Try on a copy: both moves must be possible, or neither is made.
            let (mut tried, mut added) = (arm.clone(), Vec::new());
            if z > self.target.z + MIN_MOVE
                && go(&mut tried, &mut added, over, across, self.settings.rail()).is_ok()
                && go(&mut tried, &mut added, self.target, &[Travel::Line], None).is_ok()
            {
                *arm = tried;
                steps.append(&mut added);
                return true;
            }
        }
        false
    }
}

/// Moves to a pose by the first possible motion type; if none is possible, returns the error of the
/// first.
fn go(
    arm: &mut Preflight,
    steps: &mut Vec<Action>,
    pose: Pose,
    ways: &[Travel],
    l: Option<f32>,
) -> Result<(), Error> {
    let mut refusal = None;
    for by in ways {
        let to = pose.to_array().map(|value| value as f32);
        let plain = Action::Move { to, by: *by };
        let Some(command) = plain.command() else {
            continue;
        };
        let command = match l {
            Some(l) => build::with_rail(command, l)?,
            None => command,
        };
        match arm.check(&command) {
            Ok(_) => {
                steps.push(command.into());
                return Ok(());
            }
            Err(error) => refusal = refusal.or(Some(error)),
        }
    }
    // The first motion type is the wanted one, so its refusal is the useful one.
    refusal.map_or(Ok(()), Err)
}

/// Moves to the point above `place` whose z is `height`, or as high as possible. `None` if `place`
/// is that high already.
fn rise(
    place: &Pose,
    height: f64,
    mut go: impl FnMut(Pose) -> Result<(), Error>,
) -> Option<Result<(), Error>> {
    let heights =
        (0..MAX_HEIGHTS).map(|down| height.min(MAX_HEIGHT) - HEIGHT_STEP * f64::from(down));
    let mut refusal = None;
    for z in heights.take_while(|z| *z > place.z + MIN_MOVE) {
        match go(Pose { z, ..*place }) {
            Ok(()) => return Some(Ok(())),
            Err(error) => refusal = Some(Err(error)),
        }
    }
    refusal
}

/// Advice that names the steps from which the pose is known.
fn advice_on_known_steps(plan: &Plan, step: usize) -> String {
    let leads = |step: &Step| {
        let way = |by: Travel| by == Travel::Joints;
        matches!(step.action, Action::Move { by, .. } | Action::Joints { by, .. } if way(by))
    };
    let later = plan
        .steps
        .iter()
        .enumerate()
        .skip(step)
        .find(|(_, step)| leads(step));
    match later {
        Some((at, _)) if at + 1 < plan.steps.len() => format!(
            "step {} moves all joints to its own target: begin with step {}, or with the first",
            at + 1,
            at + 2
        ),
        _ => "begin with the first step".to_owned(),
    }
}
