//! Actions: moves, homing, tools, settings.
//!
//! Each action is an async function over [`Arm`]. It resolves when the arm has done it, and
//! dropping it stops the motion it started. That is how a stop ends an action: the engine drops the
//! future.

use magician::build::{self, Axis};
use magician::commands::{JogCommonParams, Pose, PtpCommonParams};
use magician::message;
use magician::{Arm, Ctrl, Message, Set};
use magician_program::{Tool, Travel};
use serde_json::{Value, json};

use super::ActionResult;
use super::reads::{Known, hex, reading};
use crate::api::RpcError;
use crate::order::{ArmAct, Outcome, TouchTarget};
use crate::reading as form;
use crate::surface::ArmSurface;

/// Answer for an arm that stands at this pose.
pub(super) fn standing_answer(pose: &Pose) -> Value {
    json!({"stood": true, "pose": form::pose(pose)})
}

/// Carries out an action, and reads the state afterwards if the action is answered with it.
/// Dropping the future stops the motion that the action started. `draws` is the tool for later
/// drawings.
pub(super) async fn run_action(
    arm: Arm,
    what: ArmAct,
    mut known: Known,
    surface: ArmSurface,
    draws: Tool,
) -> ActionResult {
    // `SetDeviceWithL` adds or removes the rail, which the driver's status does not contain.
    let stale = matches!(what, ArmAct::Set(Set::SetDeviceWithL(_)));
    // After these the arm is expected to stand, so the reading waits for it.
    let rests = matches!(
        what,
        ArmAct::Move { .. } | ArmAct::Home | ArmAct::Step { .. }
    );
    let on_rail = known.rail.is_some();
    let mut done = ActionResult {
        outcome: act(arm.clone(), what, on_rail, surface, draws).await,
        known: None,
        reading: None,
        stale,
    };
    if let Ok(Outcome::State) = done.outcome {
        let read = async {
            if on_rail {
                // The motion may have moved the rail.
                known = Known::read(&arm).await?;
            }
            if rests {
                come_to_rest(&arm).await?;
                known.reset_poses();
            }
            let reading = reading(&arm, &mut known).await?;
            Ok::<_, magician::Error>((known, reading))
        };
        match read.await {
            Ok((known, reading)) => (done.known, done.reading) = (Some(known), Some(reading)),
            Err(error) => done.outcome = Err(error.into()),
        }
    }
    done
}

/// Waits until the arm is at rest after its last command. Something else may still move it, for
/// example a jog that brakes.
async fn come_to_rest(arm: &Arm) -> magician::Result<()> {
    // Refreshes the driver's picture, on which `moving` is based.
    arm.queue().current_index().await?;
    if arm.moving() {
        arm.wait_still().await
    } else {
        Ok(())
    }
}

/// Carries out an action. Dropping the future ends the action as documented for the driver's method
/// in progress.
async fn act(
    arm: Arm,
    act: ArmAct,
    on_rail: bool,
    surface: ArmSurface,
    draws: Tool,
) -> Result<Outcome, RpcError> {
    match act {
        ArmAct::Set(set) => {
            // Motion of the arm must not start while a laser burns: it would drag the beam.
            if magician::sets_in_motion(&set) {
                arm.laser().check_off().await?;
            }
            arm.set_any(&set).await?;
            Ok(Outcome::Value(Value::Null))
        }
        ArmAct::Enqueue(set) => {
            let index = arm.enqueue_set(&set).await?;
            Ok(Outcome::Value(json!({"index": index.0})))
        }
        ArmAct::Raw {
            id,
            params,
            queued,
            moves,
        } => raw(&arm, id, &params, queued, moves).await,
        ArmAct::StartEmptyQueue => {
            arm.queue().start_if_empty().await?;
            Ok(Outcome::Value(Value::Null))
        }
        ArmAct::Move {
            to,
            rail,
            by,
            joints,
            relative,
            wait,
        } => {
            let command = command(to, rail, by, joints, relative, on_rail)?;
            arm.laser().check_off().await?;
            if wait {
                arm.run(&[command]).await?;
                return Ok(Outcome::State);
            }
            // Without waiting, the checks of `run` are made here, before the command is queued.
            arm.permission().check(&[command])?;
            arm.preflight_for(&[command]).await?.check(&command)?;
            let index = arm.enqueue_set(&command).await?;
            arm.queue().start().await?;
            Ok(Outcome::Value(json!({"index": index.0})))
        }
        ArmAct::Home => {
            // Homing moves through the whole workspace.
            arm.laser().switch_off().await?;
            arm.home().await?;
            Ok(Outcome::State)
        }
        ArmAct::ClearAlarms => {
            // Clearing the alarms resumes a queue that they held.
            arm.permission().check_queue().await?;
            arm.clear_alarms().await?;
            Ok(Outcome::State)
        }
        ArmAct::Touch { takes, unhomed } => {
            let arm = if unhomed { arm.allowing_unhomed() } else { arm };
            let taken = match takes {
                TouchTarget::Height { adds } => surface.touch(arm, draws, adds).await,
                TouchTarget::Corner(corner) => surface.take_corner(arm, draws, corner).await,
            };
            taken.map(Outcome::Value)
        }
        ArmAct::ForgetSurface => surface.forget().await.map(Outcome::Value),
        ArmAct::Tip(bias) => {
            arm.set_any(&build::tool(bias)).await?;
            Ok(Outcome::State)
        }
        ArmAct::Tool(set) if set == build::laser(false) => {
            // Also lowers the laser's pins, if they are outputs.
            arm.laser().switch_off().await?;
            Ok(Outcome::State)
        }
        ArmAct::Tool(set) => {
            arm.set_any(&set).await?;
            Ok(Outcome::State)
        }
        ArmAct::Speed(percent) => {
            set_speed_ratio(&arm, percent).await?;
            Ok(Outcome::Value(Value::Null))
        }
        ArmAct::Step {
            axis,
            by,
            turned,
            percent,
        } => {
            arm.laser().check_off().await?;
            // A step is relative: from a moving arm its target would depend on timing.
            arm.wait_still().await?;
            if let Some(percent) = percent {
                // Read first: the command sets velocity and acceleration together, and only one
                // changes.
                let before = arm.get::<PtpCommonParams>().await?;
                arm.set(&PtpCommonParams {
                    velocity_ratio: percent,
                    ..before
                })
                .await?;
            }
            let command = if turned && matches!(axis, Axis::X | Axis::Y) {
                step_in_tool_frame(&arm, axis, by).await?
            } else {
                axis.step(by)
            };
            arm.run(&[command]).await?;
            Ok(Outcome::State)
        }
    }
}

