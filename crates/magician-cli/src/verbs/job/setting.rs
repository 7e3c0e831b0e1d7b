//! What environment and settings say of how a file is to be done.

use magician_program::{SetupDefaults, Surface};

use super::Where;
use super::options::numbers;
use crate::config::Config;
use crate::failure::Failure;
use crate::mounted::usual_tool;

impl Where {
    /// What counts here where no flag does; `runs` is whether it may burn here.
    pub(super) fn defaults(&self, config: &Config, runs: bool) -> Result<SetupDefaults, Failure> {
        let mut defaults = SetupDefaults::default();
        defaults.tool = usual_tool(config)?;
        defaults.sheet = config.table("sheet")?;
        defaults.assumed_surface = match self {
            Self::Nowhere | Self::Stage(_) => Some(Surface::VIRTUAL),
            Self::Arm => None,
        };
        defaults.surface = config.number("surface").map(Surface::level);
        defaults.draw_speed = config.number("draw.speed");
        defaults.draw_travel_speed = config.number("draw.travel_speed");
        defaults.draw_lift = config.number("draw.lift");
        defaults.engrave_speed = config.number("engrave.speed");
        // What is converted is not burnt yet: a run of it has this then.
        defaults.engrave_power = runs.then(|| config.power("engrave.power")).flatten();
        defaults.park = config.says("park").and_then(|text| numbers(text).ok());
        Ok(defaults)
    }
}

/// What the settings say of programs that run on an arm that is there.
pub(crate) fn defaults(config: &Config) -> Result<SetupDefaults, Failure> {
    Where::Arm.defaults(config, true)
}
