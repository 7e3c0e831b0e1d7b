//! The world of a virtual arm of this process, by the arm's own handle.

use magician::commands::DeviceTime;
#[cfg(feature = "sim")]
use magician::sim::world::Press;
#[cfg(feature = "sim")]
use magician::sim::{ExternalEvent, Scenario};
use magician::{Arm, ErrorKind};
use serde_json::Value;
#[cfg(feature = "sim")]
use serde_json::json;

use super::reads;
use super::{TaskResult, Work};
use crate::api::RpcError;
use crate::control::RequestId;
use crate::order::{ArmRead, ArmReport, Outcome, WorldAct};

impl Work {
    /// Does it, and has the answer follow.
    pub(super) fn change_world(&mut self, request: RequestId, act: WorldAct) {
        let (arm, known) = (self.arm.clone(), self.known.clone());
        let report = move |done: Result<Value, RpcError>| {
            let outcome = done.map(Outcome::Value);
            TaskResult::Report(ArmReport::Done { request, outcome })
        };
        if let WorldAct::Scenario(_) = act {
            self.side.spawn(async move {
                // The arm's clock begins anew: the connection sees by it that the arm was reset.
                let clock = async || drop(arm.get::<DeviceTime>().await);
                clock().await;
                let done = happens(&arm, act);
                clock().await;
                if done.is_ok() {
                    // That it was is what was asked for, and no news for the next move.
                    drop(arm.run(&[]).await);
                }
                report(done)
            });
            return;
        }
        // Now, so that what a hand does comes in its order.
        let guides = matches!(act, WorldAct::Guide(_));
        let done = happens(&self.arm, act);
        self.side.spawn(async move {
            if guides && done.is_ok() {
                return reads::answer(arm, known, request, ArmRead::State).await;
            }
            report(done)
        });
    }
}

fn unsupported() -> RpcError {
    let why = "the arm is not a virtual arm of the station's process: it has no world that can be changed";
    RpcError::arm(ErrorKind::Unsupported, why)
}

#[cfg(not(feature = "sim"))]
fn happens(_: &Arm, _: WorldAct) -> Result<Value, RpcError> {
    Err(unsupported())
}

#[cfg(not(feature = "sim"))]
pub(super) async fn look(_: &Arm) -> Result<Value, RpcError> {
    Err(unsupported())
}

#[cfg(feature = "sim")]
fn happens(arm: &Arm, act: WorldAct) -> Result<Value, RpcError> {
    let arm = arm.virtual_arm().ok_or_else(unsupported)?;
    match act {
        WorldAct::Press(long) => arm.with(|arm| {
            arm.press(if long { Press::Long } else { Press::Short });
        }),
        WorldAct::Unlock(held) => arm.with(|arm| arm.unlock(held)),
        WorldAct::Plug(plugged) => arm.with(|arm| arm.inject(ExternalEvent::Cable { plugged })),
        WorldAct::Guide(joints) => {
            if !arm.state().unlocked {
                let why = "the motors hold the arm: hold the unlock key first (world.unlock)";
                return Err(RpcError::arm(ErrorKind::InvalidInput, why));
            }
            arm.with(|arm| arm.guide(joints.into()));
        }
        WorldAct::Place { name, at } => {
            if !arm.with(|arm| arm.place(&name, at)) {
                let name = magician_protocol::visible(&name);
                let why = format!("there is no object `{name}`");
                return Err(RpcError::param("name", why));
            }
        }
        WorldAct::Scenario(text) => {
            let scenario = Scenario::from_toml(&text);
            let scenario = scenario.map_err(|error| RpcError::param("text", error.to_string()))?;
            arm.restart_in(&scenario);
            let objects = scenario.objects().iter();
            let names: Vec<_> = objects.map(|object| object.name.as_str()).collect();
            return Ok(json!({"objects": names}));
        }
    }
    Ok(Value::Null)
}

/// The objects, what pen and laser have drawn, and what a hand does.
#[cfg(feature = "sim")]
pub(super) async fn look(arm: &Arm) -> Result<Value, RpcError> {
    let arm = arm.virtual_arm().ok_or_else(unsupported)?;
    let short = |value: f64| (value * 1e6).round() / 1e6 + 0.0;
    let (objects, drawing, unlocked, plugged) = arm.with(|arm| {
        let look = arm.look();
        let object = |object: magician::sim::world::ObjectView<'_>| {
            let place = object.place();
            let at = [place.x, place.y, place.z].map(short);
            json!({
                "name": object.name(),
                "at": at,
                "size": object.size(),
                "held": object.is_held(),
            })
        };
        let objects: Vec<_> = look.objects().map(object).collect();
        let (state, line) = (arm.state(), arm.line());
        (objects, arm.drawing(), state.unlocked, line.plugged)
    });
    // The arm goes on while the picture is drawn.
    let drawing = super::jobs::beside(move || drawing.to_svg()).await?;
    Ok(json!({
        "objects": objects,
        "drawing": drawing,
        "unlocked": unlocked,
        "plugged": plugged,
    }))
}
