//! Speeds that a person asks for, instead of a plan's own.

use magician_host::build;
use magician_protocol::Set;

use crate::{Action, Plan, Step};

impl Plan {
    /// Has all moves use this share of the set speeds, percent, wherever its steps say another. Gives what the arm has to be
    /// told first.
    pub fn moves_at(&mut self, percent: f32) -> Set {
        let ratio = build::speed(percent, percent);
        self.steps.iter_mut().for_each(|step| {
            if let Some(Set::PtpCommonParams(_)) = command_of(step) {
                step.action = Action::Command(Box::new(ratio));
            }
        });
        ratio
    }

    /// Has continuous paths run at most so fast, mm/s, wherever its steps say another speed for them.
    pub fn path_at(&mut self, speed: f32) {
        self.steps.iter_mut().for_each(|step| {
            if let Some(Set::CpParams(mut params)) = command_of(step).copied() {
                params.junction_vel = speed;
                step.action = Action::Command(Box::new(params.into()));
            }
        });
    }

    /// The settings that its steps change.
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
    fn the_plans_own_speeds_give_way() {
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
