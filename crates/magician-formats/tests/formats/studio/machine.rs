//! A virtual arm at full speed, and the results of its runs.

use magician::commands::Pose;
use magician::{Options, VirtualArm, blocking::Arm, build};
use magician_formats::{Action, Content, Format, Plan, ReadOptions, Step, Tool, Travel, read};

/// Returns a sample of `magician-program`.
pub(crate) fn sample(name: &str) -> Vec<u8> {
    let path = format!(
        "{}/../magician-program/samples/{name}",
        env!("CARGO_MANIFEST_DIR")
    );
    std::fs::read(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Reads a plan, and returns it with the notes.
pub(crate) fn plan(format: Format, bytes: &[u8]) -> (Plan, Vec<String>) {
    let reading = read(format, bytes, &ReadOptions::default()).unwrap();
    let Content::Plan(plan) = reading.content else {
        panic!("no plan");
    };
    let notes = reading.notes.iter().map(ToString::to_string).collect();
    (plan, notes)
}

/// Runs a plan on a virtual arm that has been homed, with the tool of the plan or else this one,
/// and returns the final pose. Asserts that no alarm is raised.
pub(crate) fn run(plan: &Plan, tool: Tool) -> [f32; 4] {
    let arm = Arm::simulated(VirtualArm::default(), Options::default()).unwrap();
    arm.home().unwrap();
    arm.run(&[build::tool(plan.tool.unwrap_or(tool).bias())])
        .unwrap();
    let commands: Vec<_> = plan.commands().collect();
    arm.run(&commands).unwrap();
    let alarms = arm.alarms().unwrap();
    assert!(alarms.is_empty(), "{alarms:?}");
    let Pose { x, y, z, r, .. } = arm.get().unwrap();
    [x, y, z, r]
}

/// Returns a plan as text, one step per line.
pub(crate) fn plan_text(plan: &Plan) -> String {
    let line = |step: &Step| {
        let name = plan.name_of(&step.origin).unwrap_or_default();
        format!("\n        {name}: {}", action_text(&step.action))
    };
    plan.steps.iter().map(line).collect()
}

fn action_text(action: &Action) -> String {
    let numbers = |pose: &[f32; 4]| pose.map(|value| value.to_string()).join(" ");
    match action {
        Action::Move { to, by } => {
            let way = match by {
                Travel::Joints => "joints",
                Travel::Line => "line",
                Travel::Jump => "jump",
            };
            format!("{way} {}", numbers(to))
        }
        Action::Joints { to, by } => format!("angles {} {by:?}", numbers(to)),
        Action::Shift { by, line } => {
            format!("shift {}{}", numbers(by), if *line { " line" } else { "" })
        }
        Action::Arc { via, to } => format!("arc {} to {}", numbers(via), numbers(to)),
        Action::Suction(on) => format!("suction {}", if *on { "on" } else { "off" }),
        Action::Gripper(grip) => format!("gripper {grip:?}"),
        Action::Wait(milliseconds) => format!("wait {milliseconds}"),
        other => format!("{other:?}"),
    }
}
