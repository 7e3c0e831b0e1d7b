//! The view from above.

use super::panel::{Extent, Panel};
use super::symbols;
use super::{PreviewOptions, layers};
use crate::Report;
use crate::toolpath::{Layer, MarkerKind, StrokeKind, Toolpath};
use magician_sim::svg::palette::{BASE, FAINT, INK, PAPER, REACH, REACH_EDGE};
use magician_sim::svg::{Number, Svg, lines, path};

/// The base is 158 mm square.
const HALF_BASE: f64 = 79.0;

/// Which part of the plane the view shows: all ways, the sheet and the page.
pub(super) fn part(toolpath: &Toolpath, options: &PreviewOptions) -> [[f64; 2]; 2] {
    let mut extent = Extent::default();
    for layer in &toolpath.layers {
        let points = layer.above.lines().flatten();
        points.for_each(|point| extent.show(*point));
    }
    let ends = toolpath.ends.into_iter().flatten();
    ends.for_each(|[x, y, _]| extent.show([x, y]));
    let papers = [&options.sheet, &options.page].into_iter().flatten();
    papers.flatten().for_each(|corner| extent.show(*corner));
    if let Some(fence) = &options.fence {
        super::fence::extend(&mut extent, fence);
    }
    extent.part()
}

/// Draws it.
pub(super) fn draw(
    svg: &mut Svg,
    panel: &Panel,
    toolpath: &Toolpath,
    report: &Report,
    options: &PreviewOptions,
    within_reach: &[Vec<[f64; 2]>],
) {
    panel.begin(svg);
    reach(svg, panel, within_reach);
    base(svg, panel);
    // What of a page is within reach shows through it.
    let papers = [
        ("sheet", PAPER, &options.sheet),
        ("page", "none", &options.page),
    ];
    for (class, fill, corners) in papers {
        let Some(corners) = corners else { continue };
        let data = path(corners.iter().map(|corner| panel.at(*corner)), true);
        let look = [
            ("class", class),
            ("fill", fill),
            ("stroke", FAINT),
            ("stroke-width", "0.4"),
        ];
        svg.path(&data, &look);
    }
    panel.grid(svg);
    if let Some(fence) = &options.fence {
        super::fence::draw(svg, panel, fence);
    }
    let look = |layer: &Layer| lines(layer.above.lines(), |point| panel.at(point));
    layers::draw(svg, &toolpath.layers, look);
    for mark in &toolpath.markers {
        let [x, y, _] = mark.at;
        symbols::markers(svg, panel.at([x, y]), mark);
    }
    if let Some([start, end]) = toolpath.ends {
        symbols::ends(svg, [start, end].map(|[x, y, _]| panel.at([x, y])));
    }
    for (step, at) in &toolpath.refused_steps {
        if let Some([x, y, _]) = at {
            symbols::refused_step(svg, panel, [*x, *y], report.number(*step));
        }
    }
    panel.end(svg);
    panel.numbers(svg, "X / mm", "Y / mm");
}

/// What the tool can reach on the surface.
pub(super) fn reach(svg: &mut Svg, panel: &Panel, rings: &[Vec<[f64; 2]>]) {
    let look = [
        ("fill", REACH),
        ("stroke", REACH_EDGE),
        ("stroke-width", "0.3"),
    ];
    for ring in rings {
        let ring = ring.iter().map(|point| panel.at(*point));
        svg.path(&path(ring, true), &look);
    }
}

/// The base's footprint and its axis.
pub(super) fn base(svg: &mut Svg, panel: &Panel) {
    let corners = [[-HALF_BASE, -HALF_BASE], [HALF_BASE, HALF_BASE]];
    let round = Number(6.0 * panel.scale).to_string();
    let look = [
        ("fill", BASE),
        ("rx", &round),
        ("stroke", FAINT),
        ("stroke-width", "0.3"),
    ];
    svg.rectangle(corners.map(|corner| panel.at(corner)), &look);
    svg.circle(panel.at([0.0, 0.0]), 0.8, &[("fill", INK)]);
}

/// Which kinds of marks there are.
pub(super) fn kinds(toolpath: &Toolpath) -> Vec<MarkerKind> {
    let mut kinds: Vec<_> = toolpath
        .markers
        .iter()
        .flat_map(|mark| mark.kinds.clone())
        .collect();
    kinds.sort();
    kinds.dedup();
    kinds
}

/// Whether there is anything of a sort.
pub(super) fn has(toolpath: &Toolpath, sort: impl Fn(StrokeKind) -> bool) -> bool {
    toolpath
        .layers
        .iter()
        .any(|layer| sort(layer.leaves) && !layer.above.is_empty())
}
