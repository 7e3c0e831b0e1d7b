//! Jobs of a station as files, one per arm, and the journals of jobs.
//!
//! A job belongs to an arm and not to a name: under the next station the arm may have another name,
//! and another arm may have its old one. So the file of an arm is named by its serial number. Some
//! arms report no number, or the same as another arm; then the port is added. A lock file keeps two
//! stations from writing the same file.

use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use magician_job::files::replace_private;
use magician_job::{FileJournal, InterruptedRun, Journal, dirs, interrupted_runs};
use serde_json::{Value, json};

use crate::job_store::{JobStore, StoredRun};
use crate::station::{ArmEntry, check_jobs, damaged_jobs};

/// File of an older version that held the jobs of all arms by name.
const LEGACY_FILE: &str = "jobs.json";
/// Folder with the files of the arms.
const JOB_FOLDER: &str = "jobs";
/// Most virtual arms with the same name at once, each in a process of its own.
const MAX_TWINS: u32 = 32;
/// Most characters of an arm's name in a file name.
const MAX_NAME_LENGTH: usize = 100;
/// Most interrupted command-line runs that are taken over per arm. Older runs are left out.
const MAX_RUNS: usize = 8;

/// Jobs of a station as files that only their owner can read. Journals are in the folder used by
/// the command line, so that station and command can resume each other's runs.
///
/// The file of an arm is named by its serial number; if the arm reports none or several arms report
/// the same one, by number and port; for a virtual arm of this process, by its name. While a
/// station has an arm, no other station writes its file.
#[derive(Debug)]
pub struct JobFolder {
    folder: PathBuf,
    runs: Option<PathBuf>,
    arms: Vec<ArmFile>,
}

/// File of one arm.
#[derive(Debug)]
struct ArmFile {
    path: PathBuf,
    key: ArmKey,
    name: String,
    /// Content when the station started.
    content: Value,
    /// Lock, held for the station's lifetime. `None` if the file system does not support locks or
    /// is full.
    _lock: Option<File>,
}

/// Identity of an arm, independent of its name.
#[derive(Clone, Debug, PartialEq, Eq)]
struct ArmKey {
    /// Serial number. Empty if the arm reports none.
    serial: String,
    /// Canonical path of the port, so that all its names are equal.
    port: String,
    /// True if another arm reports the same serial number.
    is_shared: bool,
    is_virtual: bool,
}

/// Reason why the jobs of an arm cannot be kept.
#[derive(Debug)]
#[non_exhaustive]
pub enum JobStoreError {
    /// A file cannot be read.
    Io(PathBuf, io::Error),
    /// A file is damaged, or of a later version.
    Unreadable(PathBuf, String),
    /// Another station is using the arm.
    Taken(PathBuf, String),
}

impl fmt::Display for JobStoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Unreadable(path, why) => {
                write!(f, "the jobs in {} cannot be read: {why}", path.display())
            }
            Self::Taken(path, arm) => write!(
                f,
                "another station of this computer keeps the jobs of {arm} ({})",
                path.display()
            ),
        }
    }
}

impl std::error::Error for JobStoreError {}

impl JobFolder {
    /// Opens the files of these arms, with the serial numbers that they report. The folder need not
    /// exist. Jobs in the file of an older station are taken over by name.
    ///
    /// # Errors
    /// [`JobStoreError`]; then nothing has changed.
    pub fn open(
        folder: impl Into<PathBuf>,
        arms: &[ArmEntry],
        serials: &[String],
    ) -> Result<Self, JobStoreError> {
        let folder = folder.into();
        // Errors are ignored: a full disk must not keep a station from its arms. Starts of jobs are
        // refused then.
        let _ = fs::create_dir_all(folder.join(JOB_FOLDER));
        // Stations open files one at a time, because opening may rename them.
        let guard = File::open(folder.join(JOB_FOLDER)).ok();
        let _guard = guard.filter(|guard| guard.lock().is_ok());
        let keys = keys(&folder, arms, serials);
        let mut opened = Vec::new();
        for (key, arm) in keys.into_iter().zip(arms) {
            opened.push(ArmFile::open(&folder, key, arm)?);
        }
        let mut jobs = Self {
            folder,
            runs: dirs::state().map(|state| state.join("runs")),
            arms: opened,
        };
        jobs.migrate_legacy_file()?;
        Ok(jobs)
    }

    /// Sets the folder of journals, instead of the user's directory for state.
    #[must_use]
    pub fn with_runs(mut self, folder: impl Into<PathBuf>) -> Self {
        self.runs = Some(folder.into());
        self
    }

