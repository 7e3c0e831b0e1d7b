//! Defaults of drawing options from the environment and the settings file.

use magician_program::SetupDefaults;

use crate::config::Config;
use crate::failure::Failure;
use crate::mounted::mounted_tool;
use crate::numbers::numbers;

/// Returns the defaults for the command, and for a station that it serves.
pub(crate) fn defaults(config: &Config) -> Result<SetupDefaults, Failure> {
    let mut defaults = SetupDefaults::default();
    defaults.tool = mounted_tool(config)?;
    defaults.sheet = config.table("sheet")?;
    defaults.surface = config.surface()?;
    defaults.draw_speed = config.number("draw.speed");
    defaults.draw_travel_speed = config.number("draw.travel_speed");
    defaults.draw_lift = config.number("draw.lift");
    defaults.engrave_speed = config.number("engrave.speed");
    defaults.engrave_power = config.power("engrave.power");
    defaults.park = config
        .file_value("park")
        .and_then(|text| numbers(text).ok());
    Ok(defaults)
}
