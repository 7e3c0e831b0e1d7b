//! What the colours mean.

use super::svg::{Svg, number, path};
use super::{CARRYING, CUBE_FILL, EMPTY, FAINT, INK, REACH_EDGE, REACH_FILL};

/// Draws it.
pub(super) fn draw(svg: &mut Svg) {
    const Y: f64 = 856.0;
    let text = [("font-size", "14"), ("fill", INK)];
    let mut x = 60.0;
    for (colour, label, width) in [
        (EMPTY, "tool without a cube", 190.0),
        (CARRYING, "tool with a cube", 170.0),
    ] {
        let data = path([(x, Y - 5.0), (x + 28.0, Y - 5.0)], false);
        let line = [
            ("d", data.as_str()),
            ("stroke", colour),
            ("stroke-width", "3"),
        ];
        svg.leaf("path", &line);
        svg.text((x + 36.0, Y), label, &text);
        x += width + 20.0;
    }
    for (fill, stroke, dashes, label, width) in [
        ("#ffffff", FAINT, "none", "cube, before", 120.0),
        (CUBE_FILL, CARRYING, "none", "cube, after", 112.0),
        (
            REACH_FILL,
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
        let left = number(x);
        let top = number(Y - 13.0);
        let attributes = [
            ("x", left.as_str()),
            ("y", &top),
            ("width", "16"),
            ("height", "16"),
            ("rx", "2"),
            ("fill", fill),
            ("stroke", stroke),
            ("stroke-width", "1.5"),
            ("stroke-dasharray", dashes),
        ];
        svg.leaf("rect", &attributes);
        svg.text((x + 24.0, Y), label, &text);
        x += width + 20.0;
    }
}
