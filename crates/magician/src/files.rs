//! Atomic replacement of files: each is written beside its target and renamed.
//!
//! All files that a person names or keeps are written by [`WholeFile`]. So a full disk, a kill or a
//! power failure leaves either the previous file or the complete new one.

use std::fs::{self, File, OpenOptions, Permissions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

mod leftovers;

use self::leftovers::sweep;

/// Most symbolic links followed, as in Linux.
const MOST_LINKS: u32 = 40;
/// Longest file name on common file systems, bytes.
const LONGEST_NAME: usize = 255;
/// Partial files of earlier recordings kept before a person has to look at them. Choice.
const MOST_PARTIALS: u32 = 100;
/// Attempts to find a free name beside the target. A name may be taken by a process with the same
/// id, as in containers that share a folder. Choice.
const MOST_ATTEMPTS: u32 = 100;

/// Replaces a file, and creates its directory. A reader finds the old or the new file, never part
/// of one. Mode and symbolic link of the old one are kept.
///
/// # Errors
/// Errors of the system; the old file is then unchanged.
pub fn replace(path: &Path, text: &str) -> io::Result<()> {
    make_directory(path)?;
    write_whole(path, text.as_bytes())
}

/// Replaces a file as [`replace`] does without waiting for the disk, for files written many times a
/// second.
///
/// A killed process leaves the old or the new file; a power failure may leave an empty one on some
/// file systems.
///
/// # Errors
/// Same as [`replace`].
pub fn replace_unsynced(path: &Path, text: &str) -> io::Result<()> {
    make_directory(path)?;
    let mut file = WholeFile::create(path)?;
    file.syncs = false;
    file.write_all(text.as_bytes())?;
    file.finish()
}

/// Replaces a file as [`replace_unsynced`] does, and returns it open. It stays locked while it is
/// open.
///
/// # Errors
/// Same as [`replace`].
pub fn replace_locked(path: &Path, text: &str) -> io::Result<File> {
    make_directory(path)?;
    let mut file = WholeFile::create(path)?;
    file.syncs = false;
    file.write_all(text.as_bytes())?;
    file.finish_open()
}

/// Writes a file in an existing directory, completely or not at all: a full disk leaves the old
/// file, and nothing beside it. A target other than a regular file (a pipe, a device) is written
/// directly.
///
/// # Errors
/// Errors of the system.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes)?;
    file.finish()
}

/// Checks that [`write_whole`] can write a file there, as far as possible before there is content,
/// and changes nothing.
///
/// # Errors
/// Errors of the system.
pub fn check_writable(path: &Path) -> io::Result<()> {
    match Target::of(path)? {
        Target::File(_) => WholeFile::create(path).map(drop),
        // Opening a pipe would wait for its reader, and closing it would end the reader.
        Target::Device(_) | Target::Descriptor(_) => Ok(()),
    }
}

/// Replaces a file that only its owner may read, on systems that know owners.
///
/// # Errors
/// Same as [`replace`].
pub fn replace_private(path: &Path, text: &str) -> io::Result<()> {
    make_directory(path)?;
    rewrite_private(path, text)
}

/// Replaces a private file in an existing directory.
///
/// # Errors
/// Same as [`replace`].
pub(crate) fn rewrite_private(path: &Path, text: &str) -> io::Result<()> {
    let mut file = WholeFile::create_private(path)?;
    file.write_all(text.as_bytes())?;
    file.finish()
}

fn make_directory(path: &Path) -> io::Result<()> {
    path.parent().map_or(Ok(()), fs::create_dir_all)
}

/// Target of a path, after following its symbolic links.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// A regular file, or no file yet. A dangling link leads to the file that it names.
    File(PathBuf),
    /// A pipe or a device, written directly.
    Device(PathBuf),
    /// A file that this process has open (`/dev/stdout`). It may be a regular file, but a process
    /// that has it open would continue to write to the replaced one, so output is appended.
    Descriptor(PathBuf),
}

