//! The fence of an arm: anybody sees it, teachers change it, and it holds for every session.

use serde_json::json;

use super::dispatch::{Call, Handled, forbidden};
use super::{Awaited, Station};
use crate::api::{Role, RpcError};
use crate::control::{ArmId, WorkEnd};
use crate::fence;
use crate::order::ArmOrder;

impl Station {
    pub(super) fn fence(&mut self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        let before = self.arm(arm).entry.fence;
        let Some(change) = call.params.get("set") else {
            let fence = fence::shown(before.as_ref());
            return Ok(Handled::Now(json!({ "fence": fence })));
        };
        let fence = fence::changed(before, change)?;
        if call.grant.role < Role::Teacher {
            return Err(forbidden(
                &call.grant,
                Role::Teacher,
                "a change of the fence",
            ));
        }
        // A job and a jog were planned by the fence that was there when they began.
        if let Some((job, _)) = self.job_at(arm) {
            let error = RpcError::new(RpcError::BUSY, "a job has the arm: stop it first");
            return Err(error.with("job", job.id.clone()));
        }
        if let Some((jog, _)) = self.control.jog(arm) {
            let error = RpcError::new(RpcError::BUSY, "a jog has the arm: stop it first");
            return Err(error.with("jog", self.jog_id(jog)));
        }
        self.arm_mut(arm).entry.fence = fence;
        let (request, by) = (call.request, Some(call.session));
        let stops = fence.is_some() && fence != before;
        #[cfg(feature = "class")]
        let fence = self.fence_now(arm);
        self.order(
            arm,
            ArmOrder::Fence {
                request,
                fence: Box::new(fence),
                stops,
            },
        );
        if stops {
            // What is under way was checked against the earlier one.
            for ended in self.control.stop(call.now, arm) {
                let error = self.ended(arm, WorkEnd::Stop(by));
                self.finish(call.now, ended, Err(error));
            }
        }
        Ok(Handled::Later(request, Awaited::Arm(arm)))
    }
}