/// Sends a frame without a row in the protocol's table. The effect of its command is known only
/// from the caller's `queued` and `moves`.
async fn raw(
    arm: &Arm,
    id: u8,
    params: &[u8],
    queued: bool,
    moves: bool,
) -> Result<Outcome, RpcError> {
    // The fence cannot check a command whose target is unknown.
    if moves && arm.fence().is_some() {
        let why = message!("the arm has a fence, and where this command goes is not known");
        return Err(RpcError::arm(magician::ErrorKind::Unreachable, why));
    }
    if moves {
        arm.laser().check_off().await?;
    }
    let ctrl = if queued { Ctrl::QUEUED } else { Ctrl::SET };
    let reply = arm.raw(id, ctrl, params).await?;
    let reply = reply.frame();
    match reply.params().try_into() {
        Ok(index) if queued => Ok(Outcome::Value(json!({"index": u64::from_le_bytes(index)}))),
        // Not a queued command, or a reply without an index: returned as it is.
        _ => Ok(Outcome::Value(json!({"params": hex(reply.params())}))),
    }
}

/// Builds a step in the frame of the tool, rotated by the arm's current r.
async fn step_in_tool_frame(arm: &Arm, axis: Axis, by: f32) -> Result<Set, RpcError> {
    let r = f64::from(arm.get::<Pose>().await?.r).to_radians();
    let by = f64::from(by);
    let (x, y) = match axis {
        Axis::X => (by * r.cos(), by * r.sin()),
        // Only X and Y are turned (see the caller), so this is Y.
        _ => (-by * r.sin(), by * r.cos()),
    };
    Ok(build::line_by(x as f32, y as f32, 0.0, 0.0))
}

async fn set_speed_ratio(arm: &Arm, percent: f32) -> Result<(), RpcError> {
    // Both are read before either is set, so that a lost reply changes nothing.
    let moves = arm.get::<PtpCommonParams>().await?;
    let jogs = arm.get::<JogCommonParams>().await?;
    arm.set(&PtpCommonParams {
        velocity_ratio: percent,
        ..moves
    })
    .await?;
    arm.set(&JogCommonParams {
        velocity_ratio: percent,
        ..jogs
    })
    .await?;
    Ok(())
}

/// Builds the command of a move.
fn command(
    to: [f32; 4],
    rail: Option<f32>,
    by: Travel,
    joints: bool,
    relative: bool,
    on_rail: bool,
) -> Result<Set, RpcError> {
    let no = |name: &str, why: Message| Err(RpcError::param(name, why));
    let command = match (by, joints, relative) {
        // The height that a jump rises to is absolute, so there is no relative jump.
        (Travel::Jump, _, true) => return no("by", message!("a jump counts from no place")),
        (Travel::Line, true, true) => {
            return no(
                "by",
                message!("a relative move by joints has no straight line"),
            );
        }
        (_, true, true) => {
            let [j1, j2, j3, j4] = to;
            build::move_joints_by(j1, j2, j3, j4)
        }
        (by, false, true) => {
            let [x, y, z, r] = to;
            match by {
                Travel::Line => build::line_by(x, y, z, r),
                // A jump was refused above.
                _ => build::move_by(x, y, z, r),
            }
        }
        (by, false, false) => by.to_pose(to),
        (by, true, false) => by.to_joints(to),
    };
    match rail {
        None => Ok(command),
        Some(_) if !on_rail => no("to", message!("a fifth number is for an arm on a rail")),
        Some(rail) => Ok(build::with_rail(command, rail)?),
    }
}