    /// Takes over jobs from the file of an older station, by the names of arms.
    fn migrate_legacy_file(&mut self) -> Result<(), JobStoreError> {
        let path = self.folder.join(LEGACY_FILE);
        let Some(old) = read(&path)? else {
            return Ok(());
        };
        let Value::Array(all) = old else {
            let why = "it is no list of jobs".to_owned();
            return Err(JobStoreError::Unreadable(path, why));
        };
        let is_of = |job: &Value, arm: &ArmFile| job["arm"] == json!(arm.name);
        let mut is_written = true;
        for arm in &mut self.arms {
            let known: Vec<_> = { arm.content["jobs"].as_array() }
                .into_iter()
                .flatten()
                .map(|job| job["job"].clone())
                .collect();
            let new = |job: &&Value| is_of(job, arm) && !known.contains(&job["job"]);
            let mut jobs: Vec<_> = all.iter().filter(new).cloned().collect();
            if jobs.is_empty() {
                continue;
            }
            for job in &mut jobs {
                // The old file does not record owners, so no client could resume a queued job.
                if job["state"] == "queued" {
                    job["state"] = json!("interrupted");
                }
            }
            let mut content = match arm.content.take() {
                Value::Null => json!({"version": 2, "jobs": []}),
                content => content,
            };
            if let Some(there) = content["jobs"].as_array_mut() {
                there.splice(0..0, jobs);
            }
            arm.content = content;
            is_written &= arm.write(&arm.content).is_ok();
        }
        let rest: Vec<_> = { all.iter() }
            .filter(|job| !self.arms.iter().any(|arm| is_of(job, arm)))
            .collect();
        // Jobs are removed from the old file last, and only after they were written to another
        // file, so that an interruption loses none.
        if is_written && rest.is_empty() {
            // If this fails, the next start recognises these jobs by their ids and does not take
            // them over again.
            let _ = fs::remove_file(&path);
        } else if is_written && rest.len() < all.len() {
            let _ = replace_private(&path, &json!(rest).to_string());
        }
        Ok(())
    }
}

impl ArmFile {
    fn open(folder: &Path, key: ArmKey, arm: &ArmEntry) -> Result<Self, JobStoreError> {
        let stem = key.stem(&arm.name);
        let twins = if key.is_virtual { MAX_TWINS } else { 1 };
        // Virtual arms of several stations often have the same name: each takes the first free
        // file.
        for twin in 1..=twins {
            let stem = match twin {
                1 => stem.clone(),
                _ => format!("{stem}-{twin}"),
            };
            let path = folder.join(JOB_FOLDER).join(format!("{stem}.json"));
            let lock = File::options()
                .create(true)
                .truncate(false)
                .write(true)
                .open(path.with_extension("lock"));
            let lock = match lock.ok().map(|lock| (lock.try_lock(), lock)) {
                // In use by another station: try the next file, if there is one.
                Some((Err(TryLockError::WouldBlock), _)) => continue,
                Some((Ok(()), lock)) => Some(lock),
                // The file system has no locks: continue without one, because usually only one
                // station uses the file.
                Some((Err(TryLockError::Error(_)), _)) | None => None,
            };
            let content = read(&path)?.unwrap_or_default();
            for lost in damaged_jobs(&content) {
                tracing::warn!("{}: {lost}", path.display());
            }
            return Ok(Self {
                path,
                key,
                name: arm.name.clone(),
                content,
                _lock: lock,
            });
        }
        let path = folder.join(JOB_FOLDER).join(format!("{stem}.json"));
        Err(JobStoreError::Taken(path, arm.name.clone()))
    }

    fn write(&self, jobs: &Value) -> io::Result<()> {
        let mut file = jobs.clone();
        file["arm"] = json!({
            "name": self.name,
            "serial": self.key.serial,
            "port": self.key.port,
        });
        write_synced(&self.path, &file.to_string())
    }
}

/// Replaces a private file. On return it is on the disk.
fn write_synced(path: &Path, text: &str) -> io::Result<()> {
    let io_error =
        |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
    replace_private(path, text).map_err(io_error)?;
    // A rename is durable only when the directory is synced.
    #[cfg(unix)]
    if let Some(folder) = path.parent() {
        File::open(folder)
            .and_then(|folder| folder.sync_all())
            .map_err(io_error)?;
    }
    Ok(())
}

impl ArmKey {
    /// Returns the name of the file, without its extension.
    fn stem(&self, name: &str) -> String {
        let text = match (self.is_virtual, self.serial.as_str(), self.is_shared) {
            (true, ..) => format!("virtual-{name}"),
            (_, "", _) => format!("port-{}", self.port),
            (_, serial, true) => shared_stem(serial, &self.port),
            (_, serial, false) => format!("serial-{serial}"),
        };
        file_name_of(&text)
    }

    /// True if a run of the command line was at this arm.
    fn has_run(&self, run: &InterruptedRun) -> bool {
        let port = run.order["port"].as_str().map(port);
        let same_port = port.as_deref() == Some(self.port.as_str());
        !self.is_virtual
            && match self.serial.as_str() {
                "" => same_port,
                serial => run.arm == serial && (same_port || !self.is_shared),
            }
    }
}

