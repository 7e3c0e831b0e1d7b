//! What a station keeps, written beside everything else: a slow disk holds up no stop.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::runtime::Handle;
use tokio::sync::Notify;

use crate::job::JobStore;
use crate::running::JournalSink;
use crate::station::{FileToKeep, JobsToKeep, JournalLine};

/// Lines of the journal that wait for the disk. What comes above is not written.
const LINES: usize = 4096;

/// Writes journal and jobs on a thread for what may block. Jobs are written whole: of states that wait only the newest is, so
/// that a disk has at most one of them before it, however often they change.
pub(crate) struct Keeper {
    runtime: Handle,
    /// True where there is no thread for what may block: a page has none, and no disk.
    is_inline: bool,
    journal: JournalSink,
    store: Arc<dyn JobStore>,
    kept: KeptSink,
    waiting: Mutex<Waiting>,
    idle: Notify,
}

#[derive(Default)]
struct Waiting {
    lines: VecDeque<JournalLine>,
    lost: u64,
    /// By arm.
    jobs: BTreeMap<usize, JobsToKeep>,
    files: BTreeMap<&'static str, FileToKeep>,
    /// Something is being written.
    busy: bool,
}

/// What came of writing something.
#[derive(Debug)]
pub(crate) struct Written {
    pub(crate) what: Kept,
    pub(crate) revision: u64,
    pub(crate) outcome: Result<(), String>,
}

/// What is written whole, again and again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kept {
    /// The jobs of the arm at this place.
    Jobs(usize),
    /// The file of this name.
    File(&'static str),
}

/// Hears what came of it, on the thread that wrote it.
type KeptSink = Box<dyn Fn(Written) + Send + Sync>;

impl Keeper {
    /// On the present runtime.
    pub(crate) fn new(
        journal: JournalSink,
        store: Arc<dyn JobStore>,
        kept: impl Fn(Written) + Send + Sync + 'static,
    ) -> Arc<Self> {
        let is_inline = cfg!(any(target_family = "wasm", feature = "single-thread"));
        Self::with(is_inline, journal, store, kept)
    }

    fn with(
        is_inline: bool,
        journal: JournalSink,
        store: Arc<dyn JobStore>,
        kept: impl Fn(Written) + Send + Sync + 'static,
    ) -> Arc<Self> {
        Arc::new(Self {
            runtime: Handle::current(),
            is_inline,
            journal,
            store,
            kept: Box::new(kept),
            waiting: Mutex::default(),
            idle: Notify::new(),
        })
    }

    /// Takes what is to be written, and returns at once.
    #[cfg(test)]
    fn keep(self: &Arc<Self>, lines: Vec<JournalLine>, jobs: Option<JobsToKeep>) -> Vec<Written> {
        self.keep_all(lines, jobs.into_iter().collect(), BTreeMap::new())
    }

    /// Takes what is to be written, and returns at once. Of files by their names, and of the jobs of an arm, the newest of each
    /// is written. Where there is no other thread it is written by now, and what came of it is returned.
    pub(crate) fn keep_all(
        self: &Arc<Self>,
        lines: Vec<JournalLine>,
        jobs: Vec<JobsToKeep>,
        files: BTreeMap<&'static str, FileToKeep>,
    ) -> Vec<Written> {
        let mut written = Vec::new();
        if lines.is_empty() && jobs.is_empty() && files.is_empty() {
            return written;
        }
        let mut waiting = self.waiting();
        waiting.files.extend(files);
        let room = LINES.saturating_sub(waiting.lines.len());
        waiting.lost += lines.len().saturating_sub(room) as u64;
        waiting.lines.extend(lines.into_iter().take(room));
        let jobs = jobs.into_iter().map(|jobs| (jobs.arm(), jobs));
        waiting.jobs.extend(jobs);
        if !std::mem::replace(&mut waiting.busy, true) {
            drop(waiting);
            let keeper = Arc::clone(self);
            if self.is_inline {
                keeper.write(&mut |kept| written.push(kept));
            } else {
                self.runtime
                    .spawn_blocking(move || keeper.write(&mut |kept| (keeper.kept)(kept)));
            }
        }
        written
    }

