//! Methods of a virtual arm's world: every client may look, the holder of the lease may change it.

use magician::ErrorKind;
use magician::message;
use serde_json::{Value, json};

use super::dispatch::{Call, Handled};
use super::{Awaited, Station};
use crate::api::{Method, Needs, RpcError};
use crate::control::ArmId;
use crate::order::{ArmOrder, ArmRead, Fault, WorldAct};

impl Station {
    pub(super) fn world_call(
        &mut self,
        method: &Method,
        call: &Call<'_>,
        arm: ArmId,
    ) -> Result<Handled, RpcError> {
        if method.name == "world.scenarios" {
            return Ok(Handled::Now(scenarios()));
        }
        // Parameters first, so that a wrong one is reported for every arm.
        let act = act_of(method.name, call)?;
        let entry = &self.arm(arm).entry;
        if !entry.is_virtual {
            let why = message!(
                "{entry} is not a virtual arm: it has no world",
                entry = entry.name
            );
            return Err(RpcError::arm(ErrorKind::Unsupported, why));
        }
        let (Some(act), Needs::Lease(kind)) = (act, method.needs) else {
            let mark = call.params.text("mark").map(str::to_owned);
            return Ok(self.read(call, arm, ArmRead::World { mark }));
        };
        let request = call.request;
        self.acquire_free_lease(call, arm);
        let begun = self
            .control
            .begin(call.now, call.session, arm, request, kind);
        begun.map_err(|refusal| self.refused(arm, refusal))?;
        self.order(arm, ArmOrder::World { request, act });
        Ok(Handled::Later(request, Awaited::Arm(arm)))
    }
}

/// Returns the built-in scenarios.
fn scenarios() -> Value {
    #[cfg(feature = "sim")]
    let scenarios: Vec<_> = { magician::sim::Scenario::BUILT_IN.iter() }
        .map(|(name, text)| {
            let title = magician::sim::Scenario::from_toml(text).ok();
            let title = title.as_ref().and_then(|scenario| scenario.title());
            json!({"name": name, "title": title.unwrap_or(name), "text": text})
        })
        .collect();
    #[cfg(not(feature = "sim"))]
    let scenarios: Vec<Value> = Vec::new();
    json!({"scenarios": scenarios})
}

/// Returns the event that a method causes. `None` for methods that only look.
fn act_of(name: &str, call: &Call<'_>) -> Result<Option<WorldAct>, RpcError> {
    let params = call.params;
    let is_on = |name: &str| params.is_on(name);
    Ok(Some(match name {
        "world.press" => WorldAct::Press(is_on("long")),
        "world.unlock" => WorldAct::Unlock(is_on("held")),
        "world.unplug" => WorldAct::Plug(is_on("plugged")),
        "world.guide" => {
            let joints = params.numbers("joints").unwrap_or_default();
            let joints = <[f64; 4]>::try_from(joints);
            let wrong = |_| RpcError::param("joints", message!("`joints` must be 4 numbers"));
            WorldAct::Guide(joints.map_err(wrong)?)
        }
        "world.place" => {
            let at = <[f64; 3]>::try_from(params.numbers("at").unwrap_or_default());
            let wrong = |_| RpcError::param("at", message!("`at` must be 3 numbers"));
            WorldAct::Place {
                name: params.text("name").unwrap_or_default().to_owned(),
                at: at.map_err(wrong)?,
            }
        }
        "world.paper" => WorldAct::Paper,
        "world.input" => {
            let level = params.switch("level").map(u16::from);
            let value = params.integer("value").map(|value| value as u16);
            let ((Some(value), None) | (None, Some(value))) = (level, value) else {
                return Err(RpcError::param(
                    "level",
                    message!("give `level` or `value`"),
                ));
            };
            WorldAct::Input {
                address: params.integer("address").unwrap_or_default() as u8,
                analog: level.is_none(),
                value,
            }
        }
        "world.fault" => WorldAct::Fault(match params.text("fault") {
            Some("alarm") => Fault::Alarm(params.integer("alarm").unwrap_or_default() as u8),
            Some("slip") => Fault::Slip {
                joint: params.integer("joint").unwrap_or(1) as u8,
                degrees: params.number("degrees").unwrap_or_default(),
            },
            // The check of parameters admits no other fault.
            _ => Fault::Reset,
        }),
        "world.scenario" => WorldAct::Scenario(params.text("text").unwrap_or_default().to_owned()),
        _ => return Ok(None),
    }))
}
