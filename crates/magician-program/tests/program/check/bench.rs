//! Virtual arm in virtual time that runs a plan with a full queue.

use magician::{Set, commands};
use magician_program::Plan;

pub(crate) use arm::LoneArm;

/// Test bench of the driver's checks.
#[path = "../../../../magician/tests/preflight/bench.rs"]
#[allow(dead_code)]
mod arm;

/// Result of a plan.
#[derive(Debug)]
pub(crate) struct Done {
    /// Duration, us.
    pub(crate) took: u64,
    /// True if everything was done.
    pub(crate) finished: bool,
    /// Alarm that holds the arm, if any.
    pub(crate) alarm: Option<String>,
}

impl LoneArm {
    /// State of the tools: suction cup, gripper, laser.
    pub(crate) fn tools(&mut self) -> impl PartialEq + std::fmt::Debug + use<> {
        let cup: commands::EndEffectorSuctionCup = self.get();
        let gripper: commands::EndEffectorGripper = self.get();
        let laser: commands::EndEffectorLaser = self.get();
        (cup, gripper, laser)
    }

    /// Runs a plan, or as much of it as an alarm allows.
    pub(crate) fn run_plan(&mut self, plan: &Plan) -> Done {
        let commands: Vec<Set> = plan.commands().collect();
        // The first index is 2.
        let last = self.arm.state().queue.current_index.max(1) + commands.len() as u64;
        let took = self.run_all(&commands);
        let state = self.arm.state();
        Done {
            took,
            finished: state.queue.current_index >= last,
            alarm: state.alarms.blocking().then(|| state.alarms.to_string()),
        }
    }
}
