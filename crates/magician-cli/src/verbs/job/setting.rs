//! What flags, environment and settings say of how a file is to be done.

use magician::{Set, words};
use magician_program::artwork::Marking;
use magician_program::raster::Size;
use magician_program::{
    Action, Diagnostic, Ending, Frame, Pallet, Placement, Plan, Setup, Surface, White, Work,
};

use super::options::{File, LaserFlags, Pen, PlacementOptions, PreviewFlags, RunFlags, numbers};
use super::{Job, Where};
use crate::config::Config;
use crate::failure::Failure;
use crate::mounted::usual_tool;

/// Acceleration along paths when a speed is asked for, as at power-up, mm/s2.
const ACCELERATION: f32 = 100.0;

impl Job {
    /// What flags, environment and settings say of how the file is to be done.
    pub(super) fn setup(&self, place: &Where, config: &Config) -> Result<Setup, Failure> {
        let (asked, way, pen) = (&self.place, &self.way, &self.pen);
        let mut setup = Setup::default();
        setup.tool = asked.tool;
        setup.default_tool = usual_tool(config)?;
        setup.sheet = config.table("sheet")?;
        setup.surface = asked.surface.map(Surface::level);
        let table = match place {
            Where::Nowhere | Where::Stage(_) => Some(Surface::VIRTUAL),
            Where::Arm => None,
        };
        setup.default_surface = config.number("surface").map(Surface::level).or(table);
        let mut placement = Placement::default();
        placement.frame = match (asked.place, asked.raw) {
            (_, true) => Frame::Arm,
            (true, _) => Frame::Own,
            _ => Frame::Default,
        };
        placement.pen_z = asked.pen_z;
        placement.at = asked.at;
        placement.scale = asked.scale.unwrap_or(1.0);
        placement.rotate = asked.rotate.unwrap_or(0.0);
        (placement.fit, placement.turn) = (asked.fit, !asked.no_turn);
        placement.mirror = asked.mirror;
        placement.by = asked.by.unwrap_or_default();
        setup.placement = placement;
        let usual = Marking::pen();
        let or_config = |flag: Option<f64>, name| flag.or_else(|| config.number(name));
        setup.pen = Marking {
            lift: self.lift(config),
            speed: config
                .number("draw.speed")
                .map_or(usual.speed, |speed| speed as f32),
            travel: or_config(pen.travel_speed, "draw.travel_speed")
                .map_or(usual.travel, |speed| speed as f32),
            ..usual
        };
        setup.order = !pen.no_order;
        setup.work = self.work.clone();
        setup.size = self.size;
        setup.speed = way.speed.map(|speed| speed as f32);
        setup.laser_speed = config.number("engrave.speed");
        setup.power = self.beam.power;
        // What is converted is not burnt yet: a run of it has this then.
        setup.default_power = self.runs.then(|| config.power("engrave.power")).flatten();
        Ok(setup)
    }

    /// What the settings alone say, for programs that come without flags; the arm is one that is there.
    pub(crate) fn without_flags(config: &Config) -> Result<(Setup, Ending), Failure> {
        let plain = Self {
            file: File {
                file: "-".into(),
                format: None,
                dialect: None,
                s_max: None,
                white: White::default(),
                resample: None,
            },
            look: PreviewFlags::default(),
            place: PlacementOptions::default(),
            way: RunFlags::default(),
            beam: LaserFlags::default(),
            pen: Pen::default(),
            work: Work::Default,
            size: Size::Natural,
            pause: 0,
            runs: true,
        };
        let setup = plain.setup(&Where::Arm, config)?;
        Ok((setup, plain.ending(config, false)))
    }

    /// What becomes of the pen and the arm at the end.
    pub(super) fn ending(&self, config: &Config, drawing: bool) -> Ending {
        let usual = config.says("park").and_then(|text| numbers(text).ok());
        Ending {
            lift: self.lift(config),
            stay: self.way.stay,
            drawing,
            park: self.way.park.or(usual).filter(|_| !self.way.stay),
        }
    }

    fn lift(&self, config: &Config) -> f64 {
        let lift = self.pen.lift.or_else(|| config.number("draw.lift"));
        lift.unwrap_or(Marking::pen().lift)
    }

    /// Once at each place of the grid.
    pub(super) fn on_grid(&self, plan: Plan) -> Result<Plan, Diagnostic> {
        match self.place.grid {
            Some(grid) => plan.placed_on(&Pallet::grid(grid.rows, grid.columns, grid.pitch)),
            None => Ok(plan),
        }
    }

    /// What the arm is told first, besides what the plan says.
    pub(super) fn settings(&self, plan: &mut Plan, taught: bool) -> Vec<Set> {
        let mut settings = Vec::new();
        if let Some(ratio) = self.way.speed_ratio {
            settings.push(plan.moves_at(ratio as f32));
        }
        let path = |action: &Action| matches!(action, Action::Path { .. } | Action::Burn { .. });
        if let Some(speed) = self.way.speed.filter(|_| taught)
            && plan.steps.iter().any(|step| path(&step.action))
        {
            settings.push(words::path_speed(speed as f32, ACCELERATION));
        }
        settings
    }
}
