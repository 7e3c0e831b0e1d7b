//! Presets: named options for drawing and engraving, as files next to the user's settings file, or
//! wherever a [`PresetStore`] keeps them.
//!
//! The keys of a file are names of options ([`SetupOptions::keys`]), plus a `note` for people. Some
//! presets come with this crate; a file of the same name takes precedence.

mod report;
mod store;

use magician::{Message, message};
use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use magician_program::{
    Diagnostic, DiagnosticCode, FontChoice, Format, Lines, OptionError, SetupOptions, WorkOption,
};
use serde_json::{Map, Value};
use toml::de::DeTable;

pub use report::{PresetList, PresetReport};
#[cfg(feature = "files")]
pub use store::PresetFolder;
pub use store::PresetStore;

/// Largest size of a preset, bytes. A choice far above any real preset.
const MAX_PRESET_SIZE: usize = 1 << 16;
/// Largest number of stored presets; shipped ones do not count.
const MAX_PRESETS: usize = 1000;
/// Longest name, bytes.
const MAX_NAME_LENGTH: usize = 64;
/// Key of the note.
const NOTE_KEY: &str = "note";
/// Options that a preset may not contain: the kind of work, and if it is done at all.
const EXCLUDED_OPTIONS: [&str; 3] = ["work", "frame", "frame_power"];
/// Device names that no file may have on Windows.
const WINDOWS_DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// Presets that come with this crate.
const SHIPPED_PRESETS: [(&str, &str); 5] = [
    ("pen", include_str!("../../presets/pen.toml")),
    ("marker", include_str!("../../presets/marker.toml")),
    ("paper-cut", include_str!("../../presets/paper-cut.toml")),
    (
        "wood-engrave",
        include_str!("../../presets/wood-engrave.toml"),
    ),
    (
        "leather-engrave",
        include_str!("../../presets/leather-engrave.toml"),
    ),
];

/// Named options.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Preset {
    /// Name of the preset.
    pub name: String,
    /// Note for people.
    pub note: Option<String>,
    /// Options that the preset sets.
    pub options: SetupOptions,
    /// True if it comes with this crate.
    pub shipped: bool,
    /// Path of its file, if it has one.
    pub path: Option<PathBuf>,
    /// Text of the file.
    pub text: String,
}

impl Preset {
    /// Completes `given` with the options of this preset, for a file of this format. Also returns a
    /// note for the user: the preset's note, and its options that do not apply to this kind of
    /// work.
    ///
    /// # Errors
    /// [`OptionError`] if the combined options contradict each other.
    pub fn complete(
        &self,
        given: &SetupOptions,
        format: Option<Format>,
    ) -> Result<(SetupOptions, Option<Diagnostic>), OptionError> {
        let mut own = self.options.clone();
        if format == Some(Format::TestGrid) {
            // A test grid defines its own powers and speeds.
            (own.power, own.speed) = (None, None);
        }
        let options = given.or(&own);
        options.check().map_err(|mut error| {
            error.message = message!(
                "with the preset {preset}: {why}",
                preset = self.name,
                why = &error.message
            );
            error
        })?;
        let unused: Vec<_> = own
            .not_applicable_to(given.work)
            .iter()
            .map(|row| row.name)
            .collect();
        let unused = (!unused.is_empty()).then(|| {
            let options = unused.join(", ");
            match given.work {
                Some(WorkOption::Draw) => {
                    message!("left out as options of a laser: {options}", options)
                }
                _ => message!("left out as options of a pen: {options}", options),
            }
        });
        let notes = Message::joined(self.note.iter().map(Message::from).chain(unused));
        let note = notes.map(|notes| {
            let note = message!("preset {name}: {notes}", name = self.name, notes);
            Diagnostic::of_file(note).coded(DiagnosticCode::Assumed)
        });
        Ok((options, note))
    }
}

/// Error of a preset.
#[derive(Debug)]
#[non_exhaustive]
pub enum PresetError {
    /// The name is not allowed.
    Name(String),
    /// No preset has this name; the second field lists the known names.
    Unknown(String, Vec<String>),
    /// The preset comes with this crate and cannot be removed.
    Shipped(String),
    /// The file has a mistake.
    Broken {
        /// Path of the file.
        path: PathBuf,
        /// Text of the file.
        text: String,
        /// The mistake and its place.
        problem: Box<Diagnostic>,
    },
    /// The options cannot be saved as a preset.
    Inexpressible(Message),
    /// The system has no directory for presets.
    NoDirectory,
    /// The limit on presets is reached.
    TooMany,
    /// The file cannot be read or written.
    File(PathBuf, io::Error),
}

