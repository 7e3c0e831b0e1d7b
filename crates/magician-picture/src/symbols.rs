//! Symbols: start and end, tool actions, refused steps.

use magician_program::toolpath::{Marker, MarkerKind};

use crate::panel::Panel;
use crate::svg::palette::{CARRIED, FAINT, INK, PAPER, WRONG};
use crate::svg::{Anchor, Svg, TextStyle, path, segments};

/// Distance between signs, mm.
const SIGN_SPACING: f64 = 3.8;
/// Offset of the first sign from its point, mm.
const FIRST_SIGN_OFFSET: [f64; 2] = [2.8, -2.8];

/// Draws a dot at the start and a ring at the end.
pub(super) fn ends(svg: &mut Svg, [start, end]: [[f64; 2]; 2]) {
    begin(svg, start);
    finish(svg, end);
}

pub(super) fn begin(svg: &mut Svg, at: [f64; 2]) {
    svg.circle(
        at,
        1.1,
        &[("fill", INK), ("stroke", PAPER), ("stroke-width", "0.3")],
    );
}

pub(super) fn finish(svg: &mut Svg, at: [f64; 2]) {
    let look = [("fill", "none"), ("stroke", INK), ("stroke-width", "0.5")];
    svg.circle(at, 2.1, &look);
}

/// Draws the signs of a point side by side, and its name.
pub(super) fn markers(svg: &mut Svg, [x, y]: [f64; 2], mark: &Marker) {
    spot(svg, [x, y]);
    let mut x = x + FIRST_SIGN_OFFSET[0];
    for kind in &mark.kinds {
        sign(svg, [x, y + FIRST_SIGN_OFFSET[1]], *kind);
        x += SIGN_SPACING;
    }
    if let Some(name) = &mark.name {
        let label = TextStyle {
            size: 3.0,
            colour: INK,
            anchor: Anchor::Start,
            rim: true,
        };
        svg.text([x - 1.2, y + FIRST_SIGN_OFFSET[1] + 1.1], name, &label);
    }
}

/// Draws the point itself.
pub(super) fn spot(svg: &mut Svg, at: [f64; 2]) {
    svg.circle(at, 0.8, &[("fill", CARRIED)]);
}

/// Draws a sign: a filled triangle pointing up for gripping, a hollow one pointing down for
/// releasing, a clock for waiting.
pub(super) fn sign(svg: &mut Svg, [x, y]: [f64; 2], kind: MarkerKind) {
    let triangle = |sign: f64| {
        let corners = [[-1.5, 1.2], [1.5, 1.2], [0.0, -1.5]];
        path(corners.map(|[dx, dy]| [x + dx, y + sign * dy]), true)
    };
    let look = |fill| {
        [
            ("fill", fill),
            ("stroke", CARRIED),
            ("stroke-width", "0.4"),
            ("stroke-linejoin", "round"),
        ]
    };
    match kind {
        MarkerKind::Pick => svg.path(&triangle(1.0), &look(CARRIED)),
        MarkerKind::Place => svg.path(&triangle(-1.0), &look(PAPER)),
        MarkerKind::Wait => {
            let look = [("fill", PAPER), ("stroke", FAINT), ("stroke-width", "0.35")];
            svg.circle([x, y], 1.4, &look);
            let hands = path([[x, y - 0.9], [x, y], [x + 0.7, y]], false);
            svg.path(
                &hands,
                &[("fill", "none"), ("stroke", INK), ("stroke-width", "0.3")],
            );
        }
    }
}

/// Draws a crossed ring at a refused step, with its number. Outside the frame it moves to the edge.
pub(super) fn refused_step(svg: &mut Svg, panel: &Panel, at: [f64; 2], step: u64) {
    let [low, high] = panel.part;
    let inside = [0, 1].map(|axis| at[axis].clamp(low[axis] + 3.0, high[axis] - 3.0));
    let [x, y] = panel.at(inside);
    let ring = [("fill", "none"), ("stroke", WRONG), ("stroke-width", "0.6")];
    svg.circle([x, y], 2.4, &ring);
    let falling = [[x - 1.0, y - 1.0], [x + 1.0, y + 1.0]];
    let rising = [[x - 1.0, y + 1.0], [x + 1.0, y - 1.0]];
    svg.path(&segments([falling, rising]), &ring);
    let left = inside[0] > high[0] - 24.0;
    let label = TextStyle {
        size: 3.0,
        colour: WRONG,
        anchor: if left { Anchor::End } else { Anchor::Start },
        rim: true,
    };
    let aside = if left { -3.4 } else { 3.4 };
    svg.text([x + aside, y + 1.1], format_args!("step {step}"), &label);
}
