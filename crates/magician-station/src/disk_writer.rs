//! Writes journal, jobs and class files off the station's thread: a slow disk delays no stop.
//!
//! The station hands over what changed and goes on. One blocking task writes at a time and takes
//! everything that is waiting. Files of jobs and classes are written whole, so only the newest of
//! several waiting versions is written. Answers that promise durability wait for [`Written`].

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::runtime::Handle;
use tokio::sync::Notify;

use crate::job_store::JobStore;
use crate::running::JournalSink;
use crate::station::{FileSnapshot, JobsSnapshot, JournalLine};

/// Most journal lines that wait for the disk. Further lines are dropped and counted, so that a
/// stalled disk does not exhaust memory.
const MAX_WAITING_LINES: usize = 4096;

/// Writer of journal and jobs on a blocking thread. Jobs are written whole and only the newest
/// waiting version is written, so a disk is never more than one version behind, however often they
/// change.
pub(crate) struct DiskWriter {
    runtime: Handle,
    /// True if there is no blocking thread: a page has neither threads nor a disk.
    is_inline: bool,
    journal: JournalSink,
    store: Arc<dyn JobStore>,
    on_written: WriteSink,
    waiting: Mutex<PendingWrites>,
    idle: Notify,
}

#[derive(Default)]
struct PendingWrites {
    lines: VecDeque<JournalLine>,
    lost: u64,
    /// Newest jobs of each arm.
    jobs: BTreeMap<usize, JobsSnapshot>,
    files: BTreeMap<&'static str, FileSnapshot>,
    /// True while a task is writing.
    busy: bool,
}

/// Result of writing one file.
#[derive(Debug)]
pub(crate) struct Written {
    pub(crate) what: StoredFile,
    pub(crate) revision: u64,
    pub(crate) outcome: Result<(), String>,
}

/// File that is rewritten as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StoredFile {
    /// Jobs of the arm with this index.
    Jobs(usize),
    /// File with this name.
    File(&'static str),
}

/// Callback with the result of each write, called on the writing thread.
type WriteSink = Box<dyn Fn(Written) + Send + Sync>;

impl DiskWriter {
    /// Creates a keeper on the current runtime.
    pub(crate) fn new(
        journal: JournalSink,
        store: Arc<dyn JobStore>,
        on_written: impl Fn(Written) + Send + Sync + 'static,
    ) -> Arc<Self> {
        let is_inline = cfg!(any(target_family = "wasm", feature = "single-thread"));
        Self::with(is_inline, journal, store, on_written)
    }

    fn with(
        is_inline: bool,
        journal: JournalSink,
        store: Arc<dyn JobStore>,
        on_written: impl Fn(Written) + Send + Sync + 'static,
    ) -> Arc<Self> {
        Arc::new(Self {
            runtime: Handle::current(),
            is_inline,
            journal,
            store,
            on_written: Box::new(on_written),
            waiting: Mutex::default(),
            idle: Notify::new(),
        })
    }

    /// Queues jobs and journal lines for writing, and returns at once.
    #[cfg(test)]
    fn queue(
        self: &Arc<Self>,
        lines: Vec<JournalLine>,
        jobs: Option<JobsSnapshot>,
    ) -> Vec<Written> {
        self.queue_all(lines, jobs.into_iter().collect(), BTreeMap::new())
    }

    /// Queues everything that is to be written, and returns at once. Only the newest version of
    /// each file, and of the jobs of each arm, is written. Without a blocking thread everything is
    /// written on return, and the results are returned; with one the list is empty and results go
    /// to the sink.
    pub(crate) fn queue_all(
        self: &Arc<Self>,
        lines: Vec<JournalLine>,
        jobs: Vec<JobsSnapshot>,
        files: BTreeMap<&'static str, FileSnapshot>,
    ) -> Vec<Written> {
        let mut written = Vec::new();
        if lines.is_empty() && jobs.is_empty() && files.is_empty() {
            return written;
        }
        let mut waiting = self.waiting();
        waiting.files.extend(files);
        // New lines are dropped and not old ones, so that the journal has a single gap.
        let room = MAX_WAITING_LINES.saturating_sub(waiting.lines.len());
        waiting.lost += lines.len().saturating_sub(room) as u64;
        waiting.lines.extend(lines.into_iter().take(room));
        let jobs = jobs.into_iter().map(|jobs| (jobs.arm(), jobs));
        waiting.jobs.extend(jobs);
        // One writer at a time: it takes what is added while it writes.
        if !std::mem::replace(&mut waiting.busy, true) {
            drop(waiting);
            let disk_writer = Arc::clone(self);
            if self.is_inline {
                disk_writer.write(&mut |on_written| written.push(on_written));
            } else {
                self.runtime.spawn_blocking(move || {
                    disk_writer.write(&mut |on_written| (disk_writer.on_written)(on_written))
                });
            }
        }
        written
    }

