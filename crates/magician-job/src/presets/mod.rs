//! Presets: named options for drawing and engraving, as files next to the user's settings file, or
//! wherever a [`PresetStore`] keeps them.
//!
//! The keys of a file are names of options ([`SetupOptions::keys`]), plus a `note` for people. Some
//! presets come with this crate; a file of the same name takes precedence.

mod report;
mod store;

use magician::message;
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
        let unused: Vec<_> = own.not_of(given.work).iter().map(|row| row.name).collect();
        let tool = match given.work {
            Some(WorkOption::Draw) => "laser",
            _ => "pen",
        };
        let unused = (!unused.is_empty())
            .then(|| format!("left out as options of a {tool}: {}", unused.join(", ")));
        let told: Vec<_> = self.note.iter().cloned().chain(unused).collect();
        let told = (!told.is_empty()).then(|| {
            let told = format!("preset {}: {}", self.name, told.join("; "));
            Diagnostic::of_file(told).coded(DiagnosticCode::Assumed)
        });
        Ok((options, told))
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
    Inexpressible(String),
    /// The system has no directory for presets.
    NoDirectory,
    /// The limit on presets is reached.
    TooMany,
    /// The file cannot be read or written.
    File(PathBuf, io::Error),
}

impl fmt::Display for PresetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => write!(
                f,
                "a preset cannot be called {name:?}: its name has letters, digits, - and _, at most {MAX_NAME_LENGTH}"
            ),
            Self::Unknown(name, known) => {
                write!(
                    f,
                    "there is no preset {name}; known are {}",
                    known.join(", ")
                )
            }
            Self::Shipped(name) => write!(
                f,
                "the preset {name} comes with this program and cannot be removed"
            ),
            Self::Broken { path, problem, .. } => write!(f, "{}: {problem}", path.display()),
            Self::Inexpressible(why) => f.write_str(why),
            Self::NoDirectory => f.write_str("there is no directory for presets"),
            Self::TooMany => write!(f, "{MAX_PRESETS} presets are kept at most: remove some"),
            Self::File(path, error) => write!(f, "{}: {error}", path.display()),
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
        parse(&text).map_err(|problem| PresetError::Inexpressible(problem.message.into()))?;
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
            let why = "it is too large for a preset".to_owned();
            return Err(PresetError::Inexpressible(why));
        }
        let (note, options) =
            parse(&text).map_err(|problem| PresetError::Inexpressible(problem.to_string()))?;
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
        SetupOptions::from_fields_of_some(&alone)
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
        return Err(PresetError::Inexpressible(message.into()));
    }
    let mut text = String::new();
    let mut put = |key: &str, value: &Value| {
        let value = toml::Value::try_from(value)
            .map_err(|error| PresetError::Inexpressible(format!("{key}: {error}")))?;
        text.push_str(&format!("{key} = {value}\n"));
        Ok(())
    };
    if let Some(note) = note {
        put(NOTE_KEY, &Value::from(note))?;
    }
    let said = options.to_fields();
    if said.is_empty() {
        return Err(PresetError::Inexpressible(
            "there is no option to save".to_owned(),
        ));
    }
    for (key, value) in &said {
        put(key, value)?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn options(fields: Value) -> SetupOptions {
        SetupOptions::from_fields(fields.as_object().expect("an object")).expect("options")
    }

    #[test]
    fn shipped_presets_are_valid_and_marked_untested() {
        let presets = Presets::default();
        let names = [
            "pen",
            "marker",
            "paper-cut",
            "wood-engrave",
            "leather-engrave",
        ];
        assert_eq!(presets.names(), names);
        for name in names {
            let preset = presets.load(name).expect(name);
            assert_eq!(preset.note.as_deref(), Some("not tried on a real arm"));
            assert!(preset.shipped && preset.path.is_none() && preset.options.tool.is_some());
        }
    }

    #[cfg(unix)]
    #[test]
    fn device_in_the_folder_is_listed_but_not_read() {
        let place = tempfile::tempdir().expect("a folder");
        let link = place.path().join("endless.toml");
        std::os::unix::fs::symlink("/dev/zero", link).expect("a link");
        let refused = Presets::at(place.path().to_owned()).load("endless");
        let told = refused.expect_err("no preset").to_string();
        assert!(told.contains("it is not a regular file"), "{told}");
    }

    #[test]
    fn saved_preset_overrides_the_shipped_one() {
        let place = tempfile::tempdir().expect("a directory");
        let presets = Presets::at(place.path().join("presets"));
        let said = options(
            serde_json::json!({"tool": [1, 2, -3.5], "power": "5..80", "order": false, "at": [200, 0], "fill": "hatch", "speed": 20}),
        );
        let saved = presets
            .save("pen", Some("my \"own\""), &said)
            .expect("it is saved");
        let loaded = presets.load("pen").expect("it is there");
        assert_eq!(loaded, saved);
        assert_eq!(
            (&loaded.options, loaded.note.as_deref()),
            (&said, Some("my \"own\""))
        );
        presets.save("oak_2", None, &said).expect("it is saved");
        assert_eq!(presets.names().last().map(String::as_str), Some("oak_2"));
        let left: Vec<_> = fs::read_dir(place.path().join("presets"))
            .expect("a folder")
            .collect();
        assert_eq!(left.len(), 2, "nothing but the two");
        presets.remove("pen").expect("the file goes");
        assert!(presets.load("pen").expect("the shipped one").path.is_none());
        assert!(matches!(
            presets.remove("pen"),
            Err(PresetError::Shipped(_))
        ));
        assert!(matches!(
            presets.remove("oak"),
            Err(PresetError::Unknown(..))
        ));
        assert!(matches!(presets.load("oak"), Err(PresetError::Unknown(..))));
    }

    #[test]
    fn invalid_preset_name_is_refused() {
        let place = tempfile::tempdir().expect("a directory");
        let presets = Presets::at(place.path().join("presets"));
        let said = options(serde_json::json!({"speed": 20}));
        let long = "a".repeat(65);
        for name in [
            "", ".", "..", "../x", "a/b", "a\\b", "/x", "-x", "a b", "ä", "x.toml", "NUL", "com1",
            "a\n", &long,
        ] {
            for outcome in [
                presets.load(name).map(drop),
                presets.save(name, None, &said).map(drop),
                presets.remove(name).map(drop),
            ] {
                assert!(matches!(outcome, Err(PresetError::Name(_))), "{name:?}");
            }
        }
        assert!(!place.path().join("presets").exists() && !place.path().join("x.toml").exists());
    }

    #[test]
    fn error_in_a_preset_file_has_its_position() {
        for (text, line, column, part) in [
            ("sped = 20", 1, 1, "no sped"),
            ("# mine\nspeed = 'fast'", 2, 9, "speed is a number"),
            ("speed = 20\nwork = 'draw'", 2, 1, "no work"),
            ("frame = 'box'", 1, 1, "no frame"),
            ("note = 3", 1, 8, "quoted"),
            ("speed = -1", 1, 9, "not -1"),
            ("lift = nan", 1, 8, "not nan"),
            ("power = 120", 1, 9, "power"),
            ("width = 10\nheight = 20", 2, 10, "contradict"),
            ("fill_spacing = 1", 1, 16, "needs fill"),
            ("travel-speed = 1\ntravel_speed = 2", 2, 1, "twice"),
            ("font = 'a.ttf'", 1, 8, "font"),
            ("speed = ", 1, 9, ""),
            ("[speed]\na = 1", 1, 1, "speed"),
        ] {
            let problem = parse(text).expect_err(text);
            let place = (problem.origin.line, problem.origin.column);
            assert_eq!(place, (line, column), "{text}: {problem}");
            assert!(problem.message.contains(part), "{text}: {problem}");
        }
        let (_, options) = parse("travel-speed = 90\nlift = 5").expect("flags' names are known");
        assert_eq!(options.travel_speed, Some(90.0));
    }

    #[test]
    fn bad_preset_option_has_the_common_error_sentence() {
        const TABLE: &str = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../magician-program/tests/data/bad_options.json"
        );
        /// Entries that no preset can contain: null, unknown keys, and options that a preset may
        /// not set.
        const INEXPRESSIBLE_ENTRIES: usize = 116;
        let table = fs::read_to_string(TABLE).expect("the table");
        let table: Vec<Value> = serde_json::from_str(&table).expect("JSON");
        let mut unsayable = 0;
        for entry in &table {
            let options = entry["options"].as_object().expect("options");
            let says = |(key, value): (&String, &Value)| {
                let is_known = SetupOptions::option(key).is_some();
                is_known && !EXCLUDED_OPTIONS.contains(&key.as_str()) && !value.is_null()
            };
            if !options.iter().all(says) {
                unsayable += 1;
                continue;
            }
            let text = toml::to_string(options).expect("TOML");
            // TOML writes NaN and infinity without quotes.
            let text = ["nan", "inf", "-inf"].iter().fold(text, |text, number| {
                text.replace(&format!("= \"{number}\""), &format!("= {number}"))
            });
            let problem = parse(&text).expect_err(&text);
            assert_eq!(entry["message"], problem.message.as_str(), "{text}");
        }
        assert_eq!(unsayable, INEXPRESSIBLE_ENTRIES, "of {}", table.len());
    }

    #[test]
    fn options_that_cannot_be_reloaded_are_not_saved() {
        let place = tempfile::tempdir().expect("a directory");
        let presets = Presets::at(place.path());
        let mut with_font = SetupOptions::default();
        with_font.font = Some(FontChoice::file("a.ttf", vec![0]));
        for said in [
            SetupOptions::default(),
            with_font,
            options(serde_json::json!({"work": "draw"})),
        ] {
            let refused = presets.save("mine", None, &said);
            assert!(
                matches!(refused, Err(PresetError::Inexpressible(_))),
                "{refused:?}"
            );
        }
        assert_eq!(fs::read_dir(place.path()).expect("a folder").count(), 0);
    }
}
