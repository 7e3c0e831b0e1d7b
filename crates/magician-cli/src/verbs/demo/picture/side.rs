//! The run from the side: everything at its distance from the base axis.

use magician_motion::{ArmModel, JointAngles};
use magician_picture::svg::palette::{BASE, CARGO, CARRIED, FAINT, REACH, REACH_EDGE};
use magician_picture::svg::{Svg, path};

use super::super::scene::{ARM, CUBE, CUBES, TABLE, home};
use super::marks::{marker, rectangle, tracks};
use super::panel::{Panel, Scale};
use super::{Sample, workspace};

/// From the side: radius to the right, z upwards.
const SIDE: Scale = Scale {
    left: 752.0,
    top: 116.0,
    per_mm: 1.4,
    across: (0.0, 350.0),
    up: (-170.0, 240.0),
};

/// Draws it.
pub(super) fn draw(svg: &mut Svg, samples: &[Sample]) {
    let panel = Panel::begin(
        svg,
        SIDE,
        "side",
        "From the side",
        "distance from the base axis / mm",
        "z / mm",
    );
    let section = workspace::section(&ARM, &ArmModel::MAGICIAN.certain);
    let data = path(
        section.into_iter().map(|(radius, z)| SIDE.at(radius, z)),
        true,
    );
    let attributes = [
        ("fill", REACH),
        ("stroke", REACH_EDGE),
        ("stroke-width", "1.5"),
    ];
    svg.path(&data, &attributes);
    panel.grid(svg);
    table(svg);
    for errand in CUBES {
        for ((x, y), placed) in [(errand.from, false), (errand.to, true)] {
            square_from_the_side(svg, x.hypot(y), placed);
        }
    }
    arm_from_the_side(svg);
    tracks(svg, samples, |sample| SIDE.at(sample.radius(), sample.z));
    let at_home = home();
    marker(svg, SIDE.at(at_home.x, at_home.z), "home", [10.0, -9.0]);
    panel.end(svg);
}

fn table(svg: &mut Svg) {
    let (from, to) = (SIDE.at(0.0, TABLE), SIDE.at(SIDE.across.1, TABLE - 4.0));
    rectangle(svg, [from, to], "#dee2e6", "none", 0.0);
    let label = [("font-size", "13"), ("fill", FAINT)];
    svg.label(
        [from[0] + 10.0, to[1] + 17.0],
        "table, where the cup touches it",
        &label,
    );
}

fn square_from_the_side(svg: &mut Svg, radius: f64, placed: bool) {
    let (from, to) = (
        SIDE.at(radius - CUBE / 2.0, TABLE + CUBE),
        SIDE.at(radius + CUBE / 2.0, TABLE),
    );
    let (fill, stroke) = if placed {
        (CARGO, CARRIED)
    } else {
        ("none", FAINT)
    };
    rectangle(svg, [from, to], fill, stroke, 2.0);
}

/// The arm as it stands at home: rear arm, forearm, tool.
fn arm_from_the_side(svg: &mut Svg) {
    let joints = JointAngles::HOME;
    let (rear, fore) = (joints.j2.to_radians(), joints.j3.to_radians());
    let elbow = (ARM.rear_arm * rear.sin(), ARM.rear_arm * rear.cos());
    let wrist = (
        elbow.0 + ARM.forearm * fore.cos(),
        elbow.1 - ARM.forearm * fore.sin(),
    );
    let tool = (wrist.0 + ARM.tool.x, wrist.1);
    let points = [(0.0, 0.0), elbow, wrist, tool].map(|(radius, z)| SIDE.at(radius, z));
    let data = path(points, false);
    let attributes = [
        ("fill", "none"),
        ("stroke", BASE),
        ("stroke-width", "12"),
        ("stroke-linejoin", "round"),
        ("stroke-linecap", "round"),
    ];
    svg.path(&data, &attributes);
    for point in points.into_iter().take(3) {
        svg.circle(point, 5.0, &[("fill", FAINT)]);
    }
}
