//! Concatenation of plans.

use super::Plan;
use crate::{Origin, Step};

impl Plan {
    /// Returns this plan followed by the steps of another, under this plan's title.
    ///
    /// If the other plan uses a different tool, a step between them sets it. The surface is unknown
    /// unless both plans have the same one.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        let mut plan = self.clone();
        if other.tool.is_some() && other.tool != plan.tool {
            let told = other.preamble().map(|tool| Step::new(tool, Origin::NONE));
            plan.steps.extend(told);
        }
        if plan.surface != other.surface {
            plan.surface = None;
        }
        let names = u32::try_from(plan.names.len()).unwrap_or(u32::MAX);
        plan.names.extend(other.names.iter().cloned());
        let steps = other.steps.iter().cloned().map(|mut step| {
            if step.origin.name > 0 {
                step.origin.name = step.origin.name.saturating_add(names);
            }
            step
        });
        plan.steps.extend(steps);
        plan
    }
}

#[cfg(test)]
mod tests {
    use magician_host::build;

    use super::*;
    use crate::{Action, Surface, Tool};

    fn plan(tool: Option<Tool>, height: f64, name: &str) -> Plan {
        let mut plan = Plan::new(name);
        plan.tool = tool;
        plan.surface = Some(Surface::level(height));
        let at = plan.name(name);
        plan.push(Action::Wait(1), Origin::NONE.named(at));
        plan.push(Action::Wait(2), Origin::NONE);
        plan
    }

    #[test]
    fn joined_plans_keep_names_tools_and_surfaces() {
        let one = plan(Some(Tool::Pen), -50.0, "one");
        let both = one.joined(&plan(Some(Tool::Laser), -40.0, "two"));
        assert_eq!((both.title.as_str(), both.tool), ("one", Some(Tool::Pen)));
        assert_eq!(both.surface, None);
        assert_eq!(both.steps.len(), 2 + 1 + 2);
        let told = build::tool(Tool::Laser.bias());
        assert_eq!(both.steps[2].action.command(), Some(told));
        let named = |at: usize| both.name_of(&both.steps[at].origin);
        assert_eq!([named(0), named(1)], [Some("one"), None]);
        assert_eq!([named(3), named(4)], [Some("two"), None]);
    }

    #[test]
    fn plans_with_the_same_tool_are_joined_without_a_tool_command() {
        let one = plan(Some(Tool::Pen), -50.0, "one");
        for tool in [Some(Tool::Pen), None] {
            let both = one.joined(&plan(tool, -50.0, "two"));
            assert_eq!(both.steps.len(), 4);
            assert_eq!(both.surface, one.surface);
        }
    }
}
