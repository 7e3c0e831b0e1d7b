use super::item::Entry;
use super::{KEPT, Stream, StreamEvent, StreamFailure, StreamSettings};
use crate::connection::Connection;

/// So many readings in a row must disagree with what was counted before they are believed.
pub(super) const STRIKES: u32 = 3;
/// So many commands may be in the arm whatever they take.
const LEAST: usize = 2;

/// What is known of the places in the controller's queue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Credit {
    /// Places in all, as is counted with; 0 until the first look.
    pub(super) places: u32,
    /// Commands of others that waited when the stream began.
    pub(super) strangers: u32,
    /// Places that left space does not show free although they should be.
    withheld: u32,
    fewer: u32,
    missing: u32,
    /// The controller said that its queue is full: nothing goes before left space was read.
    pub(super) full: bool,
}

impl Credit {
    pub(super) fn new() -> Self {
        Self {
            places: 0,
            strangers: 0,
            withheld: 0,
            fewer: 0,
            missing: 0,
            full: false,
        }
    }
}

impl Stream {
    /// Commands that may go out as far as places are concerned.
    pub(super) fn credit(&self) -> usize {
        if self.credit.full || self.credit.missing > 0 {
            return 0;
        }
        // What is finished and not confirmed is still kept here.
        let kept = self.entries.kept();
        let free = self.places().saturating_sub(self.at_most() as usize);
        free.min(KEPT.saturating_sub(kept))
    }

    /// Places that can be used.
    pub(super) fn places(&self) -> usize {
        let places = self.credit.places.saturating_sub(self.credit.withheld);
        (places as usize).min(KEPT)
    }

    /// Whether the horizon lets this command go out.
    pub(super) fn within_horizon(&self, next: &Entry) -> bool {
        let under_way = self.entries.under_way(self.reader.current);
        if !self.settings.start || under_way.count < LEAST {
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

    /// Commands of others that are still before ours.
    pub(super) fn strangers_left(&self, current: u64) -> u32 {
        let before = match self.first {
            Some(first) => first.saturating_sub(1).saturating_sub(current),
            None => u64::MAX,
        };
        u64::from(self.credit.strangers).min(before) as u32
    }

    /// Left space was read, and then the current index: whether it is what was counted. `accepted` is the last index
    /// accepted when left space was asked for, `at_most` what was in the controller at most when it came.
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
        if self.credit.fewer >= STRIKES {
            let (counted, read) = (
                self.credit.places,
                self.credit.places - self.credit.withheld,
            );
            self.credit.places = read;
            (self.credit.withheld, self.credit.fewer) = (0, 0);
            self.events.push(StreamEvent::Places { counted, read });
        }
        if self.credit.missing >= STRIKES {
            let (counted, read) = (at_least, shown);
            self.fail(StreamFailure::Dropped { counted, read });
        }
        (at_least..=at_most).contains(&shown)
    }

    /// Most commands that the controller can have in its queue at present.
    pub(super) fn at_most(&self) -> u32 {
        let ours = self.entries.under_way(self.reader.current).count;
        (ours as u32).saturating_add(self.strangers_left(self.reader.current))
    }
}
