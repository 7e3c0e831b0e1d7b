//! The user's settings file, as `magician config` shows and edits it.
//!
//! Flags override environment variables, which override the file; a setting without any of them has
//! its default. Edits keep the rest of the file as it is, and an edit that would make the file
//! invalid is refused before it is written.

pub(crate) mod arms;
mod keys;

use std::path::Path;

use magician::Target;
use magician::arms::KnownArm;
use magician_job::settings::{SettingsError, SettingsFile};
use magician_job::surface_of;
use magician_program::{Diagnostic, Lines, Power, Surface};
use serde::Serialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::diagnostics::{self, Severity};
use crate::failure::Failure;
pub(crate) use keys::{KEYS, Key, list};

/// Settings of a file. A missing file counts as empty.
#[derive(Debug, Default)]
pub(crate) struct Config {
    file: SettingsFile,
    /// Values of the file in the notation that users type.
    values: Vec<(&'static str, String)>,
    /// Arms that the file describes.
    arms: Vec<KnownArm>,
}

/// Origin of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Source {
    Environment,
    File,
    Default,
}

impl Config {
    /// Reads the settings file of this user.
    pub(crate) fn load() -> Result<Self, Failure> {
        let file = SettingsFile::load().map_err(|error| Failure::invalid(error.to_string()))?;
        Self::from_file(file)
    }

    fn from_file(file: SettingsFile) -> Result<Self, Failure> {
        let (values, arms) = check(file.text()).map_err(|problem| {
            let name = file.path().unwrap_or(Path::new("config.toml"));
            invalid_file(name, file.text(), &problem)
        })?;
        Ok(Self { file, values, arms })
    }

