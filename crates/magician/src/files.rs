//! Files that are whole under their name: written beside it and renamed.
//!
//! Every file that a person names or keeps goes through [`WholeFile`], so that a full disk, a kill or a
//! power failure leaves the file that was there before, or the whole new one.

use std::fs::{self, File, OpenOptions, Permissions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

mod stumps;

use self::stumps::sweep;

/// Symbolic links that are followed, as many as Linux follows.
const MOST_LINKS: u32 = 40;
/// Longest name of a file on common file systems, bytes.
const LONGEST_NAME: usize = 255;
/// Parts of earlier recordings that are left alone before a person has to look at them.
const MOST_PARTIALS: u32 = 100;
/// Names that are tried for a file beside its target; others are of processes with the same id, as in
/// containers that share a folder.
const MOST_ATTEMPTS: u32 = 100;

/// Writes a file, and its directory, so that a reader finds the old or the new one, never half of it.
/// Mode and symbolic link of the old one are kept.
///
/// # Errors
/// What the system reports; then the old one is there.
pub fn replace(path: &Path, text: &str) -> io::Result<()> {
    make_directory(path)?;
    write_whole(path, text.as_bytes())
}

/// Replaces a file as [`replace`] does, but does not wait for the disk: for one that is written many
/// times a second. A killed program leaves the old or the new one; a power failure may leave an empty
/// one on some file systems.
///
/// # Errors
/// As [`replace`].
pub fn replace_unsynced(path: &Path, text: &str) -> io::Result<()> {
    make_directory(path)?;
    let mut file = WholeFile::create(path)?;
    file.syncs = false;
    file.write_all(text.as_bytes())?;
    file.finish()
}

/// Replaces a file as [`replace_unsynced`] does, and returns the new one, locked for as long as it is
/// open.
///
/// # Errors
/// As [`replace`].
pub fn replace_locked(path: &Path, text: &str) -> io::Result<File> {
    make_directory(path)?;
    let mut file = WholeFile::create(path)?;
    file.syncs = false;
    file.write_all(text.as_bytes())?;
    file.finish_open()
}

/// Writes a file in a directory that is there, so that it is whole or, after an error, as it was: a full
/// disk leaves the old file, and nothing beside it. Anything that is no plain file (a pipe, a device)
/// is written to as it is.
///
/// # Errors
/// What the system reports.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes)?;
    file.finish()
}

/// Checks that [`write_whole`] can write a file there, as far as possible before there is anything to
/// write, and leaves everything as it is.
///
/// # Errors
/// What the system reports.
pub fn check_writable(path: &Path) -> io::Result<()> {
    match Target::of(path)? {
        Target::File(_) => WholeFile::create(path).map(drop),
        // Opening a pipe would wait for its reader, and closing it end the reader.
        Target::Device(_) | Target::Descriptor(_) => Ok(()),
    }
}

/// Replaces a file that its owner alone may read, where the system knows owners.
///
/// # Errors
/// As [`replace`].
pub fn replace_private(path: &Path, text: &str) -> io::Result<()> {
    make_directory(path)?;
    rewrite_private(path, text)
}

/// Replaces a private file in a directory that is there.
///
/// # Errors
/// As [`replace`].
pub(crate) fn rewrite_private(path: &Path, text: &str) -> io::Result<()> {
    let mut file = WholeFile::create_private(path)?;
    file.write_all(text.as_bytes())?;
    file.finish()
}

fn make_directory(path: &Path) -> io::Result<()> {
    path.parent().map_or(Ok(()), fs::create_dir_all)
}

/// Target of a path: what its symbolic links lead to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// A plain file, or no file yet. A dangling link leads to the file that it names.
    File(PathBuf),
    /// A pipe or a device: written to as it is.
    Device(PathBuf),
    /// A file that this process has open (`/dev/stdout`). It may be a plain one, but whoever has it open
    /// would go on writing to the one that was replaced: what is written comes behind what is there.
    Descriptor(PathBuf),
}

impl Target {
    /// Follows the links of a path.
    ///
    /// # Errors
    /// What the system reports; [`io::ErrorKind::IsADirectory`] for a directory.
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

/// A file under way that gets its name when it is whole.
///
/// There are two kinds. One that is [created](Self::create) is worth nothing until it is finished:
/// dropped before, it leaves nothing behind. One that [grows](Self::grow), a trace or a recording, is
/// worth what has been written: dropped without an error it takes its name as if finished, and what a
/// killed program or a full disk leaves of it is kept.
///
/// Where there is no file of that name, a growing file grows under its name, so that others can follow
/// it and find it after a kill. Where there is one, that one stays until the new one is whole, which
/// grows beside it as `NAME.partial`.
#[derive(Debug)]
pub struct WholeFile {
    file: Arc<File>,
    /// Path that is written.
    at: PathBuf,
    /// Path that it gets when it is whole, if another one is written.
    target: Option<PathBuf>,
    grows: bool,
    syncs: bool,
    /// True if the first bytes that are written are enough to take the name.
    at_once: bool,
    /// True if a [`writer`](Self::writer) writes it: only its owner knows when it is whole.
    is_shared: bool,
    is_done: bool,
    /// True if it was locked as it was made, as far as the file system knows locks.
    is_locked: bool,
    state: Arc<State>,
}

#[derive(Debug, Default)]
struct State {
    has_bytes: AtomicBool,
    has_failed: AtomicBool,
    /// Named in an error: where what was written before is.
    partial: Option<PathBuf>,
}

impl WholeFile {
    /// Begins a file in a directory that is there. Mode and owner of the old one are kept.
    ///
    /// # Errors
    /// What the system reports: an old file without write permission is not replaced, whatever its
    /// directory allows.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::created(path, false)
    }