impl Target {
    /// Follows the links of a path.
    ///
    /// # Errors
    /// Errors of the system; [`io::ErrorKind::IsADirectory`] for a directory.
    pub fn of(path: &Path) -> io::Result<Self> {
        let mut at = path.to_owned();
        for _ in 0..MOST_LINKS {
            if cfg!(unix) && (at.starts_with("/proc") || at.starts_with("/dev/fd")) {
                return Ok(Self::Descriptor(at));
            }
            match fs::symlink_metadata(&at) {
                Ok(there) if there.is_symlink() => {
                    let to = fs::read_link(&at)?;
                    at = at.parent().map_or(to.clone(), |folder| folder.join(to));
                }
                Ok(there) if there.is_file() => return Ok(Self::File(at)),
                Ok(there) if there.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
                Ok(_) => return Ok(Self::Device(at)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::File(at)),
                Err(error) => return Err(error),
            }
        }
        Err(io::Error::other("too many symbolic links"))
    }
}

/// File being written, which gets its name when it is complete.
///
/// There are two kinds. A [created](Self::create) file is worthless until it is finished: dropped
/// before, it leaves nothing behind. A [growing](Self::grow) file (a trace, a recording) is worth
/// what has been written: dropped without an error it gets its name as if finished, and the part
/// that a killed process or a full disk leaves is kept.
///
/// If no file has the name, a growing file grows under it, so that others can follow it and find it
/// after a kill. Otherwise the old file stays until the new one is complete, which grows beside it
/// as `NAME.partial`.
#[derive(Debug)]
pub struct WholeFile {
    file: Arc<File>,
    /// Path being written.
    at: PathBuf,
    /// Final path, if another one is being written.
    target: Option<PathBuf>,
    grows: bool,
    syncs: bool,
    /// True if the first written bytes are enough to take the name.
    at_once: bool,
    /// True if a [`writer`](Self::writer) writes it: only its owner knows when it is complete.
    is_shared: bool,
    is_done: bool,
    /// True if it was locked on creation, as far as the file system supports locks.
    is_locked: bool,
    state: Arc<State>,
}

#[derive(Debug, Default)]
struct State {
    has_bytes: AtomicBool,
    has_failed: AtomicBool,
    /// Location of the written part, for the message of an error.
    partial: Option<PathBuf>,
}

