//! Where before the arm the view is: the arm from above, small.

use super::above::{base, reach};
use super::panel::Panel;
use super::toolpath::Toolpath;
use magician_sim::svg::palette::{FAINT, INK, PAPER};
use magician_sim::svg::{Anchor, Svg, TextStyle};

/// How large it is drawn.
const SCALE: f64 = 0.1;
/// Which part of the plane it shows: all that any tool reaches before the arm, mm.
const PART: [[f64; 2]; 2] = [[-100.0, -350.0], [380.0, 350.0]];
/// Its width, and its height with what is written below, mm.
pub(super) const WIDTH: f64 = (PART[1][0] - PART[0][0]) * SCALE;
pub(super) const HEIGHT: f64 = (PART[1][1] - PART[0][1]) * SCALE + 6.0;

/// Draws it with its upper left corner at a place.
pub(super) fn draw(
    svg: &mut Svg,
    corner: [f64; 2],
    view: &Panel,
    toolpath: &Toolpath,
    within_reach: &[Vec<[f64; 2]>],
) {
    let panel = Panel {
        part: PART,
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
