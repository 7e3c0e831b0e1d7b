//! Files that people write for a virtual arm, the one that keeps its flash.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use magician_sim::document::{self, DocumentError};
use magician_sim::{Flash, FlashError};

/// Why a file cannot be taken as text. The message goes on after the file's name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TextFileError {
    /// The system did not let it be read.
    #[error("cannot be read: {0}")]
    File(#[from] io::Error),
    /// It is no text.
    #[error(transparent)]
    Document(#[from] DocumentError),
}

/// Why the file of a flash cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FlashFileError {
    /// The file is there and holds no flash; it was left as it is.
    #[error("{} is damaged: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: FlashError,
    },
    /// The system did not let it be read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: io::Error,
    },
}

/// Reads a file of text: a scenario, a profile, a flash. One that does not end is not read to its end.
///
/// # Errors
/// [`TextFileError`], whose message goes on after the file's name.
pub fn read_text(path: &Path) -> Result<String, TextFileError> {
    let mut bytes = Vec::new();
    let most = document::MOST_BYTES as u64 + 1;
    File::open(path)?.take(most).read_to_end(&mut bytes)?;
    Ok(document::text(bytes)?)
}

/// Reads the file of a flash; `None` when there is none.
///
/// # Errors
/// [`FlashFileError::Damaged`] for a file that holds no flash, [`FlashFileError::File`] when it cannot be read.
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

/// Writes the file of a flash, in the place of what is there. Until it is complete on the disk what was there stays: a reader
/// finds the old one or the new one, never a part of either. It holds the Wi-Fi password, so only its owner may read it.
///
/// # Errors
/// [`FlashFileError::File`]; then what was there is there still.
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
