//! Plans: the steps that an arm shall do, as a value.

mod action;
pub(crate) mod file;
mod join;
pub(crate) mod json;
mod pace;
mod pallet;
mod part;
mod pen;
mod power;
mod step;
mod tidy;
mod transform;

use std::collections::BTreeMap;

use magician_host::build;
use magician_protocol::Set;

pub use action::{Action, Grip, Travel};
pub use file::PLAN_SCHEMA;
pub use pallet::Pallet;
pub use part::{Color, Part, Pause, PauseCause};
pub use step::{Step, Tool};

use crate::formats::Curves;
use crate::{Origin, Surface};

/// Steps for the arm in their order, each with its place in the source file.
///
/// Coordinates are the arm's: origin where the base axis meets the shoulder axis, X forward, Y to
/// the arm's left, Z up. They refer to the tip of [`tool`](Self::tool), or to the tool bias in
/// force on the arm if the plan names no tool.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// Title, by default the name of the file.
    pub title: String,
    /// Tool of the plan, which is sent to the arm first.
    pub tool: Option<Tool>,
    /// Surface that the plan works on, if known.
    pub surface: Option<Surface>,
    /// Steps.
    pub steps: Vec<Step>,
    /// Names that origins refer to.
    pub names: Vec<String>,
    /// The file behind flattened curves, if the plan was read from a program with arcs.
    pub curves: Curves,
}

impl Plan {
    /// Creates an empty plan.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            ..Self::default()
        }
    }

    /// True if a step moves the rail.
    #[must_use]
    pub fn uses_rail(&self) -> bool {
        let on_rail = |step: &Step| {
            matches!(&step.action, Action::Command(command)
                if matches!(**command, Set::PtpWithLCmd(_) | Set::PtpPoWithLCmd(_)))
        };
        self.steps.iter().any(on_rail)
    }

    /// Adds a step.
    pub fn push(&mut self, action: impl Into<Action>, origin: Origin) {
        self.steps.push(Step::new(action, origin));
    }

    /// Adds a name and returns its index, for [`Origin::named`].
    pub fn name(&mut self, name: impl Into<String>) -> usize {
        self.names.push(name.into());
        self.names.len() - 1
    }

    /// Returns the name of an origin.
    #[must_use]
    pub fn name_of(&self, origin: &Origin) -> Option<&str> {
        self.names.get(origin.name_index()?).map(String::as_str)
    }

    /// Returns the command to send first: the tool of the plan. `None` if the plan names no tool.
    #[must_use]
    pub fn preamble(&self) -> Option<Set> {
        self.tool.map(|tool| build::tool(tool.bias()))
    }

    /// Iterates over all commands in order: the preamble, then the command of each step that has
    /// one.
    pub fn commands(&self) -> impl Iterator<Item = Set> + Clone + '_ {
        let steps = self.steps.iter().filter_map(|step| step.action.command());
        self.preamble().into_iter().chain(steps)
    }

    /// Returns one command of each kind. They determine what `Arm::preflight_for` has to read from
    /// an arm.
    #[must_use]
    pub fn kinds(&self) -> Vec<Set> {
        let mut kinds = BTreeMap::new();
        // Insert one by one: `collect` would first gather and sort all commands, each of which is
        // five times the size of a step.
        for command in self.commands() {
            kinds.insert(command.row().id, command);
        }
        kinds.into_values().collect()
    }

    /// Iterates over the pauses with the index of their step.
    pub fn pauses(&self) -> impl Iterator<Item = (usize, &Pause)> {
        let steps = self.steps.iter().enumerate();
        steps.filter_map(|(nth, step)| match &step.action {
            Action::Pause(pause) => Some((nth, &**pause)),
            _ => None,
        })
    }

    /// Removes the pauses.
    pub fn without_pauses(&mut self) {
        let pauses = |step: &Step| matches!(step.action, Action::Pause(_));
        self.steps.retain(|step| !pauses(step));
    }

    /// Smallest and largest x, y and z of the steps' targets, mm. `None` if no step names a
    /// position.
    #[must_use]
    pub fn extent(&self) -> Option<[[f64; 3]; 2]> {
        let mut targets = self.steps.iter().filter_map(|step| step.action.target());
        let first = targets.next()?.map(f64::from);
        Some(targets.fold([first, first], |[least, most], to| {
            let at = |axis: usize| f64::from(to[axis]);
            [
                [0, 1, 2].map(|axis| least[axis].min(at(axis))),
                [0, 1, 2].map(|axis| most[axis].max(at(axis))),
            ]
        }))
    }

    /// True if a step may light the laser.
    #[must_use]
    pub fn burns(&self) -> bool {
        self.steps.iter().any(|step| step.action.burns())
    }
}

#[cfg(test)]
mod tests {
    use magician_host::commands::CpLeCmd;
    use magician_protocol::CpMode;

    use super::*;

    fn of(commands: impl IntoIterator<Item = Set>) -> Plan {
        let mut plan = Plan::new("p");
        commands
            .into_iter()
            .for_each(|command| plan.push(command, Origin::NONE));
        plan
    }

    fn burn(cp_mode: CpMode, power: f32) -> Set {
        CpLeCmd {
            cp_mode,
            x: 1.0,
            y: 0.0,
            z: 0.0,
            velocity_or_power: power,
        }
        .into()
    }

    #[test]
    fn any_command_that_lights_the_laser_burns() {
        for lit in [
            build::laser(true),
            burn(CpMode::Absolute, 1.0),
            burn(CpMode::Relative, 1.0),
        ] {
            assert!(
                of([build::path_to(200.0, 0.0, 0.0), lit]).burns(),
                "{lit:?}"
            );
        }
        let dark = [
            build::laser(false),
            burn(CpMode::Absolute, 0.0),
            burn(CpMode::Relative, 0.0),
        ];
        assert!(!of(dark).burns());
    }

    #[test]
    fn kinds_have_one_command_each() {
        let path = |x| build::path_to(x, 0.0, 0.0);
        let mut plan = of([path(200.0), path(210.0), build::laser(false)]);
        plan.tool = Some(Tool::Laser);
        let kinds = plan.kinds();
        assert_eq!(kinds.len(), 3);
        assert!(kinds.contains(&build::tool(Tool::Laser.bias())));
    }
}