    /// Path of the file, also if it does not exist yet; `None` if there is no home directory.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.file.path()
    }

    /// Returns the file's value of a setting, or `None` if it is not set.
    pub(crate) fn file_value(&self, name: &str) -> Option<&str> {
        let mut values = self.values.iter();
        let (_, value) = values.find(|(known, _)| *known == name)?;
        Some(value)
    }

    /// Returns the value from the environment, else from the file.
    pub(crate) fn value(&self, key: &Key) -> Option<(String, Source)> {
        let variable = key.variable.and_then(|name| std::env::var(name).ok());
        let variable = variable.filter(|value| !value.is_empty());
        let file = || {
            self.file_value(key.name)
                .map(|value| (value.to_owned(), Source::File))
        };
        variable
            .map(|value| (value, Source::Environment))
            .or_else(file)
    }

    /// False if `[arms.NAME] laser = false` is set for the arm at this port; true if unknown.
    pub(crate) fn laser_is_mounted(&self, port: Option<&str>) -> bool {
        let port = port.and_then(|port| port.parse::<Target>().ok());
        let known = port.and_then(|port| self.arm_at(&port));
        known.is_none_or(|arm| arm.laser)
    }

    /// Returns the settings of the arm at this port.
    pub(crate) fn arm_at(&self, port: &Target) -> Option<&KnownArm> {
        magician::arms::at(&self.arms, port)
    }

    /// Returns all arms that the file describes.
    pub(crate) fn arms(&self) -> &[KnownArm] {
        &self.arms
    }

    /// Returns the value of an arm's setting as the file writes it, without quotes.
    pub(crate) fn arm_value(&self, name: &str) -> Option<&str> {
        let value = self.file.written(name)?;
        let bare = value
            .strip_prefix(['"', '\''])
            .and_then(|text| text.strip_suffix(['"', '\'']));
        Some(bare.unwrap_or(value))
    }

    /// Sets or, with `None`, removes a setting of an arm. `value` is in TOML.
    pub(crate) fn set_arm_value(&mut self, name: &str, value: Option<&str>) -> Result<(), Failure> {
        let edited = match value {
            Some(value) => self.file.with(name, value),
            None => self.file.without(name),
        };
        // Check the value first: `change` would report an invalid one as a file that cannot be
        // edited, which says less.
        if let Some(edited) = &edited {
            Self::from_file(edited.clone())?;
        }
        let is_set = value.is_some();
        self.change(edited, |config| config.arm_value(name).is_some() == is_set)
    }

    /// Returns a numeric setting of the file, whose syntax was checked when the file was loaded.
    pub(crate) fn number(&self, name: &str) -> Option<f64> {
        self.file_value(name)?.parse().ok()
    }

    /// Returns the plane of the work surface from the file.
    pub(crate) fn surface(&self) -> Result<Option<Surface>, Failure> {
        surface_of(&self.file).map_err(|error| Failure::invalid(error.to_string()))
    }

    /// Returns a list of texts from the file; empty if it is not set.
    pub(crate) fn list(&self, name: &str) -> Vec<String> {
        let text = self.file_value(name).unwrap_or_default();
        list(text).map(str::to_owned).collect()
    }

    /// Returns a laser power from the file.
    pub(crate) fn power(&self, name: &str) -> Option<Power> {
        self.file_value(name)?.parse().ok()
    }

    /// Deserializes a table that another verb has written.
    pub(crate) fn table<T: serde::de::DeserializeOwned>(
        &self,
        name: &str,
    ) -> Result<Option<T>, Failure> {
        self.file.value(name).map_err(|error| {
            Failure::invalid(error.to_string())
                .hint(format!("`magician config unset {name}` removes it"))
        })
    }

    /// Sets a setting. `value` is in TOML.
    pub(crate) fn set(&mut self, name: &str, value: &str) -> Result<(), Failure> {
        self.change(self.file.with(name, value), |config| {
            config.file_value(name).is_some()
        })
    }

    /// Sets a setting to a table under its own header.
    pub(crate) fn set_table(&mut self, name: &str, value: &impl Serialize) -> Result<(), Failure> {
        self.change(self.file.with_table(name, value), |config| {
            config.file_value(name).is_some()
        })
    }

    /// Removes a setting. Returns true if it was set.
    pub(crate) fn unset(&mut self, name: &str) -> Result<bool, Failure> {
        if self.file_value(name).is_none() {
            return Ok(false);
        }
        self.change(self.file.without(name), |config| {
            config.file_value(name).is_none()
        })?;
        Ok(true)
    }

    /// Writes the edited file if it is valid and `is_right` confirms the edit.
    fn change(
        &mut self,
        edited: Option<SettingsFile>,
        is_right: impl Fn(&Self) -> bool,
    ) -> Result<(), Failure> {
        let edited = edited
            .and_then(|file| Self::from_file(file).ok())
            .filter(is_right);
        let file = edited.as_ref().map(|config| config.file.clone());
        self.file.change(file).map_err(|error| {
            let hint = match error {
                SettingsError::NoDirectory => Some("set MAGICIAN_CONFIG to the path of the file"),
                SettingsError::NotEditable(_) => Some("edit it by hand"),
                _ => None,
            };
            let failure = Failure::invalid(error.to_string());
            hint.into_iter().fold(failure, Failure::hint)
        })?;
        *self = edited.unwrap_or_default();
        Ok(())
    }
}

