//! Replacing a plan's speeds by speeds from the user.

use magician_host::build;
use magician_protocol::Set;

use crate::{Action, Plan, Step};

impl Plan {
    /// Replaces the speed ratio in all steps by `percent` of the set speeds. Returns the command to
    /// send first, for plans that set no ratio.
    pub fn moves_at(&mut self, percent: f32) -> Set {
        let ratio = build::speed(percent, percent);
        self.steps.iter_mut().for_each(|step| {
            if let Some(Set::PtpCommonParams(_)) = command_of(step) {
                step.action = Action::Command(Box::new(ratio));
            }
        });
        ratio
    }

    /// Limits the speed of continuous paths to `speed`, mm/s, wherever a step sets one.
    pub fn path_at(&mut self, speed: f32) {
        self.steps.iter_mut().for_each(|step| {
            if let Some(Set::CpParams(mut params)) = command_of(step).copied() {
                params.junction_vel = speed;
                step.action = Action::Command(Box::new(params.into()));
            }
        });
    }

    /// Iterates over the settings that steps change.
    pub fn settings(&self) -> impl Iterator<Item = &Set> {
        self.steps.iter().filter_map(command_of)
    }
}

fn command_of(step: &Step) -> Option<&Set> {
    match &step.action {
        Action::Command(command) => Some(command),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Origin;

    #[test]
    fn new_speeds_replace_those_of_the_plan() {
        let mut plan = Plan::new("p");
        plan.push(build::speed(80.0, 80.0), Origin::NONE);
        plan.push(build::path_speed(60.0, 100.0), Origin::NONE);
        plan.push(build::path_to(200.0, 0.0, 0.0), Origin::NONE);
        let first = plan.moves_at(20.0);
        plan.path_at(10.0);
        let wanted = [
            build::speed(20.0, 20.0),
            build::path_speed(10.0, 100.0),
            build::path_to(200.0, 0.0, 0.0),
        ];
        assert_eq!(first, wanted[0]);
        assert!(plan.commands().eq(wanted));
        assert_eq!(plan.settings().count(), 2);
    }
}
