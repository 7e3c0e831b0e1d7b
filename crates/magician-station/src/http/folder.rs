//! Library of programs as a folder.
//!
//! An upload is written to a part file, synced, and renamed: a program is always whole. Users may
//! put files into the folder themselves, so it is read anew for each request and nothing is cached.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, UNIX_EPOCH};

use magician::message;
use magician_program::Format;

use crate::Role;
use crate::library::{
    LibraryError, LibraryQuotas, LibraryUse, MAX_PROGRAM_SIZE, ProgramEntry, ProgramName,
    ProgramStore, Upload,
};

/// Prefix of part files. No program has a name that starts with a dot.
const PART_PREFIX: &str = ".part-";
/// A part file that was last written longer ago belongs to a process that is gone.
const STALE_PART_AGE: Duration = Duration::from_secs(3600);
/// Bytes of a file that suffice to recognise its format.
const FORMAT_HEAD_SIZE: u64 = 64 * 1024;

/// Library whose programs are the files of a folder. A program is replaced as a whole or stays as
/// it was, even if the disk is full or the process ends.
///
/// Files that users put there are programs if their names are valid. Links and everything else that
/// is not a regular file are ignored.
#[derive(Clone, Debug)]
pub struct ProgramFolder {
    path: PathBuf,
    parts: Arc<AtomicU64>,
    /// Held while a file takes its name, so that exactly one of two uploads creates a new name.
    rename_lock: Arc<Mutex<()>>,
    quotas: LibraryQuotas,
}

impl ProgramFolder {
    /// Opens this folder, which is created with the first program. Removes part files of processes
    /// that died.
    #[must_use]
    pub fn at(path: impl Into<PathBuf>) -> Self {
        let folder = Self {
            path: path.into(),
            parts: Arc::default(),
            rename_lock: Arc::default(),
            quotas: LibraryQuotas::default(),
        };
        folder.remove_stale_parts();
        folder
    }

    /// Sets the quotas.
    #[must_use]
    pub const fn with_quotas(mut self, quotas: LibraryQuotas) -> Self {
        self.quotas = quotas;
        self
    }

    fn remove_stale_parts(&self) {
        let items = fs::read_dir(&self.path).into_iter().flatten().flatten();
        for item in items {
            let is_part = item.file_name().to_string_lossy().starts_with(PART_PREFIX);
            let age = { item.metadata().and_then(|data| data.modified()) }
                .ok()
                .and_then(|at| at.elapsed().ok());
            // A young part may belong to another station that is running.
            if is_part && age.is_some_and(|age| age > STALE_PART_AGE) {
                // Left for the next start if it fails.
                let _ = fs::remove_file(item.path());
            }
        }
    }

    fn file(&self, name: &ProgramName) -> PathBuf {
        self.path.join(name.as_str())
    }

    /// Returns the names in the folder that are valid names of programs, including those of links
    /// and folders.
    fn names(&self) -> Result<impl Iterator<Item = ProgramName> + use<>, LibraryError> {
        let items = match fs::read_dir(&self.path) {
            Ok(items) => Some(items),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(failed(error)),
        };
        let items = items.into_iter().flatten().flatten();
        Ok(items.filter_map(|item| ProgramName::new(item.file_name().to_str()?)))
    }

    /// Returns the use by all other programs, and the size of this one if it exists.
    fn use_by_others(&self, name: &ProgramName) -> Result<(LibraryUse, Option<u64>), LibraryError> {
        let mut others = LibraryUse::default();
        for other in self.names()?.filter(|other| other != name) {
            if let Ok(data) = self.metadata_of(&other) {
                others = others.with(data.len());
            }
        }
        Ok((others, self.metadata_of(name).map(|data| data.len()).ok()))
    }

    /// Returns the metadata of a regular file with this name.
    fn metadata_of(&self, name: &ProgramName) -> Result<fs::Metadata, LibraryError> {
        // Not `metadata`: a link must not lead out of the folder.
        let metadata = fs::symlink_metadata(self.file(name)).map_err(failed)?;
        if metadata.is_file() {
            Ok(metadata)
        } else {
            Err(LibraryError::Unknown)
        }
    }

