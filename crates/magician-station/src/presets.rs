//! Operations of clients on presets of drawing and engraving. Files are accessed off the station's
//! thread.

use magician::ErrorKind;
use magician_job::presets::{PresetError, PresetList, PresetReport, Presets};
use magician_program::SetupOptions;
use magician_protocol::visible;
use serde_json::Value;

use crate::api::RpcError;
use crate::reading::to_value;

/// Operation on presets.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PresetAct {
    /// List the presets.
    List,
    /// Show a preset.
    Show(String),
    /// Store options under a name, with a note.
    Save(String, Option<String>, Box<SetupOptions>),
    /// Store the text of a preset file under a name.
    SaveText(String, String),
    /// Remove a preset.
    Remove(String),
}

impl PresetAct {
    pub(crate) fn carry_out(self, presets: &Presets) -> Result<Value, RpcError> {
        let saved = |saved: Result<_, PresetError>, param| {
            let saved = saved.map_err(|error| match error {
                PresetError::Inexpressible(why) => RpcError::param_quoting(param, &why),
                error => preset_error(error, "name"),
            });
            to_value(&PresetReport::from(&saved?))
        };
        match self {
            Self::List => to_value(&PresetList::of(presets)),
            Self::Show(name) => {
                let preset = presets
                    .load(&name)
                    .map_err(|error| preset_error(error, "name"))?;
                to_value(&PresetReport::from(&preset))
            }
            Self::Save(name, note, options) => {
                saved(presets.save(&name, note.as_deref(), &options), "setup")
            }
            Self::SaveText(name, text) => saved(presets.save_text(&name, text), "text"),
            Self::Remove(name) => {
                let removed = presets.remove(&name);
                removed.map_err(|error| preset_error(error, "name"))?;
                Ok(Value::Null)
            }
        }
    }
}

/// Converts an error about the preset named by a parameter to an answer.
pub(crate) fn preset_error(error: PresetError, param: &str) -> RpcError {
    let why = visible(&error.to_string()).to_string();
    let answer = match &error {
        PresetError::Name(_) | PresetError::Unknown(..) => RpcError::param(param, why),
        PresetError::NoDirectory => RpcError::arm(ErrorKind::Unsupported, why),
        PresetError::File(..) => RpcError::arm(ErrorKind::Unexpected, why),
        // The rest is about the content of the preset.
        _ => RpcError::arm(ErrorKind::InvalidInput, why),
    };
    answer.with_sentence(&error.sentence())
}
