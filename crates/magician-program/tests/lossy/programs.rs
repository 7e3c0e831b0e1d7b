//! The programs that are drawn.

use std::path::Path;

use magician_program::raster::Size;
use magician_program::rehearse::{RehearseOptions, tool_of};
use magician_program::{Content, Format, Plan, Problem, ReadOptions, Setup, Surface, read};

/// Of every kind that leaves something.
pub(crate) const PROGRAMS: [&str; 5] = [
    "house.svg",
    "curves.svg",
    "pen_outline.gcode",
    "laser_checker.gcode",
    "engrave_gradient.png",
];
/// How wide the image is, mm.
const WIDTH: f64 = 6.0;
/// How high paper and wood lie, mm.
const SURFACE: f64 = -60.0;

/// The plan of a sample in a folder, as `magician run` makes it.
pub(crate) fn plan(samples: &Path, name: &str) -> Result<Plan, Problem> {
    let path = samples.join(name);
    let bytes = std::fs::read(&path)
        .map_err(|error| Problem::of_file(format!("{}: {error}", path.display())))?;
    let format = Format::of(name, &bytes).ok_or_else(|| Problem::of_file("of no format"))?;
    let content = read(format, &bytes, &ReadOptions::default())?.content;
    let mut setup = Setup::default();
    setup.usual_surface = Some(Surface::level(SURFACE));
    if let Content::Image(_) = content {
        setup.size = Size::Width(WIDTH);
    }
    let mut plan = setup.plan(format, content)?.content;
    // An arm that restarts forgets which tool it has: it is told by the plan.
    plan.tool = Some(tool_of(&plan, &RehearseOptions::default()));
    Ok(plan)
}
