//! State of an arm on one line.

use magician::{ArmOutputs, GripperState, Link, Status};

use magician::report::PoseReport;

use crate::verbs::pose::ShowPose;

/// Formats a state.
pub(super) fn plain(status: &Status, outputs: &ArmOutputs) -> String {
    let pose = PoseReport::from(status.pose).line();
    let (done, free) = (status.current.0, status.left_space);
    let mut line = format!("{pose}  done {done} free {free}");
    for (nth, code) in status.alarms.codes().enumerate() {
        line.push_str(if nth == 0 { " alarms " } else { "," });
        line.push_str(&format!("{code:#04x}"));
    }
    if outputs.laser == Some(true) {
        line.push_str(" laser  ON");
    }
    if outputs.suction == Some(true) {
        line.push_str(" suction on");
    }
    if let Some(gripper) = outputs
        .gripper
        .filter(|gripper| *gripper != GripperState::Off)
    {
        line.push_str(&format!(" gripper {gripper}"));
    }
    if status.link != Link::Up {
        line.push_str(" LINK LOST");
    }
    line
}
