//! Lines on white, in true size.

use std::fmt::Write as _;

/// Lines that look the same.
pub(crate) struct Ink<'a> {
    pub(crate) colour: &'a str,
    /// mm.
    pub(crate) width: f64,
    pub(crate) opacity: f64,
    /// Whether lines end in half circles; what is not opaque would be darker where they overlap.
    pub(crate) round: bool,
    pub(crate) lines: Vec<&'a [[f64; 2]]>,
}

/// The corners of what all lines need, with a margin.
pub(crate) fn around<'a>(
    lines: impl IntoIterator<Item = &'a [[f64; 2]]>,
    margin: f64,
) -> [[f64; 2]; 2] {
    let points = lines.into_iter().flatten();
    let frame = points.fold([[f64::MAX; 2], [f64::MIN; 2]], |[low, high], [x, y]| {
        [
            [low[0].min(*x), low[1].min(*y)],
            [high[0].max(*x), high[1].max(*y)],
        ]
    });
    [
        frame[0].map(|value| value - margin),
        frame[1].map(|value| value + margin),
    ]
}

/// The part of a plane between two corners: x to the right, y up. `rest` is put on top, in the same coordinates with y down.
pub(crate) fn draw([low, high]: [[f64; 2]; 2], inks: &[Ink<'_>], rest: &str) -> String {
    let size = [0, 1].map(|axis| Mm(high[axis] - low[axis]));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}mm\" height=\"{}mm\" viewBox=\"{} {} {} {}\">\n\
         <rect x=\"{}\" y=\"{}\" width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <g fill=\"none\" stroke-linejoin=\"round\">\n",
        size[0],
        size[1],
        Mm(low[0]),
        Mm(-high[1]),
        size[0],
        size[1],
        Mm(low[0]),
        Mm(-high[1]),
    );
    for ink in inks.iter().filter(|ink| !ink.lines.is_empty()) {
        svg.push_str("<path d=\"");
        for line in &ink.lines {
            push(&mut svg, line);
        }
        // Writing to a string does not fail.
        let _ = writeln!(
            svg,
            "\" stroke=\"{}\" stroke-linecap=\"{}\" stroke-width=\"{}\" stroke-opacity=\"{}\"/>",
            ink.colour,
            if ink.round { "round" } else { "butt" },
            Mm(ink.width),
            Mm(ink.opacity)
        );
    }
    svg.push_str("</g>\n");
    svg.push_str(rest);
    svg.push_str("</svg>\n");
    svg
}

/// Each corner from the last, in whole hundredths, so that nothing adds up.
fn push(svg: &mut String, line: &[[f64; 2]]) {
    let mut last: Option<[i64; 2]> = None;
    for [x, y] in line {
        let to = [*x, -*y].map(|value| (value * 100.0).round() as i64);
        let way =
            last.map(|last| [to[0] - last[0], to[1] - last[1]].map(|way| Mm(way as f64 / 100.0)));
        let at = to.map(|value| Mm(value as f64 / 100.0));
        let _ = match way {
            None => write!(svg, "M{} {}", at[0], at[1]),
            Some([dx, Mm(0.0)]) => write!(svg, "h{dx}"),
            Some([Mm(0.0), dy]) => write!(svg, "v{dy}"),
            Some([dx, dy]) => write!(svg, "l{dx} {dy}"),
        };
        last = Some(to);
    }
}

/// To a hundredth, without idle zeros.
#[derive(Clone, Copy)]
pub(crate) struct Mm(pub(crate) f64);

impl std::fmt::Display for Mm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", (self.0 * 100.0).round() / 100.0 + 0.0)
    }
}
