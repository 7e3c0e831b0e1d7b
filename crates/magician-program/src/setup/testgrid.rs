//! Test grid: each cell is an image engraved with its own power and speed.

use magician_host::message;
use magician_host::{Remedy, Setting};

use super::{LaidPlan, Setup, Work};
use crate::artwork::{Marking, PlacedArtwork};
use crate::raster::{Engrave, Grid};
use crate::{Artwork, Diagnostic, Origin, Plan, Raster, Stroke, Surface, Tool};
use crate::{TestCell, TestGrid};

impl Setup {
    pub(super) fn test_grid(&self, wanted: &TestGrid) -> Result<LaidPlan, Diagnostic> {
        self.check_no_power_or_speed()?;
        let options = &wanted.options;
        let usual = match &self.work {
            Work::Engrave(engrave) => engrave.clone(),
            _ => Engrave::default(),
        };
        let fastest = Engrave {
            spacing: options.spacing,
            speed: options.fastest(),
            power: [options.weakest(); 2],
            tone: crate::raster::Tone::Grey,
            gamma: 1.0,
            invert: false,
            ..usual
        };
        let surface = self.needed_surface()?;
        let tool = self.tool_for(Tool::Laser);
        let size = wanted.size.map(|side| side * self.placement.scale);
        let grid = self.grid(size, &fastest, tool)?;
        let scale = grid.size()[0] / wanted.size[0];
        let mut plan = labels(wanted, &grid, surface, &fastest, tool);
        for cell in wanted.cells() {
            let name = format!("{} % at {} mm/s", cell.power, cell.speed);
            let origin = Origin::NONE.named(plan.name(name));
            let burnt = cell_plan(wanted, &cell, &grid, surface, &fastest)?;
            for mut step in burnt.steps {
                step.origin = origin;
                plan.steps.push(step);
            }
        }
        Ok(LaidPlan {
            plan: self.with_offset(plan, &mut Vec::new())?,
            scale,
            misfit: None,
        })
    }

    /// Refuses the options for power and speed, because the grid sets both.
    fn check_no_power_or_speed(&self) -> Result<(), Diagnostic> {
        let said = [
            (Setting::Power, self.power.is_some()),
            (Setting::Speed, self.speed.is_some()),
        ];
        let Some((setting, _)) = said.into_iter().find(|(_, said)| *said) else {
            return Ok(());
        };
        let message = message!(
            "a test grid has a {setting} of its own in each cell",
            setting
        );
        Err(Diagnostic::of_file(message).with(Remedy::without(setting)))
    }
}

/// Labels, at the lowest power and the highest speed.
fn labels(wanted: &TestGrid, grid: &Grid, surface: Surface, engrave: &Engrave, tool: Tool) -> Plan {
    let strokes = wanted.labels.iter().map(|line| {
        let points = line.iter().map(|point| position(wanted, grid, *point));
        Stroke::new(points.collect(), Origin::NONE)
    });
    let artwork = Artwork {
        title: wanted.title.clone(),
        strokes: strokes.collect(),
        ..Artwork::default()
    };
    let marking = Marking {
        tool,
        speed: engrave.speed as f32,
        acceleration: engrave.acceleration as f32,
        travel: engrave.travel as f32,
        lift: engrave.lift,
        ..Marking::laser(engrave.power[1] as f32)
    };
    PlacedArtwork::at(artwork, surface).plan(&marking)
}

/// Plan of a cell, which is engraved as an image of one black pixel.
fn cell_plan(
    wanted: &TestGrid,
    cell: &TestCell,
    grid: &Grid,
    surface: Surface,
    usual: &Engrave,
) -> Result<Plan, Diagnostic> {
    let side = wanted.options.cell;
    let shares = [side / wanted.size[0], side / wanted.size[1]];
    let place = Grid {
        origin: position(wanted, grid, cell.corner),
        across: grid.across.map(|way| way * shares[0]),
        down: grid.down.map(|way| way * shares[1]),
    };
    let engrave = Engrave {
        power: [cell.power; 2],
        speed: cell.speed,
        ..usual.clone()
    };
    let black = Raster {
        width: 1,
        height: 1,
        grey: vec![0],
        ..Raster::default()
    };
    engrave.plan(&black, &place, surface)
}

/// Position of a point of the grid.
fn position(wanted: &TestGrid, grid: &Grid, [right, down]: [f64; 2]) -> [f64; 2] {
    grid.at([right / wanted.size[0], down / wanted.size[1]])
}
