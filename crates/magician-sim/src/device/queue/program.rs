//! The queue that hosts fill, and the program in the flash that takes its place (document 1.19.4,
//! model section 12).
//!
//! A run has a queue of its own, filled a little ahead from the flash, in place of the one that
//! hosts fill; so all that looks at what comes next, continuous paths above all, need not know
//! whence it comes. Meanwhile the hosts' queue takes commands and waits.

use std::sync::Arc;

use magician_protocol::Set;

use super::{Queue, QueuedCommand};
use crate::device::store::program::Program;
use crate::{ArmInstant, Profile};

/// Lines of a running program that are read ahead.
const AHEAD: usize = 32;

/// A program that is being stored.
#[derive(Clone, Debug)]
struct Download {
    loops: u32,
    announced: u32,
    lines: Vec<Set>,
}

/// Whether the program runs.
#[derive(Clone, Debug, Default)]
enum Run {
    /// It does not.
    #[default]
    Off,
    /// As soon as the hosts' command that is under way has finished.
    Due,
    /// It does.
    On(Box<Pass>),
}

/// How far a running program has come.
#[derive(Clone, Debug)]
struct Pass {
    /// The hosts' queue, while the program has its place.
    hosts: Queue,
    /// Lines that have been read ahead, all passes together.
    read: u64,
    /// When the present pass began.
    began: Option<ArmInstant>,
    stopped: bool,
}

/// What becomes of a command that a host queues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Placed {
    /// It waits in the queue.
    Queued(u64),
    /// It is a line of the program that is being stored. It has an index of the queue, which it
    /// never enters: the current index passes over it.
    Stored(u64),
    /// There is no room.
    Full,
}

/// The queue that is carried out, the hosts' or the program's, and what becomes of the program.
#[derive(Clone, Debug)]
pub(crate) struct Queues {
    active: Queue,
    run: Run,
    download: Option<Download>,
    /// Most lines of a program.
    capacity: usize,
}

impl Queues {
    pub(crate) fn new(profile: &Profile) -> Self {
        let rules = &profile.queue;
        let started = profile.power_up.queue_started;
        Self {
            active: Queue::new(rules.depth, rules.first_index, started),
            run: Run::Off,
            download: None,
            capacity: profile.offline.capacity,
        }
    }

    /// The queue that is carried out.
    pub(crate) fn active(&self) -> &Queue {
        &self.active
    }

    pub(crate) fn active_mut(&mut self) -> &mut Queue {
        &mut self.active
    }

    /// The queue that hosts fill.
    pub(crate) fn hosts(&self) -> &Queue {
        match &self.run {
            Run::On(pass) => &pass.hosts,
            Run::Off | Run::Due => &self.active,
        }
    }

    pub(crate) fn hosts_mut(&mut self) -> &mut Queue {
        match &mut self.run {
            Run::On(pass) => &mut pass.hosts,
            Run::Off | Run::Due => &mut self.active,
        }
    }

    /// Whether there is no place for a queued command, in the queue or in the program that is being
    /// stored.
    pub(crate) fn is_full(&self) -> bool {
        match &self.download {
            Some(download) => download.lines.len() >= self.capacity,
            None => self.hosts().left() == 0,
        }
    }

    /// Gives a command that a host queues its place.
    pub(crate) fn place(&mut self, id: u8, command: QueuedCommand) -> Placed {
        if self.download.is_some() {
            return self.append_download(&command);
        }
        let index = self.hosts_mut().push(id, command);
        index.map_or(Placed::Full, Placed::Queued)
    }
}

/// Storing.
impl Queues {
    /// Whether a program is being stored.
    pub(crate) fn is_downloading(&self) -> bool {
        self.download.is_some()
    }

    /// What is queued from now on is stored. Not while the program runs.
    pub(crate) fn start_download(&mut self, loops: u32, announced: u32) {
        self.download = Some(Download {
            loops,
            announced,
            lines: Vec::new(),
        });
    }

    /// The program is complete, whatever its length was said to be: it and that length.
    pub(crate) fn take_download(&mut self) -> Option<(Program, u32)> {
        let Download {
            loops,
            announced,
            lines,
        } = self.download.take()?;
        let lines = Arc::new(lines);
        Some((Program { loops, lines }, announced))
    }

    /// Whether the program that is being stored is of another length than it was said to be.
    pub(crate) fn is_mismatched(&self) -> bool {
        let download = self.download.as_ref();
        download
            .is_some_and(|download| u32::try_from(download.lines.len()) != Ok(download.announced))
    }

    fn append_download(&mut self, command: &QueuedCommand) -> Placed {
        let Some(download) = &mut self.download else {
            return Placed::Full;
        };
        if download.lines.len() >= self.capacity {
            return Placed::Full;
        }
        if let QueuedCommand::Set(set) = command {
            download.lines.push(*set);
        }
        Placed::Stored(self.hosts_mut().allocate_index())
    }
}

/// Running.
impl Queues {
    /// Whether the program neither runs nor is about to.
    pub(crate) fn program_is_off(&self) -> bool {
        matches!(self.run, Run::Off)
    }

    /// Whether the program waits for its turn.
    pub(crate) fn program_is_due(&self) -> bool {
        matches!(self.run, Run::Due)
    }

    /// Whether the program has the place of the hosts' queue.
    pub(crate) fn program_runs(&self) -> bool {
        matches!(self.run, Run::On(_))
    }

    /// The program takes the queue's place as soon as nothing is under way.
    pub(crate) fn set_program_due(&mut self) {
        self.run = Run::Due;
    }

    /// The program is to end; whether it was running, and what is under way belongs to it.
    pub(crate) fn stop_program(&mut self) -> bool {
        match &mut self.run {
            Run::Off => false,
            Run::Due => {
                self.run = Run::Off;
                false
            }
            Run::On(pass) => {
                pass.stopped = true;
                self.active.clear();
                true
            }
        }
    }

    /// The program takes the place of the hosts' queue or gives it back, while nothing is under
    /// way; whether it runs now, if that has changed.
    pub(crate) fn change(&mut self) -> Option<bool> {
        match &self.run {
            Run::Due => {
                let program = Queue::new(AHEAD, 1, true);
                self.run = Run::On(Box::new(Pass {
                    hosts: std::mem::replace(&mut self.active, program),
                    read: 0,
                    began: None,
                    stopped: false,
                }));
                Some(true)
            }
            Run::On(_) if self.active.head().is_none() => {
                if let Run::On(pass) = std::mem::take(&mut self.run) {
                    self.active = pass.hosts;
                }
                Some(false)
            }
            Run::Off | Run::On(_) => None,
        }
    }

    /// Reads a line of the running program if there is room for it; whether there was one.
    pub(crate) fn read_ahead(&mut self, program: &Program) -> bool {
        let Run::On(pass) = &mut self.run else {
            return false;
        };
        let line = program.line(pass.read);
        let (Some(line), false) = (line, pass.stopped || self.active.left() == 0) else {
            return false;
        };
        pass.read += 1;
        let command = QueuedCommand::Set(*line);
        let _: Option<u64> = self.active.push(line.row().id, command);
        true
    }

    /// A line of the running program comes to its turn. A pass that took no time would be followed
    /// by others like it, each as idle as the one before: the program has done what it does.
    pub(crate) fn ends_idle_pass(
        &mut self,
        program: &Program,
        index: u64,
        now: ArmInstant,
    ) -> bool {
        let Run::On(pass) = &mut self.run else {
            return false;
        };
        if !program.begins_pass(index.saturating_sub(1)) {
            return false;
        }
        pass.began.replace(now) == Some(now)
    }
}
