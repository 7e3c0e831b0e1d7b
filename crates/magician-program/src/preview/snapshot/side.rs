//! The arm from the side: everything at its distance from the base axis.

use magician_host::{Geometry, JointAngles};
use magician_motion::ArmModel;

use super::super::panel::Panel;
use super::super::section::section;
use super::{Body, SCALE, SIDE, Surroundings, above, hex};
use magician_sim::svg::palette::{BASE, FAINT, INK, REACH, REACH_EDGE};
use magician_sim::svg::{Number, Svg, path};

/// Half of the base's width, and how far it goes down from the shoulder (model section 1), mm.
const BODY: [f64; 2] = [79.0, 138.0];
/// How thick table and belt are drawn, mm.
const THICK: f64 = 8.0;

/// Draws it with the upper left corner of the view at a place.
pub(super) fn draw(
    svg: &mut Svg,
    corner: [f64; 2],
    arm: &Geometry,
    joints: &JointAngles,
    around: &Surroundings,
) {
    let panel = Panel {
        part: SIDE,
        corner,
        scale: SCALE,
        id: "side",
    };
    panel.begin(svg);
    let edge = section(arm, &ArmModel::MAGICIAN.limits).into_iter();
    let look = [
        ("fill", REACH),
        ("stroke", REACH_EDGE),
        ("stroke-width", "0.3"),
    ];
    svg.path(&path(edge.map(|point| panel.at(point)), true), &look);
    panel.grid(svg);
    let [half, down] = BODY;
    let look = [
        ("fill", BASE),
        ("stroke", FAINT),
        ("stroke-width", "0.3"),
        ("rx", "1"),
    ];
    svg.rectangle(
        [[-half, -down], [half, -down / 3.0]].map(|end| panel.at(end)),
        &look,
    );
    if let Some((height, [[_, far], _])) = around.table {
        let ends = [
            [SIDE[0][0].max(half), height],
            [far.min(SIDE[1][0]), height - THICK],
        ];
        let look = [
            ("fill", "#e6dcc6"),
            ("stroke", "#cbbd9e"),
            ("stroke-width", "0.3"),
        ];
        svg.rectangle(ends.map(|end| panel.at(end)), &look);
    }
    if let Some(belt) = &around.belt {
        let half = belt.width / 2.0;
        let points = (0..=24).flat_map(|nth| {
            let along = belt.length * f64::from(nth) / 24.0;
            [-half, 0.0, half].map(|aside| belt.at(along, aside))
        });
        let ends = points.fold([f64::MAX, 0.0_f64], |[near, far], [x, y]| {
            [near.min(libm::hypot(x, y)), far.max(libm::hypot(x, y))]
        });
        let ends = [[ends[0], belt.height], [ends[1], belt.height - THICK]];
        let look = [
            ("fill", "#7d8894"),
            ("fill-opacity", "0.6"),
            ("stroke", FAINT),
            ("stroke-width", "0.3"),
        ];
        svg.rectangle(ends.map(|end| panel.at(end)), &look);
    }
    for object in &around.bodies {
        body(svg, &panel, object);
    }
    links(svg, &panel, arm, joints);
    for [from, to] in &around.beams {
        let beside = |[x, y, z]: [f64; 3]| panel.at([libm::hypot(x, y), z]);
        above::beam(svg, beside(*from), beside(*to));
    }
    panel.end(svg);
    panel.numbers(svg, "distance from the base axis / mm", "Z / mm");
}

fn body(svg: &mut Svg, panel: &Panel, body: &Body) {
    let [x, y, z, _] = body.place;
    let [length, width, height] = body.size;
    let (middle, half) = (libm::hypot(x, y), length.max(width) / 2.0);
    let fill = hex(body.color);
    let (edge, thick) = if body.held {
        (INK, "0.6")
    } else {
        (FAINT, "0.3")
    };
    let look = [
        ("fill", fill.as_str()),
        ("fill-opacity", "0.6"),
        ("stroke", edge),
        ("stroke-width", thick),
    ];
    let ends = [[middle - half, z], [middle + half, z + height]];
    svg.rectangle(ends.map(|end| panel.at(end)), &look);
}

/// Rear arm, forearm, tool.
fn links(svg: &mut Svg, panel: &Panel, arm: &Geometry, joints: &JointAngles) {
    let straight = JointAngles { j1: 0.0, ..*joints };
    let elbow = joints.j2.to_radians();
    let elbow = [
        arm.rear_arm * libm::sin(elbow),
        arm.rear_arm * libm::cos(elbow),
    ];
    let end = |arm: &Geometry| {
        let pose = arm.forward(&straight);
        [pose.x, pose.z]
    };
    let wrist = end(&Geometry {
        tool: magician_host::ToolBias::NONE,
        ..*arm
    });
    let points = [[0.0, 0.0], elbow, wrist].map(|point| panel.at(point));
    let width = Number(20.0 * SCALE).to_string();
    let look = |width, opacity| {
        [
            ("fill", "none"),
            ("stroke", "#52606d"),
            ("stroke-opacity", opacity),
            ("stroke-width", width),
            ("stroke-linecap", "round"),
            ("stroke-linejoin", "round"),
        ]
    };
    svg.path(&path(points, false), &look(&width, "0.6"));
    let tip = panel.at(end(arm));
    let [_, _, wrist] = points;
    svg.path(&path([wrist, tip], false), &look("2", "0.6"));
    for point in points {
        svg.circle(point, 1.5, &[("fill", "#323f4b")]);
    }
    svg.circle(
        tip,
        1.3,
        &[("fill", "none"), ("stroke", INK), ("stroke-width", "0.45")],
    );
}
