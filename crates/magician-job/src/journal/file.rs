//! The journal as a small file that exists while the job lasts, and is removed when it ends well.
//!
//! The file belongs to one job of one arm and is locked by its process. Several arms can report the
//! same serial number (all virtual arms that end with their process do), so each gets a file of its
//! own, with a number in its name.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read as _, Seek as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use magician_program::resume::Checkpoint;
use serde_json::Value;

use super::{InterruptedJob, Journal, JournalError, JournalKey};
use crate::dirs;
use crate::files::{replace, replace_locked};

/// Largest number of arms with one serial number that keep journals of one program. Further ones
/// keep none.
const MAX_ARMS_PER_SERIAL: u32 = 32;

/// Largest number of interrupted jobs of other programs in an error.
const MAX_LISTED_JOBS: usize = 20;

/// Claims by path of the first such file and number of the virtual arm.
type Claims = BTreeMap<(PathBuf, u64), Claim>;

/// Files of this process's virtual arms between two jobs. The world of such an arm ends with the
/// process, so until then its journal belongs to no other arm.
fn virtual_arm_claims() -> MutexGuard<'static, Claims> {
    static CLAIMS: Mutex<Claims> = Mutex::new(Claims::new());
    CLAIMS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A [`Journal`] in the user's state directory (`runs/KEY-ARM.json`), shared by all programs: one
/// can resume what another has left.
///
/// If an arm with the same serial number is running a job already, the file is
/// `runs/KEY-ARM-2.json`. A virtual arm that ends with its process resumes its own file, or else
/// the newest left by a process that has ended.
#[derive(Debug, Default)]
pub struct FileJournal {
    folder: Option<PathBuf>,
    /// First of the files of this program and serial number, and the number of the arm if it is
    /// virtual.
    key: Option<(PathBuf, Option<u64>)>,
    claim: Option<Claim>,
    /// Order that another program needs to resume the job, and the arm it belongs to.
    order: Option<(serde_json::Map<String, Value>, String)>,
}

/// Folder next to that of the journals, with the order of each journal under the same name.
const ORDER_FOLDER: &str = "orders";

/// Path of the order that belongs to a journal.
fn order_of(journal: &Path) -> PathBuf {
    let folder = journal.parent().unwrap_or(Path::new(""));
    let name = journal.file_name().unwrap_or_default();
    folder.with_file_name(ORDER_FOLDER).join(name)
}

/// Interrupted job, with the order that another program needs to resume it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct InterruptedRun {
    /// Name of its journal.
    pub name: String,
    /// Arm of the job: [`JournalKey::arm`].
    pub arm: String,
    /// Description of the job by its program ([`FileJournal::with_order`]).
    pub order: Value,
    /// Progress of the job.
    pub checkpoint: Checkpoint,
    /// Time of the last write.
    pub at: SystemTime,
}

/// Lists the interrupted jobs in a folder (`runs` of the user's state directory) that have an
/// order. Jobs that a process is running are left out.
#[must_use]
pub fn interrupted_runs(folder: &Path) -> Vec<InterruptedRun> {
    let orders = fs::read_dir(folder.with_file_name(ORDER_FOLDER));
    let left = orders.into_iter().flatten().flatten().filter_map(|entry| {
        let path = entry.path();
        let claim = Claim::try_new(folder.join(entry.file_name()))?;
        let name = path.file_stem()?.to_str()?.to_owned();
        let checkpoint: Checkpoint = serde_json::from_str(&claim.text().ok()?).ok()?;
        let at = claim.file.metadata().ok()?.modified().ok()?;
        let mut order: Value = serde_json::from_str(&fs::read_to_string(&path).ok()?).ok()?;
        let arm = order.as_object_mut()?.remove("arm")?.as_str()?.to_owned();
        Some(InterruptedRun {
            name,
            arm,
            order,
            checkpoint,
            at,
        })
    });
    let mut left: Vec<_> = left.collect();
    left.sort_by_key(|run| run.at);
    left
}

