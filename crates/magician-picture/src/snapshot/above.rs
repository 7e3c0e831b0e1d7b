//! The arm from above.

use magician_host::{Geometry, JointAngles};
use magician_program::{Reach, Surface};
use magician_sim::world::StrokeKind;

use super::{
    ABOVE_PART, BELT_COLOR, Belt, Body, LINK_COLOR, LINK_THICKNESS, SCALE, Surroundings, hex,
    links_from_above,
};
use crate::ground;
use crate::panel::Panel;
use crate::svg::palette::{BURNT, DRAWN, EMPTY, FAINT, INK, PAPER, WRONG};
use crate::svg::{Anchor, Number, Svg, TextStyle, path};

/// Distance between the arrows on a belt, mm.
const BELT_ARROW_SPACING: f64 = 60.0;

/// Draws the view with its upper left corner at a point.
pub(super) fn draw(
    svg: &mut Svg,
    corner: [f64; 2],
    arm: &Geometry,
    joints: &JointAngles,
    around: &Surroundings,
) {
    let panel = Panel {
        part: ABOVE_PART,
        corner,
        scale: SCALE,
        id: "above",
    };
    let pose = arm.forward(joints);
    panel.begin(svg);
    if let Some((_, [[x0, x1], [y0, y1]])) = around.table {
        let far = 1e4;
        let [x0, x1, y0, y1] = [x0, x1, y0, y1].map(|edge| edge.clamp(-far, far));
        let corners = [[x0, y0], [x1, y1]].map(|end| panel.at(end));
        svg.rectangle(
            corners,
            &[
                ("fill", "#f7f3ea"),
                ("stroke", "#ddd3bf"),
                ("stroke-width", "0.3"),
            ],
        );
    }
    let height = around.table.map_or(pose.z, |(height, _)| height);
    let reach = Reach::new(arm.tool, Surface::level(height), 0.0).outline();
    for ring in &reach {
        let ring = ring.iter().map(|point| panel.at(*point));
        let look = [
            ("fill", EMPTY),
            ("fill-opacity", "0.07"),
            ("stroke", "#9db8d9"),
            ("stroke-width", "0.3"),
        ];
        svg.path(&path(ring, true), &look);
    }
    panel.grid(svg);
    if let Some(conveyor) = &around.belt {
        belt(svg, &panel, conveyor);
    }
    ink(svg, &panel, around);
    for object in around.bodies.iter().filter(|object| !object.is_held()) {
        body(svg, &panel, object);
    }
    ground::base(svg, &panel);
    links(svg, &panel, arm, joints);
    for object in around.bodies.iter().filter(|object| object.is_held()) {
        body(svg, &panel, object);
    }
    names(svg, &panel, &around.bodies);
    for [from, to] in &around.beams {
        beam(svg, panel.at([from[0], from[1]]), panel.at([to[0], to[1]]));
    }
    tip(svg, panel.at([pose.x, pose.y]));
    panel.end(svg);
    panel.draw_labels(svg, "X / mm", "Y / mm");
}

fn belt(svg: &mut Svg, panel: &Panel, belt: &Belt) {
    let outline = path(belt.corners().map(|corner| panel.at(corner)), true);
    let look = [
        ("fill", BELT_COLOR),
        ("fill-opacity", "0.45"),
        ("stroke", FAINT),
        ("stroke-width", "0.3"),
    ];
    svg.path(&outline, &look);
    // Arrows show the direction for positive pulses.
    let count = (belt.length / BELT_ARROW_SPACING).clamp(1.0, 50.0) as u32;
    for nth in 0..count {
        let along = belt.length * (f64::from(nth) + 0.5) / f64::from(count);
        let arrow = [(-6.0, 10.0), (4.0, 0.0), (-6.0, -10.0)];
        let data = path(arrow.map(|(x, y)| panel.at(belt.at(along + x, y))), false);
        svg.path(
            &data,
            &[("fill", "none"), ("stroke", PAPER), ("stroke-width", "0.5")],
        );
    }
}