    fn entry(&self, name: ProgramName) -> Option<ProgramEntry> {
        let metadata = self.metadata_of(&name).ok()?;
        let modified = metadata.modified().ok()?;
        let since = modified.duration_since(UNIX_EPOCH).unwrap_or_default();
        // The format is taken from the name if possible, which saves opening the file.
        let format = Format::of(name.as_str(), b"").or_else(|| {
            let mut head = Vec::new();
            let file = File::open(self.file(&name)).ok()?;
            file.take(FORMAT_HEAD_SIZE).read_to_end(&mut head).ok()?;
            Format::of(name.as_str(), &head)
        });
        Some(ProgramEntry {
            bytes: metadata.len(),
            modified: since.as_secs_f64(),
            format,
            name,
        })
    }
}

impl ProgramStore for ProgramFolder {
    fn folder(&self) -> Option<&Path> {
        Some(&self.path)
    }

    fn list(&self) -> Result<Vec<ProgramEntry>, LibraryError> {
        let mut entries: Vec<_> = { self.names()? }
            .filter_map(|name| self.entry(name))
            .collect();
        entries.sort_by(|one, other| one.name.cmp(&other.name));
        Ok(entries)
    }

    fn open(&self, name: &ProgramName) -> Result<(u64, Box<dyn Read + Send>), LibraryError> {
        self.metadata_of(name)?;
        let file = File::open(self.file(name)).map_err(failed)?;
        let metadata = file.metadata().map_err(failed)?;
        // A file that grows meanwhile is read up to its present size, which was already sent as the
        // length.
        let size = metadata.len();
        Ok((size, Box::new(file.take(size))))
    }

    fn upload(
        &self,
        name: &ProgramName,
        by: Role,
        length: Option<u64>,
    ) -> Result<Box<dyn Upload>, LibraryError> {
        if length.is_some_and(|length| length > MAX_PROGRAM_SIZE) {
            return Err(LibraryError::TooLarge);
        }
        let (others, before) = self.use_by_others(name)?;
        let checked = self.quotas.check(by, others, before, length.unwrap_or(0));
        checked.map_err(LibraryError::Quota)?;
        fs::create_dir_all(&self.path).map_err(failed)?;
        let part = self.parts.fetch_add(1, Ordering::Relaxed);
        // The process id keeps parts of several stations apart.
        let part = format!("{PART_PREFIX}{}-{part}", std::process::id());
        let part = self.path.join(part);
        let mut options = OpenOptions::new();
        // `create_new` fails instead of opening another upload's part.
        options.write(true).create_new(true);
        let file = options.open(&part).map_err(failed)?;
        Ok(Box::new(Part {
            file: Some(file),
            path: part,
            name: name.clone(),
            by,
            written: 0,
            room: self.quotas.room(by, others, before),
            folder: self.clone(),
        }))
    }

    fn delete(&self, name: &ProgramName) -> Result<(), LibraryError> {
        let _alone = self
            .rename_lock
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        self.metadata_of(name)?;
        fs::remove_file(self.file(name)).map_err(failed)
    }
}

/// Upload in progress, in a part file.
struct Part {
    file: Option<File>,
    path: PathBuf,
    name: ProgramName,
    by: Role,
    written: u64,
    /// Bytes that the quota had free when the upload started.
    room: u64,
    folder: ProgramFolder,
}

impl Part {
    fn check_room(&self) -> Result<(), LibraryError> {
        let (others, before) = self.folder.use_by_others(&self.name)?;
        let checked = { &self.folder.quotas }.check(self.by, others, before, self.written);
        checked.map_err(LibraryError::Quota)
    }
}

impl Upload for Part {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LibraryError> {
        self.written += bytes.len() as u64;
        // Checked again, because the client may have declared a wrong length or none.
        if self.written > MAX_PROGRAM_SIZE {
            return Err(LibraryError::TooLarge);
        }
        if self.written > self.room {
            // Other programs may have been removed since.
            self.check_room()?;
        }
        let Some(file) = &mut self.file else {
            return Err(LibraryError::Unknown);
        };
        file.write_all(bytes).map_err(failed)
    }

    fn finish(mut self: Box<Self>) -> Result<bool, LibraryError> {
        if let Some(file) = self.file.take() {
            // Before the rename: after a power failure the name must not lead to an empty file.
            file.sync_all().map_err(failed)?;
        }
        let (folder, to) = (self.folder.clone(), self.folder.file(&self.name));
        let _alone = { folder.rename_lock.lock() }.unwrap_or_else(PoisonError::into_inner);
        // Checked again under the lock, because several uploads may have started with the same
        // room.
        self.check_room()?;
        let is_new = match fs::symlink_metadata(&to) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => true,
            Ok(there) if there.is_dir() => {
                let why = message!("a folder has this name");
                return Err(LibraryError::Other(why));
            }
            // A program of this name is replaced, and so is a link.
            _ => false,
        };
        fs::rename(&self.path, to).map_err(failed)?;
        // The part has become the program: dropping must not remove it.
        self.path.clear();
        Ok(is_new)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // Closed first, because Windows does not remove a file that is open.
        self.file = None;
        if !self.path.as_os_str().is_empty() {
            let _ = fs::remove_file(&self.path);
        }
    }
}

