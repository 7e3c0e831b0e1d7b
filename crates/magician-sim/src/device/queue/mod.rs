//! The controller's command queue: places, indices and what runs (model section 14).

pub(crate) mod program;

use std::collections::VecDeque;

use magician_protocol::{Effect, Set};

use crate::Micros;
use crate::device::handlers::trigger::Trigger;
use crate::device::motion::Way;

/// What a place in the queue holds. Places are few and reused, so the size of a command matters
/// less than keeping it where it is.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)]
pub(crate) enum Order {
    /// A command.
    Set(Set),
    /// A frame whose parameters could not be read: it has an index and does nothing (errata E11).
    Nothing,
}

impl Order {
    /// Whether it moves the arm and waits until it has.
    pub(crate) fn moves(&self) -> bool {
        let Self::Set(set) = self else {
            return false;
        };
        moves(set)
    }
}

/// Whether a command moves the arm and is done when it has; a jog is done when it begins.
pub(crate) fn moves(set: &Set) -> bool {
    set.row().effect == Effect::Motion
}

/// A command that waits.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) index: u64,
    pub(crate) id: u8,
    pub(crate) order: Order,
    /// Where a segment of a continuous path leads, once it is known where it begins.
    pub(crate) way: Option<Way>,
}

/// What the running command is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Busy {
    /// The motion under way is its own.
    Moving,
    /// It lets time pass until then.
    Waiting(Micros),
    /// It waits for an input.
    Triggered(Trigger),
    /// A stepper output counts its pulses.
    Turning(usize),
}

/// The command at work; it keeps its place until it has finished.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Running {
    pub(crate) index: u64,
    pub(crate) id: u8,
    pub(crate) busy: Busy,
}

/// The queue.
#[derive(Clone, Debug)]
pub(crate) struct Queue {
    depth: usize,
    waiting: VecDeque<Entry>,
    pub(crate) running: Option<Running>,
    first_index: u64,
    next_index: u64,
    /// Index of the command that finished last, 0 before the first.
    pub(crate) current: u64,
    /// Whether it takes commands: between start and stop.
    pub(crate) started: bool,
    /// Commands that came when it was full.
    pub(crate) overflows: u64,
}

impl Queue {
    pub(crate) fn new(depth: usize, first_index: u64, started: bool) -> Self {
        Self {
            depth,
            waiting: VecDeque::new(),
            running: None,
            first_index,
            next_index: first_index,
            current: 0,
            started,
            overflows: 0,
        }
    }

    /// Whether it has given no index yet.
    pub(crate) fn is_unused(&self) -> bool {
        self.next_index == self.first_index
    }

    pub(crate) fn depth(&self) -> usize {
        self.depth
    }

    pub(crate) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Free places.
    pub(crate) fn left(&self) -> usize {
        let taken = self.waiting.len() + usize::from(self.running.is_some());
        self.depth.saturating_sub(taken)
    }

    /// Stores a command; `None` when there is no place.
    pub(crate) fn push(&mut self, id: u8, order: Order) -> Option<u64> {
        if self.left() == 0 {
            self.overflows = self.overflows.saturating_add(1);
            return None;
        }
        let index = self.pass_index();
        self.waiting.push_back(Entry {
            index,
            id,
            order,
            way: None,
        });
        Some(index)
    }

    /// The next index, for a command that does not wait here.
    pub(crate) fn pass_index(&mut self) -> u64 {
        let index = self.next_index;
        self.next_index = self.next_index.wrapping_add(1).max(1);
        index
    }

    pub(crate) fn head(&self) -> Option<&Order> {
        self.waiting.front().map(|entry| &entry.order)
    }

    /// What waits, the next one first.
    pub(crate) fn entries(&self) -> impl DoubleEndedIterator<Item = &Entry> {
        self.waiting.iter()
    }

    pub(crate) fn entries_mut(&mut self) -> impl DoubleEndedIterator<Item = &mut Entry> {
        self.waiting.iter_mut()
    }

    pub(crate) fn pop(&mut self) -> Option<Entry> {
        self.waiting.pop_front()
    }

    /// Drops what waits; returns how many. Numbering goes on.
    pub(crate) fn clear(&mut self) -> usize {
        let count = self.waiting.len();
        self.waiting.clear();
        count
    }
}
