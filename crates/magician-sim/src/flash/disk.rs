//! The flash as a file. Whoever reads it finds the old one or the new one, never a piece of either.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::{Flash, FlashError};
use crate::document::{self, DocumentError};

impl Flash {
    /// Reads a file; `None` when there is none.
    ///
    /// # Errors
    /// [`FlashError::Damaged`] for a file that holds no flash, [`FlashError::File`] when it cannot be read.
    pub fn load(path: &Path) -> Result<Option<Self>, FlashError> {
        let damaged = |reason| FlashError::Damaged {
            path: path.to_owned(),
            reason: Box::new(reason),
        };
        let text = match document::read(path) {
            Ok(text) => text,
            Err(DocumentError::File(error)) if error.kind() == io::ErrorKind::NotFound => {
                return Ok(None);
            }
            Err(DocumentError::File(source)) => return Err(failed(path, "read", source)),
            Err(error) => return Err(damaged(error.into())),
        };
        Self::from_toml(&text).map(Some).map_err(damaged)
    }

    /// Writes a file, in the place of what is there. Until it is complete on the disk what was there stays: it is
    /// written beside it first, as `FILE.new`. It holds the Wi-Fi password, so only its owner may read it.
    ///
    /// # Errors
    /// [`FlashError::File`]; then what was there is there still.
    pub fn save(&self, path: &Path) -> Result<(), FlashError> {
        // A symlink stays one.
        let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let beside = beside(path);
        let written = create(&beside).and_then(|mut file| {
            file.write_all(self.to_toml().as_bytes())?;
            file.sync_all()
        });
        written.map_err(|source| failed(&beside, "write", source))?;
        fs::rename(&beside, path).map_err(|source| failed(path, "replace", source))
    }
}

fn failed(path: &Path, action: &'static str, source: io::Error) -> FlashError {
    FlashError::File {
        path: path.to_owned(),
        action,
        source,
    }
}

fn beside(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".new");
    name.into()
}

fn create(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}
