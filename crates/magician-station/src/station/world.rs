//! The world of a virtual arm: looked at by anybody, changed by the holder of the lease.

use magician::ErrorKind;

use super::dispatch::{Call, Handled};
use super::{Awaited, Station};
use crate::api::{Method, Needs, RpcError};
use crate::control::ArmId;
use crate::order::{ArmOrder, ArmRead, WorldAct};

impl Station {
    pub(super) fn world_call(
        &mut self,
        method: &Method,
        call: &Call<'_>,
        arm: ArmId,
    ) -> Result<Handled, RpcError> {
        let act = act_of(method.name, call)?;
        let entry = &self.arm(arm).entry;
        if !entry.is_virtual {
            let why = format!("{} is not a virtual arm: it has no world", entry.name);
            return Err(RpcError::arm(ErrorKind::Unsupported, why));
        }
        let (Some(act), Needs::Lease(kind)) = (act, method.needs) else {
            return Ok(self.read(call, arm, ArmRead::World));
        };
        let request = call.request;
        self.take_lease(call, arm);
        let begun = self
            .control
            .begin(call.now, call.session, arm, request, kind);
        begun.map_err(|refusal| self.refused(arm, refusal))?;
        self.order(arm, ArmOrder::World { request, act });
        Ok(Handled::Later(request, Awaited::Arm(arm)))
    }
}

/// What a method does there; none for a look.
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
            let wrong = |_| RpcError::param("joints", "`joints` must be 4 numbers");
            WorldAct::Guide(joints.map_err(wrong)?)
        }
        "world.place" => {
            let at = <[f64; 3]>::try_from(params.numbers("at").unwrap_or_default());
            let wrong = |_| RpcError::param("at", "`at` must be 3 numbers");
            WorldAct::Place {
                name: params.text("name").unwrap_or_default().to_owned(),
                at: at.map_err(wrong)?,
            }
        }
        "world.scenario" => WorldAct::Scenario(params.text("text").unwrap_or_default().to_owned()),
        _ => return Ok(None),
    }))
}
