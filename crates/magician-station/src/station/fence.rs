//! Methods of the fence: every client may read it, teachers may change it, and it applies to all
//! sessions.

#[cfg(feature = "class")]
use magician::Fence;
use magician::message;
use serde_json::json;

use super::dispatch::{Call, Handled, forbidden};
use super::{Awaited, Station};
use crate::api::{Role, RpcError};
#[cfg(feature = "class")]
use crate::control::RequestId;
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
        // Reading needs no role, so it is checked here and not in the table.
        if call.grant.role < Role::Teacher {
            return Err(forbidden(
                &call.grant,
                Role::Teacher,
                message!("a change of the fence"),
            ));
        }
        // A job and a jog were checked against the fence at their start, so the fence must not
        // change under them.
        if let Some((job, _)) = self.job_at(arm) {
            let error = RpcError::new(RpcError::BUSY, message!("a job has the arm: stop it first"));
            return Err(error.with("job", job.id.clone()));
        }
        if let Some((jog, _)) = self.control.jog(arm) {
            let error = RpcError::new(RpcError::BUSY, message!("a jog has the arm: stop it first"));
            return Err(error.with("jog", self.jog_id(jog)));
        }
        self.arm_mut(arm).entry.fence = fence;
        let (request, by) = (call.request, Some(call.session));
        // Removing a fence, or an equal one, endangers nothing in progress.
        let stops = fence.is_some() && fence != before;
        #[cfg(feature = "class")]
        let fence = self.next_fence(arm);
        self.order(
            arm,
            ArmOrder::Fence {
                request,
                fence: Box::new(fence),
                stops,
            },
        );
        if stops {
            // Requests in progress were checked against the earlier fence.
            for ended in self.control.stop(call.now, arm) {
                let error = self.ended_error(arm, WorkEnd::Stop(by));
                self.finish(call.now, ended, Err(error));
            }
        }
        Ok(Handled::Later(request, Awaited::Arm(arm)))
    }
}

/// The fence in a class: the fence of the class applies in addition while others than teachers hold
/// the arm.
#[cfg(feature = "class")]
impl Station {
    /// Returns the fence of an arm for a teacher, or for anyone else.
    pub(super) fn fence_for(&self, arm: ArmId, teacher: bool) -> Option<Fence> {
        let own = self.arm(arm).entry.fence;
        match self.class.fence {
            Some(class) if !teacher => Some(fence::stricter(own.unwrap_or_default(), &class)),
            _ => own,
        }
    }

    /// Orders a fence for an arm, if it differs from the current one.
    pub(super) fn order_fence(&mut self, arm: ArmId, fence: Option<Fence>) {
        if self.class.fences[arm.0 as usize] != fence {
            self.class.fences[arm.0 as usize] = fence;
            let request = RequestId(self.next_id());
            let (fence, stops) = (Box::new(fence), false);
            self.order(
                arm,
                ArmOrder::Fence {
                    request,
                    fence,
                    stops,
                },
            );
        }
    }

    /// Returns the fence that the arm has from now on. The caller orders it.
    pub(super) fn next_fence(&mut self, arm: ArmId) -> Option<Fence> {
        let fence = self.fence_for(arm, self.is_held_by_teacher(arm));
        self.class.fences[arm.0 as usize] = fence;
        fence
    }

    /// True if a teacher holds the arm.
    fn is_held_by_teacher(&self, arm: ArmId) -> bool {
        let holder = self.control.holder(arm);
        holder.is_some_and(|holder| !self.control.is_bound(holder))
    }

    /// Orders the fence of the current holder for each arm. A running job keeps the fence with
    /// which it started.
    pub(super) fn order_fences(&mut self) {
        for arm in self.arm_ids() {
            let runs = self
                .job_at(arm)
                .is_some_and(|(job, _)| job.state != "paused");
            if !runs {
                let fence = self.fence_for(arm, self.is_held_by_teacher(arm));
                self.order_fence(arm, fence);
            }
        }
    }
}
