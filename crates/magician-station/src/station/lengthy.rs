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
const CHECKS: usize = 2;
/// Library operations that read or write at once.
const FILES: usize = 4;
/// Most requests that wait. Further ones are refused.
const WAITING: usize = 64;

/// Long-running request.
#[derive(Debug)]
pub(super) enum Lengthy {
    /// Check of a program.
    Check(ArmId, ArmOrder),
    /// Operation on the library by a session of this role.
    Library(Role, LibraryAct),
}

impl Lengthy {
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
pub(super) struct LengthyWork {
    waiting: VecDeque<(RequestId, SessionId, Lengthy)>,
    /// Running requests: session, and true if the request computes.
    running: BTreeMap<RequestId, (SessionId, bool)>,
}

impl LengthyWork {
    /// Returns the first request that may run now.
    fn next(&mut self) -> Option<(RequestId, Lengthy)> {
        let running = &self.running;
        let computing = running.values().filter(|(_, computes)| *computes).count();
        let free = |computes| {
            if computes {
                computing < CHECKS
            } else {
                // Kinds have separate limits, so that a long check does not delay a list of
                // programs.
                running.len() - computing < FILES
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
    pub(super) fn in_turn(&mut self, call: &Call<'_>, what: Lengthy) -> Result<Handled, RpcError> {
        if self.lengthy.waiting.len() >= WAITING {
            let why = format!("{WAITING} checks and changes of programs wait already");
            return Err(RpcError::new(RpcError::TOO_MANY, why).with("limit", WAITING));
        }
        let request = call.request;
        let awaited = match &what {
            Lengthy::Check(arm, _) => Awaited::Arm(*arm),
            Lengthy::Library(..) => Awaited::Library,
        };
        { &mut self.lengthy.waiting }.push_back((request, call.session, what));
        self.take_turns();
        Ok(Handled::Later(request, awaited))
    }

    /// Starts everything that can start.
    fn take_turns(&mut self) {
        while let Some((request, what)) = self.lengthy.next() {
            match what {
                Lengthy::Check(arm, order) => self.order(arm, order),
                Lengthy::Library(by, act) => {
                    self.library.push_back(LibraryOrder { request, by, act });
                }
            }
        }
    }

    /// Handles the end of a request, if it was a long-running one.
    pub(super) fn turn_is_over(&mut self, request: RequestId) {
        if self.lengthy.running.remove(&request).is_some() {
            self.take_turns();
        }
    }

    /// Drops waiting requests of sockets that are gone.
    pub(super) fn forget_turns(&mut self) {
        let pending = &self.pending;
        { &mut self.lengthy.waiting }.retain(|(request, ..)| pending.contains_key(request));
    }
}
