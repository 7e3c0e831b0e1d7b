//! Text files for a virtual arm, and the file of its flash memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use magician_sim::document::{self, DocumentError};
use magician_sim::{Flash, FlashError};

/// Error of a text file. The message continues after the file name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TextFileError {
    /// The file could not be read.
    #[error("cannot be read: {0}")]
    File(#[from] io::Error),
    /// The content is not text.
    #[error(transparent)]
    Document(#[from] DocumentError),
}

/// Error of a flash file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FlashFileError {
    /// The file exists but holds no flash; it was left unchanged.
    #[error("{} is damaged: {reason}", path.display())]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// Reason.
        reason: FlashError,
    },
    /// The file could not be read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Operation that failed.
        action: &'static str,
        /// Error of the system.
        source: io::Error,
    },
}

/// Reads a text file: a scenario, a profile, a flash. Reading stops at the size limit, so an
/// endless file does no harm.
///
/// # Errors
/// [`TextFileError`], whose message continues after the file name.
pub fn read_text(path: &Path) -> Result<String, TextFileError> {
    let mut bytes = Vec::new();
    // A byte more than allowed shows that a file is too large.
    let most = document::MOST_BYTES as u64 + 1;
    File::open(path)?.take(most).read_to_end(&mut bytes)?;
    Ok(document::text(bytes)?)
}

/// Reads a flash file; `None` if it does not exist.
///
/// # Errors
/// [`FlashFileError::Damaged`] if the file holds no flash, [`FlashFileError::File`] if it cannot be
/// read.
pub fn load_flash(path: &Path) -> Result<Option<Flash>, FlashFileError> {
    let damaged = |reason| FlashFileError::Damaged {
        path: path.to_owned(),
        reason,
    };
    let text = match read_text(path) {
        Ok(text) => text,
        Err(TextFileError::File(error)) if error.kind() == io::ErrorKind::NotFound => {
            return Ok(None);
        }
        Err(TextFileError::File(source)) => return Err(failed(path, "read", source)),
        Err(TextFileError::Document(error)) => return Err(damaged(error.into())),
    };
    Flash::from_toml(&text).map(Some).map_err(damaged)
}

/// Replaces a flash file. The old file stays until the new one is completely on the disk, so a
/// reader finds either of them, never a part. It contains the Wi-Fi password, so only its owner may
/// read it.
///
/// # Errors
/// [`FlashFileError::File`]; the old file is then unchanged.
pub fn save_flash(flash: &Flash, path: &Path) -> Result<(), FlashFileError> {
    crate::files::rewrite_private(path, &flash.to_toml())
        .map_err(|source| failed(path, "write", source))
}

fn failed(path: &Path, action: &'static str, source: io::Error) -> FlashFileError {
    FlashFileError::File {
        path: path.to_owned(),
        action,
        source,
    }
}
