//! What a run leaves for the one that goes on with it: a small file while it lasts, gone at its good end.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use magician_program::resume::{Mark, Verdict};
use tracing::debug;

use crate::dirs;
use crate::failure::Failure;

/// Between two writes that only say how far it is.
const PAUSE: Duration = Duration::from_millis(100);
/// So many steps are written down before they are given to the arm.
const AHEAD: u64 = 64;

/// The file of one run.
#[derive(Debug)]
pub(super) struct Journal {
    path: Option<PathBuf>,
    pub(super) mark: Mark,
    /// While it lasts it is written only for an arm that outlives this program.
    lasting: bool,
    written: Option<Instant>,
}

impl Journal {
    /// Of what is known by this key, at this arm.
    pub(super) fn new(key: &str, arm: &str, mark: Mark, lasting: bool) -> Self {
        Self {
            path: place(key, arm),
            mark,
            lasting,
            written: None,
        }
    }

    /// What an earlier run of the same has left.
    pub(super) fn left(&self) -> Result<Mark, Failure> {
        let none = || {
            Failure::invalid("there is nothing to resume: this program, placed like this, was not interrupted here")
                .hint("--from STEP begins at any step")
        };
        let path = self.path.as_ref().ok_or_else(none)?;
        let text = fs::read_to_string(path).map_err(|_| none())?;
        let mark: Option<Mark> = serde_json::from_str(&text).ok();
        let mark = mark.filter(|mark| mark.version == Mark::VERSION);
        mark.ok_or_else(|| {
            let message = format!(
                "{} is not readable: another version wrote it",
                path.display()
            );
            Failure::invalid(message).hint("--from STEP begins at any step")
        })
    }

    /// A run begins behind so many steps, at that place within the next if there is one, when the arm's clock shows this, ms,
    /// and its index this, if it is at rest.
    pub(super) fn begins(
        &mut self,
        (finished, within): (u64, Option<[f64; 3]>),
        clock: u32,
        rest: Option<u64>,
    ) {
        (self.mark.finished, self.mark.handed) = (finished, finished);
        self.mark.within = within.map(|place| (finished, place));
        (self.mark.clock, self.mark.rest) = (clock, rest);
    }

    /// So many steps are about to be given to the arm.
    pub(super) fn hands(&mut self, steps: u64) {
        if steps > self.mark.handed {
            self.mark.handed = steps
                .saturating_add(AHEAD)
                .min(self.mark.steps.unwrap_or(u64::MAX));
            self.write_if_lasting();
        }
    }

    /// How far it is.
    pub(super) fn reached(&mut self, finished: u64, index: Option<(u64, u64)>) {
        let mark = &mut self.mark;
        if mark.finished == finished && mark.index == index {
            return;
        }
        (mark.finished, mark.index) = (finished, index);
        if self
            .written
            .is_none_or(|written| written.elapsed() >= PAUSE)
        {
            self.write_if_lasting();
        }
    }

    /// It is over before its end.
    pub(super) fn ends(&mut self, verdict: Verdict) {
        self.mark = std::mem::take(&mut self.mark).ended(verdict);
        self.write();
    }

    /// It is over, and nobody can tell yet how far it came.
    pub(super) fn breaks_off(&mut self) {
        self.write();
    }

    /// It has come to its end.
    pub(super) fn remove(&self) {
        if let Some(path) = &self.path {
            // One that was never written is not there.
            let _ = fs::remove_file(path);
        }
    }

    fn write_if_lasting(&mut self) {
        if self.lasting {
            self.write();
        }
    }

    /// A run without a journal is better than none: what goes wrong is only logged.
    fn write(&mut self) {
        self.written = Some(Instant::now());
        let Some(path) = &self.path else {
            return;
        };
        let written = (|| {
            let text = serde_json::to_string(&self.mark)?;
            fs::create_dir_all(path.parent().unwrap_or(path))?;
            let fresh = path.with_extension(format!("{}.new", std::process::id()));
            fs::write(&fresh, text)?;
            fs::rename(&fresh, path)
        })();
        if let Err(error) = written {
            debug!(%error, "{} cannot be written", path.display());
        }
    }
}

fn place(key: &str, arm: &str) -> Option<PathBuf> {
    let plain = |sign: char| {
        if sign.is_ascii_alphanumeric() {
            sign
        } else {
            '-'
        }
    };
    let arm: String = arm.chars().map(plain).take(60).collect();
    Some(
        dirs::state()?
            .join("runs")
            .join(format!("{key}-{arm}.json")),
    )
}