fn ink(svg: &mut Svg, panel: &Panel, around: &Surroundings) {
    for stroke in around.drawing.strokes() {
        let mut data = path(stroke.points.iter().map(|point| panel.at(*point)), false);
        if stroke.points.len() == 1 {
            data.push_str("h0");
        }
        let opacity = Number(stroke.power / 100.0).to_string();
        let (colour, width) = match stroke.kind {
            StrokeKind::Ink => (DRAWN, "0.3"),
            StrokeKind::Burn => (BURNT, "0.2"),
        };
        let look = [
            ("fill", "none"),
            ("stroke", colour),
            ("stroke-opacity", &opacity),
            ("stroke-width", width),
            ("stroke-linecap", "round"),
            ("stroke-linejoin", "round"),
        ];
        svg.path(&data, &look);
    }
}

pub(super) fn body(svg: &mut Svg, panel: &Panel, body: &Body) {
    let corners = body.corners().map(|corner| panel.at(corner));
    let fill = hex(body.color);
    let [edge, thick] = body.edge();
    let look = [
        ("fill", fill.as_str()),
        ("fill-opacity", "0.85"),
        ("stroke", edge),
        ("stroke-width", thick),
    ];
    svg.path(&path(corners, true), &look);
}

/// Writes the objects' names, each to the right of its object, shifted down to avoid overlaps.
fn names(svg: &mut Svg, panel: &Panel, bodies: &[Body]) {
    const NAME_SIZE: f64 = 2.8;
    let style = TextStyle {
        size: NAME_SIZE,
        colour: INK,
        anchor: Anchor::Start,
        rim: true,
    };
    let mut taken: Vec<([f64; 2], f64)> = Vec::new();
    for body in bodies {
        let [x, y, ..] = body.place;
        let [length, width, _] = body.size.map(|side| side / 2.0);
        let reach = libm::hypot(length, width);
        let mut at = panel.at([x + reach + 4.0, y - 4.0]);
        // A letter is about half as wide as high. Without the shift the names of stacked objects
        // would overlap.
        let size = 0.55 * NAME_SIZE * body.name.chars().count() as f64;
        while taken.iter().any(|([left, line], other)| {
            (at[1] - line).abs() < NAME_SIZE && at[0] < left + other && *left < at[0] + size
        }) {
            at[1] += 0.5;
        }
        svg.text(at, &body.name, &style);
        taken.push((at, size));
    }
}

/// Draws the links, from the base axis to the tip of the tool.
pub(super) fn links(svg: &mut Svg, panel: &Panel, arm: &Geometry, joints: &JointAngles) {
    let [axis, wrist, end] = links_from_above(arm, joints).map(|point| panel.at(point));
    let width = Number(LINK_THICKNESS[0] * panel.scale).to_string();
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
    svg.path(&path([axis, wrist], false), &look(&width, "0.55"));
    svg.path(&path([wrist, end], false), &look("2", "0.55"));
    svg.circle(axis, 1.6, &[("fill", "#323f4b")]);
    svg.circle(wrist, 1.6, &[("fill", "#323f4b")]);
}

/// Draws a sensor and its beam.
pub(super) fn beam(svg: &mut Svg, from: [f64; 2], to: [f64; 2]) {
    let look = [
        ("stroke", WRONG),
        ("stroke-width", "0.3"),
        ("stroke-dasharray", "1 0.8"),
    ];
    svg.path(&path([from, to], false), &look);
    svg.circle(
        from,
        0.9,
        &[("fill", WRONG), ("stroke", PAPER), ("stroke-width", "0.2")],
    );
}

/// Draws the tip of the tool.
pub(super) fn tip(svg: &mut Svg, at: [f64; 2]) {
    let look = [("fill", "none"), ("stroke", INK), ("stroke-width", "0.45")];
    svg.circle(at, 1.3, &look);
}