impl WholeFile {
    /// Creates a file in an existing directory. Mode and owner of the old one are kept.
    ///
    /// # Errors
    /// Errors of the system. An old file without write permission is not replaced, even if its
    /// directory would allow it.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::created(path, false)
    }

    /// Creates a file that only its owner may read, on systems that know owners.
    ///
    /// # Errors
    /// Same as [`create`](Self::create).
    pub(crate) fn create_private(path: &Path) -> io::Result<Self> {
        Self::created(path, true)
    }

    fn created(path: &Path, is_private: bool) -> io::Result<Self> {
        let target = match Target::of(path)? {
            Target::File(path) => path,
            special => return Self::special(special),
        };
        let old = Old::find(&target)?;
        sweep(&target);
        let (at, file) = beside(&target, is_private || old.is_some())?;
        let mut whole = Self::written_at(file, at);
        whole.is_locked = true;
        whole.target = Some(target);
        if let Some(old) = old.filter(|_| !is_private) {
            old.pass_on(&whole.file)?;
        }
        Ok(whole)
    }

    /// Starts a growing file, locked until its end.
    ///
    /// # Errors
    /// Errors of the system, and [`io::ErrorKind::ResourceBusy`] if another program is writing it.
    pub fn grow(path: &Path) -> io::Result<Self> {
        let target = match Target::of(path)? {
            Target::File(path) => path,
            special => return Self::special(special),
        };
        let growing = |file, at| {
            let mut growing = Self::written_at(file, at);
            growing.grows = true;
            growing
        };
        match reserve(&target, false) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            reserved => return Ok(growing(reserved?, target)),
        }
        let old = Old::find(&target)?;
        if is_locked(&target) {
            return Err(busy());
        }
        for number in 1..=MOST_PARTIALS {
            let at = partial(&target, number);
            let file = match reserve(&at, true) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    if is_locked(&at) {
                        return Err(busy());
                    }
                    // The part left by an earlier program is kept for a person to look at.
                    continue;
                }
                reserved => reserved?,
            };
            let state = State {
                partial: Some(at.clone()),
                ..State::default()
            };
            let mut growing = growing(file, at);
            growing.target = Some(target);
            growing.state = Arc::new(state);
            if let Some(old) = old {
                old.pass_on(&growing.file)?;
            }
            return Ok(growing);
        }
        let first = partial(&target, 1);
        let many = format!("remove what earlier ones left: {} ..", first.display());
        Err(io::Error::new(io::ErrorKind::AlreadyExists, many))
    }

    /// Starts a growing file that takes its name with the first bytes: for a library, which is not
    /// notified of the end of its program.
    ///
    /// # Errors
    /// Same as [`grow`](Self::grow).
    pub fn grow_in_place(path: &Path) -> io::Result<Self> {
        let mut growing = Self::grow(path)?;
        growing.at_once = true;
        Ok(growing)
    }

    fn special(target: Target) -> io::Result<Self> {
        let mut options = File::options();
        let (path, options) = match target {
            Target::Descriptor(path) => (path, options.append(true)),
            Target::Device(path) | Target::File(path) => (path, options.write(true)),
        };
        Ok(Self::written_at(options.open(&path)?, path))
    }

    fn written_at(file: File, at: PathBuf) -> Self {
        Self {
            file: Arc::new(file),
            at,
            target: None,
            grows: false,
            syncs: true,
            at_once: false,
            is_shared: false,
            is_done: false,
            is_locked: false,
            state: Arc::default(),
        }
    }

    /// Returns a writer for another owner. From now on only [`finish`](Self::finish) gives the file
    /// its name.
    pub fn writer(&mut self) -> impl Write + Send + use<> {
        self.is_shared = true;
        SharedWriter {
            file: Arc::clone(&self.file),
            state: Arc::clone(&self.state),
        }
    }

    /// Replaces the whole content and continues to grow: for a file whose parts are worthless.
    ///
    /// # Errors
    /// Errors of the system; the previous content is then unchanged.
    pub fn rewrite(&mut self, bytes: &[u8]) -> io::Result<()> {
        if !self.grows {
            return self.write_all(bytes);
        }
        let (at, mut file) = beside(&self.at, true)?;
        let written = (|| {
            file.write_all(bytes)?;
            file.set_permissions(self.file.metadata()?.permissions())?;
            file.sync_all()?;
            fs::rename(&at, &self.at)
        })();
        if let Err(error) = written {
            // A part of it is worthless.
            let _ = fs::remove_file(&at);
            self.state.has_failed.store(true, Ordering::Relaxed);
            return Err(self.state.with_place(error));
        }
        self.file = Arc::new(file);
        self.state.has_bytes.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// Gives the file its name, once its content is on the disk.
    ///
    /// # Errors
    /// Errors of the system; the old file is then unchanged.
    pub fn finish(mut self) -> io::Result<()> {
        self.end()
    }

    /// Finishes the file and returns it, still open, and locked if it was.
    ///
    /// # Errors
    /// Same as [`finish`](Self::finish).
    pub fn finish_open(mut self) -> io::Result<File> {
        self.end()?;
        self.file.try_clone()
    }

    /// Takes a lock that lasts while the file is open.
    ///
    /// # Errors
    /// Errors of the system, and [`io::ErrorKind::WouldBlock`] if another program holds the lock.
    pub fn try_lock(&self) -> io::Result<()> {
        if self.is_locked {
            Ok(())
        } else {
            Ok(self.file.try_lock()?)
        }
    }

    fn end(&mut self) -> io::Result<()> {
        // A partly written file must never get the name of a complete one.
        if self.state.has_failed.load(Ordering::Relaxed) {
            return Err(io::Error::other("it was not written to its end"));
        }
        if self.grows && !self.state.has_bytes.load(Ordering::Relaxed) {
            // No data was written; dropping the writer keeps the old file.
            return Ok(());
        }
        let named = self.take_name();
        named.map_err(|error| self.state.with_place(error))?;
        self.is_done = true;
        Ok(())
    }

    fn take_name(&mut self) -> io::Result<()> {
        let Some(target) = &self.target else {
            return Ok(());
        };
        // Renamed before its content is on the disk, the file could be empty after a power failure.
        if self.syncs {
            self.file.sync_all()?;
        }
        fs::rename(&self.at, target)?;
        self.at.clone_from(target);
        self.target = None;
        Ok(())
    }

    /// Removes a worthless file, and gives a complete one its name.
    fn abandon(&mut self) {
        let is_empty = !self.state.has_bytes.load(Ordering::Relaxed);
        let is_ours = self.grows || self.target.is_some();
        if !self.grows || is_empty {
            if is_ours {
                let _ = fs::remove_file(&self.at);
            }
            return;
        }
        let has_failed = self.state.has_failed.load(Ordering::Relaxed);
        // A panic, or another owner: it is unknown if the content is complete, so its part is kept
        // aside.
        if has_failed || self.is_shared || std::thread::panicking() {
            return;
        }
        if let Err(error) = self.end() {
            tracing::warn!(%error, "the file stays at {}", self.at.display());
        }
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.state.write(&self.file, bytes)?;
        if self.at_once && count > 0 {
            self.at_once = false;
            self.take_name()?;
        }
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if !self.is_done {
            self.abandon();
        }
    }
}