    fn write(&self, kept: &mut dyn FnMut(Written)) {
        loop {
            let mut waiting = self.waiting();
            let lines = std::mem::take(&mut waiting.lines);
            let jobs = std::mem::take(&mut waiting.jobs);
            let lost = std::mem::take(&mut waiting.lost);
            let files = std::mem::take(&mut waiting.files);
            if lines.is_empty() && jobs.is_empty() && files.is_empty() {
                waiting.busy = false;
                drop(waiting);
                self.idle.notify_waiters();
                return;
            }
            drop(waiting);
            // Answers wait for jobs and files, and none for the journal.
            for (arm, jobs) in jobs {
                let saved = self.store.save(arm, &jobs.to_value());
                if let Err(error) = &saved {
                    tracing::warn!(%error, "the jobs are not kept");
                }
                kept(Written {
                    what: Kept::Jobs(arm),
                    revision: jobs.revision(),
                    outcome: saved.map_err(|error| error.to_string()),
                });
            }
            for (name, file) in files {
                let saved = self.store.keep(name, &file.text);
                if let Err(error) = &saved {
                    tracing::warn!(%error, "the file is not kept");
                }
                kept(Written {
                    what: Kept::File(name),
                    revision: file.revision,
                    outcome: saved.map_err(|error| error.to_string()),
                });
            }
            lines.into_iter().for_each(&self.journal);
            if lost > 0 {
                tracing::warn!(lost, "lines of the journal are lost: the disk is slow");
            }
        }
    }

    /// Waits until all that was taken is written.
    pub(crate) async fn flush(&self) {
        loop {
            let idle = self.idle.notified();
            tokio::pin!(idle);
            idle.as_mut().enable();
            if !self.waiting().busy {
                return;
            }
            idle.await;
        }
    }

    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use magician_job::Journal;
    use serde_json::Value;

    use super::*;
    use crate::job::NoStore;

    /// A disk that writes when it is told to.
    struct Slow {
        began: mpsc::Sender<Value>,
        go: Mutex<mpsc::Receiver<()>>,
    }

    impl JobStore for Slow {
        fn load(&self, _: usize) -> Value {
            Value::Null
        }

        fn save(&self, _: usize, jobs: &Value) -> std::io::Result<()> {
            self.began.send(jobs.clone()).unwrap();
            self.go.lock().unwrap().recv().unwrap();
            Ok(())
        }

        fn journal(&self) -> Box<dyn Journal> {
            NoStore.journal()
        }
    }

    /// A keeper with a thread of its own, whatever this build has: its disk may block.
    fn beside(journal: JournalSink, store: impl JobStore + 'static) -> Arc<Keeper> {
        Keeper::with(false, journal, Arc::new(store), |_| {})
    }

    #[tokio::test]
    async fn without_a_thread_jobs_are_written_by_the_return() {
        let keeper = Keeper::with(true, Box::new(|_| {}), Arc::new(NoStore), |_| {
            panic!("it was returned")
        });
        let written = keeper.keep(Vec::new(), Some(JobsToKeep::of_ids(&["first"])));
        let [written] = written.as_slice() else {
            panic!("{written:?}");
        };
        assert_eq!((written.what, written.revision), (Kept::Jobs(0), 1));
        assert_eq!(written.outcome, Ok(()));
    }

    #[tokio::test]
    async fn of_jobs_that_wait_for_the_disk_the_newest_alone_is_written() {
        let ((began, saved), (write, go)) = (mpsc::channel(), mpsc::channel());
        let go = Mutex::new(go);
        let keeper = beside(Box::new(|_| {}), Slow { began, go });
        keeper.keep(Vec::new(), Some(JobsToKeep::of_ids(&["first"])));
        let id = |saved: Value| saved["jobs"][0]["job"].as_str().map(str::to_owned);
        assert_eq!(id(saved.recv().unwrap()).as_deref(), Some("first"));
        for number in 0..1000 {
            keeper.keep(Vec::new(), Some(JobsToKeep::of_ids(&[&number.to_string()])));
        }
        write.send(()).unwrap();
        write.send(()).unwrap();
        keeper.flush().await;
        let rest: Vec<_> = saved.try_iter().filter_map(id).collect();
        assert_eq!(rest, ["999"]);
    }

    #[tokio::test]
    async fn a_journal_that_is_not_written_takes_no_more_than_its_room() {
        let ((go, held), (begins, begun)) = (mpsc::channel::<()>(), mpsc::channel());
        let held = Mutex::new(held);
        let written = Arc::new(Mutex::new(0));
        let count = Arc::clone(&written);
        let journal = Box::new(move |_: JournalLine| {
            let _ = begins.send(());
            // The first line waits; what is sent, or hung up, lets it go.
            let _ = held.lock().unwrap().recv();
            *count.lock().unwrap() += 1;
        });
        let keeper = beside(journal, NoStore);
        let line = JournalLine::default();
        keeper.keep(vec![line.clone()], None);
        // The first is at work from here on: no more than the room is held beside it.
        begun.recv().unwrap();
        for _ in 0..3 {
            keeper.keep(vec![line.clone(); LINES], None);
        }
        drop(go);
        keeper.flush().await;
        assert_eq!(*written.lock().unwrap(), LINES + 1);
    }
}
