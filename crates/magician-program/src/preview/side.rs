//! The view from the side: everything at its distance from the base axis.

use magician::{Geometry, Limits};

use super::panel::Panel;
use super::section::section;
use super::svg::{Svg, path};
use super::trip::{Layer, Trip};
use super::{FAINT, REACH, REACH_EDGE, layers, symbols};

/// What is left free round what is shown, mm.
const MARGIN: f64 = 12.0;
/// The view goes no farther than this from the base, mm.
const FARTHEST: f64 = 420.0;

/// Which part of the plane the view shows; as far to the right as the other view.
pub(super) fn part(trip: &mut Trip) -> [[f64; 2]; 2] {
    let (mut low, mut high) = ([-30.0_f64, 0.0_f64], [120.0_f64, 0.0_f64]);
    let mut show = |[radius, z]: [f64; 2]| {
        low[1] = low[1].min(z - MARGIN);
        high = [high[0].max(radius + MARGIN), high[1].max(z + MARGIN)];
    };
    for layer in &mut trip.layers {
        layer.side.lines().flatten().copied().for_each(&mut show);
    }
    let ends = trip.ends.into_iter().flatten();
    ends.for_each(|[x, y, z]| show([x.hypot(y), z]));
    let rounded =
        |value: f64, up: fn(f64) -> f64| (up(value / 10.0) * 10.0).clamp(-FARTHEST, FARTHEST);
    [
        low.map(|value| rounded(value, f64::floor)),
        high.map(|value| rounded(value, f64::ceil)),
    ]
}

/// Draws it.
pub(super) fn draw(svg: &mut Svg, panel: &Panel, trip: &mut Trip, arm: &Geometry) {
    panel.begin(svg);
    let edge = section(arm, &Limits::CONTROLLER).into_iter();
    let look = [
        ("fill", REACH),
        ("stroke", REACH_EDGE),
        ("stroke-width", "0.3"),
    ];
    svg.path(&path(edge.map(|point| panel.at(point)), true), &look);
    panel.grid(svg);
    let [low, high] = panel.part;
    let axis = [low[1], high[1]].map(|z| panel.at([0.0, z]));
    let look = [
        ("stroke", FAINT),
        ("stroke-width", "0.3"),
        ("stroke-dasharray", "5 1.2 1 1.2"),
    ];
    svg.path(&path(axis, false), &look);
    let data = |layer: &mut Layer| super::svg::tracks(&mut layer.side, |point| panel.at(point));
    layers::draw(svg, &mut trip.layers, data);
    let beside = |[x, y, z]: [f64; 3]| panel.at([x.hypot(y), z]);
    for mark in &trip.marks {
        symbols::marks(svg, beside(mark.at), mark, false);
    }
    if let Some(ends) = trip.ends {
        symbols::ends(svg, ends.map(beside));
    }
    panel.end(svg, "distance from the base axis / mm", "Z / mm");
}
