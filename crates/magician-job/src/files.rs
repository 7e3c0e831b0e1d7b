//! Files that others may be reading or writing.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write as _};
use std::path::Path;

/// Writes a file, and its directory, so that a reader finds the old or the new one, never half of it. A link stays a link.
///
/// # Errors
/// What the system reports; then the old one is there.
pub fn replace(path: &Path, text: &str) -> io::Result<()> {
    replace_by(
        path,
        text,
        File::options().write(true).create(true).truncate(true),
    )
}

/// As [`replace`], a file that its owner alone may read, where the system knows owners.
///
/// # Errors
/// As [`replace`].
pub fn replace_private(path: &Path, text: &str) -> io::Result<()> {
    let mut options = File::options();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    replace_by(path, text, &options)
}

fn replace_by(path: &Path, text: &str, options: &OpenOptions) -> io::Result<()> {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if let Some(directory) = path.parent() {
        fs::create_dir_all(directory)?;
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.new", std::process::id()));
    let fresh = path.with_file_name(name);
    let written = options.open(&fresh).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    let done = written.and_then(|()| fs::rename(&fresh, &path));
    if done.is_err() {
        // What is left of it is of no use.
        let _ = fs::remove_file(&fresh);
    }
    done
}

/// A file to write from its beginning, locked; one that another program is writing stays as it is.
///
/// # Errors
/// What the system reports, and [`io::ErrorKind::ResourceBusy`] for one that is locked.
pub fn create(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.write(true).create(true).truncate(false);
    let file = options.open(path)?;
    if file.metadata().is_ok_and(|metadata| metadata.is_file()) {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                let busy = io::ErrorKind::ResourceBusy;
                return Err(io::Error::new(busy, "another program is writing to it"));
            }
            // Some file systems know no locks.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        file.set_len(0)?;
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_as_a_whole_and_through_a_link() {
        let place = tempfile::tempdir().expect("a directory");
        let path = place.path().join("new/config.toml");
        replace(&path, "a = 1\n").expect("written");
        replace(&path, "a = 2\n").expect("written again");
        assert_eq!(fs::read_to_string(&path).expect("read"), "a = 2\n");
        let files = fs::read_dir(path.parent().expect("its place")).expect("read");
        assert_eq!(files.count(), 1);
    }

    #[test]
    fn a_file_that_is_being_written_is_left_alone() {
        let place = tempfile::tempdir().expect("a directory");
        let path = place.path().join("a.csv");
        let mut first = create(&path).expect("made");
        first.write_all(b"one").expect("written");
        let error = create(&path).expect_err("locked");
        assert_eq!(error.kind(), io::ErrorKind::ResourceBusy);
        assert_eq!(fs::read(&path).expect("read"), b"one");
        drop(first);
        drop(create(&path).expect("free"));
        assert_eq!(fs::read(&path).expect("read"), b"");
    }
}