/// Returns the identities of these arms. A serial number counts as shared if two of them report it,
/// or two arms did at an earlier start.
fn keys(folder: &Path, arms: &[ArmEntry], serials: &[String]) -> Vec<ArmKey> {
    let real = |at: usize| !arms[at].is_virtual;
    let serial = |at: usize| serials.get(at).map_or("", |serial| serial.trim());
    let known: Vec<_> = fs::read_dir(folder.join(JOB_FOLDER))
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    let keys = (0..arms.len()).map(|at| {
        let own = serial(at);
        let mut others = (0..arms.len()).filter(|other| *other != at && real(*other));
        // The prefix of the file names of arms that shared this number.
        let was_shared = file_name_of(&shared_stem(own, ""));
        let is_shared = !own.is_empty()
            && (others.any(|other| serial(other) == own)
                || known.iter().any(|name| name.starts_with(&was_shared)));
        ArmKey {
            serial: own.to_owned(),
            port: port(&arms[at].port),
            is_shared,
            is_virtual: !real(at),
        }
    });
    let keys: Vec<_> = keys.collect();
    for key in keys.iter().filter(|key| key.is_shared && !key.is_virtual) {
        // The arm that was the only one with this number keeps its jobs under the new name.
        let alone = ArmKey {
            is_shared: false,
            ..key.clone()
        };
        let at = |key: &ArmKey| {
            folder
                .join(JOB_FOLDER)
                .join(format!("{}.json", key.stem("")))
        };
        let (from, to) = (at(&alone), at(key));
        let was_here = read(&from)
            .ok()
            .flatten()
            .is_some_and(|file| file["arm"]["port"].as_str() == Some(key.port.as_str()));
        if was_here && !to.exists() {
            // If this fails the arm starts with an empty list, and the old file stays.
            let _ = fs::rename(from, to);
        }
    }
    keys
}

fn shared_stem(serial: &str, port: &str) -> String {
    format!("shared-{serial}@{port}")
}

/// Converts text to a valid file name. If characters were replaced, a digest is appended, so that
/// different texts stay different.
fn file_name_of(text: &str) -> String {
    let allowed_char = |letter: char| match letter {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '-' | '_' | '@' => letter,
        // Separators and other characters that some file systems refuse.
        _ => '_',
    };
    let name: String = text
        .chars()
        .take(MAX_NAME_LENGTH)
        .map(allowed_char)
        .collect();
    if name == text {
        return name;
    }
    // 32-bit FNV-1a.
    let offset: u32 = 0x811c_9dc5;
    let hash = text.bytes().fold(offset, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    format!("{name}-{hash:08x}")
}

/// Returns the canonical path of a port, or the text itself if it is not a path.
fn port(port: impl AsRef<str>) -> String {
    let port = port.as_ref();
    match fs::canonicalize(port) {
        Ok(path) => path.display().to_string(),
        Err(_) => port.to_owned(),
    }
}

/// Reads a file of jobs. `None` if it does not exist.
fn read(path: &Path) -> Result<Option<Value>, JobStoreError> {
    let text = match fs::read(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(JobStoreError::Io(path.to_owned(), error)),
        Ok(text) => text,
    };
    let unreadable = |why: String| JobStoreError::Unreadable(path.to_owned(), why);
    let file: Value =
        serde_json::from_slice(&text).map_err(|error| unreadable(error.to_string()))?;
    check_jobs(&file).map_err(unreadable)?;
    Ok(Some(file))
}

fn unix(at: SystemTime) -> f64 {
    let since = at.duration_since(UNIX_EPOCH);
    since.map_or(0.0, |since| since.as_secs_f64())
}

/// Converts an interrupted run. `None` if its journal is incomplete.
fn stored_run(run: InterruptedRun) -> Option<StoredRun> {
    let started = run.order["started"].as_f64()?;
    Some(StoredRun {
        // The start time is included because the same program may run again at the same arm.
        name: format!("{} {started}", run.name),
        title: run.checkpoint.title.clone(),
        order: serde_json::from_value(run.order["order"].clone()).ok()?,
        steps: run.order["steps"].as_u64(),
        done: run.checkpoint.finished,
        started,
        ended: unix(run.at),
    })
}

impl JobStore for JobFolder {
    fn load(&self, arm: usize) -> Value {
        let file = self.arms.get(arm);
        file.map_or(Value::Null, |file| file.content.clone())
    }

    fn save(&self, arm: usize, jobs: &Value) -> io::Result<()> {
        let file = self.arms.get(arm);
        file.map_or(Ok(()), |file| file.write(jobs))
    }

    fn load_text(&self, name: &str) -> io::Result<Option<String>> {
        match fs::read(self.folder.join(name)) {
            Ok(bytes) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn save_text(&self, name: &str, text: &str) -> io::Result<()> {
        write_synced(&self.folder.join(name), text)
    }

    fn runs(&self, arm: usize) -> Vec<StoredRun> {
        let (Some(file), Some(runs)) = (self.arms.get(arm), &self.runs) else {
            return Vec::new();
        };
        let of_arm = interrupted_runs(runs).into_iter();
        let mut runs: Vec<_> = of_arm
            .filter(|run| file.key.has_run(run))
            .filter_map(stored_run)
            .collect();
        // `interrupted_runs` returns the oldest first.
        runs.drain(..runs.len().saturating_sub(MAX_RUNS));
        runs
    }

    fn journal(&self) -> Box<dyn Journal> {
        Box::new(match &self.runs {
            Some(folder) => FileJournal::at(folder),
            None => FileJournal::new(),
        })
    }
}
