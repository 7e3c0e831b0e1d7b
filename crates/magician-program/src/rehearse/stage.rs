//! Setup of the virtual arm for a rehearsal.

use std::time::Duration;

use magician_host::build;
use magician_host::message;
use magician_host::preflight::Preflight;
use magician_host::{Error, FrameBuf, Geometry, JointAngles, Set};
use magician_motion::{ArmModel, Pose};
use magician_protocol::commands::ClearAllAlarmsState;
use magician_protocol::{Ctrl, RailVersion};
use magician_sim::{Controller, Profile, Scenario, World};

use super::HOST_LINK;
use crate::{Action, Plan, Tool};

/// Compliance of a tool in addition to the height range of the surface, mm.
const TOOL_COMPLIANCE: f64 = 3.0;
/// Largest compliance of a tool, mm. The tool does not reach parts of the surface that lie further
/// below its highest point.
const MAX_COMPLIANCE: f64 = 100.0;
/// Smallest start height of a tool above the table, mm.
const MIN_START_HEIGHT: f64 = 20.0;
/// Start position if the tool is too low in the home pose, mm.
const RAISED_START: [f64; 2] = [200.0, 0.0];
/// Height above the surface that still counts as touching, mm. Covers the rounding of coordinates.
const TOUCH_TOLERANCE: f64 = 1e-3;
/// Largest distance of a table from the base plane, mm; beyond it the height must be a mistake.
const MAX_TABLE_DISTANCE: f64 = 1000.0;

/// Options of a rehearsal that the plan itself leaves open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RehearseOptions {
    /// Tool on the arm. Default: the plan's tool, or the tool that its steps need.
    pub tool: Option<Tool>,
    /// z reported by the arm when its tool touches the table, mm. Default: the plan's surface, or
    /// where its pen draws.
    pub table: Option<f64>,
    /// Joints at the start. Default: the home pose, or above the table. Set this for a plan made
    /// from a known pose, so that the rehearsal starts there too. The virtual arm reports J1
    /// relative to its angle at the start.
    pub standing: Option<JointAngles>,
    /// Interval at which the tool position is recorded; `None` records none.
    pub watch: Option<Duration>,
}

impl RehearseOptions {
    /// Sets [`tool`](Self::tool).
    #[must_use]
    pub fn tool(mut self, tool: Tool) -> Self {
        self.tool = Some(tool);
        self
    }

    /// Sets [`watch`](Self::watch).
    #[must_use]
    pub fn watch(mut self, each: Duration) -> Self {
        self.watch = Some(each);
        self
    }

    /// Sets [`standing`](Self::standing).
    #[must_use]
    pub fn standing(mut self, joints: JointAngles) -> Self {
        self.standing = Some(joints);
        self
    }

    /// Sets [`table`](Self::table).
    #[must_use]
    pub fn table(mut self, height: f64) -> Self {
        self.table = Some(height);
        self
    }
}

/// Sets up a virtual arm for a plan: no alarms, its tool mounted and set, a level table below. The
/// arm is homed and stands at its home point, or above the table if its tool would be
/// inside the table there.
///
/// A plan with rail positions gets an arm on a rail. A plan without a tool gets the tool that its
/// steps need: a laser for burning, a cup or gripper for handling, else a pen. A tilted surface
/// becomes a table at its highest point, with a tool that is compliant enough to reach the lowest.
///
/// # Errors
/// [`InvalidInput`](magician_host::ErrorKind::InvalidInput) for a table height that is NaN,
/// infinite or out of range.
pub fn stage(plan: &Plan, options: &RehearseOptions) -> Result<Controller, Error> {
    let tool = tool_of(plan, options);
    let scenario = scenario(plan, options, tool)?;
    let mut arm = Controller::in_world(Profile::default(), World::from_scenario(&scenario));
    if let Some(joints) = start_joints(plan, options, tool)? {
        arm = arm.standing_at(joints);
    }
    let sent = [
        Set::ClearAllAlarmsState(ClearAllAlarmsState {}),
        build::tool(tool.bias()),
    ];
    let rail = { plan.uses_rail() }.then(|| build::rail(true, RailVersion::V2));
    for command in sent.iter().chain(&rail) {
        send(&mut arm, command, Ctrl::SET)?;
    }
    Ok(arm)
}

/// Joint angles that hold the tool above the table. `None` if the home pose is at least
/// [`MIN_START_HEIGHT`] above it, or no such angles are within the limits.
fn joints_above(table: f64, tool: Tool) -> Option<JointAngles> {
    let geometry = Geometry::magician(tool.bias());
    let home = geometry.forward(&JointAngles::HOME);
    let raised = Pose {
        z: table + MIN_START_HEIGHT,
        ..home
    };
    let [x, y] = RAISED_START;
    let aside = Pose { x, y, ..raised };
    if home.z >= raised.z {
        return None;
    }
    let limits = ArmModel::MAGICIAN.certain;
    let mut places = [raised, aside].into_iter();
    places.find_map(|place| geometry.inverse_within(&place, &limits).ok())
}

