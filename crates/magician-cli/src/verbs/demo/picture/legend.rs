//! What the colours mean.

use magician_picture::svg::palette::{CARGO, CARRIED, EMPTY, FAINT, INK, PAPER, REACH, REACH_EDGE};
use magician_picture::svg::{Svg, path};

/// Draws it.
pub(super) fn draw(svg: &mut Svg) {
    const Y: f64 = 856.0;
    let text = [("font-size", "14"), ("fill", INK)];
    let mut x = 60.0;
    for (colour, label, width) in [
        (EMPTY, "tool without a cube", 190.0),
        (CARRIED, "tool with a cube", 170.0),
    ] {
        let data = path([[x, Y - 5.0], [x + 28.0, Y - 5.0]], false);
        svg.path(&data, &[("stroke", colour), ("stroke-width", "3")]);
        svg.label([x + 36.0, Y], label, &text);
        x += width + 20.0;
    }
    for (fill, stroke, dashes, label, width) in [
        (PAPER, FAINT, "none", "cube, before", 120.0),
        (CARGO, CARRIED, "none", "cube, after", 112.0),
        (
            REACH,
            REACH_EDGE,
            "none",
            "within reach at some height",
            215.0,
        ),
        (
            "none",
            REACH_EDGE,
            "5 4",
            "within reach at the height of the cubes",
            300.0,
        ),
    ] {
        let attributes = [
            ("rx", "2"),
            ("fill", fill),
            ("stroke", stroke),
            ("stroke-width", "1.5"),
            ("stroke-dasharray", dashes),
        ];
        svg.rectangle([[x, Y - 13.0], [x + 16.0, Y + 3.0]], &attributes);
        svg.label([x + 24.0, Y], label, &text);
        x += width + 20.0;
    }
}
