//! What an arm is to do, step by step, as a value.

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

/// What the arm is to do: steps in their order, each with where it came from.
///
/// Coordinates are the arm's (origin where the base axis meets the shoulder axis, X forward, Y to the arm's left, Z up), for
/// the tip of [`tool`](Self::tool), or for the tool bias in force on the arm when there is none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// What it is called; a file's name if it has no better one.
    pub title: String,
    /// The tool that it is made for. The arm is told of it first.
    pub tool: Option<Tool>,
    /// The surface that it works on, where that is known.
    pub surface: Option<Surface>,
    /// The steps.
    pub steps: Vec<Step>,
    /// Names that origins refer to.
    pub names: Vec<String>,
    /// The curves behind its lines, if it was read from a program that has arcs.
    pub curves: Curves,
}

impl Plan {
    /// An empty one.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            ..Self::default()
        }
    }

    /// True if it leads to positions on a rail.
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

    /// Adds a name and tells its index, for [`Origin::named`].
    pub fn name(&mut self, name: impl Into<String>) -> usize {
        self.names.push(name.into());
        self.names.len() - 1
    }

    /// The name of an origin.
    #[must_use]
    pub fn name_of(&self, origin: &Origin) -> Option<&str> {
        self.names.get(origin.name_index()?).map(String::as_str)
    }

    /// What the arm is told first: the tool that the plan is made for.
    #[must_use]
    pub fn preamble(&self) -> Option<Set> {
        self.tool.map(|tool| build::tool(tool.bias()))
    }

    /// Everything the arm is told, in order: the preamble, and the command of each step that has one.
    pub fn commands(&self) -> impl Iterator<Item = Set> + Clone + '_ {
        let steps = self.steps.iter().filter_map(|step| step.action.command());
        self.preamble().into_iter().chain(steps)
    }

    /// One command of each kind: what `Arm::preflight_for` has to read of an arm depends on
    /// nothing else.
    #[must_use]
    pub fn kinds(&self) -> Vec<Set> {
        let mut kinds = BTreeMap::new();
        // One by one: collecting sorts them all first, and a command takes five times the room of a step.
        for command in self.commands() {
            kinds.insert(command.row().id, command);
        }
        kinds.into_values().collect()
    }

    /// The places, from 0, at which it waits for a person.
    pub fn pauses(&self) -> impl Iterator<Item = (usize, &Pause)> {
        let steps = self.steps.iter().enumerate();
        steps.filter_map(|(nth, step)| match &step.action {
            Action::Pause(pause) => Some((nth, &**pause)),
            _ => None,
        })
    }

    /// Takes its pauses out.
    pub fn without_pauses(&mut self) {
        let pauses = |step: &Step| matches!(step.action, Action::Pause(_));
        self.steps.retain(|step| !pauses(step));
    }

    /// Least and greatest x, y and z to which steps lead, mm. `None` if none leads to a position.
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

    /// Whether anything of it may light the laser.
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
    fn what_lights_the_laser_burns_in_whatever_form() {
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
    fn kinds_are_one_of_each() {
        let path = |x| build::path_to(x, 0.0, 0.0);
        let mut plan = of([path(200.0), path(210.0), build::laser(false)]);
        plan.tool = Some(Tool::Laser);
        let kinds = plan.kinds();
        assert_eq!(kinds.len(), 3);
        assert!(kinds.contains(&build::tool(Tool::Laser.bias())));
    }
}