    fn write(&self, on_written: &mut dyn FnMut(Written)) {
        loop {
            let mut waiting = self.waiting();
            let lines = std::mem::take(&mut waiting.lines);
            let jobs = std::mem::take(&mut waiting.jobs);
            let lost = std::mem::take(&mut waiting.lost);
            let files = std::mem::take(&mut waiting.files);
            if lines.is_empty() && jobs.is_empty() && files.is_empty() {
                // Cleared under the lock that found nothing to do, so no work is left behind.
                waiting.busy = false;
                drop(waiting);
                self.idle.notify_waiters();
                return;
            }
            drop(waiting);
            // Jobs and files first: answers to clients wait for them. No answer waits for the
            // journal.
            for (arm, jobs) in jobs {
                let saved = self.store.save(arm, &jobs.to_value());
                if let Err(error) = &saved {
                    tracing::warn!(%error, "the jobs are not kept");
                }
                on_written(Written {
                    what: StoredFile::Jobs(arm),
                    revision: jobs.revision(),
                    outcome: saved.map_err(|error| error.to_string()),
                });
            }
            for (name, file) in files {
                let saved = self.store.save_text(name, &file.text);
                if let Err(error) = &saved {
                    tracing::warn!(%error, "the file is not kept");
                }
                on_written(Written {
                    what: StoredFile::File(name),
                    revision: file.revision,
                    outcome: saved.map_err(|error| error.to_string()),
                });
            }
            // The sink handles its own errors: the journal logs a warning.
            lines.into_iter().for_each(&self.journal);
            if lost > 0 {
                tracing::warn!(lost, "lines of the journal are lost: the disk is slow");
            }
        }
    }

    /// Waits until everything queued before the call is written.
    pub(crate) async fn flush(&self) {
        loop {
            // Registered before the check: a writer that finishes in between would otherwise be
            // missed.
            let idle = self.idle.notified();
            tokio::pin!(idle);
            idle.as_mut().enable();
            if !self.waiting().busy {
                return;
            }
            idle.await;
        }
    }

    fn waiting(&self) -> MutexGuard<'_, PendingWrites> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use magician_job::Journal;
    use serde_json::Value;

    use super::*;
    use crate::job_store::NoJobStore;

    /// Test disk that writes when the test allows it.
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
            NoJobStore.journal()
        }
    }

    /// Creates a keeper with a blocking thread in every build: the test's disk may block.
    fn threaded_writer(journal: JournalSink, store: impl JobStore + 'static) -> Arc<DiskWriter> {
        DiskWriter::with(false, journal, Arc::new(store), |_| {})
    }

    #[tokio::test]
    async fn inline_keeper_writes_before_returning() {
        let disk_writer = DiskWriter::with(true, Box::new(|_| {}), Arc::new(NoJobStore), |_| {
            panic!("it was returned")
        });
        let written = disk_writer.queue(Vec::new(), Some(JobsSnapshot::of_ids(&["first"])));
        let [written] = written.as_slice() else {
            panic!("{written:?}");
        };
        assert_eq!((written.what, written.revision), (StoredFile::Jobs(0), 1));
        assert_eq!(written.outcome, Ok(()));
    }

    #[tokio::test]
    async fn only_the_newest_waiting_jobs_are_written() {
        let ((began, saved), (write, go)) = (mpsc::channel(), mpsc::channel());
        let go = Mutex::new(go);
        let disk_writer = threaded_writer(Box::new(|_| {}), Slow { began, go });
        disk_writer.queue(Vec::new(), Some(JobsSnapshot::of_ids(&["first"])));
        let id = |saved: Value| saved["jobs"][0]["job"].as_str().map(str::to_owned);
        assert_eq!(id(saved.recv().unwrap()).as_deref(), Some("first"));
        for number in 0..1000 {
            disk_writer.queue(
                Vec::new(),
                Some(JobsSnapshot::of_ids(&[&number.to_string()])),
            );
        }
        write.send(()).unwrap();
        write.send(()).unwrap();
        disk_writer.flush().await;
        let rest: Vec<_> = saved.try_iter().filter_map(id).collect();
        assert_eq!(rest, ["999"]);
    }

    #[tokio::test]
    async fn unwritten_journal_is_bounded() {
        let ((go, held), (begins, begun)) = (mpsc::channel::<()>(), mpsc::channel());
        let held = Mutex::new(held);
        let written = Arc::new(Mutex::new(0));
        let count = Arc::clone(&written);
        let journal = Box::new(move |_: JournalLine| {
            let _ = begins.send(());
            // Holds the first line back until the test sends, or drops the channel.
            let _ = held.lock().unwrap().recv();
            *count.lock().unwrap() += 1;
        });
        let disk_writer = threaded_writer(journal, NoJobStore);
        let line = JournalLine::default();
        disk_writer.queue(vec![line.clone()], None);
        // The first line is being written: from here on only the waiting room counts.
        begun.recv().unwrap();
        for _ in 0..3 {
            disk_writer.queue(vec![line.clone(); MAX_WAITING_LINES], None);
        }
        drop(go);
        disk_writer.flush().await;
        assert_eq!(*written.lock().unwrap(), MAX_WAITING_LINES + 1);
    }
}
