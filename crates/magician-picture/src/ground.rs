//! The ground in front of the arm from above: base and reach.

use crate::panel::Panel;
use crate::svg::palette::{BASE, FAINT, INK, REACH, REACH_EDGE};
use crate::svg::{Number, Svg, path};

/// Half the side of the base, mm: it is 158 mm square.
pub(super) const BASE_HALF_SIDE: f64 = 79.0;

/// Attributes of the outline of the reach at a second height.
pub(super) const OUTLINE_ATTRIBUTES: [(&str, &str); 4] = [
    ("fill", "none"),
    ("stroke", REACH_EDGE),
    ("stroke-width", "0.35"),
    ("stroke-dasharray", "1.6 1.2"),
];

/// Draws the reach of the tool on the surface.
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

/// Draws the base's footprint and its axis.
pub(super) fn base(svg: &mut Svg, panel: &Panel) {
    let corners = [
        [-BASE_HALF_SIDE, -BASE_HALF_SIDE],
        [BASE_HALF_SIDE, BASE_HALF_SIDE],
    ];
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
