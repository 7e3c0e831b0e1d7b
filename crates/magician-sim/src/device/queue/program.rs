//! The program in the flash: how it gets there, and how the base key runs it (document 1.19.4, model section 12).
//!
//! A run has a queue of its own, filled a little ahead from the flash, in place of the one that hosts fill; so all that
//! looks at what comes next, continuous paths above all, need not know whence it comes. Meanwhile the hosts' queue takes
//! commands and waits.

use std::sync::Arc;

use magician_protocol::Set;

use crate::Micros;
use crate::device::Device;
use crate::device::queue::{Order, Queue};
use crate::event::Event;

/// Lines of a running program that are read ahead.
const AHEAD: usize = 32;

/// A program for the arm to run by itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Program {
    /// How often it runs.
    pub(crate) loops: u32,
    /// Its commands. Shared, for a copy of the controller need not copy them.
    pub(crate) lines: Arc<Vec<Set>>,
}

/// A program that is being stored.
#[derive(Clone, Debug)]
pub(crate) struct Download {
    loops: u32,
    announced: u32,
    lines: Vec<Set>,
}

/// Whether the program runs.
#[derive(Clone, Debug, Default)]
pub(crate) enum Run {
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
pub(crate) struct Pass {
    /// The hosts' queue, while the program has its place.
    hosts: Queue,
    /// Lines that have been read ahead, all passes together.
    read: u64,
    /// When the present pass began.
    began: Option<Micros>,
    stopped: bool,
}

impl Program {
    fn line(&self, at: u64) -> Option<&Set> {
        let count = self.lines.len() as u64;
        if count == 0 || at / count >= u64::from(self.loops) {
            return None;
        }
        self.lines.get(usize::try_from(at % count).ok()?)
    }

    fn begins_pass(&self, at: u64) -> bool {
        at.is_multiple_of(self.lines.len().max(1) as u64)
    }
}

/// Storing.
impl Device {
    /// What is queued from now on is stored. Not while the program runs.
    pub(crate) fn start_download(&mut self, loops: u32, announced: u32) -> bool {
        if !matches!(self.run, Run::Off) {
            return false;
        }
        self.download = Some(Download {
            loops,
            announced,
            lines: Vec::new(),
        });
        true
    }

    /// The program is complete, whatever its length was said to be: it takes the place of the one in the flash.
    pub(crate) fn stop_download(&mut self) {
        let Some(download) = self.download.take() else {
            return;
        };
        let Download {
            loops,
            announced,
            lines,
        } = download;
        let stored = u32::try_from(lines.len()).unwrap_or(u32::MAX);
        let lines = Arc::new(lines);
        self.write_flash(|flash| flash.program = Program { loops, lines });
        self.log.push(Event::Downloaded { stored, announced });
    }

    /// Whether the program that is being stored is of another length than it was said to be.
    pub(crate) fn is_mismatched(&self) -> bool {
        let download = self.download.as_ref();
        download
            .is_some_and(|download| u32::try_from(download.lines.len()) != Ok(download.announced))
    }

    /// Whether there is no place for a queued command, in the queue or in the program that is being stored.
    pub(crate) fn is_full(&self) -> bool {
        match &self.download {
            Some(download) => download.lines.len() >= self.profile.offline.capacity,
            None => self.hosts().left() == 0,
        }
    }

    /// Stores a queued command while a program is being stored. It gets an index of the queue, which it never enters:
    /// the current index passes over it. `None`: it is to be queued; `Some(None)`: there is no room.
    pub(crate) fn store_line(&mut self, id: u8, order: &Order) -> Option<Option<u64>> {
        let download = self.download.as_mut()?;
        if download.lines.len() >= self.profile.offline.capacity {
            return Some(None);
        }
        if let Order::Set(set) = order {
            download.lines.push(*set);
        }
        let index = self.hosts_mut().pass_index();
        self.log.push(Event::Stored { index, id });
        Some(Some(index))
    }
}

/// Running.
impl Device {
    /// The queue that hosts fill.
    pub(crate) fn hosts(&self) -> &Queue {
        match &self.run {
            Run::On(pass) => &pass.hosts,
            Run::Off | Run::Due => &self.queue,
        }
    }

    pub(crate) fn hosts_mut(&mut self) -> &mut Queue {
        match &mut self.run {
            Run::On(pass) => &mut pass.hosts,
            Run::Off | Run::Due => &mut self.queue,
        }
    }

    /// Whether the program has the place of the hosts' queue.
    pub(crate) fn runs_program(&self) -> bool {
        matches!(self.run, Run::On(_))
    }

    /// The base key starts the program, or stops it.
    pub(crate) fn toggle_program(&mut self) {
        if !matches!(self.run, Run::Off) {
            self.stop_program();
        } else if self.download.is_none() && self.flash.program.line(0).is_some() {
            self.run = Run::Due;
            self.replan_segment();
        }
    }

    /// Ends the program: what moves comes to its end, a wait is cut short.
    pub(crate) fn stop_program(&mut self) {
        match &mut self.run {
            Run::Off => {}
            Run::Due => self.run = Run::Off,
            Run::On(pass) => {
                pass.stopped = true;
                self.queue.clear();
                self.replan_segment();
                self.cut_wait();
            }
        }
    }

    /// The program takes the place of the hosts' queue or gives it back, when nothing is under way.
    pub(crate) fn change_queue(&mut self) {
        if self.queue.running.is_some() || self.motion.is_moving() {
            return;
        }
        match &self.run {
            Run::Due => {
                let program = Queue::new(AHEAD, 1, true);
                self.run = Run::On(Box::new(Pass {
                    hosts: std::mem::replace(&mut self.queue, program),
                    read: 0,
                    began: None,
                    stopped: false,
                }));
                self.log.push(Event::Program { runs: true });
                while self.read_ahead() {}
            }
            Run::On(_) if self.queue.head().is_none() => {
                if let Run::On(pass) = std::mem::take(&mut self.run) {
                    self.queue = pass.hosts;
                }
                self.log.push(Event::Program { runs: false });
            }
            Run::Off | Run::On(_) => {}
        }
    }

    /// Reads a line of the running program if there is room for it; whether there was one.
    pub(crate) fn read_ahead(&mut self) -> bool {
        let Run::On(pass) = &mut self.run else {
            return false;
        };
        let line = self.flash.program.line(pass.read);
        let (Some(line), false) = (line, pass.stopped || self.queue.left() == 0) else {
            return false;
        };
        pass.read += 1;
        let _: Option<u64> = self.queue.push(line.row().id, Order::Set(*line));
        self.path_grows();
        true
    }

    /// A line of the running program comes to its turn. A pass that took no time would be followed by others like it,
    /// each as idle as the one before: the program has done what it does.
    pub(crate) fn pass_over(&mut self, index: u64) -> bool {
        let now = self.now;
        let Run::On(pass) = &mut self.run else {
            return false;
        };
        if !self.flash.program.begins_pass(index.saturating_sub(1)) {
            return false;
        }
        let idle = pass.began == Some(now);
        pass.began = Some(now);
        if idle {
            self.stop_program();
        }
        idle
    }
}