fn failed(error: io::Error) -> LibraryError {
    match error.kind() {
        io::ErrorKind::NotFound => LibraryError::Unknown,
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
            LibraryError::Full
        }
        // Permissions and failures of the disk.
        _ => LibraryError::Other(error.to_string().into()),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::library::{bytes_of, store_program};

    fn name(text: &str) -> ProgramName {
        ProgramName::new(text).expect(text)
    }

    fn files(place: &Path) -> usize {
        fs::read_dir(place).unwrap().count()
    }

    #[test]
    fn upload_is_stored_completely_or_not_at_all() {
        let place = tempfile::tempdir().unwrap();
        let folder = ProgramFolder::at(place.path().join("new"));
        assert_eq!(folder.list(), Ok(Vec::new()));
        let house = name("house.svg");
        assert_eq!(
            store_program(&folder, &house, Role::Student, b"<svg/>"),
            Ok(true)
        );
        assert_eq!(
            store_program(&folder, &house, Role::Student, b"<svg />"),
            Ok(false)
        );
        assert_eq!(bytes_of(&folder, &house).unwrap(), b"<svg />");
        // A dropped upload leaves no file, nor does an upload that is too large.
        let mut upload = folder.upload(&house, Role::Student, None).unwrap();
        upload.write(b"half").unwrap();
        assert_eq!(files(&place.path().join("new")), 2);
        drop(upload);
        let mut upload = folder.upload(&name("large"), Role::Student, None).unwrap();
        let piece = vec![0; 1 << 20];
        for _ in 0..64 {
            upload.write(&piece).unwrap();
        }
        assert_eq!(upload.write(&[0]), Err(LibraryError::TooLarge));
        drop(upload);
        assert_eq!(files(&place.path().join("new")), 1);
        assert_eq!(bytes_of(&folder, &house).unwrap(), b"<svg />");
        let listed = folder.list().unwrap();
        assert_eq!(
            (listed.len(), listed[0].bytes, listed[0].format),
            (1, 7, Some(Format::Svg))
        );
        assert!(listed[0].modified > 1e9);
        assert_eq!(folder.delete(&house), Ok(()));
        assert_eq!(folder.delete(&house), Err(LibraryError::Unknown));
        assert_eq!(bytes_of(&folder, &house), Err(LibraryError::Unknown));
    }

    /// Step of the test: an upload with or without a declared length, or a removal.
    #[derive(Clone, Debug)]
    struct Act {
        name: u8,
        by: Role,
        bytes: usize,
        declares_length: bool,
        removes: bool,
    }

    fn acts() -> impl Strategy<Value = Vec<Act>> {
        let by = prop_oneof![Just(Role::Student), Just(Role::Teacher)];
        let act = (
            0..14_u8,
            by,
            0..40_usize,
            any::<bool>(),
            prop::bool::weighted(0.15),
        );
        let act = act.prop_map(|(name, by, bytes, declares_length, removes)| Act {
            name,
            by,
            bytes,
            declares_length,
            removes,
        });
        prop::collection::vec(act, 1..80)
    }

    fn library_use(folder: &ProgramFolder) -> LibraryUse {
        let entries = folder.list().unwrap();
        entries
            .iter()
            .fold(LibraryUse::default(), |sum, entry| sum.with(entry.bytes))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// For any sequence of uploads: the library never exceeds the quota `all`, students never
        /// fill it beyond the quota `students`, and a refusal is correct and changes nothing.
        #[test]
        fn student_quota_reserves_room_for_teachers(acts in acts()) {
            let (students, all) = (
                LibraryUse { programs: 6, bytes: 150 },
                LibraryUse { programs: 9, bytes: 240 },
            );
            let place = tempfile::tempdir().unwrap();
            let folder = ProgramFolder::at(place.path()).with_quotas(LibraryQuotas { students, all });
            for act in acts {
                let name = name(&format!("p{}", act.name));
                if act.removes {
                    let _ = folder.delete(&name);
                    continue;
                }
                let before = library_use(&folder);
                let old_size = folder.metadata_of(&name).ok().map(|data| data.len());
                let bytes = vec![b'x'; act.bytes];
                let length = act.declares_length.then_some(act.bytes as u64);
                let put = || {
                    let mut upload = folder.upload(&name, act.by, length)?;
                    for piece in bytes.chunks(7) {
                        upload.write(piece)?;
                    }
                    upload.finish()
                };
                let outcome = put();
                let after = library_use(&folder);
                prop_assert!(after.programs <= all.programs && after.bytes <= all.bytes);
                let grows = old_size.is_none_or(|old_size| act.bytes as u64 > old_size);
                match outcome {
                    Ok(is_new) => {
                        prop_assert_eq!(is_new, old_size.is_none());
                        if act.by == Role::Student && grows {
                            prop_assert!(after.bytes <= students.bytes, "{:?}", after);
                            prop_assert!(!is_new || after.programs <= students.programs);
                        }
                    }
                    Err(LibraryError::Quota(exceeded)) => {
                        let level = if act.by == Role::Student { students } else { all };
                        prop_assert_eq!(
                            (exceeded.quota, exceeded.used, after),
                            (level, before, before)
                        );
                        prop_assert!(grows, "what does not grow is taken");
                        let too_many = old_size.is_none()
                            && before.programs == level.programs.max(before.programs);
                        let others = before.bytes - old_size.unwrap_or(0);
                        prop_assert!(too_many || others + act.bytes as u64 > level.bytes);
                    }
                    Err(other) => prop_assert!(false, "{}", other),
                }
                // No part file is left over.
                prop_assert_eq!(files(place.path()), after.programs);
            }
        }
    }

    #[test]
    fn open_program_is_unchanged_by_its_replacement() {
        let place = tempfile::tempdir().unwrap();
        let folder = ProgramFolder::at(place.path());
        store_program(&folder, &name("a"), Role::Student, b"old").unwrap();
        let (size, mut from) = folder.open(&name("a")).unwrap();
        store_program(&folder, &name("a"), Role::Student, b"newer").unwrap();
        let mut read = Vec::new();
        from.read_to_end(&mut read).unwrap();
        assert_eq!((size, read.as_slice()), (3, &b"old"[..]));
    }

    #[test]
    fn stale_part_files_are_removed() {
        let place = tempfile::tempdir().unwrap();
        for (part, age) in [("1-0", STALE_PART_AGE * 2), ("2-0", STALE_PART_AGE / 2)] {
            let file = File::create(place.path().join(format!("{PART_PREFIX}{part}"))).unwrap();
            let then = std::time::SystemTime::now() - age;
            file.set_modified(then).unwrap();
        }
        let _folder = ProgramFolder::at(place.path());
        assert!(!place.path().join(format!("{PART_PREFIX}1-0")).exists());
        // Young enough to be in progress.
        assert!(place.path().join(format!("{PART_PREFIX}2-0")).exists());
    }

    #[cfg(unix)]
    #[test]
    fn links_folders_and_hidden_files_are_not_listed() {
        let place = tempfile::tempdir().unwrap();
        let outside = place.path().join("secret");
        fs::write(&outside, "secret").unwrap();
        let inside = place.path().join("programs");
        fs::create_dir(&inside).unwrap();
        std::os::unix::fs::symlink(&outside, inside.join("link")).unwrap();
        fs::create_dir(inside.join("folder")).unwrap();
        fs::write(inside.join(".hidden"), "").unwrap();
        fs::write(inside.join("with\ttab"), "").unwrap();
        let folder = ProgramFolder::at(&inside);
        assert_eq!(folder.list(), Ok(Vec::new()));
        assert!(folder.open(&name("link")).is_err());
        assert!(folder.delete(&name("folder")).is_err());
        assert!(folder.delete(&name("link")).is_err());
        assert!(inside.join("link").is_symlink());
        assert!(store_program(&folder, &name("folder"), Role::Student, b"x").is_err());
        // Replacing a link creates a file and leaves the link's target alone.
        store_program(&folder, &name("link"), Role::Student, b"mine").unwrap();
        assert_eq!(fs::read(&outside).unwrap(), b"secret");
        assert_eq!(bytes_of(&folder, &name("link")).unwrap(), b"mine");
    }
}
