//! The tool that settings say is on the arm.

use magician_program::Tool;

use crate::config::{Config, Key};
use crate::failure::Failure;

/// The tool of the environment or the settings, if they name one.
pub(crate) fn usual_tool(config: &Config) -> Result<Option<Tool>, Failure> {
    let key = Key::named("tool");
    let Some((text, _)) = key.and_then(|key| config.value(key)) else {
        return Ok(None);
    };
    let tool = text.parse::<Tool>();
    tool.map(Some)
        .map_err(|why| Failure::usage(format!("MAGICIAN_TOOL is `{text}`: {why}")))
}