/// State of this arm, as the start of a preflight check.
#[must_use]
pub fn start_of(arm: &Controller) -> Preflight {
    let state = arm.state();
    let start = Preflight::of_model(arm.arm_model(), state.joints, state.tool);
    match state.rail {
        Some(l) => start.on_rail(l),
        None => start,
    }
}

/// State of the arm that [`stage`] returns, as the start of a preflight check, without creating
/// that arm.
///
/// # Errors
/// Same as [`stage`].
pub fn start_of_stage(plan: &Plan, options: &RehearseOptions) -> Result<Preflight, Error> {
    let tool = tool_of(plan, options);
    let joints = start_joints(plan, options, tool)?.unwrap_or(JointAngles::HOME);
    let start = Preflight::at(joints, tool.bias());
    Ok(if plan.uses_rail() {
        start.on_rail(0.0)
    } else {
        start
    })
}

/// Joints at the start; `None` for the home pose.
fn start_joints(
    plan: &Plan,
    options: &RehearseOptions,
    tool: Tool,
) -> Result<Option<JointAngles>, Error> {
    let table = table(plan, options, tool_kind(plan, tool))?;
    let above = || table.and_then(|(height, _)| joints_above(height, tool));
    Ok(options.standing.or_else(above))
}

/// Sends a command as its frame; the reply is dropped.
pub(super) fn send(arm: &mut Controller, command: &Set, ctrl: Ctrl) -> Result<(), Error> {
    let frame = FrameBuf::set(command, ctrl)?;
    arm.exchange(HOST_LINK, frame.bytes());
    Ok(())
}

/// Tool for the rehearsal of a plan.
#[must_use]
pub fn tool_of(plan: &Plan, options: &RehearseOptions) -> Tool {
    options
        .tool
        .or(plan.tool)
        .unwrap_or_else(|| needed_tool(plan))
}

/// Replaces a tool that is given only by its bias by the kind of tool that the plan needs. Returns
/// a named tool unchanged.
pub(crate) fn tool_kind(plan: &Plan, tool: Tool) -> Tool {
    match tool {
        Tool::Bias(_) => needed_tool(plan),
        named => named,
    }
}

fn needed_tool(plan: &Plan) -> Tool {
    let needs = |wanted: fn(&Action) -> bool| plan.steps.iter().any(|step| wanted(&step.action));
    if needs(Action::is_of_a_laser) {
        Tool::Laser
    } else if needs(|action| matches!(action, Action::Gripper(_))) {
        Tool::Gripper
    } else if needs(|action| matches!(action, Action::Suction(_))) {
        Tool::Suction
    } else {
        Tool::Pen
    }
}

fn scenario(plan: &Plan, options: &RehearseOptions, tool: Tool) -> Result<Scenario, Error> {
    let kind = tool_kind(plan, tool);
    let (height, slope) = table(plan, options, kind)?.unzip();
    let give = (TOOL_COMPLIANCE + slope.unwrap_or(0.0)).min(MAX_COMPLIANCE);
    let mut text =
        format!("arm = {{ homed = true }}\ntool = {{ kind = \"{kind}\", give = {give:?} }}\n");
    if let Some(height) = height {
        text.push_str(&format!("table = {{ height = {height:?} }}\n"));
    }
    let scenario = Scenario::from_toml(&text);
    scenario.map_err(|error| Error::invalid(error.to_string()))
}

/// Height of the table, and depth of the lowest point of the surface below it; `None` without a
/// table.
fn table(plan: &Plan, options: &RehearseOptions, tool: Tool) -> Result<Option<(f64, f64)>, Error> {
    let table = table_of(plan, options, tool);
    match table {
        Some((height, _)) if !height.is_finite() || height.abs() > MAX_TABLE_DISTANCE => {
            let message = message!(
                "a table at {height} mm is out of range for this arm",
                height
            );
            Err(Error::invalid(message).with_limit(height, MAX_TABLE_DISTANCE, "mm"))
        }
        _ => Ok(table),
    }
}

fn table_of(plan: &Plan, options: &RehearseOptions, tool: Tool) -> Option<(f64, f64)> {
    if let Some(height) = options.table {
        return Some((height, 0.0));
    }
    let drawn = plan.steps.iter().filter_map(|step| match step.action {
        Action::Path { to } | Action::Burn { to, .. } => Some(to.map(f64::from)),
        _ => None,
    });
    match plan.surface {
        Some(surface) if surface.slope == [0.0, 0.0] => Some((surface.height, 0.0)),
        Some(surface) => {
            // A tilted surface counts only where the plan touches it.
            let targets = plan.steps.iter().filter_map(|step| step.action.target());
            let touched = targets.filter_map(|to| {
                let [x, y, z] = to.map(f64::from);
                let height = surface.at([x, y]);
                (z <= height + TOUCH_TOLERANCE).then_some(height)
            });
            let range = extent(touched).unwrap_or([surface.height; 2]);
            Some((range[1], range[1] - range[0]))
        }
        None if tool == Tool::Pen => {
            let [lowest, _] = extent(drawn.map(|[_, _, z]| z))?;
            Some((lowest, 0.0))
        }
        None => None,
    }
}

fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range, value| {
        let [least, most] = range.unwrap_or([value; 2]);
        Some([value.min(least), value.max(most)])
    })
}
