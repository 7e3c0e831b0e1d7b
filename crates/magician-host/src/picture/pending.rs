//! Commands that wait in the arm's queue and change something when they are done.

use std::collections::VecDeque;
use std::fmt;

use magician_protocol::{Frame, FrameBuf, Row};

use super::laser::{Channels, Light};
use super::settings::reaches;

/// Commands that are followed: more than the queue of any arm holds, with those on their way to it.
const MOST: usize = 128;

/// A queued command.
#[derive(Clone, Copy)]
pub(super) struct Pending {
    pub(super) row: &'static Row,
    pub(super) request: FrameBuf,
    /// `None` before the arm has told it.
    index: Option<u64>,
    /// What it sets holds once it has finished.
    pub(super) certain: bool,
    /// One of its kind was done at once while it waited, and it is not known yet which of them came first.
    overtaken: bool,
    light: Option<Light>,
    /// As long as the queue does not run it cannot burn.
    inert: bool,
    /// The queue was cleared while it waited: it may have been done before.
    pub(super) cleared: bool,
}

/// Without its row, whose description is long.
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
    /// What it has done to the laser when it has finished.
    pub(super) fn light_at_its_end(&self) -> Option<Light> {
        self.light.filter(|light| !light.burns || !self.inert)
    }

    fn may_light(&self, channels: Channels) -> bool {
        let light = self.light.filter(|light| light.burns);
        !self.inert && light.is_some_and(|light| light.channels.meet(channels))
    }

    fn is(&self, request: &Frame<'_>) -> bool {
        self.row.id == request.id() && self.request.frame().params() == request.params()
    }
}

/// Queued commands in the order in which they were sent.
#[derive(Clone, Debug, Default)]
pub(super) struct PendingQueue(VecDeque<Pending>);

impl PendingQueue {
    /// A command goes out to the queue. Returns one that is followed no longer.
    pub(super) fn sent(&mut self, row: &'static Row, request: &Frame<'_>) -> Option<Pending> {
        // One that is sent again is the same command.
        let again = |one: &Pending| one.index.is_none() && !one.cleared && one.is(request);
        if self.0.iter().any(again) {
            return None;
        }
        self.push(row, request, None)
    }

    /// The arm has taken a command under this index.
    pub(super) fn accepted(&mut self, index: u64, row: &'static Row, request: &Frame<'_>) {
        let waits = |one: &Pending| one.index.is_none() && one.is(request);
        let Some(at) = self.0.iter().position(waits) else {
            self.push(row, request, Some(index));
            return;
        };
        if let Some(one) = self.0.get_mut(at) {
            one.index = Some(index);
        }
        // Those that were sent before it and are not answered are over when this one is, if they were taken.
        for one in self.0.iter_mut().take(at).filter(|one| one.index.is_none()) {
            (one.index, one.certain) = (Some(index), false);
        }
    }

    /// A command that the arm has not taken.
    pub(super) fn withdraw(&mut self, request: &Frame<'_>) {
        let waits = |one: &Pending| one.index.is_none() && one.is(request);
        if let Some(at) = self.0.iter().position(waits) {
            self.0.remove(at);
        }
    }

    /// The next one, in order, that the arm has finished by its current index.
    pub(super) fn pop_finished(&mut self, current: u64) -> Option<Pending> {
        let over = |one: &Pending| one.index.is_some_and(|index| index <= current);
        let Some(at) = self.0.iter().position(over) else {
            // The rest comes after what was answered by now.
            self.0.iter_mut().for_each(|one| one.overtaken = false);
            return None;
        };
        let one = self.0.remove(at)?;
        let certain = one.certain && !one.overtaken;
        Some(Pending { certain, ..one })
    }

    /// The next one that was in the queue when it was cleared: whether it was done is not known. A path may be under way, and
    /// stays until it has finished, or the arm stands.
    pub(super) fn pop_cleared(&mut self) -> Option<Pending> {
        let is_over = |one: &Pending| one.cleared && !one.may_light(Channels::PATH);
        let at = self.0.iter().position(is_over)?;
        let one = self.0.remove(at)?;
        let certain = false;
        Some(Pending { certain, ..one })
    }

    /// The queue was cleared. What of it was done before shows in the next current index.
    pub(super) fn cleared(&mut self) {
        for one in &mut self.0 {
            one.cleared = true;
        }
    }

    /// The current index was read after a Clear: what it has not reached was dropped, but the command under way. Returns
    /// the rows of commands whose index is not known.
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
            // It burns until the laser is switched off, or until it has finished.
            std::mem::take(&mut under_way) && one.may_light(Channels::PATH)
        });
        unknown
    }

    /// The laser was switched off, and the queue does not run: nothing lights it any more.
    pub(super) fn rest(&mut self) {
        self.0.iter_mut().for_each(|one| one.inert = true);
    }

    /// The arm stands: of what was in the queue when it was cleared nothing is under way.
    pub(super) fn stands(&mut self) {
        for one in self.0.iter_mut().filter(|one| one.cleared) {
            one.inert = true;
        }
    }

    /// The queue runs, or may.
    pub(super) fn release(&mut self) {
        for one in self.0.iter_mut().filter(|one| !one.cleared) {
            one.inert = false;
        }
    }

    /// A command was done at once, before or after those of its kind.
    pub(super) fn overtaken(&mut self, by: &Row) {
        for one in self.0.iter_mut().filter(|one| reaches(by, one.row)) {
            one.overtaken = true;
        }
    }

    /// What they set is not known even when they have finished: another program may have set it since.
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
        let full = self.0.len() >= MOST;
        let oldest = if full { self.0.pop_front() } else { None };
        self.0.push_back(Pending {
            row,
            request: FrameBuf::from(*request),
            index,
            certain: true,
            overtaken: false,
            light: Light::of(request),
            inert: false,
            cleared: false,
        });
        oldest.map(|oldest| Pending {
            certain: false,
            ..oldest
        })
    }
}
