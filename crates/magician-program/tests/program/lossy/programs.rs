//! Programs for the tests over bad lines.

use std::path::Path;

use magician_program::raster::Size;
use magician_program::rehearse::{RehearseOptions, tool_of};
use magician_program::{Content, Diagnostic, Format, Plan, ReadOptions, Setup, Surface, read};

/// Programs of every kind that leaves marks.
pub(crate) const PROGRAMS: [&str; 5] = [
    "house.svg",
    "curves.svg",
    "pen_outline.gcode",
    "laser_checker.gcode",
    "engrave_gradient.png",
];
/// Width of the image, mm.
const WIDTH: f64 = 6.0;
/// Height of paper and wood, mm.
const SURFACE: f64 = -60.0;

/// Plan of a sample in a folder, as `magician run` makes it.
pub(crate) fn plan(samples: &Path, name: &str) -> Result<Plan, Diagnostic> {
    let path = samples.join(name);
    let bytes = std::fs::read(&path)
        .map_err(|error| Diagnostic::of_file(format!("{}: {error}", path.display())))?;
    let format = Format::of(name, &bytes).ok_or_else(|| Diagnostic::of_file("of no format"))?;
    laid_out(name, format, &bytes)
}

/// Plan that is hard to draw right over a bad line: long strokes with sharp corners, short segments
/// along curves, and pen lifts between them. The curve has `points` points.
pub(crate) fn hard(points: u32) -> Result<Plan, Diagnostic> {
    let mut curve = String::new();
    for point in 0..=points {
        let turn = std::f64::consts::TAU * f64::from(point) / f64::from(points);
        let radius = 22.0 + 8.0 * (5.0 * turn).cos();
        let (x, y) = (40.0 + radius * turn.cos(), 35.0 + radius * turn.sin());
        curve += &format!("{x:.3},{y:.3} ");
    }
    let svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='80mm' height='70mm' viewBox='0 0 80 70'>\
         <g fill='none' stroke='black'><polyline points='2,2 8,2 8,8 2,8 5,14 14,2'/>\
         <polyline points='{curve}'/>\
         <polyline points='66,2 78,2 70,8 78,14 66,14'/><polyline points='2,68 8,62 14,68 20,62 26,68'/></g></svg>"
    );
    laid_out("hard.svg", Format::Svg, svg.as_bytes())
}

fn laid_out(name: &str, format: Format, bytes: &[u8]) -> Result<Plan, Diagnostic> {
    let content = read(format, bytes, &ReadOptions::default())?.content;
    let mut setup = Setup::default();
    setup.default_surface = Some(Surface::level(SURFACE));
    if let Content::Image(_) = content {
        setup.size = Size::Width(WIDTH);
    }
    let mut plan = setup.plan(format, content)?.fitting()?.plan;
    plan.title = name.to_owned();
    // An arm that restarts forgets its tool, so the plan sets it.
    plan.tool = Some(tool_of(&plan, &RehearseOptions::default()));
    Ok(plan)
}
