//! Presets as JSON objects, shared by the command and the station.

use serde::Serialize;
use serde_json::{Map, Value};

use super::{Preset, Presets};

/// Preset as JSON.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct PresetReport {
    /// Name of the preset.
    pub name: String,
    /// True if it comes with this program and no file of its name hides it.
    pub shipped: bool,
    /// Note for people.
    pub note: Option<String>,
    /// Path of its file, if it has one.
    pub path: Option<String>,
    /// Options that it sets; absent in a list.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub options: Option<Map<String, Value>>,
    /// Text of its file; absent in a list.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// Mistake in its file, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// List of all presets.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct PresetList {
    /// Presets, shipped ones first.
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
    /// Lists the presets. A broken file appears with its problem and does not hide the others.
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