impl PresetError {
    /// Error as a sentence.
    #[must_use]
    pub fn sentence(&self) -> Message {
        match self {
            Self::Name(name) => message!(
                "a preset cannot be called {name}: its name has letters, digits, - and _, at most {most}",
                name = format!("{name:?}"),
                most = MAX_NAME_LENGTH
            ),
            Self::Unknown(name, known) => message!(
                "there is no preset {name}; known are {known}",
                name,
                known = known.join(", ")
            ),
            Self::Shipped(name) => message!(
                "the preset {name} comes with this program and cannot be removed",
                name
            ),
            Self::Broken { path, problem, .. } => message!(
                "{path}: {why}",
                path = path.display().to_string(),
                why = problem.sentence()
            ),
            Self::Inexpressible(why) => why.clone(),
            Self::NoDirectory => message!("there is no directory for presets"),
            Self::TooMany => message!(
                "{most} presets are kept at most: remove some",
                most = MAX_PRESETS
            ),
            Self::File(path, error) => message!(
                "{path}: {why}",
                path = path.display().to_string(),
                why = error.to_string()
            ),
        }
    }
}

impl fmt::Display for PresetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // Escapes control characters of the file, unlike the sentence.
            Self::Broken { path, problem, .. } => write!(f, "{}: {problem}", path.display()),
            _ => f.write_str(&self.sentence()),
        }
    }
}

impl std::error::Error for PresetError {}

/// All presets: the ones shipped with this crate, and the ones in a store.
#[derive(Clone, Debug, Default)]
pub struct Presets {
    store: Option<Arc<dyn PresetStore>>,
}

impl Presets {
    /// Presets of this user: `presets`, next to the settings file ([`magician::arms::file`]).
    #[cfg(feature = "settings")]
    #[must_use]
    pub fn of_user() -> Self {
        let beside = magician::arms::file();
        let folder = beside.and_then(|file| Some(file.parent()?.join("presets")));
        folder.map_or_else(Self::default, Self::at)
    }

    /// Presets in a folder.
    #[cfg(feature = "files")]
    #[must_use]
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self::with_store(Arc::new(PresetFolder::at(folder)))
    }

    /// Presets in another store.
    #[must_use]
    pub fn with_store(store: Arc<dyn PresetStore>) -> Self {
        Self { store: Some(store) }
    }

    /// Names of all presets, shipped ones first.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = SHIPPED_PRESETS
            .iter()
            .map(|(name, _)| (*name).to_owned())
            .collect();
        let mut own = self.own_names();
        // A file that hides a shipped preset is listed at the shipped one's place.
        own.retain(|name| !names.contains(name));
        names.append(&mut own);
        names
    }

    /// Names of the presets in the store.
    fn own_names(&self) -> Vec<String> {
        let mut own = { self.store.as_ref() }.map_or_else(Vec::new, |store| store.names());
        own.retain(|name| is_name(name));
        own.sort_unstable();
        own
    }

    /// Loads the preset with this name.
    ///
    /// # Errors
    /// [`PresetError`].
    pub fn load(&self, name: &str) -> Result<Preset, PresetError> {
        check_name(name)?;
        let store = self.store.as_ref();
        let kept = store.map(|store| store.load(name)).transpose();
        let kept = kept
            .map_err(|error| self.write_error(name, error))?
            .flatten();
        let shipped = kept.is_none();
        let Some(text) = kept.or_else(|| shipped_text(name).map(str::to_owned)) else {
            return Err(PresetError::Unknown(name.to_owned(), self.names()));
        };
        let path = self.path(name).filter(|_| !shipped);
        let read = match text.len() {
            0..=MAX_PRESET_SIZE => parse(&text),
            _ => Err(Diagnostic::of_file(message!(
                "it is too large for a preset"
            ))),
        };
        let (note, options) = read.map_err(|problem| PresetError::Broken {
            path: path.clone().unwrap_or_else(|| name.into()),
            text: text.clone(),
            problem: Box::new(problem),
        })?;
        Ok(Preset {
            name: name.to_owned(),
            note,
            options,
            shipped,
            path,
            text,
        })
    }

    /// Saves options under a name, replacing a preset of that name.
    ///
    /// # Errors
    /// [`PresetError`].
    pub fn save(
        &self,
        name: &str,
        note: Option<&str>,
        options: &SetupOptions,
    ) -> Result<Preset, PresetError> {
        check_name(name)?;
        let text = to_text(note, options)?;
        // Options that could not be loaded again must not be saved.
        parse(&text).map_err(|problem| PresetError::Inexpressible(problem.message))?;
        self.save_text(name, text)
    }

    /// Saves the text of a preset file under a name, replacing a preset of that name.
    ///
    /// # Errors
    /// [`PresetError`].
    pub fn save_text(&self, name: &str, text: String) -> Result<Preset, PresetError> {
        check_name(name)?;
        let store = self.store.as_ref().ok_or(PresetError::NoDirectory)?;
        if text.len() > MAX_PRESET_SIZE {
            let why = message!("it is too large for a preset");
            return Err(PresetError::Inexpressible(why));
        }
        let (note, options) =
            parse(&text).map_err(|problem| PresetError::Inexpressible(problem.sentence()))?;
        let own = self.own_names();
        if own.len() >= MAX_PRESETS && !own.iter().any(|known| known == name) {
            return Err(PresetError::TooMany);
        }
        let kept = store.save(name, &text);
        kept.map_err(|error| self.write_error(name, error))?;
        Ok(Preset {
            name: name.to_owned(),
            note,
            options,
            shipped: false,
            path: self.path(name),
            text,
        })
    }

    /// Removes the file of a preset and returns its path. If it hid a preset that comes with this
    /// crate, that one applies again.
    ///
    /// # Errors
    /// [`PresetError`].
    pub fn remove(&self, name: &str) -> Result<Option<PathBuf>, PresetError> {
        check_name(name)?;
        let removed = { self.store.as_ref() }.map_or(Ok(false), |store| store.remove(name));
        if removed.map_err(|error| self.write_error(name, error))? {
            Ok(self.path(name))
        } else if shipped_text(name).is_some() {
            Err(PresetError::Shipped(name.to_owned()))
        } else {
            Err(PresetError::Unknown(name.to_owned(), self.names()))
        }
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        self.store.as_ref()?.path(name)
    }

    fn write_error(&self, name: &str, error: io::Error) -> PresetError {
        PresetError::File(self.path(name).unwrap_or_else(|| name.into()), error)
    }
}

