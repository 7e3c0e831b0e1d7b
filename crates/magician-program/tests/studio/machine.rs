//! A virtual arm at full speed, and what it did.

use magician::commands::Pose;
use magician::{Options, VirtualArm, blocking::Arm, words};
use magician_program::{Content, Format, Plan, ReadOptions, Tool, read};

/// A sample as the crate has it.
pub(crate) fn sample(name: &str) -> Vec<u8> {
    let path = format!("{}/samples/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// A plan, and the notes of its reading.
pub(crate) fn plan(format: Format, bytes: &[u8]) -> (Plan, Vec<String>) {
    let reading = read(format, bytes, &ReadOptions::default()).unwrap();
    let Content::Plan(plan) = reading.content else {
        panic!("no plan");
    };
    let notes = reading.notes.iter().map(ToString::to_string).collect();
    (plan, notes)
}

/// Runs a plan on a virtual arm that has been homed, with the tool that it names or this one, and tells where it ends. No
/// alarm comes up.
pub(crate) fn run(plan: &Plan, tool: Tool) -> [f32; 4] {
    let arm = Arm::simulated(VirtualArm::default(), Options::default()).unwrap();
    arm.home().unwrap();
    arm.perform(&[words::tool(plan.tool.unwrap_or(tool).bias())])
        .unwrap();
    let commands: Vec<_> = plan.commands().collect();
    arm.perform(&commands).unwrap();
    let alarms = arm.alarms().unwrap();
    assert!(alarms.is_empty(), "{alarms:?}");
    let Pose { x, y, z, r, .. } = arm.get().unwrap();
    [x, y, z, r]
}