struct SharedWriter {
    file: Arc<File>,
    state: Arc<State>,
}

impl Write for SharedWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.state.write(&self.file, bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl State {
    fn write(&self, mut file: &File, bytes: &[u8]) -> io::Result<usize> {
        match file.write(bytes) {
            Ok(count) => {
                self.has_bytes.store(true, Ordering::Relaxed);
                Ok(count)
            }
            // `write_all` retries an interrupted write, so it is no failure.
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Err(error),
            Err(error) => {
                self.has_failed.store(true, Ordering::Relaxed);
                Err(self.with_place(error))
            }
        }
    }

    fn with_place(&self, error: io::Error) -> io::Error {
        match &self.partial {
            Some(partial) if self.has_bytes.load(Ordering::Relaxed) => {
                let place = partial.display();
                let told = format!("{error}; what was written before is in {place}");
                io::Error::new(error.kind(), told)
            }
            // Nothing was written, so there is no place to name.
            _ => error,
        }
    }
}

/// File to be replaced.
struct Old {
    permissions: Permissions,
    #[cfg(unix)]
    owner: (u32, u32),
}

impl Old {
    /// Finds the file and checks that it is writable; `None` if there is no such file.
    fn find(path: &Path) -> io::Result<Option<Self>> {
        let file = match File::options().append(true).open(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            file => file?,
        };
        let metadata = file.metadata()?;
        Ok(Some(Self {
            permissions: metadata.permissions(),
            #[cfg(unix)]
            owner: {
                use std::os::unix::fs::MetadataExt as _;
                (metadata.uid(), metadata.gid())
            },
        }))
    }

    fn pass_on(&self, file: &File) -> io::Result<()> {
        // Only the superuser may change owners; for others the new file simply stays theirs.
        #[cfg(unix)]
        let _ = std::os::unix::fs::fchown(file, Some(self.owner.0), Some(self.owner.1));
        file.set_permissions(self.permissions.clone())
    }
}

/// Creates a new file beside another one, so that it can be renamed.
fn beside(path: &Path, is_private: bool) -> io::Result<(PathBuf, File)> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    for _ in 0..MOST_ATTEMPTS {
        // Two threads of this process must not choose the same name.
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let at = named(path, &format!(".{}-{number}.new", std::process::id()));
        match new(&at, is_private) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            file => {
                let file = file?;
                // Some file systems do not support locks; there nothing is swept either.
                let _ = file.try_lock();
                return Ok((at, file));
            }
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Returns the name of a file that grows beside an existing target.
fn partial(path: &Path, number: u32) -> PathBuf {
    match number {
        1 => named(path, ".partial"),
        _ => named(path, &format!(".partial{number}")),
    }
}

/// Returns a path with `ending` appended, shortened if the name would be too long.
fn named(path: &Path, ending: &str) -> PathBuf {
    let name = path.file_name().unwrap_or_default();
    let mut longer = name.to_owned();
    longer.push(ending);
    if longer.len() > LONGEST_NAME {
        let name = name.to_string_lossy();
        let mut kept = name.len().min(LONGEST_NAME - ending.len());
        while !name.is_char_boundary(kept) {
            kept -= 1;
        }
        longer = name[..kept].into();
        longer.push(ending);
    }
    path.with_file_name(longer)
}

#[cfg_attr(not(unix), expect(unused_variables, reason = "modes are of Unix"))]
fn new(path: &Path, is_private: bool) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    if is_private {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    options.open(path)
}

/// Creates a new file and locks it.
fn reserve(path: &Path, is_private: bool) -> io::Result<File> {
    let file = new(path, is_private)?;
    // Some file systems do not support locks; there two writers of one file go unnoticed.
    let _ = file.lock();
    Ok(file)
}

fn is_locked(path: &Path) -> bool {
    let file = File::options().append(true).open(path);
    // Any other result, including a file system without locks, counts as free.
    file.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}

fn busy() -> io::Error {
    let busy = io::ErrorKind::ResourceBusy;
    io::Error::new(busy, "another program is writing to it")
}

#[cfg(test)]
mod tests;
