//! Jobs as a file, and their journals where all programs keep them.

use std::fs;
use std::path::PathBuf;

use magician_job::files::replace_private;
use magician_job::{FileJournal, Journal};
use serde_json::Value;

use crate::job::JobStore;

/// The jobs of a station as a file, which is for its owner alone. Journals of jobs are where the command has those of its runs:
/// each goes on with what the other has left.
#[derive(Clone, Debug)]
pub struct JobFile {
    path: PathBuf,
    runs: Option<PathBuf>,
}

impl JobFile {
    /// At this place; the file need not exist.
    #[must_use]
    pub fn at(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            runs: None,
        }
    }

    /// With the journals of jobs in this folder, instead of the user's directory for state.
    #[must_use]
    pub fn with_runs(mut self, folder: impl Into<PathBuf>) -> Self {
        self.runs = Some(folder.into());
        self
    }
}

impl JobStore for JobFile {
    fn load(&self) -> Value {
        let text = fs::read_to_string(&self.path).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or(Value::Null)
    }

    fn save(&self, jobs: &Value) {
        if let Err(error) = replace_private(&self.path, &jobs.to_string()) {
            tracing::warn!(%error, path = %self.path.display(), "the jobs are not kept");
        }
    }

    fn kept(&self, name: &str) -> Option<String> {
        fs::read_to_string(self.path.with_file_name(name)).ok()
    }

    fn keep(&self, name: &str, text: &str) {
        let path = self.path.with_file_name(name);
        if let Err(error) = replace_private(&path, text) {
            tracing::warn!(%error, path = %path.display(), "the file is not kept");
        }
    }

    fn journal(&self) -> Box<dyn Journal> {
        Box::new(match &self.runs {
            Some(folder) => FileJournal::at(folder),
            None => FileJournal::new(),
        })
    }
}