fn check_name(name: &str) -> Result<(), PresetError> {
    if is_name(name) {
        Ok(())
    } else {
        Err(PresetError::Name(name.to_owned()))
    }
}

/// True if a preset can have this name on every system.
fn is_name(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    let numbered = |stem: &str| {
        let number = lower.strip_prefix(stem);
        number.is_some_and(|rest| rest.len() == 1 && rest.bytes().all(|byte| byte.is_ascii_digit()))
    };
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
    (1..=MAX_NAME_LENGTH).contains(&name.len())
        && name.bytes().all(plain)
        && !name.starts_with('-')
        && !WINDOWS_DEVICES.contains(&lower.as_str())
        && !numbered("com")
        && !numbered("lpt")
}

fn shipped_text(name: &str) -> Option<&'static str> {
    let mut all = SHIPPED_PRESETS.iter();
    all.find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// Parses the text of a preset file into its note and options; an error has its place.
fn parse(text: &str) -> Result<(Option<String>, SetupOptions), Diagnostic> {
    let lines = Lines::new(text);
    let spans = DeTable::parse(text).map_err(|error| {
        let place = lines.origin(error.span().unwrap_or_default());
        Diagnostic::new(place, error.message().trim().to_owned())
    })?;
    let mut values: Map<String, Value> =
        toml::from_str(text).map_err(|error| Diagnostic::of_file(error.message().trim()))?;
    let (mut fields, mut places) = (Map::new(), Vec::new());
    let mut note = None;
    for (key, span) in spans.get_ref() {
        let at_value = lines.origin(span.span());
        let value = match values.remove(key.get_ref().as_ref()) {
            // JSON has no NaN and no infinity: keep the text, so that the check names the option.
            None | Some(Value::Null) => text[span.span()].into(),
            Some(value) => value,
        };
        let name = key.get_ref().replace('-', "_");
        if name == NOTE_KEY {
            let Value::String(text) = value else {
                return Err(Diagnostic::new(
                    at_value,
                    message!("note: expected a quoted string"),
                ));
            };
            note = Some(text);
            continue;
        }
        if EXCLUDED_OPTIONS.contains(&name.as_str()) || !SetupOptions::keys().contains(&name) {
            let message = message!("a preset has no {option}", option = key.get_ref());
            return Err(Diagnostic::new(lines.origin(key.span()), message));
        }
        let alone = Map::from_iter([(name.clone(), value.clone())]);
        // A single option may need others next to it: that is checked below, on all of them.
        SetupOptions::from_partial_fields(&alone)
            .map_err(|error| Diagnostic::new(at_value, error.message))?;
        places.push((name.clone(), at_value));
        if fields.insert(name, value).is_some() {
            let message = message!("{option} is there twice", option = key.get_ref());
            return Err(Diagnostic::new(lines.origin(key.span()), message));
        }
    }
    let options = SetupOptions::from_fields(&fields).map_err(|error| {
        let place = places.iter().find(|(name, _)| *name == error.key);
        let place = place.map(|(_, place)| *place).unwrap_or_default();
        Diagnostic::new(place, error.message)
    })?;
    Ok((note, options))
}

/// Text of a preset file with these options.
fn to_text(note: Option<&str>, options: &SetupOptions) -> Result<String, PresetError> {
    if let Some(FontChoice::File { name, .. }) = &options.font {
        let message = message!("a preset cannot keep the font of a file: {name}", name);
        return Err(PresetError::Inexpressible(message));
    }
    let mut text = String::new();
    let mut put = |key: &str, value: &Value| {
        let value = toml::Value::try_from(value)
            .map_err(|error| PresetError::Inexpressible(format!("{key}: {error}").into()))?;
        text.push_str(&format!("{key} = {value}\n"));
        Ok(())
    };
    if let Some(note) = note {
        put(NOTE_KEY, &Value::from(note))?;
    }
    let said = options.to_fields();
    if said.is_empty() {
        return Err(PresetError::Inexpressible(message!(
            "there is no option to save"
        )));
    }
    for (key, value) in &said {
        put(key, value)?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests;
