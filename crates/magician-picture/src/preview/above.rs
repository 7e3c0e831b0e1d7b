//! The view from above.

use magician_program::Report;
use magician_program::toolpath::{Layer, MarkerKind, StrokeKind, Toolpath};

use super::PreviewOptions;
use crate::ground::{base, reach};
use crate::layers::PathStyle;
use crate::panel::{Extent, Panel};
use crate::svg::palette::{FAINT, PAPER};
use crate::svg::{Svg, lines, path};
use crate::symbols;
use crate::{fence, layers};

/// Returns the part of the plane to show: all paths, the sheet, the page and the fence.
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
        fence::extend(&mut extent, fence);
    }
    extent.part()
}

/// Draws the view.
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
    // A page is transparent, so that the reach below it stays visible.
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
        fence::draw(svg, panel, fence);
    }
    let look = |layer: &Layer| lines(layer.above.lines(), |point| panel.at(point));
    layers::draw(svg, &toolpath.layers, PathStyle::Plan, look);
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
    panel.draw_labels(svg, "X / mm", "Y / mm");
}

/// Returns the kinds of markers that occur, sorted.
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

/// True if any layer with a kind of strokes that `accepts` accepts is not empty.
pub(super) fn has(toolpath: &Toolpath, accepts: impl Fn(StrokeKind) -> bool) -> bool {
    toolpath
        .layers
        .iter()
        .any(|layer| accepts(layer.mark) && !layer.above.is_empty())
}
