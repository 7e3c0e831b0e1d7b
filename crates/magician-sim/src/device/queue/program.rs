//! The hosts' queue, and the stored program that takes its place while it runs (document 1.19.4,
//! model section 12).
//!
//! A running program has a separate queue, filled a little ahead from the flash. It is swapped with
//! the hosts' queue, so everything that looks at waiting commands, above all continuous paths,
//! works for both. Meanwhile the hosts' queue accepts commands and waits.

use std::sync::Arc;

use magician_protocol::Set;

use super::{Queue, QueuedCommand};
use crate::device::store::program::Program;
use crate::{ArmInstant, Profile};

/// Number of program lines read ahead: as many as the hosts' queue has places, so that paths look
/// equally far ahead.
const READ_AHEAD_LINES: usize = 32;

/// A program being stored.
#[derive(Clone, Debug)]
struct Download {
    loops: u32,
    announced: u32,
    lines: Vec<Set>,
}

/// Run state of the stored program.
#[derive(Clone, Debug, Default)]
enum Run {
    /// Not running.
    #[default]
    Off,
    /// Waits for the end of the running command of the hosts.
    Due,
    /// Running.
    On(Box<ProgramRun>),
}

/// Progress of a running program.
#[derive(Clone, Debug)]
struct ProgramRun {
    /// The hosts' queue, set aside.
    hosts: Queue,
    /// Number of lines read, over all passes.
    read: u64,
    /// Start of the present pass.
    began: Option<ArmInstant>,
    stopped: bool,
}

/// Result of queueing a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum QueueResult {
    /// Waiting in the queue, with this index.
    Queued(u64),
    /// Stored as a line of a program. No queued command gets this index; the current index skips
    /// it.
    Stored(u64),
    /// Refused: the queue is full.
    Full,
}

/// The active queue, of the hosts or of the program, and the state of the stored program.
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

    /// The queue from which commands are taken.
    pub(crate) fn active(&self) -> &Queue {
        &self.active
    }

    pub(crate) fn active_mut(&mut self) -> &mut Queue {
        &mut self.active
    }

    /// The queue filled by hosts.
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

    /// True if there is no place for a queued command, in the queue or in the program being stored.
    pub(crate) fn is_full(&self) -> bool {
        match &self.download {
            Some(download) => download.lines.len() >= self.capacity,
            None => self.hosts().left() == 0,
        }
    }

    /// Places a queued command of a host.
    pub(crate) fn place(&mut self, id: u8, command: QueuedCommand) -> QueueResult {
        if self.download.is_some() {
            return self.append_download(&command);
        }
        let index = self.hosts_mut().push(id, command);
        index.map_or(QueueResult::Full, QueueResult::Queued)
    }
}

/// Storing a program.
impl Queues {
    /// True while a program is being stored.
    pub(crate) fn is_downloading(&self) -> bool {
        self.download.is_some()
    }

    /// Starts to store queued commands. The caller checks that no program runs.
    pub(crate) fn start_download(&mut self, loops: u32, announced: u32) {
        self.download = Some(Download {
            loops,
            announced,
            lines: Vec::new(),
        });
    }

    /// Ends the download and returns the program with its announced length, whatever its real
    /// length is.
    pub(crate) fn take_download(&mut self) -> Option<(Program, u32)> {
        let Download {
            loops,
            announced,
            lines,
        } = self.download.take()?;
        let lines = Arc::new(lines);
        Some((Program { loops, lines }, announced))
    }

    /// True if the program being stored differs from its announced length.
    pub(crate) fn is_mismatched(&self) -> bool {
        let download = self.download.as_ref();
        download
            .is_some_and(|download| u32::try_from(download.lines.len()) != Ok(download.announced))
    }

    fn append_download(&mut self, command: &QueuedCommand) -> QueueResult {
        let Some(download) = &mut self.download else {
            return QueueResult::Full;
        };
        // The flash is full: the host sees a full queue.
        if download.lines.len() >= self.capacity {
            return QueueResult::Full;
        }
        // An unreadable frame takes an index but no line: nothing could be stored of it.
        if let QueuedCommand::Set(set) = command {
            download.lines.push(*set);
        }
        QueueResult::Stored(self.hosts_mut().allocate_index())
    }
}

/// Running a program.
impl Queues {
    /// True if the program neither runs nor waits for its turn.
    pub(crate) fn program_is_off(&self) -> bool {
        matches!(self.run, Run::Off)
    }

    /// True if the program waits for its turn.
    pub(crate) fn program_is_due(&self) -> bool {
        matches!(self.run, Run::Due)
    }

    /// True if the program runs.
    pub(crate) fn program_runs(&self) -> bool {
        matches!(self.run, Run::On(_))
    }

    /// Schedules the program for the moment at which nothing is under way.
    pub(crate) fn set_program_due(&mut self) {
        self.run = Run::Due;
    }

    /// Stops the program. Returns true if it was running, so that the running command belongs to
    /// it.
    pub(crate) fn stop_program(&mut self) -> bool {
        match &mut self.run {
            Run::Off => false,
            Run::Due => {
                self.run = Run::Off;
                false
            }
            Run::On(pass) => {
                pass.stopped = true;
                // Lines read ahead are dropped; the running one goes to its end.
                self.active.clear();
                true
            }
        }
    }

    /// Exchanges the hosts' queue and that of the program. Call it only while nothing is under way.
    ///
    /// Returns true if the program has started, false if it has ended, `None` if nothing has
    /// changed.
    pub(crate) fn change(&mut self) -> Option<bool> {
        match &self.run {
            Run::Due => {
                // Indices of the program's queue count lines from 1 and are never reported to
                // hosts.
                let program = Queue::new(READ_AHEAD_LINES, 1, true);
                self.run = Run::On(Box::new(ProgramRun {
                    hosts: std::mem::replace(&mut self.active, program),
                    read: 0,
                    began: None,
                    stopped: false,
                }));
                Some(true)
            }
            // No line is left: `read_ahead` fills the queue before this is reached.
            Run::On(_) if self.active.head().is_none() => {
                if let Run::On(pass) = std::mem::take(&mut self.run) {
                    self.active = pass.hosts;
                }
                Some(false)
            }
            Run::Off | Run::On(_) => None,
        }
    }

    /// Reads the next line of a running program if there is room. Returns true if there was one.
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

    /// True if a line starts a pass at the same instant as the pass before.
    ///
    /// A pass that takes no time would be repeated endlessly within one instant, so the program
    /// ends.
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
