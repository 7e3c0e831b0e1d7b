//! Pictures of the marks that pen and laser left, in true size.

#[cfg(feature = "png")]
mod png;

use magician_motion::TopView;
use magician_sim::world::{Drawing, Stroke, StrokeKind};

#[cfg(feature = "png")]
pub use png::drawing_png;

use crate::svg::palette::{BURNT, DRAWN, EDGE};
use crate::svg::{Fine, Svg, fine_path};

/// Width of the pen's line, mm. Assumed without a source (G): pens differ.
const INK_WIDTH: f64 = 0.5;
/// Width of the laser's line, mm. Assumed without a source (G): it depends on focus and material.
const BURN_WIDTH: f64 = 0.2;
/// Margin, mm.
const MARGIN: f64 = 5.0;
/// Radius of the mark at the arm's base axis, mm.
const BASE_MARK_RADIUS: f64 = 3.0;

/// Additional contents of a picture of a drawing.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DrawingOptions {
    /// Corners of the sheet in the arm's x and y, mm. If given, the picture shows the whole sheet.
    pub sheet: Option<Vec<[f64; 2]>>,
    /// True if the picture extends to the arm's base.
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

/// Returns the picture of a drawing as SVG, seen from above.
///
/// X goes to the right and Y up, and one unit is a millimetre. The picture has a margin and prints
/// in true size. Burnt lines are darker with more power. The picture can include the sheet, and the
/// arm's base axis as a circle with a cross.
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
    let [[left, bottom], [right, top]] = shown_part(drawing, options);
    let mut svg = Svg::true_size([left, -top], [right - left, top - bottom]);
    if let Some(corners) = &options.sheet {
        let data = data(corners) + "Z";
        let attributes = [
            ("class", "sheet"),
            ("d", data.as_str()),
            ("fill", "none"),
            ("stroke", EDGE),
            ("stroke-width", "0.3"),
        ];
        svg.leaf("path", &attributes);
    }
    if shows_base(drawing, options) {
        draw_base_mark(&mut svg);
    }
    let attributes = [
        ("fill", "none"),
        ("stroke-linecap", "round"),
        ("stroke-linejoin", "round"),
    ];
    svg.group("g", &attributes);
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
                let mut attributes = vec![
                    ("stroke", BURNT),
                    ("stroke-width", burn.as_str()),
                    ("stroke-opacity", &power),
                ];
                if !has_round_ends(stroke) {
                    attributes.push(("stroke-linecap", "butt"));
                }
                svg.path(&data, &attributes);
            }
        }
    }
    svg.finish()
}

/// True if the base is shown: on request, or if there is nothing else to show.
fn shows_base(drawing: &Drawing, options: &DrawingOptions) -> bool {
    options.whole || (drawing.bounds().is_none() && options.sheet.is_none())
}

/// Lower left and upper right corner of the part of the plane that is shown, mm, with the margin.
fn shown_part(drawing: &Drawing, options: &DrawingOptions) -> [[f64; 2]; 2] {
    let drawn = drawing.bounds().into_iter().flatten();
    let sheet = options.sheet.iter().flatten().copied();
    let base = [[-BASE_MARK_RADIUS; 2], [BASE_MARK_RADIUS; 2]].into_iter();
    let base = base.filter(|_| shows_base(drawing, options));
    let shown = drawn.chain(sheet).chain(base).map(project);
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

/// True if a line has round caps. Burnt lines have none: where the power changes, overlapping caps
/// would be darker than both lines. A dot needs them to be visible at all.
fn has_round_ends(stroke: &Stroke) -> bool {
    stroke.kind == StrokeKind::Ink || stroke.points.len() < 2
}

/// Projects a point of the ground to the picture.
fn project(place: [f64; 2]) -> [f64; 2] {
    TopView::PAPER.project(place)
}

/// Marks the axis of the base with a circle and a cross.
fn draw_base_mark(svg: &mut Svg) {
    let attributes = [("stroke", EDGE), ("stroke-width", "0.3")];
    svg.path(
        &format!(
            "M-{BASE_MARK_RADIUS} 0H{BASE_MARK_RADIUS}M0 -{BASE_MARK_RADIUS}V{BASE_MARK_RADIUS}"
        ),
        &attributes,
    );
    let radius = Fine(BASE_MARK_RADIUS).to_string();
    let attributes = [("r", radius.as_str()), ("fill", "none")]
        .into_iter()
        .chain(attributes);
    svg.leaf("circle", &attributes.collect::<Vec<_>>());
}

/// Returns path data through points of the ground, y down.
fn data(points: &[[f64; 2]]) -> String {
    fine_path(points.iter().map(|point| {
        let [x, y] = project(*point);
        [x, -y]
    }))
}
