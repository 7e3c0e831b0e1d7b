//! A drawing as SVG, in true size.

use std::fmt::Write as _;

use magician_motion::TopView;

use super::drawing::{Drawing, StrokeKind};

/// Width of the pen's line, mm (G).
pub(super) const INK_WIDTH: f64 = 0.5;
/// Width of the laser's line, mm (G).
pub(super) const BURN_WIDTH: f64 = 0.2;
/// What is left free around, mm.
const MARGIN: f64 = 5.0;
/// Radius of the arm's mark, mm.
pub(super) const MARK: f64 = 3.0;

/// What a picture of a drawing shows besides what was left.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PictureOptions {
    /// The corners of the sheet, where it is known, in the arm's x and y, mm: the picture shows all of it.
    pub sheet: Option<Vec<[f64; 2]>>,
    /// Whether the picture goes as far as the arm's base.
    pub whole: bool,
}

impl PictureOptions {
    /// Sets [`sheet`](Self::sheet).
    #[must_use]
    pub fn sheet(mut self, corners: impl Into<Vec<[f64; 2]>>) -> Self {
        self.sheet = Some(corners.into());
        self
    }

    /// Sets [`whole`](Self::whole).
    #[must_use]
    pub fn whole(mut self, whole: bool) -> Self {
        self.whole = whole;
        self
    }
}

impl Drawing {
    /// The drawing as SVG, seen from above: X to the right, Y up, one unit a millimetre, printed in true size, with a margin.
    /// What was burnt is the darker the more power it got.
    #[must_use]
    pub fn to_svg(&self) -> String {
        self.to_svg_with(&PictureOptions::default())
    }

    /// The same with the sheet that it lies on, or as far as the arm's base, whose axis a small circle with a cross marks.
    #[must_use]
    pub fn to_svg_with(&self, options: &PictureOptions) -> String {
        let [[left, bottom], [right, top]] = self.frame(options);
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
        if let Some(corners) = &options.sheet {
            svg.push_str("<path class=\"sheet\" d=\"");
            push_path(&mut svg, corners);
            svg.push_str("Z\" fill=\"none\" stroke=\"#999\" stroke-width=\"0.3\"/>\n");
        }
        if self.shows_base(options) {
            svg.push_str(&mark());
        }
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

    /// Whether the base is in a picture: if that is asked for, or if there is nothing else to show.
    pub(super) fn shows_base(&self, options: &PictureOptions) -> bool {
        options.whole || (self.bounds().is_none() && options.sheet.is_none())
    }

    /// What a picture shows, with a margin, as a part of the plane: to the right, and up.
    pub(super) fn frame(&self, options: &PictureOptions) -> [[f64; 2]; 2] {
        let drawn = self.bounds().into_iter().flatten();
        let sheet = options.sheet.iter().flatten().copied();
        let base = [[-MARK; 2], [MARK; 2]].into_iter();
        let base = base.filter(|_| self.shows_base(options));
        let shown = drawn.chain(sheet).chain(base).map(seen);
        let shown = shown.fold([[f64::MAX; 2], [f64::MIN; 2]], |[low, high], [x, y]| {
            [
                [low[0].min(x), low[1].min(y)],
                [high[0].max(x), high[1].max(y)],
            ]
        });
        let [low, high] = shown;
        [
            low.map(|least| least - MARGIN),
            high.map(|most| most + MARGIN),
        ]
    }
}

/// A place of the ground as a picture of paper shows it.
pub(super) fn seen(place: [f64; 2]) -> [f64; 2] {
    TopView::PAPER.project(place)
}

fn mark() -> String {
    format!(
        "<path d=\"M-{MARK} 0H{MARK}M0 -{MARK}V{MARK}\" stroke=\"#999\" stroke-width=\"0.3\"/>\n\
         <circle r=\"{MARK}\" fill=\"none\" stroke=\"#999\" stroke-width=\"0.3\"/>\n"
    )
}

fn push_path(svg: &mut String, points: &[[f64; 2]]) {
    for (nth, point) in points.iter().enumerate() {
        let word = if nth == 0 { "M" } else { "L" };
        let [x, y] = seen(*point);
        // Writing to a string does not fail.
        let _ = write!(svg, "{word}{} {}", Mm(x), Mm(-y));
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
