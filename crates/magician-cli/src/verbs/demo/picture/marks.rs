//! What both views draw: tracks, places, labels.

use std::fmt::Display;

use magician_picture::svg::palette::{CARRIED, EMPTY, INK, PAPER};
use magician_picture::svg::{Number, Svg, lines, rim};

use super::Sample;

/// The path of the tool, a line for each stretch with or without a cube.
pub(super) fn tracks(svg: &mut Svg, samples: &[Sample], at: impl Fn(&Sample) -> [f64; 2]) {
    let places: Vec<[f64; 2]> = samples.iter().map(at).collect();
    let mut stretches = [Vec::new(), Vec::new()];
    let mut from = 0;
    for run in samples.chunk_by(|a, b| a.carrying == b.carrying) {
        let (first, until) = (from, from + run.len());
        // A stretch begins where the one before it ended.
        let stretch = &places[first.saturating_sub(1)..until];
        stretches[usize::from(run[0].carrying)].push(stretch);
        from = until;
    }
    for (stretches, colour) in stretches.into_iter().zip([EMPTY, CARRIED]) {
        let attributes = [
            ("fill", "none"),
            ("stroke", colour),
            ("stroke-width", "2"),
            ("stroke-opacity", "0.85"),
            ("stroke-linejoin", "round"),
            ("stroke-linecap", "round"),
        ];
        svg.path(&lines(stretches, |place| place), &attributes);
    }
}

pub(super) fn marker(svg: &mut Svg, [x, y]: [f64; 2], label: &str, shift: [f64; 2]) {
    let look = [("fill", PAPER), ("stroke", INK), ("stroke-width", "2")];
    svg.circle([x, y], 5.0, &look);
    let text = [("font-size", "14"), ("fill", INK), ("font-weight", "bold")];
    haloed(svg, [x + shift[0], y + shift[1]], label, &text);
}

/// Text that stays legible on lines.
pub(super) fn haloed(svg: &mut Svg, at: [f64; 2], text: impl Display, attributes: &[(&str, &str)]) {
    svg.label(at, text, &[attributes, &rim("4")].concat());
}

pub(super) fn rectangle(
    svg: &mut Svg,
    corners: [[f64; 2]; 2],
    fill: &str,
    stroke: &str,
    round: f64,
) {
    let round = Number(round).to_string();
    let attributes = [
        ("rx", round.as_str()),
        ("fill", fill),
        ("stroke", stroke),
        ("stroke-width", "1.5"),
    ];
    svg.rectangle(corners, &attributes);
}
