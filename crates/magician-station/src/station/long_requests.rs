//! Long-running requests: checks and conversions of programs, and the library.
//!
//! They run off the station's thread. Few run at once and at most one per session and kind, so that
//! one client cannot occupy the machine; the rest waits in order. They never delay a stop.

use std::collections::{BTreeMap, VecDeque};

use super::Awaited;
use super::Station;
use super::dispatch::{Call, Handled};
use crate::api::{Role, RpcError};
use crate::control::{ArmId, RequestId, SessionId};
use crate::library::{LibraryAct, LibraryOrder};
use crate::order::ArmOrder;

/// Checks and conversions that compute at once. Two leave processors free for the arms on a small
/// machine; a choice.
const MAX_COMPUTING: usize = 2;
/// Library operations that read or write at once.
const MAX_FILE_OPERATIONS: usize = 4;
/// Most requests that wait. Further ones are refused.
const MAX_WAITING: usize = 64;

/// Long-running request.
#[derive(Debug)]
pub(super) enum LongRequest {
    /// Check of a program.
    Check(ArmId, ArmOrder),
    /// Operation on the library by a session of this role.
    Library(Role, LibraryAct),
}

impl LongRequest {
    /// True if the request computes, false if it only reads or writes. Conversions of taught
    /// programs count as the latter: they are short, and should not wait behind a check.
    fn computes(&self) -> bool {
        matches!(
            self,
            Self::Check(..) | Self::Library(_, LibraryAct::Convert { .. })
        )
    }
}

/// Long-running requests, waiting and running.
#[derive(Debug, Default)]
pub(super) struct LongRequests {
    waiting: VecDeque<(RequestId, SessionId, LongRequest)>,
    /// Running requests: session, and true if the request computes.
    running: BTreeMap<RequestId, (SessionId, bool)>,
}

impl LongRequests {
    /// Returns the first request that may run now.
    fn next(&mut self) -> Option<(RequestId, LongRequest)> {
        let running = &self.running;
        let computing = running.values().filter(|(_, computes)| *computes).count();
        let free = |computes| {
            if computes {
                computing < MAX_COMPUTING
            } else {
                // Kinds have separate limits, so that a long check does not delay a list of
                // programs.
                running.len() - computing < MAX_FILE_OPERATIONS
            }
        };
        let of = |session, computes| running.values().any(|run| *run == (session, computes));
        let at = self.waiting.iter().position(|(_, session, what)| {
            // A session may compute and read at the same time, but do neither twice.
            free(what.computes()) && !of(*session, what.computes())
        })?;
        let (request, session, what) = self.waiting.remove(at)?;
        self.running.insert(request, (session, what.computes()));
        Some((request, what))
    }

    /// Returns the number of waiting and running requests.
    pub(super) fn len(&self) -> usize {
        self.waiting.len() + self.running.len()
    }
}

impl Station {
    /// Queues a request and starts it when its turn comes.
    pub(super) fn queue_long_request(
        &mut self,
        call: &Call<'_>,
        what: LongRequest,
    ) -> Result<Handled, RpcError> {
        if self.long_requests.waiting.len() >= MAX_WAITING {
            let why = magician::message!(
                "{count} checks and changes of programs wait already",
                count = MAX_WAITING
            );
            return Err(RpcError::new(RpcError::TOO_MANY, why).with("limit", MAX_WAITING));
        }
        let request = call.request;
        let awaited = match &what {
            LongRequest::Check(arm, _) => Awaited::Arm(*arm),
            LongRequest::Library(..) => Awaited::Library,
        };
        { &mut self.long_requests.waiting }.push_back((request, call.session, what));
        self.start_long_requests();
        Ok(Handled::Later(request, awaited))
    }

    /// Starts everything that can start.
    fn start_long_requests(&mut self) {
        while let Some((request, what)) = self.long_requests.next() {
            match what {
                LongRequest::Check(arm, order) => self.order(arm, order),
                LongRequest::Library(by, act) => {
                    self.library.push_back(LibraryOrder { request, by, act });
                }
            }
        }
    }

    /// Handles the end of a request, if it was a long-running one.
    pub(super) fn finish_long_request(&mut self, request: RequestId) {
        if self.long_requests.running.remove(&request).is_some() {
            self.start_long_requests();
        }
    }

    /// Drops waiting requests of sockets that are gone.
    pub(super) fn drop_closed_requests(&mut self) {
        let pending = &self.pending;
        { &mut self.long_requests.waiting }.retain(|(request, ..)| pending.contains_key(request));
    }
}
