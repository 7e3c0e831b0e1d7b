//! Reports of a check, compared with the virtual arm that then runs the plan.

mod bench;
mod from_step;
mod programs;
mod report;
mod times;

use magician_program::{Action, Origin, Plan, Travel};

/// Plan of these actions, each with its own line.
fn plan_of(actions: impl IntoIterator<Item = Action>) -> Plan {
    let mut plan = Plan::new("p");
    for (at, action) in actions.into_iter().enumerate() {
        plan.push(
            action,
            Origin {
                line: at as u32 + 1,
                column: 1,
                length: 5,
                name: 0,
            },
        );
    }
    plan
}

/// Straight move.
fn line([x, y, z]: [f32; 3]) -> Action {
    Action::Move {
        to: [x, y, z, 0.0],
        by: Travel::Line,
    }
}
