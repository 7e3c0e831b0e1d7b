//! In-memory storage of a station: a page has no files.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician_job::presets::PresetStore;
use magician_job::{Journal, JournalError, JournalKey};
use magician_program::Format;
use magician_program::resume::Checkpoint;
use magician_station::{
    JobStore, LibraryError, MAX_PROGRAM_SIZE, ProgramEntry, ProgramName, ProgramStore, Role, Upload,
};
use serde_json::Value;
use tokio::time::Instant;

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Values behind these locks are complete between statements, so a poisoned lock is still
    // usable.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Unix time, extrapolated from an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UnixClock {
    /// Unix seconds at that instant.
    pub(crate) unix: f64,
    pub(crate) at: Instant,
}

impl UnixClock {
    fn now(self) -> f64 {
        self.unix + self.at.elapsed().as_secs_f64()
    }
}

/// Library of programs. Its total size is limited to [`MAX_PROGRAM_SIZE`], which for other stations
/// limits a single program.
#[derive(Clone)]
pub(crate) struct MemoryPrograms {
    programs: Arc<Mutex<BTreeMap<ProgramName, StoredProgram>>>,
    unix_clock: UnixClock,
}

struct StoredProgram {
    bytes: Arc<[u8]>,
    modified: f64,
}

impl MemoryPrograms {
    pub(crate) fn new(unix_clock: UnixClock) -> Self {
        Self {
            programs: Arc::default(),
            unix_clock,
        }
    }

    /// Total size of all other programs, bytes.
    fn size_of_others(&self, name: &ProgramName) -> u64 {
        let programs = lock(&self.programs);
        let others = programs.iter().filter(|(other, _)| *other != name);
        others.map(|(_, stored)| stored.bytes.len() as u64).sum()
    }
}

impl ProgramStore for MemoryPrograms {
    fn folder(&self) -> Option<&Path> {
        None
    }

    fn list(&self) -> Result<Vec<ProgramEntry>, LibraryError> {
        let programs = lock(&self.programs);
        let entry = |(name, stored): (&ProgramName, &StoredProgram)| ProgramEntry {
            name: name.clone(),
            bytes: stored.bytes.len() as u64,
            modified: stored.modified,
            format: Format::of(name.as_str(), &stored.bytes),
        };
        Ok(programs.iter().map(entry).collect())
    }

    fn open(&self, name: &ProgramName) -> Result<(u64, Box<dyn Read + Send>), LibraryError> {
        let programs = lock(&self.programs);
        let stored = programs.get(name).ok_or(LibraryError::Unknown)?;
        let bytes = Arc::clone(&stored.bytes);
        Ok((bytes.len() as u64, Box::new(Cursor::new(bytes))))
    }

    fn upload(
        &self,
        name: &ProgramName,
        _: Role,
        _: Option<u64>,
    ) -> Result<Box<dyn Upload>, LibraryError> {
        Ok(Box::new(ProgramUpload {
            library: self.clone(),
            name: name.clone(),
            bytes: Vec::new(),
        }))
    }

    fn delete(&self, name: &ProgramName) -> Result<(), LibraryError> {
        let mut programs = lock(&self.programs);
        programs.remove(name).map(drop).ok_or(LibraryError::Unknown)
    }
}

struct ProgramUpload {
    library: MemoryPrograms,
    name: ProgramName,
    bytes: Vec<u8>,
}

impl Upload for ProgramUpload {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LibraryError> {
        let size = self.bytes.len() as u64 + bytes.len() as u64;
        if size > MAX_PROGRAM_SIZE {
            return Err(LibraryError::TooLarge);
        }
        if self.library.size_of_others(&self.name) + size > MAX_PROGRAM_SIZE {
            return Err(LibraryError::Full);
        }
        self.bytes.extend_from_slice(bytes);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<bool, LibraryError> {
        let stored = StoredProgram {
            bytes: self.bytes.into(),
            modified: self.library.unix_clock.now(),
        };
        let before = lock(&self.library.programs).insert(self.name, stored);
        Ok(before.is_none())
    }
}

/// Presets. The page stores them with the programs, under names that no program can have:
/// `preset+NAME.toml`.
#[derive(Clone, Debug, Default)]
pub(crate) struct MemoryPresets(Arc<Mutex<BTreeMap<String, String>>>);

impl MemoryPresets {
    /// Returns NAME if `stored` is `preset+NAME.toml`, else `None`.
    pub(crate) fn preset_name(stored: &[u8]) -> Option<&str> {
        let stored = std::str::from_utf8(stored).ok()?;
        stored.strip_prefix("preset+")?.strip_suffix(".toml")
    }
}

impl PresetStore for MemoryPresets {
    fn names(&self) -> Vec<String> {
        lock(&self.0).keys().cloned().collect()
    }

    fn load(&self, name: &str) -> io::Result<Option<String>> {
        Ok(lock(&self.0).get(name).cloned())
    }

    fn save(&self, name: &str, text: &str) -> io::Result<()> {
        lock(&self.0).insert(name.to_owned(), text.to_owned());
        Ok(())
    }

    fn remove(&self, name: &str) -> io::Result<bool> {
        Ok(lock(&self.0).remove(name).is_some())
    }
}

/// Program, arm, and number of a virtual arm of the page.
type MemoryJournalKey = (String, String, Option<u64>);

/// Journals of jobs by program and arm.
#[derive(Clone, Debug, Default)]
pub(crate) struct MemoryJobs(Arc<Mutex<BTreeMap<MemoryJournalKey, Checkpoint>>>);

impl JobStore for MemoryJobs {
    fn load(&self, _: usize) -> Value {
        Value::Null
    }

    /// Saves nothing: the station itself holds the jobs, and no job survives it.
    fn save(&self, _: usize, _: &Value) -> io::Result<()> {
        Ok(())
    }

    fn journal(&self) -> Box<dyn Journal> {
        Box::new(MemoryJournal {
            stored: self.clone(),
            key: MemoryJournalKey::default(),
        })
    }
}

struct MemoryJournal {
    stored: MemoryJobs,
    key: MemoryJournalKey,
}

impl Journal for MemoryJournal {
    fn open(&mut self, key: &JournalKey) {
        self.key = (key.program.clone(), key.arm.clone(), key.virtual_arm);
    }

    fn load(&self) -> Result<Checkpoint, JournalError> {
        let journals = lock(&self.stored.0);
        { journals.get(&self.key).cloned() }.ok_or(JournalError::NotFound)
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> std::io::Result<()> {
        lock(&self.stored.0).insert(self.key.clone(), checkpoint.clone());
        Ok(())
    }

    fn remove(&mut self) {
        lock(&self.stored.0).remove(&self.key);
    }
}
