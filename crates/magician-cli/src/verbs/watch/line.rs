//! A state on one line, for people and for programs.

use magician::{Link, Status};
use serde::Serialize;

use crate::verbs::pose::PoseReport;

/// A state as JSON has it: the pose under the names of `pose --json`, and what else was read.
#[derive(Serialize)]
pub(super) struct WatchReport {
    #[serde(flatten)]
    pose: PoseReport,
    current_index: u64,
    left_space: u32,
    alarms: Vec<u8>,
    link: &'static str,
    /// Whether the laser is on; null where the arm does not say.
    laser: Option<bool>,
}

impl WatchReport {
    pub(super) fn new(status: &Status, laser: Option<bool>) -> Self {
        Self {
            pose: PoseReport::from(status.pose),
            current_index: status.current.0,
            left_space: status.left_space,
            alarms: status.alarms.codes().collect(),
            link: match status.link {
                Link::Up => "up",
                Link::Lost { .. } => "lost",
                _ => "closed",
            },
            laser,
        }
    }
}

/// A state in words.
pub(super) fn plain(status: &Status, laser: Option<bool>) -> String {
    let pose = PoseReport::from(status.pose).line();
    let (done, free) = (status.current.0, status.left_space);
    let mut line = format!("{pose}  done {done} free {free}");
    for (nth, code) in status.alarms.codes().enumerate() {
        line.push_str(if nth == 0 { " alarms " } else { "," });
        line.push_str(&format!("{code:#04x}"));
    }
    if laser == Some(true) {
        line.push_str(" laser  ON");
    }
    if status.link != Link::Up {
        line.push_str(" LINK LOST");
    }
    line
}
