//! What pen and laser left, in true size.

#[cfg(feature = "png")]
mod png;

use magician_motion::TopView;
use magician_sim::world::{Drawing, Stroke, StrokeKind};

#[cfg(feature = "png")]
pub use png::drawing_png;

use crate::svg::palette::{BURNT, DRAWN, EDGE};
use crate::svg::{Fine, Svg, fine_path};

/// Width of the pen's line, mm (G).
const INK_WIDTH: f64 = 0.5;
/// Width of the laser's line, mm (G).
const BURN_WIDTH: f64 = 0.2;
/// What is left free around, mm.
const MARGIN: f64 = 5.0;
/// Radius of the arm's mark, mm.
const MARK: f64 = 3.0;

/// What a picture of a drawing shows besides what was left.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DrawingOptions {
    /// The corners of the sheet, where it is known, in the arm's x and y, mm: the picture shows all of it.
    pub sheet: Option<Vec<[f64; 2]>>,
    /// Whether the picture goes as far as the arm's base.
    pub whole: bool,
}

impl DrawingOptions {
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

/// The picture of a drawing as SVG, seen from above: X to the right, Y up, one unit a millimetre, printed in true size, with a
/// margin; what was burnt is the darker the more power it got. With the sheet that it lies on, or as far as the arm's base,
/// whose axis a small circle with a cross marks.
///
/// ```
/// use magician_picture::{DrawingOptions, drawing_svg};
/// use magician_sim::world::{Drawing, Stroke, StrokeKind};
///
/// let points = vec![[200.0, 0.0], [240.0, 0.0]];
/// let stroke = Stroke { kind: StrokeKind::Ink, power: 100.0, points };
/// let svg = drawing_svg(&Drawing::from(vec![stroke]), &DrawingOptions::default());
/// assert!(svg.contains("d=\"M200 0L240 0\""));
/// ```
#[must_use]
pub fn drawing_svg(drawing: &Drawing, options: &DrawingOptions) -> String {
    let [[left, bottom], [right, top]] = frame(drawing, options);
    let mut svg = Svg::true_size([left, -top], [right - left, top - bottom]);
    if let Some(corners) = &options.sheet {
        let data = data(corners) + "Z";
        let look = [
            ("class", "sheet"),
            ("d", data.as_str()),
            ("fill", "none"),
            ("stroke", EDGE),
            ("stroke-width", "0.3"),
        ];
        svg.leaf("path", &look);
    }
    if shows_base(drawing, options) {
        mark(&mut svg);
    }
    let look = [
        ("fill", "none"),
        ("stroke-linecap", "round"),
        ("stroke-linejoin", "round"),
    ];
    svg.group("g", &look);
    svg.line_feed();
    let [ink, burn] = [INK_WIDTH, BURN_WIDTH].map(|width| Fine(width).to_string());
    for stroke in drawing.strokes() {
        let data = data(&stroke.points);
        match stroke.kind {
            StrokeKind::Ink => {
                svg.path(&data, &[("stroke", DRAWN), ("stroke-width", &ink)]);
            }
            StrokeKind::Burn => {
                let power = Fine(stroke.power / 100.0).to_string();
                let mut look = vec![
                    ("stroke", BURNT),
                    ("stroke-width", burn.as_str()),
                    ("stroke-opacity", &power),
                ];
                if !has_round_ends(stroke) {
                    look.push(("stroke-linecap", "butt"));
                }
                svg.path(&data, &look);
            }
        }
    }
    svg.finish()
}

/// Whether the base is in a picture: if that is asked for, or if there is nothing else to show.
fn shows_base(drawing: &Drawing, options: &DrawingOptions) -> bool {
    options.whole || (drawing.bounds().is_none() && options.sheet.is_none())
}

/// What a picture shows, with a margin, as a part of the plane: to the right, and up.
fn frame(drawing: &Drawing, options: &DrawingOptions) -> [[f64; 2]; 2] {
    let drawn = drawing.bounds().into_iter().flatten();
    let sheet = options.sheet.iter().flatten().copied();
    let base = [[-MARK; 2], [MARK; 2]].into_iter();
    let base = base.filter(|_| shows_base(drawing, options));
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

/// Whether a line ends in half circles. A line that is burnt does not: where its power changes, ends that overlap would be darker than
/// both. A dot would be nothing without.
fn has_round_ends(stroke: &Stroke) -> bool {
    stroke.kind == StrokeKind::Ink || stroke.points.len() < 2
}

/// A place of the ground as a picture of paper shows it.
fn seen(place: [f64; 2]) -> [f64; 2] {
    TopView::PAPER.project(place)
}

/// The axis of the base: a circle with a cross.
fn mark(svg: &mut Svg) {
    let look = [("stroke", EDGE), ("stroke-width", "0.3")];
    svg.path(&format!("M-{MARK} 0H{MARK}M0 -{MARK}V{MARK}"), &look);
    let radius = Fine(MARK).to_string();
    let look = [("r", radius.as_str()), ("fill", "none")]
        .into_iter()
        .chain(look);
    svg.leaf("circle", &look.collect::<Vec<_>>());
}

/// The path through places of the ground, y down.
fn data(points: &[[f64; 2]]) -> String {
    fine_path(points.iter().map(|point| {
        let [x, y] = seen(*point);
        [x, -y]
    }))
}