/// Values of a file and its arms.
type Values = (Vec<(&'static str, String)>, Vec<KnownArm>);

/// Parses and checks a file, or returns its fault.
fn check(text: &str) -> Result<Values, Diagnostic> {
    let lines = Lines::new(text);
    let file = DeTable::parse(text).map_err(|error| {
        let place = lines.origin(error.span().unwrap_or_default());
        Diagnostic::new(place, error.message().trim().to_owned())
    })?;
    let (mut values, mut arms) = (Vec::new(), Vec::new());
    for (name, value) in file.get_ref() {
        if name.get_ref() == arms::TABLE {
            arms = arms::read(&lines, value)?;
            continue;
        }
        let is_section = KEYS
            .iter()
            .any(|key| section(key.name) == Some(name.get_ref()));
        match value.get_ref() {
            DeValue::Table(table) if is_section => {
                for (inner, value) in table {
                    let full = format!("{}.{}", name.get_ref(), inner.get_ref());
                    values.push(entry(&lines, &full, inner.span(), value)?);
                }
            }
            _ if is_section => {
                let message = format!("write [{}] and its values below it", name.get_ref());
                return Err(Diagnostic::new(lines.origin(value.span()), message));
            }
            _ => values.push(entry(&lines, name.get_ref(), name.span(), value)?),
        }
    }
    Ok((values, arms))
}

fn entry(
    lines: &Lines<'_>,
    name: &str,
    place: std::ops::Range<usize>,
    value: &Spanned<DeValue<'_>>,
) -> Result<(&'static str, String), Diagnostic> {
    let Some(key) = KEYS.iter().find(|key| key.name == name) else {
        let problem = Diagnostic::new(lines.origin(place), format!("unknown setting `{name}`"));
        return Err(problem.help(suggestion(name)));
    };
    let text = key.read(value.get_ref());
    let text =
        text.map_err(|why| Diagnostic::new(lines.origin(value.span()), format!("{name}: {why}")))?;
    Ok((key.name, text))
}

/// Returns the part of a name before its dot.
fn section(name: &str) -> Option<&str> {
    name.split_once('.').map(|(section, _)| section)
}

/// Returns a hint for an unknown name: the settings of that name in a section, or the most similar
/// one.
pub(crate) fn suggestion(name: &str) -> String {
    let in_sections: Vec<String> = KEYS
        .iter()
        .filter(|key| {
            key.name
                .split_once('.')
                .is_some_and(|(_, last)| last == name)
        })
        .map(|key| format!("`{}`", key.name))
        .collect();
    if !in_sections.is_empty() {
        return format!("did you mean {}?", in_sections.join(" or "));
    }
    let distance = |key: &&Key| strsim::damerau_levenshtein(key.name, name);
    let nearest = KEYS.iter().min_by_key(distance);
    match nearest.filter(|key| distance(key) <= 3) {
        Some(key) => format!("did you mean `{}`?", key.name),
        None => "`magician config` lists all settings".to_owned(),
    }
}

fn invalid_file(path: &Path, text: &str, problem: &Diagnostic) -> Failure {
    let file = path.display().to_string();
    let drawn = diagnostics::draw(problem, Severity::Error, &file, Some(text));
    Failure::invalid(format!("{file}: {problem}")).drawn(drawn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_value_is_reported_with_its_position() {
        let text = "port = 'COM3'\nsurface = -6_0.5\n[draw]\nspeed = 60\n[sheet]\nrotation = 1\n";
        let (values, _) = check(text).expect("it is right");
        let wanted = [
            ("port", "COM3"),
            ("draw.speed", "60"),
            ("surface", "-60.5"),
            ("sheet", "calibrated"),
        ];
        for (name, value) in wanted {
            assert!(
                values.contains(&(name, value.to_owned())),
                "{name}: {values:?}"
            );
        }
        for (text, line, part) in [
            ("prot = 'COM3'", 1, "unknown setting `prot`"),
            ("[serve]\nlisten = 8910", 2, "quoted"),
            ("[serve]\nallow_host = 'a'", 2, "in brackets"),
            ("[serve]\nallow_host = ['a', 1]", 2, "in brackets"),
            ("[serve]\nstudent_laser = 'true'", 2, "true or false"),
            ("[serve]\nlink = 'a'", 2, "serve.link"),
            ("\nport = 3", 2, "quoted"),
            ("window = 9", 1, "1 to 8"),
            ("[draw]\nsped = 3", 2, "draw.sped"),
            ("draw = 3", 1, "[draw]"),
            ("port = ", 1, ""),
            ("a.b.c = 1", 1, "unknown setting `a`"),
        ] {
            let problem = check(text).expect_err(text);
            assert_eq!(problem.origin.line, line, "{text}");
            assert!(problem.message.contains(part), "{text}: {problem}");
        }
    }
}