/// File that belongs to one job.
#[derive(Debug)]
struct Claim {
    path: PathBuf,
    /// Open and locked.
    file: File,
}

impl FileJournal {
    /// A journal in the user's state directory. Keeps nothing if the system has no such directory.
    #[must_use]
    pub fn new() -> Self {
        Self::in_folder(dirs::state().map(|state| state.join("runs")))
    }

    /// A journal in this folder.
    #[must_use]
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self::in_folder(Some(folder.into()))
    }

    fn in_folder(folder: Option<PathBuf>) -> Self {
        Self {
            folder,
            key: None,
            claim: None,
            order: None,
        }
    }

    /// Adds an order, with which other programs can resume the job: it is stored next to the
    /// journal ([`interrupted_runs`]).
    ///
    /// When a job that had no order is resumed, none is added: the job belongs to the program that
    /// started it.
    #[must_use]
    pub fn with_order(mut self, order: serde_json::Map<String, Value>) -> Self {
        self.order = Some((order, String::new()));
        self
    }

    /// Writes the order, once.
    fn write_order(&mut self, path: &Path) -> io::Result<()> {
        if let Some((mut order, arm)) = self.order.take() {
            order.insert("arm".to_owned(), arm.into());
            let text = serde_json::to_string(&order)?;
            replace(&order_of(path), &text)?;
        }
        Ok(())
    }

    /// Locks the folder, where the system can do that, so that no other process chooses a file at
    /// the same time.
    fn lock_folder(&self) -> Option<File> {
        let folder = File::open(self.folder.as_ref()?).ok()?;
        folder.lock().ok()?;
        Some(folder)
    }

    /// Error for a program without a journal, with the interrupted jobs of other programs at the
    /// same arm.
    fn no_journal_error(&self) -> JournalError {
        let others = self.other_jobs().unwrap_or_default();
        if others.is_empty() {
            JournalError::NotFound
        } else {
            JournalError::OtherPrograms(others)
        }
    }

    fn other_jobs(&self) -> Option<Vec<InterruptedJob>> {
        let (first, _) = self.key.as_ref()?;
        let own = first.file_stem()?.to_str()?;
        let (_, arm) = own.split_once('-')?;
        let is_of_arm = |path: &PathBuf| {
            let stem = path.file_stem().and_then(|stem| stem.to_str());
            let rest = stem
                .and_then(|stem| stem.split_once('-'))
                .map(|(_, rest)| rest);
            let rest = rest.and_then(|rest| rest.strip_prefix(arm));
            // Further arms of one serial number have a number at the end.
            let is_number =
                |count: &str| !count.is_empty() && count.bytes().all(|sign| sign.is_ascii_digit());
            rest.is_some_and(|rest| {
                rest.is_empty() || rest.strip_prefix('-').is_some_and(is_number)
            })
        };
        let entries = fs::read_dir(first.parent()?).ok()?.flatten();
        let claims = entries.map(|entry| entry.path()).filter(is_of_arm);
        let left = claims.filter_map(Claim::try_new).filter_map(|claim| {
            let at = claim
                .file
                .metadata()
                .and_then(|about| about.modified())
                .ok()?;
            let checkpoint: Checkpoint = serde_json::from_str(&claim.text().ok()?).ok()?;
            Some(InterruptedJob {
                title: checkpoint.title,
                finished: checkpoint.finished,
                at,
            })
        });
        let mut left: Vec<_> = left.collect();
        left.sort_by_key(|job| Reverse(job.at));
        left.truncate(MAX_LISTED_JOBS);
        Some(left)
    }

    fn try_write(&mut self, text: &str) -> io::Result<()> {
        let Some((first, _)) = &self.key else {
            let why = "the system names no folder for it";
            return Err(io::Error::new(io::ErrorKind::NotFound, why));
        };
        let _guard = self.lock_folder();
        let path = match &self.claim {
            Some(claim) => claim.path.clone(),
            None => candidate_paths(first)
                .find(|path| !path.exists())
                .ok_or(io::ErrorKind::AlreadyExists)?,
        };
        self.write_order(&path)?;
        let file = replace_locked(&path, text)?;
        self.claim = Some(Claim { path, file });
        Ok(())
    }
}

