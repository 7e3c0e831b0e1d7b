//! Wording of an order's result, for the pads.

use magician::ErrorKind;
use magician_job::jog::{OrderError, ToolOrder};
use magician_job::{Fault, JobError};
use magician_program::Grip;

use crate::failure::{Failure, Kind};

/// Converts the error of an order into a failure.
pub(super) fn failure(error: &OrderError) -> Failure {
    match error {
        OrderError::Arm(error) => Failure::from(&**error),
        OrderError::Program(error) => program(error),
        OrderError::Busy => {
            let message = "the arm is busy: space stops it";
            Failure::new(Kind::Driver(ErrorKind::Closed), message)
        }
        _ => Failure::new(Kind::Driver(ErrorKind::Closed), error.to_string()),
    }
}

/// Converts the error of a pad's program into a failure.
fn program(error: &JobError) -> Failure {
    let refused = match &error.fault {
        Fault::Refused { report, .. } => report.refused_steps.first().map(|first| (report, first)),
        _ => None,
    };
    match (&error.fault, refused) {
        (Fault::Arm(error), _) => Failure::from(&**error),
        (Fault::Program(problem), _) => {
            let name = problem.name.as_ref();
            let name = name.map_or_else(String::new, |name| format!("{name}: "));
            Failure::invalid(format!("{name}{}", problem.message))
        }
        (_, Some((report, refused_step))) => {
            let name = refused_step.name.clone();
            let name = name.unwrap_or_else(|| format!("step {}", report.number(refused_step.step)));
            let message = format!("{name}: {}", refused_step.error.message());
            Failure::new(Kind::Driver(refused_step.error.kind()), message)
        }
        _ => Failure::new(Kind::Driver(ErrorKind::Closed), error.to_string()),
    }
}

/// Describes the new state of a tool.
pub(super) const fn tool(order: ToolOrder) -> &'static str {
    match order {
        ToolOrder::Suction(true) => "suction on",
        ToolOrder::Suction(false) => "suction off",
        ToolOrder::Gripper(Grip::Close) => "the gripper closes",
        ToolOrder::Gripper(Grip::Open) => "the gripper opens",
        ToolOrder::Gripper(Grip::Off) => "the gripper's pump is off",
        ToolOrder::Laser(true) => "the laser burns",
        ToolOrder::Laser(false) => "the laser is off",
        ToolOrder::Tip(_) => "the arm uses the tool that the program was taught with",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}
