//! The tool that is on the arm: what the arm was told, and what settings say.

use magician::commands::EndEffectorParams;
use magician_program::Tool;

use crate::config::{Config, Key};
use crate::failure::Failure;

/// The tool whose bias is in force.
pub(crate) fn tool_of(bias: &EndEffectorParams) -> Tool {
    let found = [bias.x_bias, bias.y_bias, bias.z_bias];
    let is = |tool: &Tool| {
        let known = tool.bias();
        [known.x, known.y, known.z].map(|part| part as f32) == found
    };
    let known = Tool::NAMED.into_iter().map(|(_, tool)| tool).find(is);
    known.unwrap_or(Tool::Bias(found))
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tools_are_known_by_their_bias() {
        let bias = |x_bias, z_bias| EndEffectorParams {
            x_bias,
            y_bias: 0.0,
            z_bias,
        };
        assert_eq!(tool_of(&bias(0.0, 0.0)), Tool::None);
        assert_eq!(tool_of(&bias(61.0, 0.0)), Tool::Pen);
        assert_eq!(tool_of(&bias(61.0, 5.0)), Tool::Bias([61.0, 0.0, 5.0]));
    }
}