    /// Begins a file that its owner alone may read, where the system knows owners.
    ///
    /// # Errors
    /// As [`create`](Self::create).
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

    /// Begins a file that grows, locked until its end.
    ///
    /// # Errors
    /// What the system reports, and [`io::ErrorKind::ResourceBusy`] if another program is writing it.
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
                    // What an earlier program left is kept for a person to look at.
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

    /// Begins a growing file that takes its name with its first bytes: for a library, which is not told
    /// of the end of its program.
    ///
    /// # Errors
    /// As [`grow`](Self::grow).
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

    /// A writer of this file, for another owner. Now only [`finish`](Self::finish) gives the file its name.
    pub fn writer(&mut self) -> impl Write + Send + use<> {
        self.is_shared = true;
        SharedWriter {
            file: Arc::clone(&self.file),
            state: Arc::clone(&self.state),
        }
    }

    /// Writes everything anew, as a whole, and goes on to grow: for a file that is worth nothing in part.
    ///
    /// # Errors
    /// What the system reports; what was written before is there.
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
            // What is left of it is of no use.
            let _ = fs::remove_file(&at);
            self.state.has_failed.store(true, Ordering::Relaxed);
            return Err(self.state.with_place(error));
        }
        self.file = Arc::new(file);
        self.state.has_bytes.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// Gives the file its name; it is on the disk then.
    ///
    /// # Errors
    /// What the system reports; then the old file is there.
    pub fn finish(mut self) -> io::Result<()> {
        self.end()
    }

    /// Finishes the file and returns it, still open and locked if it was.
    ///
    /// # Errors
    /// As [`finish`](Self::finish).
    pub fn finish_open(mut self) -> io::Result<File> {
        self.end()?;
        self.file.try_clone()
    }

    /// Takes a lock that lasts as long as the file is open.
    ///
    /// # Errors
    /// What the system reports, and [`io::ErrorKind::WouldBlock`] if another program has it.
    pub fn try_lock(&self) -> io::Result<()> {
        if self.is_locked {
            Ok(())
        } else {
            Ok(self.file.try_lock()?)
        }
    }

    fn end(&mut self) -> io::Result<()> {
        if self.state.has_failed.load(Ordering::Relaxed) {
            return Err(io::Error::other("it was not written to its end"));
        }
        if self.grows && !self.state.has_bytes.load(Ordering::Relaxed) {
            // It never began; dropped, it leaves the old one.
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
        // Renamed before its bytes are on the disk, a file may be empty after a power failure.
        if self.syncs {
            self.file.sync_all()?;
        }
        fs::rename(&self.at, target)?;
        self.at.clone_from(target);
        self.target = None;
        Ok(())
    }

    /// Removes what is worth nothing; gives its name to what is whole.
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
            _ => error,
        }
    }
}

/// The file that is replaced.
struct Old {
    permissions: Permissions,
    #[cfg(unix)]
    owner: (u32, u32),
}

impl Old {
    /// Finds it and checks that it may be written; `None` if there is none.
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
        // Only the superuser may give files away; what others write is their own.
        #[cfg(unix)]
        let _ = std::os::unix::fs::fchown(file, Some(self.owner.0), Some(self.owner.1));
        file.set_permissions(self.permissions.clone())
    }
}

/// A new file beside another one, so that it can be renamed.
fn beside(path: &Path, is_private: bool) -> io::Result<(PathBuf, File)> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    for _ in 0..MOST_ATTEMPTS {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let at = named(path, &format!(".{}-{number}.new", std::process::id()));
        match new(&at, is_private) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            file => {
                let file = file?;
                // Some file systems know no locks; there nothing is swept either.
                let _ = file.try_lock();
                return Ok((at, file));
            }
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Name of a file that grows while another one has its name.
fn partial(path: &Path, number: u32) -> PathBuf {
    match number {
        1 => named(path, ".partial"),
        _ => named(path, &format!(".partial{number}")),
    }
}

/// A path with an ending more; of a long name as much as fits.
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

/// A new file, locked.
fn reserve(path: &Path, is_private: bool) -> io::Result<File> {
    let file = new(path, is_private)?;
    // Some file systems know no locks; then two programs that write one file are not told apart.
    let _ = file.lock();
    Ok(file)
}

fn is_locked(path: &Path) -> bool {
    let file = File::options().append(true).open(path);
    file.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}

fn busy() -> io::Error {
    let busy = io::ErrorKind::ResourceBusy;
    io::Error::new(busy, "another program is writing to it")
}

#[cfg(test)]
mod tests;
