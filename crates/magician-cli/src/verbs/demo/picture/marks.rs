//! What both views draw: tracks, places, labels.

use std::fmt::Display;

use super::svg::{Svg, number, path};
use super::{CARRYING, EMPTY, INK, Sample};

/// The way of the tool, a line for each stretch with or without a cube.
pub(super) fn tracks(svg: &mut Svg, samples: &[Sample], at: impl Fn(&Sample) -> (f64, f64)) {
    for carrying in [false, true] {
        let mut data = String::new();
        let mut last: Option<&Sample> = None;
        for run in samples.chunk_by(|a, b| a.carrying == b.carrying) {
            // A stretch begins where the one before it ended.
            if run.first().is_some_and(|first| first.carrying == carrying) {
                data.push_str(&path(last.into_iter().chain(run).map(&at), false));
            }
            last = run.last();
        }
        let colour = if carrying { CARRYING } else { EMPTY };
        let attributes = [
            ("d", data.as_str()),
            ("fill", "none"),
            ("stroke", colour),
            ("stroke-width", "2"),
            ("stroke-opacity", "0.85"),
            ("stroke-linejoin", "round"),
            ("stroke-linecap", "round"),
        ];
        svg.leaf("path", &attributes);
    }
}

pub(super) fn marker(svg: &mut Svg, (x, y): (f64, f64), label: &str, shift: (f64, f64)) {
    let (cx, cy) = (number(x), number(y));
    let attributes = [
        ("cx", cx.as_str()),
        ("cy", cy.as_str()),
        ("r", "5"),
        ("fill", "#ffffff"),
        ("stroke", INK),
        ("stroke-width", "2"),
    ];
    svg.leaf("circle", &attributes);
    let text = [("font-size", "14"), ("fill", INK), ("font-weight", "bold")];
    haloed(svg, (x + shift.0, y + shift.1), label, &text);
}

/// Text that stays legible on lines.
pub(super) fn haloed(
    svg: &mut Svg,
    at: (f64, f64),
    text: impl Display,
    attributes: &[(&str, &str)],
) {
    let halo = [
        ("stroke", "#ffffff"),
        ("stroke-width", "4"),
        ("stroke-linejoin", "round"),
        ("paint-order", "stroke"),
    ];
    svg.text(at, text, &[attributes, &halo].concat());
}

pub(super) fn rectangle(
    svg: &mut Svg,
    a: (f64, f64),
    b: (f64, f64),
    fill: &str,
    stroke: &str,
    round: &str,
) {
    let [x, y, width, height] = [
        a.0.min(b.0),
        a.1.min(b.1),
        (a.0 - b.0).abs(),
        (a.1 - b.1).abs(),
    ]
    .map(number);
    let attributes = [
        ("x", x.as_str()),
        ("y", &y),
        ("width", &width),
        ("height", &height),
        ("rx", round),
        ("fill", fill),
        ("stroke", stroke),
        ("stroke-width", "1.5"),
    ];
    svg.leaf("rect", &attributes);
}
