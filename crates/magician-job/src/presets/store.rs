//! Storage of presets.

use std::fmt;
#[cfg(feature = "files")]
use std::fs;
use std::io;
use std::path::PathBuf;

#[cfg(feature = "files")]
use crate::files::replace;

/// Storage for the texts of presets. [`Presets`](super::Presets) has checked the names.
pub trait PresetStore: fmt::Debug + Send + Sync {
    /// Names of the stored presets.
    fn names(&self) -> Vec<String>;

    /// Loads the text of a preset; `None` if it does not exist.
    ///
    /// # Errors
    /// The cause if it cannot be read.
    fn load(&self, name: &str) -> io::Result<Option<String>>;

    /// Stores a text, replacing an earlier one.
    ///
    /// # Errors
    /// The cause if it cannot be written.
    fn save(&self, name: &str, text: &str) -> io::Result<()>;

    /// Removes a preset; true if it existed.
    ///
    /// # Errors
    /// The cause if it cannot be removed.
    fn remove(&self, name: &str) -> io::Result<bool>;

    /// Path of a preset's file, if it is stored as one.
    fn path(&self, name: &str) -> Option<PathBuf> {
        let _ = name;
        None
    }
}

/// Presets as files `NAME.toml` in a folder.
#[cfg(feature = "files")]
#[derive(Clone, Debug)]
pub struct PresetFolder {
    folder: PathBuf,
}

#[cfg(feature = "files")]
impl PresetFolder {
    /// A store in this folder, which is created on the first save.
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
            // Too large for a preset: refuse it before reading.
            Ok(metadata) if metadata.len() > super::MAX_PRESET_SIZE as u64 => {
                Err(io::Error::other("it is too large for a preset"))
            }
            // Pipes and devices may never end.
            Ok(metadata) if !metadata.is_file() => {
                Err(io::Error::other("it is not a regular file"))
            }
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
