//! The user's settings file: its values, and edits that keep the rest of it as its owner wrote it.
//!
//! The names allowed in it are defined by the program that shows them.
//!
//! Edits work on the text and return a copy; [`SettingsFile::change`] checks the result and writes
//! it as a whole, so a failed edit leaves the file unchanged.

mod edit;

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use magician::{Message, message};
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::de::DeTable;

use crate::files::{read_text, replace};

/// Largest size of a settings file, bytes. A choice far above any real file.
const MAX_FILE_SIZE: u64 = 1 << 20;

/// Text of a settings file; empty if the file does not exist.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SettingsFile {
    path: Option<PathBuf>,
    text: String,
}

/// Error of a settings file.
#[derive(Debug)]
#[non_exhaustive]
pub enum SettingsError {
    /// The file cannot be read, or is too large.
    Unreadable(PathBuf, String),
    /// The file is not TOML, or a value has the wrong type.
    Broken(PathBuf, String),
    /// The system has no directory for settings.
    NoDirectory,
    /// The place to change is written in a way that [`SettingsFile`] cannot edit.
    NotEditable(PathBuf),
    /// The file cannot be written.
    Unwritable(PathBuf, io::Error),
}

impl SettingsError {
    /// Error as a sentence.
    #[must_use]
    pub fn sentence(&self) -> Message {
        let shown = |path: &Path| path.display().to_string();
        match self {
            Self::Unreadable(path, why) => {
                message!("{path} cannot be read: {why}", path = shown(path), why)
            }
            Self::Broken(path, why) => message!("{path}: {why}", path = shown(path), why),
            Self::NoDirectory => message!("this system has no directory for settings"),
            Self::NotEditable(path) => message!(
                "{path} cannot be edited by this program",
                path = shown(path)
            ),
            Self::Unwritable(path, why) => message!(
                "{path} cannot be written: {why}",
                path = shown(path),
                why = why.to_string()
            ),
        }
    }
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence())
    }
}

impl std::error::Error for SettingsError {}

impl SettingsFile {
    /// Reads this user's file ([`magician::arms::file`]).
    ///
    /// # Errors
    /// [`SettingsError::Unreadable`].
    pub fn load() -> Result<Self, SettingsError> {
        let path = magician::arms::file();
        let text = match &path {
            Some(path) => read(path)?,
            None => String::new(),
        };
        Ok(Self { path, text })
    }

    /// Path of the file, even if it does not exist yet.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Text of the file.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Text of the value of a name; dots separate the names of tables.
    #[must_use]
    pub fn written(&self, name: &str) -> Option<&str> {
        let (_, value) = edit::find(&self.text, name)??;
        self.text.get(value)
    }

    /// Value of a top-level name; `None` if absent.
    ///
    /// # Errors
    /// [`SettingsError::Broken`].
    pub fn value<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, SettingsError> {
        let broken = |why: String| {
            let path = self.path.clone();
            SettingsError::Broken(path.unwrap_or_else(|| "config.toml".into()), why)
        };
        let file: toml::Table = toml::from_str(&self.text)
            .map_err(|error| broken(error.message().trim().to_owned()))?;
        let value = file.get(name).map(|value| value.clone().try_into());
        value
            .transpose()
            .map_err(|error: toml::de::Error| broken(format!("{name}: {}", error.message())))
    }

    /// Copy with a new value for a name; `value` is TOML text. `None` if that is impossible.
    #[must_use]
    pub fn with(&self, name: &str, value: &str) -> Option<Self> {
        Some(self.of(edit::with(&self.text, name, value)?))
    }

    /// Copy with this table under its own header at the end. `None` if that is impossible.
    #[must_use]
    pub fn with_table(&self, name: &str, value: &impl Serialize) -> Option<Self> {
        let table = toml::Table::try_from(value).ok()?;
        Some(self.of(edit::with_table(&self.text, name, &table)?))
    }

    /// Copy without a name. `None` if that is impossible.
    #[must_use]
    pub fn without(&self, name: &str) -> Option<Self> {
        Some(self.of(edit::without(&self.text, name)?))
    }

    fn of(&self, text: String) -> Self {
        let path = self.path.clone();
        Self { path, text }
    }

    /// Applies an edit and writes the file.
    ///
    /// # Errors
    /// [`SettingsError::NoDirectory`]; [`SettingsError::NotEditable`] without an edit, or if it
    /// results in invalid TOML; [`SettingsError::Unwritable`]. The file is unchanged then.
    pub fn change(&mut self, edited: Option<Self>) -> Result<(), SettingsError> {
        let path = self.path.clone().ok_or(SettingsError::NoDirectory)?;
        // The edits work on text, so check that the result is still TOML.
        let edited = edited.filter(|edited| DeTable::parse(&edited.text).is_ok());
        let edited = edited.ok_or_else(|| SettingsError::NotEditable(path.clone()))?;
        replace(&path, &edited.text).map_err(|error| SettingsError::Unwritable(path, error))?;
        *self = edited;
        Ok(())
    }
}

/// Text as a TOML string.
#[must_use]
pub fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn read(path: &Path) -> Result<String, SettingsError> {
    let wrong = |why: String| SettingsError::Unreadable(path.to_owned(), why);
    match read_text(path, MAX_FILE_SIZE) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(String::new()),
        Err(error) => Err(wrong(error.to_string())),
        Ok(text) => text.ok_or_else(|| wrong("it is too large for a settings file".to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn file(path: &Path) -> SettingsFile {
        let text = read(path).expect("it can be read");
        let path = Some(path.to_owned());
        SettingsFile { path, text }
    }

    #[test]
    fn change_is_written_and_the_rest_preserved() {
        let place = tempfile::tempdir().expect("a directory");
        let path = place.path().join("deep").join("config.toml");
        let mut settings = file(&path);
        assert_eq!((settings.text(), settings.written("surface")), ("", None));
        settings
            .change(settings.with("surface", "-61.5"))
            .expect("it is written");
        settings
            .change(settings.with("tool", &quoted("1,2,3")))
            .expect("it is written");
        let again = file(&path);
        assert_eq!(again, settings);
        assert_eq!(
            again.value::<f64>("surface").expect("a number"),
            Some(-61.5)
        );
        assert_eq!(again.written("tool"), Some("\"1,2,3\""));
        settings
            .change(settings.without("surface"))
            .expect("it is written");
        assert_eq!(
            fs::read_to_string(&path).expect("it is there"),
            "tool = \"1,2,3\"\n"
        );
    }

    #[test]
    fn edit_with_invalid_toml_changes_nothing() {
        let place = tempfile::tempdir().expect("a directory");
        let path = place.path().join("config.toml");
        fs::write(&path, "tool = \"pen\"\n").expect("it is written");
        let mut settings = file(&path);
        for edited in [None, settings.with("surface", "high")] {
            let error = settings.change(edited).expect_err("it is refused");
            assert!(matches!(error, SettingsError::NotEditable(_)), "{error}");
        }
        assert_eq!(file(&path), settings);
        let error = settings.value::<f64>("tool").expect_err("no number");
        assert!(error.to_string().contains("config.toml: tool: "), "{error}");
        let error = SettingsFile::default().change(Some(settings));
        assert!(matches!(error, Err(SettingsError::NoDirectory)));
    }
}
