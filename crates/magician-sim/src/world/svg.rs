//! A drawing as SVG, in true size.

use std::fmt::Write as _;

use super::drawing::{Drawing, StrokeKind};

/// Width of the pen's line, mm (G).
pub(super) const INK_WIDTH: f64 = 0.5;
/// Width of the laser's line, mm (G).
pub(super) const BURN_WIDTH: f64 = 0.2;
/// What is left free around, mm.
const MARGIN: f64 = 5.0;
/// Radius of the arm's mark, mm.
pub(super) const MARK: f64 = 3.0;

impl Drawing {
    /// The drawing as SVG, seen from above: X to the right, Y up, one unit a millimetre, printed in true size. A small
    /// circle with a cross on white paper marks the axis of the arm's base. What was burnt is the darker the more power it got.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let [[left, bottom], [right, top]] = self.frame();
        let (width, height) = (Mm(right - left), Mm(top - bottom));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
             viewBox=\"{} {} {width} {height}\">\n",
            Mm(left),
            Mm(-top)
        );
        // Paper: on a dark page ink on nothing cannot be seen.
        let _ = writeln!(
            svg,
            "<rect x=\"{}\" y=\"{}\" width=\"100%\" height=\"100%\" fill=\"#fff\"/>",
            Mm(left),
            Mm(-top)
        );
        svg.push_str(&mark());
        svg.push_str("<g fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n");
        for stroke in self.strokes() {
            svg.push_str("<path d=\"");
            push_path(&mut svg, &stroke.points);
            svg.push_str("\" ");
            let style = match stroke.kind {
                StrokeKind::Ink => format!("stroke=\"#1a1a1a\" stroke-width=\"{INK_WIDTH}\"/>\n"),
                StrokeKind::Burn => format!(
                    "stroke=\"#4a2508\" stroke-width=\"{BURN_WIDTH}\" stroke-opacity=\"{}\"/>\n",
                    Mm(stroke.power / 100.0)
                ),
            };
            svg.push_str(&style);
        }
        svg.push_str("</g>\n</svg>\n");
        svg
    }

    /// What a picture shows: the drawing and the arm's base, with a margin.
    pub(super) fn frame(&self) -> [[f64; 2]; 2] {
        let [least, most] = self.bounds().unwrap_or_default();
        let low = least.map(|value| value.min(-MARK) - MARGIN);
        let high = most.map(|value| value.max(MARK) + MARGIN);
        [low, high]
    }
}

fn mark() -> String {
    format!(
        "<path d=\"M-{MARK} 0H{MARK}M0 -{MARK}V{MARK}\" stroke=\"#999\" stroke-width=\"0.3\"/>\n\
         <circle r=\"{MARK}\" fill=\"none\" stroke=\"#999\" stroke-width=\"0.3\"/>\n"
    )
}

fn push_path(svg: &mut String, points: &[[f64; 2]]) {
    for (nth, [x, y]) in points.iter().enumerate() {
        let word = if nth == 0 { "M" } else { "L" };
        // Writing to a string does not fail.
        let _ = write!(svg, "{word}{} {}", Mm(*x), Mm(-*y));
    }
    if points.len() == 1 {
        // A line of no length with round ends is a dot.
        svg.push_str("h0");
    }
}

/// A number to a micrometre, without idle zeros.
struct Mm(f64);

impl std::fmt::Display for Mm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = format!("{:.3}", self.0);
        let digits = digits.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if digits == "-0" { "0" } else { digits })
    }
}
