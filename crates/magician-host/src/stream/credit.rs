//! Credit: how many commands may be sent without overfilling the queue or exceeding the horizon.

use super::item::Entry;
use super::{MAX_KEPT, Stream, StreamEvent, StreamFailure, StreamSettings};
use crate::connection::Connection;

/// Consecutive readings that must contradict the count before they are believed.
// A choice: a single one may be old.
pub(super) const CONTRADICTIONS_TO_BELIEVE: u32 = 3;
/// Number of commands allowed in the arm regardless of their times: the running one and the next.
const MIN_COMMANDS_IN_ARM: usize = 2;

/// Knowledge about the places in the controller's queue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Credit {
    /// Number of places assumed; 0 until the first reading.
    pub(super) places: u32,
    /// Commands of others that waited when the stream began.
    pub(super) foreign: u32,
    /// Places that the left space shows as taken although they should be free.
    withheld: u32,
    fewer: u32,
    missing: u32,
    /// True after a refusal for a full queue: nothing is sent until left space was read.
    pub(super) full: bool,
}

impl Credit {
    pub(super) fn new() -> Self {
        Self {
            places: 0,
            foreign: 0,
            withheld: 0,
            fewer: 0,
            missing: 0,
            full: false,
        }
    }
}

impl Stream {
    /// Number of commands that may be sent as far as places are concerned.
    pub(super) fn credit(&self) -> usize {
        if self.credit.full || self.credit.missing > 0 {
            return 0;
        }
        // Finished but unconfirmed commands still count towards `MAX_KEPT`.
        let kept = self.entries.kept();
        let free = self.places().saturating_sub(self.at_most() as usize);
        free.min(MAX_KEPT.saturating_sub(kept))
    }

    /// Number of usable places.
    pub(super) fn places(&self) -> usize {
        let places = self.credit.places.saturating_sub(self.credit.withheld);
        (places as usize).min(MAX_KEPT)
    }

    /// True if the horizon permits sending this command.
    pub(super) fn within_horizon(&self, next: &Entry) -> bool {
        let under_way = self.entries.under_way(self.reader.current);
        if !self.settings.start || under_way.count < MIN_COMMANDS_IN_ARM {
            return true;
        }
        let burns = next.burns() || under_way.burns();
        under_way.time().saturating_add(next.item.time) <= self.horizon(burns)
    }

    pub(super) fn horizon(&self, burns: bool) -> u64 {
        let StreamSettings {
            horizon,
            laser_horizon,
            ..
        } = self.settings;
        if burns {
            horizon.min(laser_horizon)
        } else {
            horizon
        }
    }

    /// Commands of others that are still ahead of ours.
    pub(super) fn foreign_left(&self, current: u64) -> u32 {
        let before = match self.first {
            Some(first) => first.saturating_sub(1).saturating_sub(current),
            None => u64::MAX,
        };
        u64::from(self.credit.foreign).min(before) as u32
    }

    /// Compares a left space, and the current index read after it, with the count. True if they
    /// agree.
    ///
    /// `accepted` is the last index accepted when left space was requested, `at_most` the largest
    /// possible number of queued commands when it arrived.
    pub(super) fn compare(
        &mut self,
        left: u32,
        accepted: Option<u64>,
        at_most: u32,
        connection: &Connection,
    ) -> bool {
        self.credit.full = false;
        if left > self.credit.places {
            self.credit.places = left.max(connection.capacity());
        }
        let current = self.reader.current;
        let sure = self.entries.iter().filter_map(Entry::index);
        let sure =
            sure.filter(|index| *index > current && accepted.is_some_and(|last| *index <= last));
        let at_least = sure.count() as u32;
        let shown = self.credit.places.saturating_sub(left);
        self.credit.withheld = shown.saturating_sub(at_most);
        self.credit.fewer = if shown > at_most {
            self.credit.fewer + 1
        } else {
            0
        };
        self.credit.missing = if shown < at_least {
            self.credit.missing + 1
        } else {
            0
        };
        // Three in a row: the queue has fewer places than assumed, or another host fills it.
        if self.credit.fewer >= CONTRADICTIONS_TO_BELIEVE {
            let (counted, read) = (
                self.credit.places,
                self.credit.places - self.credit.withheld,
            );
            self.credit.places = read;
            (self.credit.withheld, self.credit.fewer) = (0, 0);
            self.events.push(StreamEvent::Places { counted, read });
        }
        // Three in a row: accepted commands are gone, so another host cleared the queue.
        if self.credit.missing >= CONTRADICTIONS_TO_BELIEVE {
            let (counted, read) = (at_least, shown);
            self.fail(StreamFailure::Dropped { counted, read });
        }
        (at_least..=at_most).contains(&shown)
    }

    /// Largest number of commands that can be in the controller's queue at present.
    pub(super) fn at_most(&self) -> u32 {
        let ours = self.entries.under_way(self.reader.current).count;
        (ours as u32).saturating_add(self.foreign_left(self.reader.current))
    }
}
