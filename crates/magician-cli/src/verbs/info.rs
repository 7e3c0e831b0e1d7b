//! `info`: shows the arm's identity, firmware, tool and state.

use clap::Args;
use magician::report::ArmInfo;

use super::queue::finished;
use crate::columns::Columns;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;

/// Show the arm's identity and state
#[derive(Args, Debug)]
pub(crate) struct Info {}

impl Info {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let answer = context.arm(StopPolicy::Look, async |arm, _| {
            let fence = arm.fence().map(|fence| fence.to_string());
            Ok((ArmInfo::read(arm).await?, fence))
        })?;
        let (answer, fence) = answer;
        context.show(&answer, |out| {
            let mut columns = Columns::default();
            columns.row(["port", &answer.port]);
            columns.row(["name", &answer.device_name]);
            columns.row(["serial number", &answer.device_sn]);
            columns.row(["firmware", &answer.firmware]);
            if let Some([a, b, c]) = answer.device_id {
                columns.row(["processor id", &format!("{a:08x} {b:08x} {c:08x}")]);
            }
            columns.row([
                "switched on",
                &format!("{} ago", duration(answer.uptime_ms)),
            ]);
            columns.row(["rail", if answer.with_l { "in use" } else { "none" }]);
            columns.row(["alarms", &alarms(&answer.alarms)]);
            columns.row(["laser", laser(answer.laser)]);
            columns.row(["suction cup", switched(answer.suction)]);
            columns.row(["gripper", answer.gripper.unwrap_or(UNKNOWN)]);
            if let Some(fence) = &fence {
                columns.row(["fence", fence]);
            }
            let (current, left) = (answer.queue_current_index, answer.queue_left_space);
            columns.row([
                "queue",
                &format!("finished {}, room for {left}", finished(current)),
            ]);
            columns.write(out)
        })
    }
}

const UNKNOWN: &str = "not known";

fn switched(on: Option<bool>) -> &'static str {
    match on {
        Some(true) => "on",
        Some(false) => "off",
        None => UNKNOWN,
    }
}

/// Returns the word for the laser's state; upper case if it is on.
fn laser(on: Option<bool>) -> &'static str {
    match on {
        Some(true) => "ON",
        on => switched(on),
    }
}

fn alarms(codes: &[u8]) -> String {
    codes
        .iter()
        .copied()
        .collect::<magician_protocol::AlarmSet>()
        .to_string()
}

fn duration(milliseconds: u32) -> String {
    let seconds = milliseconds / 1000;
    let (hours, minutes, rest) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match (hours, minutes) {
        (0, 0) => format!("{}.{} s", seconds, milliseconds % 1000 / 100),
        (0, _) => format!("{minutes} min {rest} s"),
        _ => format!("{hours} h {minutes} min"),
    }
}
