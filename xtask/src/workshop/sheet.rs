//! Lines on white, in true size.

use magician_picture::svg::{Number, Svg, lines};

/// Lines of one style.
pub(crate) struct Ink<'a> {
    pub(crate) colour: &'a str,
    /// Width of the lines, mm.
    pub(crate) width: f64,
    pub(crate) opacity: f64,
    /// True for round ends. Translucent lines would be darker where round ends overlap.
    pub(crate) round: bool,
    pub(crate) lines: Vec<&'a [[f64; 2]]>,
}

/// Returns the corners of the area that contains all lines, with a margin.
pub(crate) fn corners_around<'a>(
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

/// Draws the area between two corners: x to the right, y up.
pub(crate) fn draw([low, high]: [[f64; 2]; 2], inks: &[Ink<'_>]) -> String {
    let hundredths = |value: f64| (value * 100.0).round() / 100.0;
    let [left, right, bottom, top] = [low[0], high[0], low[1], high[1]].map(hundredths);
    let mut svg = Svg::true_size([left, -top], [right - left, top - bottom]);
    svg.group("g", &[("fill", "none"), ("stroke-linejoin", "round")]);
    svg.line_feed();
    for ink in inks.iter().filter(|ink| !ink.lines.is_empty()) {
        let [width, opacity] = [ink.width, ink.opacity].map(|value| Number(value).to_string());
        let look = [
            ("stroke", ink.colour),
            ("stroke-linecap", if ink.round { "round" } else { "butt" }),
            ("stroke-width", &width),
            ("stroke-opacity", &opacity),
        ];
        svg.path(&lines(ink.lines.iter().copied(), |[x, y]| [x, -y]), &look);
    }
    svg.end();
    svg.finish()
}
