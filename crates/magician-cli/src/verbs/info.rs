use clap::Args;
use magician::commands::{DeviceId, DeviceName, DeviceSn, DeviceTime, DeviceVersion, DeviceWithL};
use magician::{Arm, ErrorKind};
use serde::Serialize;

use super::queue::finished;
use crate::columns::Columns;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::fence::Bounds;

/// Show the arm's identity and state
#[derive(Args, Debug)]
pub(crate) struct Info {}

#[derive(Serialize)]
struct ArmInfo {
    port: String,
    device_name: String,
    device_sn: String,
    firmware: String,
    device_id: Option<[u32; 3]>,
    uptime_ms: u32,
    with_l: bool,
    alarms: Vec<u8>,
    queue_current_index: u64,
    queue_left_space: u32,
    /// Whether the laser is on; null where the arm does not say.
    laser: Option<bool>,
    /// The fence that this computer holds it to, if there is one.
    fence: Option<Bounds>,
}

impl Info {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let answer = context.arm(StopPolicy::Look, async |arm, _| {
            let fence = arm.fence().map(ToString::to_string);
            Ok((read(arm).await?, fence))
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

async fn read(arm: &Arm) -> Result<ArmInfo, Failure> {
    let version = arm.get::<DeviceVersion>().await?;
    let numbers = [
        version.major_version,
        version.minor_version,
        version.revision,
    ];
    Ok(ArmInfo {
        port: arm.name().to_owned(),
        device_name: arm
            .get::<DeviceName>()
            .await?
            .device_name
            .lossy()
            .to_string(),
        device_sn: arm.get::<DeviceSn>().await?.device_sn.lossy().to_string(),
        firmware: numbers.map(|number| number.to_string()).join("."),
        device_id: device_id(arm).await?,
        uptime_ms: arm.get::<DeviceTime>().await?.g_systick,
        with_l: arm.get::<DeviceWithL>().await?.with_l.is_on(),
        alarms: arm.alarms().await?.codes().collect(),
        queue_current_index: arm.current_index().await?.0,
        queue_left_space: arm.left_space().await?,
        laser: arm.laser().await?,
        fence: arm.fence().map(Bounds::from),
    })
}

/// Whether the laser is on, in words.
fn laser(on: Option<bool>) -> &'static str {
    match on {
        Some(true) => "ON",
        Some(false) => "off",
        None => "not known",
    }
}

/// Older firmware does not answer this one.
async fn device_id(arm: &Arm) -> Result<Option<[u32; 3]>, Failure> {
    match arm.get::<DeviceId>().await {
        Ok(id) => Ok(Some(id.device_id)),
        Err(error) if error.kind() == ErrorKind::Timeout => Ok(None),
        Err(error) => Err(error.into()),
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
