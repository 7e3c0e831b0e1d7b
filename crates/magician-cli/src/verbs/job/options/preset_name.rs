//! Names of presets as the value of a flag.

use std::sync::LazyLock;

use clap::builder::{PossibleValue, TypedValueParser};
use magician_job::presets::Presets;

/// Value parser for the name of a preset. Completes the user's and the built-in presets.
#[derive(Clone, Debug)]
pub(crate) struct PresetName;

impl TypedValueParser for PresetName {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        arg: Option<&clap::Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<String, clap::Error> {
        clap::builder::StringValueParser::new().parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| Presets::of_user().names());
        let names = NAMES.iter().map(String::as_str);
        Some(Box::new(names.map(PossibleValue::new)))
    }
}
