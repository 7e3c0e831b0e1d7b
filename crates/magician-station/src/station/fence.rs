//! The fence of an arm: anybody sees it, teachers change it, and it holds for every session.

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
        if call.grant.role < Role::Teacher {
            return Err(forbidden(
                &call.grant,
                Role::Teacher,
                "a change of the fence",
            ));
        }
        // A job and a jog were planned by the fence that was there when they began.
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

/// In a class the fence of an arm changes with its holder: that of the class holds for all but teachers.
#[cfg(feature = "class")]
impl Station {
    /// The fence by which an arm moves for this side: the class's counts for all but teachers.
    pub(super) fn fence_for(&self, arm: ArmId, teacher: bool) -> Option<Fence> {
        let own = self.arm(arm).entry.fence;
        match self.class.fence {
            Some(class) if !teacher => Some(fence::stricter(own.unwrap_or_default(), &class)),
            _ => own,
        }
    }

    /// Has an arm move by this fence from here on.
    pub(super) fn put_fence(&mut self, arm: ArmId, fence: Option<Fence>) {
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

    /// The fence that an arm has from here on, which is ordered by the caller.
    pub(super) fn fence_now(&mut self, arm: ArmId) -> Option<Fence> {
        let fence = self.fence_for(arm, self.is_taught(arm));
        self.class.fences[arm.0 as usize] = fence;
        fence
    }

    /// Whether a teacher has the arm.
    fn is_taught(&self, arm: ArmId) -> bool {
        let holder = self.control.holder(arm);
        holder.is_some_and(|holder| !self.control.is_bound(holder))
    }

    /// Each arm gets the fence of whoever has it. A job ends by the fence that it began with.
    pub(super) fn put_fences(&mut self) {
        for arm in self.arm_ids() {
            let runs = self
                .job_at(arm)
                .is_some_and(|(job, _)| job.state != "paused");
            if !runs {
                let fence = self.fence_for(arm, self.is_taught(arm));
                self.put_fence(arm, fence);
            }
        }
    }
}
