//! What takes its time beside the arms: a few at once, one for each session, the rest in order. It never holds up a stop.

use std::collections::{BTreeMap, VecDeque};

use super::Awaited;
use super::Station;
use super::dispatch::{Call, Handled};
use crate::api::{Role, RpcError};
use crate::control::{ArmId, RequestId, SessionId};
use crate::library::{LibraryAct, LibraryOrder};
use crate::order::ArmOrder;

/// Checks and conversions at once.
const CHECKS: usize = 2;
/// Looks into the library, and changes of it, at once.
const FILES: usize = 4;
/// What waits for its turn, at most.
const WAITING: usize = 64;

/// Something that takes its time.
#[derive(Debug)]
pub(super) enum Lengthy {
    /// A check of a program.
    Check(ArmId, ArmOrder),
    /// Something of the library, for a session of this role.
    Library(Role, LibraryAct),
}

impl Lengthy {
    /// Whether it computes, and does not only read or write.
    fn computes(&self) -> bool {
        matches!(
            self,
            Self::Check(..) | Self::Library(_, LibraryAct::Convert { .. })
        )
    }
}

/// What is under way, and what waits.
#[derive(Debug, Default)]
pub(super) struct LengthyWork {
    waiting: VecDeque<(RequestId, SessionId, Lengthy)>,
    /// What is under way, whose it is, and whether it computes.
    running: BTreeMap<RequestId, (SessionId, bool)>,
}

impl LengthyWork {
    /// The first whose turn it is.
    fn next(&mut self) -> Option<(RequestId, Lengthy)> {
        let running = &self.running;
        let computing = running.values().filter(|(_, computes)| *computes).count();
        let free = |computes| {
            if computes {
                computing < CHECKS
            } else {
                running.len() - computing < FILES
            }
        };
        let of = |session, computes| running.values().any(|run| *run == (session, computes));
        let at = self.waiting.iter().position(|(_, session, what)| {
            free(what.computes()) && !of(*session, what.computes())
        })?;
        let (request, session, what) = self.waiting.remove(at)?;
        self.running.insert(request, (session, what.computes()));
        Some((request, what))
    }

    /// As many wait or run.
    pub(super) fn len(&self) -> usize {
        self.waiting.len() + self.running.len()
    }
}

impl Station {
    /// Does something beside the arms when its turn has come.
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

    /// Begins what can begin.
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

    /// A request is over, if it was one of these.
    pub(super) fn turn_is_over(&mut self, request: RequestId) {
        if self.lengthy.running.remove(&request).is_some() {
            self.take_turns();
        }
    }

    /// What was asked by a socket that is gone does not begin.
    pub(super) fn forget_turns(&mut self) {
        let pending = &self.pending;
        { &mut self.lengthy.waiting }.retain(|(request, ..)| pending.contains_key(request));
    }
}
