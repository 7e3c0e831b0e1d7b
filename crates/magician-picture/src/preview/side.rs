//! The view from the side: everything at its distance from the base axis.

use magician_host::Geometry;
use magician_program::toolpath::{Layer, Toolpath};

use crate::layers::PathStyle;
use crate::panel::{Extent, Panel};
use crate::svg::palette::FAINT;
use crate::svg::{Svg, lines, path};
use crate::{layers, section, symbols};

/// Returns the part of the plane to show.
pub(super) fn part(toolpath: &Toolpath) -> [[f64; 2]; 2] {
    let mut extent = Extent::default();
    for layer in &toolpath.layers {
        let points = layer.side.lines().flatten();
        points.for_each(|point| extent.show(*point));
    }
    let ends = toolpath.ends.into_iter().flatten();
    ends.for_each(|[x, y, z]| extent.show([libm::hypot(x, y), z]));
    extent.part()
}

/// Draws the view.
pub(super) fn draw(svg: &mut Svg, panel: &Panel, toolpath: &Toolpath, arm: &Geometry) {
    panel.begin(svg);
    section::draw(svg, panel, arm);
    panel.grid(svg);
    let [low, high] = panel.part;
    let axis = [low[1], high[1]].map(|z| panel.at([0.0, z]));
    let look = [
        ("stroke", FAINT),
        ("stroke-width", "0.3"),
        ("stroke-dasharray", "5 1.2 1 1.2"),
    ];
    svg.path(&path(axis, false), &look);
    let data = |layer: &Layer| lines(layer.side.lines(), |point| panel.at(point));
    layers::draw(svg, &toolpath.layers, PathStyle::Plan, data);
    let side_view = |[x, y, z]: [f64; 3]| panel.at([libm::hypot(x, y), z]);
    for mark in &toolpath.markers {
        symbols::spot(svg, side_view(mark.at));
    }
    if let Some(ends) = toolpath.ends {
        symbols::ends(svg, ends.map(side_view));
    }
    panel.end(svg);
    panel.draw_labels(svg, "distance from the base axis / mm", "Z / mm");
}
