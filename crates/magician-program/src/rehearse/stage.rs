//! The virtual arm on which a plan is rehearsed.

use std::time::Duration;

use magician_host::build;
use magician_host::message;
use magician_host::preflight::Preflight;
use magician_host::{Error, FrameBuf, Geometry, JointAngles, Set};
use magician_motion::{ArmModel, Pose};
use magician_protocol::commands::ClearAllAlarmsState;
use magician_protocol::{Ctrl, RailVersion};
use magician_sim::{Controller, Profile, Scenario, World};

use super::HOST;
use crate::{Action, Plan, Tool};

/// How far a tool gives way beyond the slope of its surface, mm.
const GIVE: f64 = 3.0;
/// No tool gives way farther, mm: where a surface is lower yet, nothing is left on the table.
const MOST_GIVE: f64 = 100.0;
/// So far above the table a tool begins at least, mm.
const CLEAR: f64 = 20.0;
/// Where it begins if it cannot be so high where it is at home, mm.
const ABOVE: [f64; 2] = [200.0, 0.0];
/// So much above the surface is at the surface: the rounding of what is sent, mm.
const AT_SURFACE: f64 = 1e-3;
/// A table that is farther off than this is none, mm.
const FARTHEST_TABLE: f64 = 1000.0;

/// What a plan is rehearsed with, where it does not say so itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RehearseOptions {
    /// The tool on the arm; the plan's own if it names one, else the one that its steps need.
    pub tool: Option<Tool>,
    /// The z that the arm reports where its tool touches the table, mm; the plan's surface if it has one, else where its
    /// pen draws.
    pub table: Option<f64>,
    /// Where it stands when it begins; in its home pose, or above the table, if not said. What was told of a place must stay
    /// true when the plan is made with it. Its base counts from there.
    pub standing: Option<JointAngles>,
    /// How often to look where the tool is, for its way; never if it does not say.
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

/// A virtual arm that is ready for a plan: without an alarm, its tool mounted and told of, a level table under it. It
/// stands at its home point and has been homed; where its tool would be in the table there, it stands above the table.
///
/// A plan that goes to places on a rail has the arm on one.
///
/// A plan without a tool gets the one that its steps need: a laser for what burns, cup or gripper for what they hold, else
/// a pen. A surface that is not level is stood for by a table at its highest point, and a tool that gives way as far as
/// it is lower elsewhere.
///
/// # Errors
/// [`InvalidInput`](magician_host::ErrorKind::InvalidInput) for a table at no height.
pub fn stage(plan: &Plan, options: &RehearseOptions) -> Result<Controller, Error> {
    let tool = tool_of(plan, options);
    let scenario = scenario(plan, options, tool)?;
    let mut arm = Controller::in_world(Profile::default(), World::from_scenario(&scenario));
    if let Some(joints) = raised(plan, options, tool)? {
        arm = arm.standing_at(joints);
    }
    let told = [
        Set::ClearAllAlarmsState(ClearAllAlarmsState {}),
        build::tool(tool.bias()),
    ];
    let rail = { plan.uses_rail() }.then(|| build::rail(true, RailVersion::V2));
    for command in told.iter().chain(&rail) {
        tell(&mut arm, command, Ctrl::SET)?;
    }
    Ok(arm)
}

/// Where the arm stands whose tool would be in the table at home, or hardly above it.
fn above(table: f64, tool: Tool) -> Option<JointAngles> {
    let geometry = Geometry::magician(tool.bias());
    let home = geometry.forward(&JointAngles::HOME);
    let raised = Pose {
        z: table + CLEAR,
        ..home
    };
    let [x, y] = ABOVE;
    let aside = Pose { x, y, ..raised };
    if home.z >= raised.z {
        return None;
    }
    let limits = ArmModel::MAGICIAN.certain;
    let mut places = [raised, aside].into_iter();
    places.find_map(|place| geometry.inverse_within(&place, &limits).ok())
}

/// Where a check begins that is to hold for this arm.
#[must_use]
pub fn start_of(arm: &Controller) -> Preflight {
    let state = arm.state();
    let start = Preflight::of_model(arm.arm_model(), state.joints, state.tool);
    match state.rail {
        Some(l) => start.on_rail(l),
        None => start,
    }
}

/// Where a check begins that is to hold for the arm of a [`stage`], without making one.
///
/// # Errors
/// As [`stage`].
pub fn stands(plan: &Plan, options: &RehearseOptions) -> Result<Preflight, Error> {
    let tool = tool_of(plan, options);
    let joints = raised(plan, options, tool)?.unwrap_or(JointAngles::HOME);
    let start = Preflight::at(joints, tool.bias());
    Ok(if plan.uses_rail() {
        start.on_rail(0.0)
    } else {
        start
    })
}

/// Where the arm stands, if not at home.
fn raised(
    plan: &Plan,
    options: &RehearseOptions,
    tool: Tool,
) -> Result<Option<JointAngles>, Error> {
    let table = table(plan, options, kind_of(plan, tool))?;
    let above = || table.and_then(|(height, _)| above(height, tool));
    Ok(options.standing.or_else(above))
}

/// Sends a command as the bytes that it is, and forgets the answer.
pub(super) fn tell(arm: &mut Controller, command: &Set, ctrl: Ctrl) -> Result<(), Error> {
    let frame = FrameBuf::set(command, ctrl)?;
    arm.exchange(HOST, frame.bytes());
    Ok(())
}

/// The tool that a plan is rehearsed with.
#[must_use]
pub fn tool_of(plan: &Plan, options: &RehearseOptions) -> Tool {
    options.tool.or(plan.tool).unwrap_or_else(|| needed(plan))
}

/// What a tool that is only a bias must be for the plan; any other is what it is.
pub(crate) fn kind_of(plan: &Plan, tool: Tool) -> Tool {
    match tool {
        Tool::Bias(_) => needed(plan),
        named => named,
    }
}

fn needed(plan: &Plan) -> Tool {
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
    let kind = kind_of(plan, tool);
    let (height, slope) = table(plan, options, kind)?.unzip();
    let give = (GIVE + slope.unwrap_or(0.0)).min(MOST_GIVE);
    let mut text =
        format!("arm = {{ homed = true }}\ntool = {{ kind = \"{kind}\", give = {give:?} }}\n");
    if let Some(height) = height {
        text.push_str(&format!("table = {{ height = {height:?} }}\n"));
    }
    let scenario = Scenario::from_toml(&text);
    scenario.map_err(|error| Error::invalid(error.to_string()))
}

/// How high the table is, if there is one for the arm, and by how much the surface is lower at its lowest.
fn table(plan: &Plan, options: &RehearseOptions, tool: Tool) -> Result<Option<(f64, f64)>, Error> {
    let table = table_of(plan, options, tool);
    match table {
        Some((height, _)) if !height.is_finite() || height.abs() > FARTHEST_TABLE => {
            let message = message!(
                "a table at {height} mm is out of range for this arm",
                height
            );
            Err(Error::invalid(message).with_limit(height, FARTHEST_TABLE, "mm"))
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
            let targets = plan.steps.iter().filter_map(|step| step.action.target());
            let touched = targets.filter_map(|to| {
                let [x, y, z] = to.map(f64::from);
                let height = surface.at([x, y]);
                (z <= height + AT_SURFACE).then_some(height)
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
