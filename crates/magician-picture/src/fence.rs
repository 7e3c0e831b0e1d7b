//! The fence of the arm from above: its box and its keep-outs.

use magician_motion::{Cuboid, Fence};

use crate::panel::{Extent, Panel};
use crate::svg::{Svg, segments};

/// Colour of the box's outline and of keep-outs.
const EDGE_COLOR: &str = "#8a5a00";
/// Distance of hatch lines, mm on the sheet.
const HATCH_SPACING: f64 = 2.0;
/// Largest number of hatch lines. In a box that needs more, the lines are farther apart.
const MAX_HATCH_LINES: f64 = 200.0;

/// Extends the view to the whole box, so that a path that leaves it is visible.
pub(super) fn extend(extent: &mut Extent, fence: &Fence) {
    let boxes = fence.within().into_iter();
    for Cuboid { min, max } in boxes {
        let [x, y, _] = min;
        let [u, v, _] = max;
        extent.show([x, y]);
        extent.show([u, v]);
    }
}

/// Draws the fence.
pub(super) fn draw(svg: &mut Svg, panel: &Panel, fence: &Fence) {
    let corners = |cuboid: &Cuboid| {
        let ([x, y, _], [u, v, _]) = (cuboid.min, cuboid.max);
        [[x, y], [u, v]].map(|corner| panel.at(corner))
    };
    for keep_out in fence.keep_outs() {
        draw_keep_out(svg, corners(keep_out));
    }
    if let Some(within) = fence.within() {
        draw_outline(svg, corners(&within));
    }
}

/// Draws the outline of a box.
pub(super) fn draw_outline(svg: &mut Svg, corners: [[f64; 2]; 2]) {
    let look = [
        ("class", "fence"),
        ("fill", "none"),
        ("stroke", EDGE_COLOR),
        ("stroke-width", "0.5"),
        ("stroke-dasharray", "3 1.5"),
    ];
    svg.rectangle(corners, &look);
}

/// Draws a keep-out.
pub(super) fn draw_keep_out(svg: &mut Svg, corners: [[f64; 2]; 2]) {
    svg.group(
        "g",
        &[
            ("class", "keep-out"),
            ("stroke", EDGE_COLOR),
            ("fill", "none"),
        ],
    );
    svg.rectangle(corners, &[("stroke-width", "0.4")]);
    svg.path(&segments(hatch_lines(corners)), &[("stroke-width", "0.2")]);
    svg.end();
}

/// Returns diagonal lines across a rectangle.
fn hatch_lines([a, b]: [[f64; 2]; 2]) -> Vec<[[f64; 2]; 2]> {
    let (left, right) = (a[0].min(b[0]), a[0].max(b[0]));
    let (top, bottom) = (a[1].min(b[1]), a[1].max(b[1]));
    let length = (right - left) + (bottom - top);
    let spacing = HATCH_SPACING.max(length / MAX_HATCH_LINES);
    let count = if length.is_finite() {
        (length / spacing) as u32
    } else {
        0
    };
    let lines = (1..=count).map(|nth| {
        // Points with x + y = `offset`, both counted from the upper left corner.
        let offset = f64::from(nth) * spacing;
        let past_bottom = (offset - (bottom - top)).max(0.0);
        let past_right = (offset - (right - left)).max(0.0);
        [
            [left + past_bottom, top + (offset - past_bottom)],
            [left + (offset - past_right), top + past_right],
        ]
    });
    lines.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hatching_stays_within_its_rectangle() {
        let lines = hatch_lines([[10.0, 40.0], [30.0, 20.5]]);
        assert!(lines.len() > 10);
        for [x, y] in lines.into_iter().flatten() {
            assert!(
                (10.0..=30.0).contains(&x) && (20.5..=40.0).contains(&y),
                "{x} {y}"
            );
        }
    }
}
