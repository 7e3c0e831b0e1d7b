//! Presets as objects of JSON: the same for the command and for a station.

use serde::Serialize;
use serde_json::{Map, Value};

use super::{Preset, Presets};

/// A preset as JSON has it.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct PresetReport {
    /// What it is called.
    pub name: String,
    /// Whether it comes with this program; a file of its name goes before it.
    pub shipped: bool,
    /// Its note.
    pub note: Option<String>,
    /// Its file, if it has one.
    pub path: Option<String>,
    /// What it says; not in a list.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub options: Option<Map<String, Value>>,
    /// The text of its file; not in a list.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// What is wrong with its file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// All presets.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct PresetList {
    /// Those that come with this program first.
    pub presets: Vec<PresetReport>,
}

impl From<&Preset> for PresetReport {
    fn from(preset: &Preset) -> Self {
        Self {
            name: preset.name.clone(),
            shipped: preset.shipped,
            note: preset.note.clone(),
            path: preset.path.as_ref().map(|path| path.display().to_string()),
            options: Some(preset.options.to_fields()),
            text: Some(preset.text.clone()),
            problem: None,
        }
    }
}

impl PresetList {
    /// Those that there are. One that is wrong does not hide the others.
    #[must_use]
    pub fn of(presets: &Presets) -> Self {
        let listed = { presets.names().into_iter() }.map(|name| match presets.load(&name) {
            Ok(preset) => PresetReport {
                options: None,
                text: None,
                ..PresetReport::from(&preset)
            },
            Err(error) => PresetReport {
                shipped: false,
                note: None,
                path: None,
                options: None,
                text: None,
                problem: Some(error.to_string()),
                name,
            },
        });
        Self {
            presets: listed.collect(),
        }
    }
}
