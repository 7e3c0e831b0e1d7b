//! Methods of the lease.

use magician::message;
use std::time::Duration;

use serde_json::Value;

use super::dispatch::{Call, Handled};
use super::{Awaited, Station};
use crate::api::RpcError;
use crate::control::{ArmId, LeaseId, Refusal, SessionId};

impl Station {
    pub(super) fn lease_call(&mut self, name: &str, call: &Call<'_>) -> Result<Handled, RpcError> {
        let (now, session, request) = (call.now, call.session, call.request);
        match (name, call.arm) {
            ("lease.acquire", Some(arm)) => {
                let wait = call.params.number("wait_s").unwrap_or(0.0);
                // The check of parameters bounds the number, so the conversion does not fail.
                let wait = Duration::try_from_secs_f64(wait).unwrap_or_default();
                self.control.acquire(now, session, arm, request, wait);
                Ok(Handled::Later(request, Awaited::Lease { asked: false }))
            }
            ("lease.ask", Some(arm)) => {
                self.control.ask(now, session, arm, request);
                Ok(Handled::Later(request, Awaited::Lease { asked: true }))
            }
            ("lease.take", Some(arm)) => {
                self.control.take(now, session, arm, request);
                Ok(Handled::Later(request, Awaited::Lease { asked: false }))
            }
            ("lease.answer", Some(arm)) => self.answer_ask(call, arm),
            ("lease.renew", _) => {
                let lease = self.lease(call)?;
                // Any message renews the lease. This one also reports whether the lease still
                // exists.
                let renewed = self.control.renew(session, lease);
                renewed
                    .map_err(|_| RpcError::new(RpcError::LEASE, message!("the lease has ended")))?;
                Ok(Handled::Now(Value::Null))
            }
            ("lease.release", _) => {
                let lease = self.lease(call)?;
                // A lease that has already ended gets the same answer, so a repeated release is
                // harmless.
                self.control.release(now, session, lease);
                Ok(Handled::Now(Value::Null))
            }
            _ => Err(RpcError::internal("a lease of no arm")),
        }
    }

    fn answer_ask(&mut self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        let unknown = || RpcError::param("session", message!("that session does not ask"));
        let text = call.params.text("session").unwrap_or_default();
        let asker = SessionId(self.number('s', text).ok_or_else(unknown)?);
        let grant = call.params.is_on("grant");
        let answered = self
            .control
            .answer(call.now, call.session, arm, asker, grant);
        match answered {
            Ok(()) => {}
            // The asker gave up meanwhile, or the clock granted it the lease.
            Err(Refusal::Unknown) if self.sessions.contains_key(&asker) => {}
            Err(refusal) => return Err(self.refused(arm, refusal)),
        }
        Ok(Handled::Now(Value::Null))
    }

    /// Returns the lease named in the request.
    fn lease(&self, call: &Call<'_>) -> Result<LeaseId, RpcError> {
        let text = call.params.text("lease").unwrap_or_default();
        let number = self.number('l', text);
        let unknown = || RpcError::param("lease", message!("there is no such lease"));
        number.map(LeaseId).ok_or_else(unknown)
    }
}
