//! Files that others may be reading or writing.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

pub use magician::files::{check_writable, replace, replace_private, write_whole};

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
    use std::fs;
    use std::io::Write as _;

    use super::*;

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
