//! Commands in the arm's queue that will change a setting or an output when they run.

use std::collections::VecDeque;
use std::fmt;

use magician_protocol::{Frame, FrameBuf, Row};

use super::laser::{Channels, LaserEffect};
use super::settings::reaches;

/// Largest number of commands tracked: more than any arm's queue holds, with those on their way to
/// it.
const MAX_TRACKED_COMMANDS: usize = 128;

/// A queued command.
#[derive(Clone, Copy)]
pub(super) struct Pending {
    pub(super) row: &'static Row,
    pub(super) request: FrameBuf,
    /// Index. `None` before the arm has accepted it.
    index: Option<u64>,
    /// True if its effect holds once it has finished.
    pub(super) certain: bool,
    /// True if an immediate command of its kind was executed while it waited, so that their order
    /// is unknown.
    overtaken: bool,
    effect: Option<LaserEffect>,
    /// True while it cannot burn, because the queue does not run.
    inert: bool,
    /// True if the queue was cleared while it waited; it may have run before.
    pub(super) cleared: bool,
}

/// Omits the row, whose description is long.
impl fmt::Debug for Pending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pending")
            .field("request", &self.request)
            .field("index", &self.index)
            .field("certain", &self.certain)
            .field("inert", &self.inert)
            .field("cleared", &self.cleared)
            .finish_non_exhaustive()
    }
}

impl Pending {
    /// Effect on the laser after the end of the command. `None` if it leaves the laser unchanged.
    pub(super) fn light_at_its_end(&self) -> Option<LaserEffect> {
        self.effect.filter(|effect| !effect.burns || !self.inert)
    }

    fn may_light(&self, channels: Channels) -> bool {
        let effect = self.effect.filter(|effect| effect.burns);
        !self.inert && effect.is_some_and(|effect| effect.channels.intersects(channels))
    }

    fn is(&self, request: &Frame<'_>) -> bool {
        self.row.id == request.id() && self.request.frame().params() == request.params()
    }
}

/// Queued commands in the order of sending.
#[derive(Clone, Debug, Default)]
pub(super) struct PendingQueue(VecDeque<Pending>);

impl PendingQueue {
    /// Notes that a command is sent to the queue. Returns the oldest one if it can no longer be
    /// tracked.
    pub(super) fn sent(&mut self, row: &'static Row, request: &Frame<'_>) -> Option<Pending> {
        // A retransmission is the same command.
        let again = |one: &Pending| one.index.is_none() && !one.cleared && one.is(request);
        if self.0.iter().any(again) {
            return None;
        }
        self.push(row, request, None)
    }

    /// Notes that the arm accepted a command with this index.
    pub(super) fn accepted(&mut self, index: u64, row: &'static Row, request: &Frame<'_>) {
        let waits = |one: &Pending| one.index.is_none() && one.is(request);
        let Some(at) = self.0.iter().position(waits) else {
            self.push(row, request, Some(index));
            return;
        };
        if let Some(one) = self.0.get_mut(at) {
            one.index = Some(index);
        }
        // Unanswered earlier commands, if accepted at all, finish before this one.
        for one in self.0.iter_mut().take(at).filter(|one| one.index.is_none()) {
            (one.index, one.certain) = (Some(index), false);
        }
    }

    /// Removes a command that the arm has not taken.
    pub(super) fn withdraw(&mut self, request: &Frame<'_>) {
        let waits = |one: &Pending| one.index.is_none() && one.is(request);
        if let Some(at) = self.0.iter().position(waits) {
            self.0.remove(at);
        }
    }

    /// Removes the next command that has finished at this current index, in order.
    pub(super) fn pop_finished(&mut self, current: u64) -> Option<Pending> {
        let over = |one: &Pending| one.index.is_some_and(|index| index <= current);
        let Some(at) = self.0.iter().position(over) else {
            // The remaining commands run after everything answered so far.
            self.0.iter_mut().for_each(|one| one.overtaken = false);
            return None;
        };
        let one = self.0.remove(at)?;
        let certain = one.certain && !one.overtaken;
        Some(Pending { certain, ..one })
    }

    /// Removes the next command that was in the queue when it was cleared, and marks it uncertain.
    ///
    /// A path may be running, so it stays until it has finished or the arm is at rest.
    pub(super) fn pop_cleared(&mut self) -> Option<Pending> {
        let is_over = |one: &Pending| one.cleared && !one.may_light(Channels::PATH);
        let at = self.0.iter().position(is_over)?;
        let one = self.0.remove(at)?;
        let certain = false;
        Some(Pending { certain, ..one })
    }

    /// Notes a Clear. The next current index shows which commands ran before.
    pub(super) fn cleared(&mut self) {
        for one in &mut self.0 {
            one.cleared = true;
        }
    }

    /// Evaluates the current index read after a Clear: all commands beyond it were dropped, except
    /// the running one. Returns the rows of commands without a known index.
    pub(super) fn settle_clear(&mut self) -> Vec<&'static Row> {
        let mut under_way = true;
        let mut unknown = Vec::new();
        self.0.retain(|one| {
            if !one.cleared {
                return true;
            }
            if one.index.is_none() {
                unknown.push(one.row);
            }
            // A running path burns until the laser is switched off or the path has finished.
            std::mem::take(&mut under_way) && one.may_light(Channels::PATH)
        });
        unknown
    }

    /// Marks all commands as unable to burn, because the laser is off and the queue does not run.
    pub(super) fn rest(&mut self) {
        self.0.iter_mut().for_each(|one| one.inert = true);
    }

    /// Notes that the arm is at rest: no command that was cleared is still running.
    pub(super) fn stands(&mut self) {
        for one in self.0.iter_mut().filter(|one| one.cleared) {
            one.inert = true;
        }
    }

    /// Notes that the queue runs or may run.
    pub(super) fn release(&mut self) {
        for one in self.0.iter_mut().filter(|one| !one.cleared) {
            one.inert = false;
        }
    }

    /// Notes that an immediate command was executed, before or after queued ones of its kind.
    pub(super) fn overtaken(&mut self, by: &Row) {
        for one in self.0.iter_mut().filter(|one| reaches(by, one.row)) {
            one.overtaken = true;
        }
    }

    /// Marks the effects as uncertain even after the end, because another program may have changed
    /// them since.
    pub(super) fn doubt(&mut self) {
        self.0.iter_mut().for_each(|one| one.certain = false);
    }

    pub(super) fn may_light(&self, channels: Channels) -> bool {
        self.any(|one| one.may_light(channels))
    }

    pub(super) fn any(&self, is_it: impl FnMut(&Pending) -> bool) -> bool {
        self.0.iter().any(is_it)
    }

    fn push(
        &mut self,
        row: &'static Row,
        request: &Frame<'_>,
        index: Option<u64>,
    ) -> Option<Pending> {
        // Bounded memory: the oldest leaves as uncertain.
        let full = self.0.len() >= MAX_TRACKED_COMMANDS;
        let oldest = if full { self.0.pop_front() } else { None };
        self.0.push_back(Pending {
            row,
            request: FrameBuf::from(*request),
            index,
            certain: true,
            overtaken: false,
            // Computed once: the list is searched for every display.
            effect: LaserEffect::of(request),
            inert: false,
            cleared: false,
        });
        oldest.map(|oldest| Pending {
            certain: false,
            ..oldest
        })
    }
}
