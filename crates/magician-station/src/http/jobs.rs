//! Jobs in a folder, a file for each arm, and their journals where all programs keep them.

use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use magician_job::files::replace_private;
use magician_job::{FileJournal, Journal, LeftRun, dirs, left_runs};
use serde_json::{Value, json};

use crate::job::{JobStore, KeptRun};
use crate::station::{ArmEntry, check_jobs, damaged_jobs};

/// File of all arms, by their names, that stations wrote before there was one for each arm.
const OLD: &str = "jobs.json";
/// Folder of the files of arms.
const FOLDER: &str = "jobs";
/// Virtual arms of one name in as many processes at once.
const MOST_TWINS: u32 = 32;
/// Longest part of a name of a file that is the arm's.
const LONGEST_NAME: usize = 100;
/// Runs of the command line at an arm that are taken up, the newest.
const MOST_RUNS: usize = 8;

/// The jobs of a station as files, which are for their owner alone. Journals of jobs are where the command has those of its runs:
/// each goes on with what the other has left.
///
/// The file of an arm has the name of its serial number; where it reports none, or others report the same, of that and its
/// port; that of a virtual arm of this process, of its name. While a station has an arm, no other writes its file.
#[derive(Debug)]
pub struct JobFolder {
    folder: PathBuf,
    runs: Option<PathBuf>,
    arms: Vec<ArmFile>,
}

/// The file of an arm.
#[derive(Debug)]
struct ArmFile {
    path: PathBuf,
    key: ArmKey,
    name: String,
    /// Content at the start.
    content: Value,
    /// Held as long as the station lives. `None` where the file system knows no locks, or has no room for one.
    _lock: Option<File>,
}

/// The arm itself, whatever it is called.
#[derive(Clone, Debug, PartialEq, Eq)]
struct ArmKey {
    /// Empty if it reports none.
    serial: String,
    /// By the one name that all its names lead to.
    port: String,
    /// True if its serial number is not its alone.
    is_shared: bool,
    is_virtual: bool,
}

/// Why the jobs of an arm cannot be kept.
#[derive(Debug)]
#[non_exhaustive]
pub enum JobStoreError {
    /// A file cannot be read.
    Io(PathBuf, io::Error),
    /// A file is damaged, or of a later version.
    Unreadable(PathBuf, String),
    /// Another station has the arm.
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
    /// The jobs of these arms, which report these serial numbers, in a folder that need not exist. What an older station has
    /// left of arms of these names is taken over.
    ///
    /// # Errors
    /// [`JobStoreError`]; nothing is changed then.
    pub fn open(
        folder: impl Into<PathBuf>,
        arms: &[ArmEntry],
        serials: &[String],
    ) -> Result<Self, JobStoreError> {
        let folder = folder.into();
        // A full disk does not keep a station from its arms; starts of jobs are refused then.
        let _ = fs::create_dir_all(folder.join(FOLDER));
        let guard = File::open(folder.join(FOLDER)).ok();
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
        jobs.take_over()?;
        Ok(jobs)
    }

    /// With the journals of jobs in this folder, instead of the user's directory for state.
    #[must_use]
    pub fn with_runs(mut self, folder: impl Into<PathBuf>) -> Self {
        self.runs = Some(folder.into());
        self
    }

