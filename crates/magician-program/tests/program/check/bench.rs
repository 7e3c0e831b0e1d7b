//! A virtual arm in virtual time that does a plan, its queue kept full.

use magician::{Set, commands};
use magician_program::Plan;

pub(crate) use arm::LoneArm;

/// The arm of the checks that the driver has.
#[path = "../../../../magician/tests/preflight/bench.rs"]
#[allow(dead_code)]
mod arm;

/// What a plan has come to.
#[derive(Debug)]
pub(crate) struct Done {
    /// How long it took, us.
    pub(crate) took: u64,
    /// Everything has been done.
    pub(crate) finished: bool,
    /// An alarm holds the arm.
    pub(crate) alarm: Option<String>,
}

impl LoneArm {
    /// What the tools are told to do: suction cup, gripper, laser.
    pub(crate) fn tools(&mut self) -> impl PartialEq + std::fmt::Debug + use<> {
        let cup: commands::EndEffectorSuctionCup = self.get();
        let gripper: commands::EndEffectorGripper = self.get();
        let laser: commands::EndEffectorLaser = self.get();
        (cup, gripper, laser)
    }

    /// Does all of a plan, or as much as an alarm lets it.
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
