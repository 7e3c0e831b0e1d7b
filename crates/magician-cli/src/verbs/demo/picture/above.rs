//! The run from above.

use magician_motion::{ArmModel, TopView};
use magician_picture::svg::palette::{BASE, CARGO, CARRIED, FAINT, INK, PAPER, REACH, REACH_EDGE};
use magician_picture::svg::{Svg, path};

use super::super::scene::{ARM, CUBE, CUBES, TOP, home};
use super::marks::{haloed, marker, rectangle, tracks};
use super::panel::{Panel, Scale};
use super::{Sample, workspace};

/// From above, as on paper.
const ABOVE: Scale = Scale {
    left: 60.0,
    top: 116.0,
    per_mm: 1.4,
    across: (-90.0, 340.0),
    up: (-240.0, 240.0),
};

/// Where a place x, y lies in the picture.
fn at(x: f64, y: f64) -> [f64; 2] {
    let [right, up] = TopView::PAPER.project([x, y]);
    ABOVE.at(right, up)
}

/// Draws it.
pub(super) fn draw(svg: &mut Svg, samples: &[Sample]) {
    let section = workspace::section(&ARM, &ArmModel::MAGICIAN.certain);
    let panel = Panel::begin(svg, ABOVE, "above", "From above", "x / mm", "y / mm");
    let (near, far) = section
        .iter()
        .fold((f64::MAX, 0.0_f64), |(near, far), point| {
            (near.min(point.0), far.max(point.0))
        });
    reach_from_above(svg, near, far, REACH, "none");
    if let Some((near, far)) = workspace::radii_at(&section, TOP) {
        reach_from_above(svg, near, far, "none", "5 4");
    }
    panel.grid(svg);
    base_from_above(svg);
    for errand in CUBES {
        square_from_above(svg, errand.from, false);
        square_from_above(svg, errand.to, true);
    }
    tracks(svg, samples, |sample| at(sample.x, sample.y));
    for (nth, errand) in CUBES.iter().enumerate() {
        number_from_above(svg, errand.from, nth + 1);
        number_from_above(svg, errand.to, nth + 1);
    }
    let at_home = home();
    let spot = at(at_home.x, at_home.y);
    marker(svg, spot, "home", [10.0, -9.0]);
    panel.end(svg);
}

/// A sector between two radii, as wide as J1 turns.
fn reach_from_above(svg: &mut Svg, near: f64, far: f64, fill: &str, dashes: &str) {
    let turn = ArmModel::MAGICIAN.certain.j1;
    let steps = 90_u32;
    let angle = |step: u32| {
        (turn.min + (turn.max - turn.min) * f64::from(step) / f64::from(steps)).to_radians()
    };
    let on = |radius: f64, step| {
        at(
            radius * f64::cos(angle(step)),
            radius * f64::sin(angle(step)),
        )
    };
    let outer = (0..=steps).map(|step| on(far, step));
    let inner = (0..=steps).rev().map(|step| on(near, step));
    let data = path(outer.chain(inner), true);
    let attributes = [
        ("fill", fill),
        ("stroke", REACH_EDGE),
        ("stroke-width", "1.5"),
        ("stroke-dasharray", dashes),
    ];
    svg.path(&data, &attributes);
}

/// The base's footprint, 158 mm square, and its axis.
fn base_from_above(svg: &mut Svg) {
    const HALF: f64 = 79.0;
    let corners = [at(HALF, HALF), at(-HALF, -HALF)];
    rectangle(svg, corners, BASE, FAINT, 8.0);
    svg.circle(at(0.0, 0.0), 5.0, &[("fill", INK)]);
    let label = [
        ("font-size", "14"),
        ("fill", INK),
        ("text-anchor", "middle"),
    ];
    svg.label(at(0.0, -32.0), "base", &label);
}

fn square_from_above(svg: &mut Svg, (x, y): (f64, f64), placed: bool) {
    const HALF: f64 = CUBE / 2.0;
    let (fill, stroke) = if placed {
        (CARGO, CARRIED)
    } else {
        (PAPER, FAINT)
    };
    rectangle(
        svg,
        [at(x + HALF, y + HALF), at(x - HALF, y - HALF)],
        fill,
        stroke,
        3.0,
    );
}

/// The number of a cube, on top of everything.
fn number_from_above(svg: &mut Svg, (x, y): (f64, f64), number: usize) {
    let [px, py] = at(x, y);
    let label = [
        ("font-size", "13"),
        ("fill", INK),
        ("text-anchor", "middle"),
        ("font-weight", "bold"),
    ];
    haloed(svg, [px - 10.0, py - 5.0], number, &label);
}