    /// Takes over the jobs that an older station has kept of arms of these names.
    fn take_over(&mut self) -> Result<(), JobStoreError> {
        let path = self.folder.join(OLD);
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
                // Whose it was is not known any more.
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
        // Only now, and only what is in another file: nothing is lost however this ends.
        if is_written && rest.is_empty() {
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
        let twins = if key.is_virtual { MOST_TWINS } else { 1 };
        for twin in 1..=twins {
            let stem = match twin {
                1 => stem.clone(),
                _ => format!("{stem}-{twin}"),
            };
            let path = folder.join(FOLDER).join(format!("{stem}.json"));
            let lock = File::options()
                .create(true)
                .truncate(false)
                .write(true)
                .open(path.with_extension("lock"));
            let lock = match lock.ok().map(|lock| (lock.try_lock(), lock)) {
                Some((Err(TryLockError::WouldBlock), _)) => continue,
                Some((Ok(()), lock)) => Some(lock),
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
        let path = folder.join(FOLDER).join(format!("{stem}.json"));
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

/// Writes a private file whole. It is on the disk when this returns.
fn write_synced(path: &Path, text: &str) -> io::Result<()> {
    let told =
        |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
    replace_private(path, text).map_err(told)?;
    // Renamed, the file is on the disk when its folder is.
    #[cfg(unix)]
    if let Some(folder) = path.parent() {
        File::open(folder)
            .and_then(|folder| folder.sync_all())
            .map_err(told)?;
    }
    Ok(())
}

impl ArmKey {
    /// Name of the file, without its ending.
    fn stem(&self, name: &str) -> String {
        let text = match (self.is_virtual, self.serial.as_str(), self.is_shared) {
            (true, ..) => format!("virtual-{name}"),
            (_, "", _) => format!("port-{}", self.port),
            (_, serial, true) => shared_stem(serial, &self.port),
            (_, serial, false) => format!("serial-{serial}"),
        };
        plain(&text)
    }

    /// True if a run of the command line was at this arm.
    fn has_run(&self, run: &LeftRun) -> bool {
        let port = run.order["port"].as_str().map(port);
        let same_port = port.as_deref() == Some(self.port.as_str());
        !self.is_virtual
            && match self.serial.as_str() {
                "" => same_port,
                serial => run.arm == serial && (same_port || !self.is_shared),
            }
    }
}

/// The keys of these arms. A serial number is shared if two of them report it, or two arms did at an earlier start.
fn keys(folder: &Path, arms: &[ArmEntry], serials: &[String]) -> Vec<ArmKey> {
    let real = |at: usize| !arms[at].is_virtual;
    let serial = |at: usize| serials.get(at).map_or("", |serial| serial.trim());
    let known: Vec<_> = fs::read_dir(folder.join(FOLDER))
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    let keys = (0..arms.len()).map(|at| {
        let own = serial(at);
        let mut others = (0..arms.len()).filter(|other| *other != at && real(*other));
        let was_shared = plain(&shared_stem(own, ""));
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
        // The one that had the number for itself up to now keeps its jobs.
        let alone = ArmKey {
            is_shared: false,
            ..key.clone()
        };
        let at = |key: &ArmKey| folder.join(FOLDER).join(format!("{}.json", key.stem("")));
        let (from, to) = (at(&alone), at(key));
        let was_here = read(&from)
            .ok()
            .flatten()
            .is_some_and(|file| file["arm"]["port"].as_str() == Some(key.port.as_str()));
        if was_here && !to.exists() {
            let _ = fs::rename(from, to);
        }
    }
    keys
}

fn shared_stem(serial: &str, port: &str) -> String {
    format!("shared-{serial}@{port}")
}

/// A text as the name of a file; one that is altered gets a digest, so that no two are one.
fn plain(text: &str) -> String {
    let sign = |sign: char| match sign {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '-' | '_' | '@' => sign,
        _ => '_',
    };
    let name: String = text.chars().take(LONGEST_NAME).map(sign).collect();
    if name == text {
        return name;
    }
    let offset: u32 = 0x811c_9dc5;
    let hash = text.bytes().fold(offset, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    format!("{name}-{hash:08x}")
}

/// The port, by the one name that all its names lead to.
fn port(port: impl AsRef<str>) -> String {
    let port = port.as_ref();
    match fs::canonicalize(port) {
        Ok(path) => path.display().to_string(),
        Err(_) => port.to_owned(),
    }
}

/// A file of jobs; `None` if there is none.
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

/// A run as a station takes it up.
fn kept(run: LeftRun) -> Option<KeptRun> {
    let started = run.order["started"].as_f64()?;
    Some(KeptRun {
        // The same program may run at the same arm again.
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

    fn kept(&self, name: &str) -> io::Result<Option<String>> {
        match fs::read(self.folder.join(name)) {
            Ok(bytes) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn keep(&self, name: &str, text: &str) -> io::Result<()> {
        write_synced(&self.folder.join(name), text)
    }

    fn runs(&self, arm: usize) -> Vec<KeptRun> {
        let (Some(file), Some(runs)) = (self.arms.get(arm), &self.runs) else {
            return Vec::new();
        };
        let of_arm = left_runs(runs).into_iter();
        let mut runs: Vec<_> = of_arm
            .filter(|run| file.key.has_run(run))
            .filter_map(kept)
            .collect();
        runs.drain(..runs.len().saturating_sub(MOST_RUNS));
        runs
    }

    fn journal(&self) -> Box<dyn Journal> {
        Box::new(match &self.runs {
            Some(folder) => FileJournal::at(folder),
            None => FileJournal::new(),
        })
    }
}
