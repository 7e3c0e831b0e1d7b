//! Where presets are kept.

use std::fmt;
#[cfg(feature = "files")]
use std::fs;
use std::io;
use std::path::PathBuf;

#[cfg(feature = "files")]
use crate::files::replace;

/// Keeps the texts of presets under their names, which [`Presets`](super::Presets) has checked.
pub trait PresetStore: fmt::Debug + Send + Sync {
    /// The names of those that are there.
    fn names(&self) -> Vec<String>;

    /// The text of one; nothing if it is not there.
    ///
    /// # Errors
    /// It cannot be read.
    fn load(&self, name: &str) -> io::Result<Option<String>>;

    /// Keeps this text, in the place of what was there.
    ///
    /// # Errors
    /// It cannot be kept.
    fn save(&self, name: &str, text: &str) -> io::Result<()>;

    /// Removes one; whether it was there.
    ///
    /// # Errors
    /// It cannot be removed.
    fn remove(&self, name: &str) -> io::Result<bool>;

    /// The file of one, if it is one.
    fn path(&self, name: &str) -> Option<PathBuf> {
        let _ = name;
        None
    }
}

/// Presets as files of a folder: `NAME.toml`.
#[cfg(feature = "files")]
#[derive(Clone, Debug)]
pub struct PresetFolder {
    folder: PathBuf,
}

#[cfg(feature = "files")]
impl PresetFolder {
    /// In this folder, which is made when it is needed.
    #[must_use]
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.toml"))
    }
}

#[cfg(feature = "files")]
impl PresetStore for PresetFolder {
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let files = entries.map(|entry| entry.path());
        files
            .filter(|path| path.extension().is_some_and(|end| end == "toml"))
            .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
            .collect()
    }

    fn load(&self, name: &str) -> io::Result<Option<String>> {
        let file = self.file(name);
        match fs::metadata(&file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            // What is no preset is not read to its end.
            Ok(about) if about.len() > super::LARGEST as u64 => {
                Err(io::Error::other("it is too large for a preset"))
            }
            // A pipe may never end, nor a device.
            Ok(about) if !about.is_file() => Err(io::Error::other("it is not a regular file")),
            _ => fs::read_to_string(&file).map(Some),
        }
    }

    fn save(&self, name: &str, text: &str) -> io::Result<()> {
        replace(&self.file(name), text)
    }

    fn remove(&self, name: &str) -> io::Result<bool> {
        match fs::remove_file(self.file(name)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
            removed => removed.map(|()| true),
        }
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        Some(self.file(name))
    }
}
