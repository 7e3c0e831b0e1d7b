//! The arm from the side: everything at its distance from the base axis.

use magician_host::{Geometry, JointAngles};

use super::{
    BASE_BODY, BELT_COLOR, Body, LINK_COLOR, LINK_THICKNESS, PLATE_THICKNESS, SCALE, SIDE_PART,
    Surroundings, TABLE_COLOR, above, base_side_corners, hex, links_from_side,
};
use crate::panel::Panel;
use crate::section;
use crate::svg::palette::{BASE, FAINT};
use crate::svg::{Number, Svg, path};

/// Draws the view with its upper left corner at a point.
pub(super) fn draw(
    svg: &mut Svg,
    corner: [f64; 2],
    arm: &Geometry,
    joints: &JointAngles,
    around: &Surroundings,
) {
    let panel = Panel {
        part: SIDE_PART,
        corner,
        scale: SCALE,
        id: "side",
    };
    panel.begin(svg);
    section::draw(svg, &panel, arm);
    panel.grid(svg);
    foot(svg, &panel);
    if let Some((height, [[_, far], _])) = around.table {
        table(svg, &panel, height, far);
    }
    if let Some(belt) = &around.belt {
        let look = [
            ("fill", BELT_COLOR),
            ("fill-opacity", "0.6"),
            ("stroke", FAINT),
            ("stroke-width", "0.3"),
        ];
        svg.rectangle(belt.side_corners().map(|end| panel.at(end)), &look);
    }
    for object in &around.bodies {
        body(svg, &panel, object);
    }
    links(svg, &panel, arm, joints);
    for [from, to] in &around.beams {
        let side_view = |[x, y, z]: [f64; 3]| panel.at([libm::hypot(x, y), z]);
        above::beam(svg, side_view(*from), side_view(*to));
    }
    panel.end(svg);
    panel.draw_labels(svg, "distance from the base axis / mm", "Z / mm");
}

/// Draws the base.
pub(super) fn foot(svg: &mut Svg, panel: &Panel) {
    let look = [
        ("fill", BASE),
        ("stroke", FAINT),
        ("stroke-width", "0.3"),
        ("rx", "1"),
    ];
    svg.rectangle(base_side_corners().map(|end| panel.at(end)), &look);
}

/// Draws a table of this height, from the base to a distance.
pub(super) fn table(svg: &mut Svg, panel: &Panel, height: f64, far: f64) {
    let [low, high] = panel.part;
    let ends = [
        [low[0].max(BASE_BODY[0]), height],
        [far.min(high[0]), height - PLATE_THICKNESS],
    ];
    let look = [
        ("fill", TABLE_COLOR),
        ("stroke", "#cbbd9e"),
        ("stroke-width", "0.3"),
    ];
    svg.rectangle(ends.map(|end| panel.at(end)), &look);
}

pub(super) fn body(svg: &mut Svg, panel: &Panel, body: &Body) {
    let fill = hex(body.color);
    let [edge, thick] = body.edge();
    let look = [
        ("fill", fill.as_str()),
        ("fill-opacity", "0.6"),
        ("stroke", edge),
        ("stroke-width", thick),
    ];
    svg.rectangle(body.side_corners().map(|end| panel.at(end)), &look);
}

/// Draws rear arm, forearm and tool.
pub(super) fn links(svg: &mut Svg, panel: &Panel, arm: &Geometry, joints: &JointAngles) {
    let [shoulder, elbow, wrist, tip] = links_from_side(arm, joints).map(|point| panel.at(point));
    let points = [shoulder, elbow, wrist];
    let width = Number(LINK_THICKNESS[1] * panel.scale).to_string();
    let look = |width, opacity| {
        [
            ("fill", "none"),
            ("stroke", LINK_COLOR),
            ("stroke-opacity", opacity),
            ("stroke-width", width),
            ("stroke-linecap", "round"),
            ("stroke-linejoin", "round"),
        ]
    };
    svg.path(&path(points, false), &look(&width, "0.6"));
    svg.path(&path([wrist, tip], false), &look("2", "0.6"));
    for point in points {
        svg.circle(point, 1.5, &[("fill", "#323f4b")]);
    }
    above::tip(svg, tip);
}
