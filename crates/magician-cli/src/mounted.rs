//! Tool that the settings name as mounted.

use magician_program::Tool;

use crate::config::{Config, Key};
use crate::failure::Failure;

/// Returns the tool from the environment or the settings; `None` if neither names one.
pub(crate) fn mounted_tool(config: &Config) -> Result<Option<Tool>, Failure> {
    let key = Key::named("tool");
    let Some((text, _)) = key.and_then(|key| config.value(key)) else {
        return Ok(None);
    };
    let tool = text.parse::<Tool>();
    tool.map(Some)
        .map_err(|why| Failure::usage(format!("MAGICIAN_TOOL is `{text}`: {why}")))
}
