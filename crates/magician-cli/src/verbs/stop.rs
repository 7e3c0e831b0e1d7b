//! `stop`: stops the arm, or holds its queue.

use clap::Args;
use magician::report::PoseReport;
use magician::{Arm, commands};
use magician_job::report::outputs_left_on;
use magician_program::Diagnostic;
use magician_station::client::{ClientError, StationAddress, StationClient};
use serde::Deserialize;
use serde_json::json;
use tokio::time::timeout;

use super::pose::ShowPose;
use crate::context::{Context, STAND_BY, StopPolicy};
use crate::failure::Failure;
use crate::output::Output;

/// Stop the arm: motion, queue, laser and motors
#[derive(Args, Debug)]
#[command(after_help = "\
Stops the motion, drops the waiting commands, switches the laser and both motor outputs off, and \
    checks that the arm has stopped. Suction cup and gripper stay as they are, so that nothing falls: a note says what is still on. This is not a safety function: in an emergency use the arm's power switch.")]
pub(crate) struct Stop {
    /// Finish the command under way and hold the rest of the queue
    #[arg(long)]
    gentle: bool,
}

/// Note of a stop that opened no session.
const UNREAD: &str =
    "the station gave no session: whether suction cup or gripper are still on is not known";

impl Stop {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let policy = if self.gentle {
            StopPolicy::Hold
        } else {
            StopPolicy::Stop
        };
        // A station answers once the arm stands. It does so even if it gives no session, and if
        // another client moves the arm again.
        let stopped = if self.gentle {
            None
        } else {
            stop_by_request(context)?
        };
        let (answer, outputs) = match stopped {
            Some(pose) => {
                let read = async |arm: &Arm, _: &mut Output| Ok(arm.read_outputs().await?);
                (pose, context.arm(StopPolicy::Look, read).ok())
            }
            None => context.arm(policy, async |arm, _| {
                if self.gentle {
                    arm.stop_gentle().await?;
                } else {
                    arm.stop().await?;
                }
                let pose = arm.get::<commands::Pose>().await?;
                Ok((PoseReport::from(pose), Some(arm.read_outputs().await?)))
            })?,
        };
        // A gentle stop lets the current command finish, which may still switch outputs.
        if !self.gentle {
            match outputs {
                Some(outputs) => outputs_left_on(&outputs)
                    .iter()
                    .for_each(|note| context.note(note)),
                None => context.note(&Diagnostic::of_file(UNREAD)),
            }
        }
        let what = if self.gentle { "stopping" } else { "stopped" };
        context.show(&answer, |out| {
            out.line(format_args!("{what}: {}", answer.line()))
        })
    }
}

/// Stops the arm at a station by a single request, which needs no session. Returns the pose at
/// which it stands, or `None` without a station or without its confirmation.
///
/// # Errors
/// Only an interruption: other failures are reported better by the session that is tried next.
fn stop_by_request(context: &mut Context) -> Result<Option<PoseReport>, Failure> {
    let Some(url) = context.global.station.clone() else {
        return Ok(None);
    };
    let (token, trust) = (context.global.token_for(&url), context.global.trust());
    let call = async |method, params| {
        let call = StationClient::call_once(&url, token.as_deref(), &trust, method, params);
        timeout(STAND_BY, call)
            .await
            .unwrap_or(Err(ClientError::Lost))
    };
    let stop = async {
        let address: StationAddress = url.parse().map_err(ClientError::Address)?;
        // Without a name the station stops all of its arms.
        let arm = match address.arm {
            Some(arm) => json!(arm),
            None => match call("arm.list", json!({})).await?["arms"]
                .as_array()
                .map(Vec::as_slice)
            {
                Some([only]) => only["name"].clone(),
                _ => return Ok(None),
            },
        };
        let answer = call("arm.stop", json!({"arm": arm})).await?;
        let stopped = &answer["arms"][0];
        let pose = PoseReport::deserialize(&stopped["pose"]).ok();
        Ok::<_, ClientError>(pose.filter(|_| stopped["stood"] == true))
    };
    context.alone(async |_, signals| {
        tokio::select! {
            stopped = stop => Ok(stopped.ok().flatten()),
            _ = signals.next() => Err(Failure::interrupted()),
        }
    })
}
