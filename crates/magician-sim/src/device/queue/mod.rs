//! The controller's command queue: places, indices and what runs (model section 14).

pub(crate) mod program;

use std::collections::VecDeque;

use magician_protocol::commands::{CpCmd, CpLeCmd};
use magician_protocol::{Effect, Set};

use super::io::trigger::Trigger;
use super::motion::{PathLine, PathPoint};
use crate::ArmInstant;

/// What a place in the queue holds. Places are few and reused, so the size of a command matters
/// less than keeping it where it is.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)]
pub(crate) enum QueuedCommand {
    /// A command.
    Set(Set),
    /// A frame whose parameters could not be read: it has an index and does nothing (errata E11).
    Nothing,
}

impl QueuedCommand {
    /// Whether it moves the arm and waits until it has.
    pub(crate) fn moves(&self) -> bool {
        let Self::Set(set) = self else {
            return false;
        };
        moves(set)
    }

    /// Where it leads if it is a segment of a continuous path.
    fn path_point(&self) -> Option<PathPoint> {
        match self {
            Self::Set(
                Set::CpCmd(CpCmd {
                    cp_mode, x, y, z, ..
                })
                | Set::CpLeCmd(CpLeCmd {
                    cp_mode, x, y, z, ..
                }),
            ) => Some(PathPoint {
                mode: *cp_mode,
                numbers: [*x, *y, *z],
            }),
            _ => None,
        }
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
    pub(crate) command: QueuedCommand,
    /// Where a segment of a continuous path leads, once it is known where it begins.
    pub(crate) way: Option<PathLine>,
}

/// What the running command is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Busy {
    /// The motion under way is its own.
    Moving,
    /// It lets time pass until then.
    Waiting(ArmInstant),
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
    running: Option<Running>,
    first_index: u64,
    next_index: u64,
    current: u64,
    started: bool,
    overflows: u64,
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

    /// The command at work.
    pub(crate) fn running(&self) -> Option<Running> {
        self.running
    }

    /// What the command at work is busy with.
    pub(crate) fn busy(&self) -> Option<Busy> {
        self.running.map(|running| running.busy)
    }

    /// Index of the command that finished last, 0 before the first.
    pub(crate) fn current(&self) -> u64 {
        self.current
    }

    /// Whether it takes commands: between start and stop.
    pub(crate) fn is_started(&self) -> bool {
        self.started
    }

    /// Commands that came when it was full.
    pub(crate) fn overflows(&self) -> u64 {
        self.overflows
    }

    /// Free places.
    pub(crate) fn left(&self) -> usize {
        let taken = self.waiting.len() + usize::from(self.running.is_some());
        self.depth.saturating_sub(taken)
    }

    pub(crate) fn set_started(&mut self, started: bool) {
        self.started = started;
    }

    /// Stores a command; `None` when there is no place.
    pub(crate) fn push(&mut self, id: u8, command: QueuedCommand) -> Option<u64> {
        if self.left() == 0 {
            self.overflows = self.overflows.saturating_add(1);
            return None;
        }
        let index = self.allocate_index();
        self.waiting.push_back(Entry {
            index,
            id,
            command,
            way: None,
        });
        Some(index)
    }

    /// The next index, for a command that does not wait here.
    pub(crate) fn allocate_index(&mut self) -> u64 {
        let index = self.next_index;
        self.next_index = self.next_index.wrapping_add(1).max(1);
        index
    }

    pub(crate) fn head(&self) -> Option<&QueuedCommand> {
        self.waiting.front().map(|entry| &entry.command)
    }

    pub(crate) fn pop(&mut self) -> Option<Entry> {
        self.waiting.pop_front()
    }

    /// A command that has begun is not finished at once.
    pub(crate) fn run(&mut self, running: Running) {
        self.running = Some(running);
    }

    /// The command at work has ended; `None` where there is none.
    pub(crate) fn take_running(&mut self) -> Option<Running> {
        self.running.take()
    }

    /// A command has finished.
    pub(crate) fn set_current(&mut self, index: u64) {
        self.current = index;
    }

    /// Drops what waits; returns how many. Numbering goes on.
    pub(crate) fn clear(&mut self) -> usize {
        let count = self.waiting.len();
        self.waiting.clear();
        count
    }
}

/// The segments of a continuous path that wait, and where they lead.
impl Queue {
    /// The ways of the segments at the head, as far as they are known.
    pub(crate) fn ways(&self) -> impl Iterator<Item = &PathLine> {
        self.waiting.iter().map_while(|entry| entry.way.as_ref())
    }

    /// Finds out where the segments at the head lead, the first of them from a point, up to one
    /// that is known.
    pub(crate) fn resolve_ways(
        &mut self,
        mut from: [f64; 3],
        way: impl Fn([f64; 3], PathPoint) -> PathLine,
    ) {
        for entry in &mut self.waiting {
            let Some(point) = entry.command.path_point() else {
                return;
            };
            if entry.way.is_some() {
                return;
            }
            let next = way(from, point);
            from = next.to();
            entry.way = Some(next);
        }
    }

    pub(crate) fn forget_ways(&mut self) {
        for entry in &mut self.waiting {
            entry.way = None;
        }
    }

    /// Whether anything waits before the last command, and where that leads if it is known.
    pub(crate) fn way_before_last(&self) -> Option<Option<PathLine>> {
        self.waiting.iter().rev().nth(1).map(|entry| entry.way)
    }

    /// Finds out where the last command leads if it is a segment; whether it is.
    pub(crate) fn resolve_last(&mut self, way: impl FnOnce(PathPoint) -> PathLine) -> bool {
        let Some(entry) = self.waiting.back_mut() else {
            return false;
        };
        let Some(point) = entry.command.path_point() else {
            return false;
        };
        entry.way = Some(way(point));
        true
    }
}