impl Journal for FileJournal {
    fn open(&mut self, key: &JournalKey) {
        let plain = |sign: char| {
            if sign.is_ascii_alphanumeric() {
                sign
            } else {
                '-'
            }
        };
        // Shortened, because file systems limit the length of names.
        let arm: String = key.arm.chars().map(plain).take(60).collect();
        let name = format!("{}-{arm}.json", key.program);
        let first = self.folder.as_ref().map(|folder| folder.join(name));
        self.key = first.map(|first| (first, key.virtual_arm));
        let _guard = self.lock_folder();
        self.claim = self.key.as_ref().and_then(|(first, number)| {
            let own =
                number.and_then(|number| virtual_arm_claims().remove(&(first.clone(), number)));
            own.or_else(|| newest_unclaimed(first))
        });
        let goes_on = |claim: &Claim| claim.path.exists() && !order_of(&claim.path).exists();
        if self.claim.as_ref().is_some_and(goes_on) {
            self.order = None;
        }
        if let Some((_, arm)) = &mut self.order {
            arm.clone_from(&key.arm);
        }
    }

    fn load(&self) -> Result<Checkpoint, JournalError> {
        let claim = self.claim.as_ref().filter(|claim| claim.path.exists());
        let claim = claim.ok_or_else(|| self.no_journal_error())?;
        let checkpoint: Option<Checkpoint> = claim
            .text()
            .ok()
            .and_then(|text| serde_json::from_str(&text).ok());
        let checkpoint = checkpoint.filter(|checkpoint| checkpoint.version == Checkpoint::VERSION);
        checkpoint.ok_or_else(|| JournalError::Unreadable {
            place: claim.path.display().to_string(),
        })
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> io::Result<()> {
        let written = serde_json::to_string(checkpoint)
            .map_err(io::Error::from)
            .and_then(|text| self.try_write(&text));
        // An older checkpoint would be taken for the last one.
        if written.is_err() {
            self.remove();
        }
        written
    }

    fn remove(&mut self) {
        let _guard = self.lock_folder();
        if let Some(claim) = self.claim.take() {
            // Fails if the file was never written.
            let _ = fs::remove_file(&claim.path);
            let _ = fs::remove_file(order_of(&claim.path));
        }
    }
}

impl Drop for FileJournal {
    fn drop(&mut self) {
        // Keep the lock, so that no other arm takes the file between two jobs.
        if let (Some((first, Some(number))), Some(claim)) = (self.key.take(), self.claim.take()) {
            virtual_arm_claims().insert((first, number), claim);
        }
    }
}

impl Claim {
    /// Claims a file unless another job holds it.
    fn try_new(path: PathBuf) -> Option<Self> {
        let file = File::open(&path).ok()?;
        // On a file system without locks the file counts as free.
        let is_taken = matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock));
        (!is_taken).then_some(Self { path, file })
    }

    fn text(&self) -> io::Result<String> {
        let (mut file, mut text) = (&self.file, String::new());
        // Read through the locked file: some systems refuse to read it through another one.
        file.rewind()?;
        file.read_to_string(&mut text)?;
        Ok(text)
    }
}

/// Paths of the files of one program and serial number.
fn candidate_paths(first: &Path) -> impl Iterator<Item = PathBuf> {
    let stem = first.file_stem().unwrap_or_default().to_string_lossy();
    (1..=MAX_ARMS_PER_SERIAL).map(move |number| match number {
        1 => first.to_owned(),
        _ => first.with_file_name(format!("{stem}-{number}.json")),
    })
}

/// Newest of the files that no job holds.
fn newest_unclaimed(first: &Path) -> Option<Claim> {
    let free = candidate_paths(first).filter_map(Claim::try_new);
    free.max_by_key(|claim| {
        claim
            .file
            .metadata()
            .and_then(|about| about.modified())
            .ok()
    })
}
