//! Locator map: where in front of the arm the view is.

use magician_program::toolpath::Toolpath;

use crate::ground::{base, reach};
use crate::panel::Panel;
use crate::svg::palette::{FAINT, INK, PAPER};
use crate::svg::{Anchor, Svg, TextStyle};

/// Scale of the map, 1 : 10.
const SCALE: f64 = 0.1;
/// Part of the plane shown, mm: the reach of any tool in front of the arm.
const SHOWN_PART: [[f64; 2]; 2] = [[-100.0, -350.0], [380.0, 350.0]];
/// Left edge of the map if the view extends beyond the left edge of [`SHOWN_PART`], mm: the reach
/// of any tool beside the arm.
const WIDE_LEFT_EDGE: f64 = -380.0;
/// Height of the map including the text below it, mm.
pub(super) const HEIGHT: f64 = (SHOWN_PART[1][1] - SHOWN_PART[0][1]) * SCALE + 6.0;

/// Width of the locator of a view, mm.
pub(super) fn width(view: &Panel) -> f64 {
    let [[left, _], [right, _]] = part(view);
    (right - left) * SCALE
}

fn part(view: &Panel) -> [[f64; 2]; 2] {
    let [[left, bottom], end] = SHOWN_PART;
    let left = if view.part[0][0] < left {
        WIDE_LEFT_EDGE
    } else {
        left
    };
    [[left, bottom], end]
}

/// Draws the map with its upper left corner at a point.
pub(super) fn draw(
    svg: &mut Svg,
    corner: [f64; 2],
    view: &Panel,
    toolpath: &Toolpath,
    within_reach: &[Vec<[f64; 2]>],
) {
    let panel = Panel {
        part: part(view),
        corner,
        scale: SCALE,
        id: "locator",
    };
    panel.begin(svg);
    reach(svg, &panel, within_reach);
    base(svg, &panel);
    let frame = view.part.map(|end| panel.at(end));
    let look = [
        ("fill", PAPER),
        ("fill-opacity", "0.6"),
        ("stroke", INK),
        ("stroke-width", "0.3"),
    ];
    svg.rectangle(frame, &look);
    if let Some(bounds) = toolpath.bounds {
        let drawn = bounds.map(|end| panel.at(end));
        svg.rectangle(drawn, &[("fill", INK), ("fill-opacity", "0.75")]);
    }
    panel.end(svg);
    let text = TextStyle {
        size: 2.8,
        colour: FAINT,
        anchor: Anchor::Start,
        rim: false,
    };
    let bottom = corner[1] + panel.size()[1];
    svg.text(
        [corner[0], bottom + 3.8],
        "the view before the arm, 1 : 10",
        &text,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn view_beside_the_arm_is_within_the_locator() {
        for left in [-170.0, -99.0, 150.0] {
            let view = Panel {
                part: [[left, 100.0], [left + 80.0, 180.0]],
                corner: [0.0, 0.0],
                scale: 1.0,
                id: "above",
            };
            let [[least, _], [most, _]] = part(&view);
            assert!(least <= left && left + 80.0 <= most, "{left}");
            assert!((width(&view) - (most - least) * SCALE).abs() < 1e-9);
        }
    }
}
