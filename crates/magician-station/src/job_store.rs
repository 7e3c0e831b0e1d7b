//! Interface for storing jobs, so that a restarted station lists and resumes them.

use std::io;

use magician_job::{Journal, NoJournal};
use serde_json::Value;

use crate::order::JobOrder;

/// Stores jobs beyond the lifetime of a station. `arm` is the index of an arm in the station's
/// configuration.
pub trait JobStore: Send + Sync {
    /// Returns the last saved jobs of an arm. Null if none were saved.
    fn load(&self, arm: usize) -> Value;

    /// Replaces the saved jobs of an arm. On return they are on the disk.
    ///
    /// # Errors
    /// The cause. Then the earlier version is still stored.
    fn save(&self, arm: usize, jobs: &Value) -> io::Result<()>;

    /// Creates a journal for a job.
    fn journal(&self) -> Box<dyn Journal>;

    /// Returns runs of the command line at this arm that were interrupted and can be resumed.
    fn runs(&self, arm: usize) -> Vec<StoredRun> {
        let _ = arm;
        Vec::new()
    }

    /// Returns a stored text by name (a class, its schedule). `None` if absent.
    ///
    /// # Errors
    /// The cause, if the text exists but cannot be read.
    fn load_text(&self, name: &str) -> io::Result<Option<String>> {
        let _ = name;
        Ok(None)
    }

    /// Stores a text by name, readable by its owner alone. On return it is on the disk.
    ///
    /// # Errors
    /// The cause. Then the earlier version is still stored.
    fn save_text(&self, name: &str, text: &str) -> io::Result<()> {
        let _ = (name, text);
        Ok(())
    }
}

/// Interrupted run of the command line.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StoredRun {
    /// Name of its journal; unique while the journal exists.
    pub name: String,
    /// Title of its program.
    pub title: String,
    /// Program and options.
    pub order: JobOrder,
    /// Steps of one loop, if known.
    pub steps: Option<u64>,
    /// Finished steps over all loops.
    pub done: u64,
    /// Start, Unix seconds.
    pub started: f64,
    /// Last entry in its journal, Unix seconds.
    pub ended: f64,
}

/// Store that keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoJobStore;

impl JobStore for NoJobStore {
    fn load(&self, _: usize) -> Value {
        Value::Null
    }

    fn save(&self, _: usize, _: &Value) -> io::Result<()> {
        Ok(())
    }

    fn journal(&self) -> Box<dyn Journal> {
        Box::new(NoJournal)
    }
}
