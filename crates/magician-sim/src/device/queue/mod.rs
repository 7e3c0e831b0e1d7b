//! The command queue: places, indices, and the running command (model section 14).
//!
//! Every accepted command gets the next index. A command keeps its place until it has finished, so
//! at most `depth` commands are waiting or running. The queue also caches the lines of waiting path
//! segments, so that look-ahead need not decode them again.

pub(crate) mod program;

use std::collections::VecDeque;

use magician_protocol::commands::{CpCmd, CpLeCmd};
use magician_protocol::{Effect, Set};

use super::io::trigger::Trigger;
use super::motion::{PathLine, PathPoint};
use crate::ArmInstant;

/// Content of a place. Places are few and reused, so their size matters less than keeping a command
/// where it is.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)]
pub(crate) enum QueuedCommand {
    /// A command.
    Set(Set),
    /// A frame with unreadable parameters: it takes an index and does nothing (errata E11).
    Nothing,
}

impl QueuedCommand {
    /// True if it moves the arm, and finishes when the motion ends.
    pub(crate) fn moves(&self) -> bool {
        let Self::Set(set) = self else {
            return false;
        };
        moves(set)
    }

    /// Target of a segment of a continuous path; `None` for any other command.
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
            // Only CP and CPLE commands are path segments.
            _ => None,
        }
    }
}

/// True for a command that moves the arm and finishes with the motion. A jog finishes when it
/// starts.
pub(crate) fn moves(set: &Set) -> bool {
    set.row().effect == Effect::Motion
}

/// A waiting command.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) index: u64,
    pub(crate) id: u8,
    pub(crate) command: QueuedCommand,
    /// Line of a path segment, once its start is known.
    pub(crate) path_line: Option<PathLine>,
}

/// Activity of the running command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    /// A motion that the command started itself.
    Moving,
    /// A wait until an instant.
    Waiting(ArmInstant),
    /// A wait for an input.
    Triggered(Trigger),
    /// Counting pulses on a stepper output.
    Turning(usize),
}

/// The running command. It keeps its place until it has finished.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Running {
    pub(crate) index: u64,
    pub(crate) id: u8,
    pub(crate) busy: Activity,
}

/// A queue of commands.
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
            // 0 before the first command has finished: a choice (model section 15a).
            current: 0,
            started,
            overflows: 0,
        }
    }

    /// True if no index has been given yet.
    pub(crate) fn is_unused(&self) -> bool {
        self.next_index == self.first_index
    }

    pub(crate) fn depth(&self) -> usize {
        self.depth
    }

    pub(crate) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// The running command.
    pub(crate) fn running(&self) -> Option<Running> {
        self.running
    }

    /// Activity of the running command.
    pub(crate) fn busy(&self) -> Option<Activity> {
        self.running.map(|running| running.busy)
    }

    /// Index of the command that finished last; 0 before the first.
    pub(crate) fn current(&self) -> u64 {
        self.current
    }

    /// True between start and stop.
    pub(crate) fn is_started(&self) -> bool {
        self.started
    }

    /// Number of commands that found the queue full.
    pub(crate) fn overflows(&self) -> u64 {
        self.overflows
    }

    /// Number of free places: depth - waiting - running (model section 14).
    pub(crate) fn left(&self) -> usize {
        let taken = self.waiting.len() + usize::from(self.running.is_some());
        self.depth.saturating_sub(taken)
    }

    pub(crate) fn set_started(&mut self, started: bool) {
        self.started = started;
    }

    /// Stores a command and returns its index; `None` if there is no place.
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
            path_line: None,
        });
        Some(index)
    }

    /// Allocates an index for a command that does not wait in the queue.
    pub(crate) fn allocate_index(&mut self) -> u64 {
        let index = self.next_index;
        // 0 is never given: hosts take it for an error (model section 14).
        self.next_index = self.next_index.wrapping_add(1).max(1);
        index
    }

    pub(crate) fn head(&self) -> Option<&QueuedCommand> {
        self.waiting.front().map(|entry| &entry.command)
    }

    pub(crate) fn pop(&mut self) -> Option<Entry> {
        self.waiting.pop_front()
    }

    /// Records a command that has started and not finished.
    pub(crate) fn run(&mut self, running: Running) {
        self.running = Some(running);
    }

    /// Removes the running command; `None` if none runs.
    pub(crate) fn take_running(&mut self) -> Option<Running> {
        self.running.take()
    }

    /// Records the index of a finished command.
    pub(crate) fn set_current(&mut self, index: u64) {
        self.current = index;
    }

    /// Drops the waiting commands and returns their number. Numbering continues.
    pub(crate) fn clear(&mut self) -> usize {
        let count = self.waiting.len();
        self.waiting.clear();
        count
    }
}

/// Lines of the waiting segments of a continuous path.
impl Queue {
    /// Lines of the segments at the head, as far as they are known.
    pub(crate) fn path_lines(&self) -> impl Iterator<Item = &PathLine> {
        self.waiting
            .iter()
            .map_while(|entry| entry.path_line.as_ref())
    }

    /// Resolves the lines of the segments at the head, the first of them from a point, up to one
    /// that is known already.
    pub(crate) fn resolve_path_lines(
        &mut self,
        mut from: [f64; 3],
        way: impl Fn([f64; 3], PathPoint) -> PathLine,
    ) {
        for entry in &mut self.waiting {
            let Some(point) = entry.command.path_point() else {
                return;
            };
            if entry.path_line.is_some() {
                return;
            }
            let next = way(from, point);
            from = next.to();
            entry.path_line = Some(next);
        }
    }

    pub(crate) fn forget_path_lines(&mut self) {
        for entry in &mut self.waiting {
            entry.path_line = None;
        }
    }

    /// Line of the command before the last one; the outer `None` if the last is the only one.
    pub(crate) fn path_line_before_last(&self) -> Option<Option<PathLine>> {
        self.waiting
            .iter()
            .rev()
            .nth(1)
            .map(|entry| entry.path_line)
    }

    /// Resolves the line of the last command. Returns true if it is a segment.
    pub(crate) fn resolve_last(&mut self, way: impl FnOnce(PathPoint) -> PathLine) -> bool {
        let Some(entry) = self.waiting.back_mut() else {
            return false;
        };
        let Some(point) = entry.command.path_point() else {
            return false;
        };
        entry.path_line = Some(way(point));
        true
    }
}
