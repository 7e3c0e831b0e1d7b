//! Commands of the demo, and the checks after they have run.

use std::time::Duration;

use magician::commands::Pose;
use magician::{Arm, RunSummary, Set, build};
use magician_program::{Origin, Plan, Program};

use super::scene::{self, CUBE_TOP_Z, CUBES, CubeMove, LIFT_HEIGHT, TOOL};
use crate::failure::{Failure, Kind};

/// Share of the set speeds, percent.
const SPEED_RATIO: f32 = 75.0;
/// Time for the cup to grip a cube or to release it. A choice.
const GRIP_TIME: Duration = Duration::from_millis(300);
/// Largest deviation of the joints from their expected angles at the end, deg.
const JOINT_TOLERANCE: f32 = 0.01;

/// Returns the whole program, from the settings it needs to the way home.
pub(super) fn commands() -> Vec<Set> {
    let mut commands = vec![
        build::tool(TOOL),
        build::jump_height(LIFT_HEIGHT as f32, (CUBE_TOP_Z + LIFT_HEIGHT) as f32),
        build::speed(SPEED_RATIO, SPEED_RATIO),
        build::suction(false),
    ];
    for cube in CUBES {
        commands.extend(carry(cube));
    }
    let home = scene::home();
    commands.push(build::jump_to(
        home.x as f32,
        home.y as f32,
        home.z as f32,
        home.r as f32,
    ));
    commands
}

/// Returns the commands that pick a cube and place it.
fn carry(CubeMove { from, to }: CubeMove) -> [Set; 6] {
    let above = |(x, y): (f64, f64)| build::jump_to(x as f32, y as f32, CUBE_TOP_Z as f32, 0.0);
    [
        above(from),
        build::suction(true),
        build::wait(GRIP_TIME),
        above(to),
        build::suction(false),
        build::wait(GRIP_TIME),
    ]
}

/// Converts commands into a program, one step each.
pub(super) fn program(commands: &[Set]) -> Program {
    let mut plan = Plan::new("the demonstration");
    for command in commands {
        plan.push(*command, Origin::NONE);
    }
    Program::new(plan, Some(1))
}

/// Fails unless the arm ran all commands with consecutive indices, has no alarm, and is back at its
/// start.
pub(super) async fn confirm(arm: &Arm, ran: &RunSummary, commands: usize) -> Result<(), Failure> {
    let failed = |what: String| Err(Failure::new(Kind::CheckFailed, what));
    let index = |index: Option<magician::QueueIndex>| index.map_or(0, |index| index.0);
    let indices = (index(ran.last) + 1).saturating_sub(index(ran.first));
    if ran.commands != commands as u64 || indices != commands as u64 {
        let took = ran.commands;
        return failed(format!(
            "the arm accepted {took} of {commands} commands in {indices} queue indices"
        ));
    }
    let alarms = arm.alarms().await?;
    if !alarms.is_empty() {
        return failed(format!("alarms at the end: {alarms}"));
    }
    let (pose, home) = (arm.get::<Pose>().await?, scene::JOINTS_AT_END);
    let apart = pose
        .joint_angle
        .iter()
        .zip(home)
        .map(|(found, wanted)| (found - wanted).abs());
    if apart.fold(0.0, f32::max) > JOINT_TOLERANCE {
        return failed(format!(
            "the arm ends at joints {:?}, not at home",
            pose.joint_angle
        ));
    }
    Ok(())
}
