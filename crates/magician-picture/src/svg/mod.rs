//! Writer of SVG: nested elements with escaped attributes, and numbers and paths as short as
//! possible.

pub mod palette;

use std::fmt::{Display, Write};

use magician_protocol::{markup, visible};

/// Font families for the texts of pictures, in order of preference.
pub const FONT_FAMILIES: &str = "Roboto, 'DejaVu Sans', Helvetica, Arial, sans-serif";

const XMLNS: &str = "http://www.w3.org/2000/svg";

/// An SVG being written.
#[derive(Debug, Default)]
pub struct Svg {
    text: String,
    open: Vec<&'static str>,
}

/// Direction of a line of text from its anchor point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// To the right.
    Start,
    /// Centred.
    Middle,
    /// To the left.
    End,
}

/// Style of a line of text.
#[derive(Clone, Copy, Debug)]
pub struct TextStyle {
    /// Height of the letters.
    pub size: f64,
    /// Colour, from the [`palette`].
    pub colour: &'static str,
    /// Anchor.
    pub anchor: Anchor,
    /// True for a white rim, which keeps the text legible on lines.
    pub rim: bool,
}

impl Svg {
    /// Begins a picture of this size on white, with a title that viewers show. Coordinates are in
    /// `unit` (such as `mm`), or in pixels if `unit` is empty. X goes to the right, y down.
    ///
    /// ```
    /// use magician_picture::svg::{Number, Svg, palette, path};
    ///
    /// let mut svg = Svg::page([40.0, 20.0], "mm", "a <line>");
    /// let line = path([[5.0, 10.0], [35.0, 10.5]], false);
    /// svg.path(&line, &[("stroke", palette::INK), ("stroke-width", &Number(0.5).to_string())]);
    /// let text = svg.finish();
    /// assert!(text.contains("a &lt;line&gt;") && text.contains("d=\"m5 10 30 .5\""));
    /// ```
    #[must_use]
    pub fn page([width, height]: [f64; 2], unit: &str, title: &str) -> Self {
        let [width, height] = [width, height].map(Number);
        let mut svg = Self::default();
        let view = format!("0 0 {width} {height}");
        let size = [width, height].map(|side| format!("{side}{unit}"));
        let attributes = [
            ("xmlns", XMLNS),
            ("width", &size[0]),
            ("height", &size[1]),
            ("viewBox", &view),
            ("font-family", FONT_FAMILIES),
        ];
        svg.group("svg", &attributes);
        svg.group("title", &[]);
        escape(title, &mut svg.text);
        svg.end();
        let ground = [
            ("width", "100%"),
            ("height", "100%"),
            ("fill", palette::PAPER),
        ];
        svg.leaf("rect", &ground);
        svg
    }

    /// Begins a picture on white that shows a part of a plane in true size. The part is given by
    /// its upper left corner, and its width and height, mm. X goes to the right, y down.
    #[must_use]
    pub fn true_size([left, top]: [f64; 2], [width, height]: [f64; 2]) -> Self {
        let [left, top, width, height] =
            [left, top, width, height].map(|value| Fine(value).to_string());
        let mut svg = Self::default();
        let attributes = [
            ("xmlns", XMLNS),
            ("width", &format!("{width}mm")),
            ("height", &format!("{height}mm")),
            ("viewBox", &format!("{left} {top} {width} {height}")),
        ];
        svg.group("svg", &attributes);
        svg.line_feed();
        // White paper, because ink on a transparent background is invisible on a dark page.
        let ground = [
            ("x", left.as_str()),
            ("y", &top),
            ("width", "100%"),
            ("height", "100%"),
            ("fill", palette::PAPER),
        ];
        svg.leaf("rect", &ground);
        svg
    }

    /// Adds a line feed.
    pub fn line_feed(&mut self) {
        self.text.push('\n');
    }

    /// Opens an element; [`end`](Self::end) closes it.
    pub fn group(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.tag(name, attributes, ">");
        self.open.push(name);
    }

    /// Closes the element opened last.
    pub fn end(&mut self) {
        if let Some(name) = self.open.pop() {
            // Writing to a string cannot fail.
            let _ = writeln!(self.text, "</{name}>");
        }
    }

    /// Adds an element without content.
    pub fn leaf(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.tag(name, attributes, "/>");
        self.text.push('\n');
    }

    /// Adds a path in coordinates of the picture.
    pub fn path(&mut self, data: &str, attributes: &[(&str, &str)]) {
        let data = [("d", data)];
        self.leaf("path", &[&data, attributes].concat());
    }

    /// Adds a circle.
    pub fn circle(&mut self, [x, y]: [f64; 2], radius: f64, attributes: &[(&str, &str)]) {
        let [x, y, radius] = [x, y, radius].map(|value| Number(value).to_string());
        let round = [("cx", x.as_str()), ("cy", &y), ("r", &radius)];
        self.leaf("circle", &[&round, attributes].concat());
    }

    /// Adds a rectangle given by two opposite corners.
    pub fn rectangle(&mut self, corners: [[f64; 2]; 2], attributes: &[(&str, &str)]) {
        let [[x, y], [width, height]] = {
            let [a, b] = corners;
            let low = [a[0].min(b[0]), a[1].min(b[1])];
            [low, [(a[0] - b[0]).abs(), (a[1] - b[1]).abs()]]
        };
        let [x, y, width, height] = [x, y, width, height].map(|value| Number(value).to_string());
        let frame = [
            ("x", x.as_str()),
            ("y", &y),
            ("width", &width),
            ("height", &height),
        ];
        self.leaf("rect", &[&frame, attributes].concat());
    }

    /// Adds a line of text.
    pub fn text(&mut self, at: [f64; 2], text: impl Display, style: &TextStyle) {
        let size = Number(style.size).to_string();
        let mut attributes = vec![("font-size", size.as_str()), ("fill", style.colour)];
        match style.anchor {
            Anchor::Start => {}
            Anchor::Middle => attributes.push(("text-anchor", "middle")),
            Anchor::End => attributes.push(("text-anchor", "end")),
        }
        if style.rim {
            attributes.extend(rim("0.9"));
        }
        self.label(at, text, &attributes);
    }

    /// Adds a line of text with custom attributes.
    pub fn label(&mut self, [x, y]: [f64; 2], text: impl Display, attributes: &[(&str, &str)]) {
        let [x, y] = [x, y].map(|value| Number(value).to_string());
        let at = [("x", x.as_str()), ("y", &y)];
        self.tag("text", &[&at, attributes].concat(), ">");
        escape(text, &mut self.text);
        self.text.push_str("</text>\n");
    }

    fn tag(&mut self, name: &str, attributes: &[(&str, &str)], end: &str) {
        self.text.push('<');
        self.text.push_str(name);
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"");
            escape(value, &mut self.text);
            self.text.push('"');
        }
        self.text.push_str(end);
    }

    /// Closes all elements and returns the text.
    #[must_use]
    pub fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.end();
        }
        self.text
    }
}

/// Attributes of a white rim, which keeps text legible on lines.
#[must_use]
pub fn rim(width: &str) -> [(&str, &str); 4] {
    [
        ("stroke", palette::PAPER),
        ("stroke-width", width),
        ("stroke-linejoin", "round"),
        ("paint-order", "stroke"),
    ]
}

/// Escapes markup. Characters that XML forbids or that change the direction of text are shown by
/// [`visible`].
fn escape(text: impl Display, to: &mut String) {
    let _ = write!(to, "{}", markup(visible(text)));
}

/// A length rounded to 0.01 mm, as short as possible.
#[derive(Clone, Copy)]
pub struct Number(pub f64);

impl Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        rounded(f, self.0, 100.0)
    }
}

/// A length rounded to a micrometre, as short as possible.
#[derive(Clone, Copy)]
pub struct Fine(pub f64);

impl Display for Fine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        rounded(f, self.0, 1000.0)
    }
}

fn rounded(f: &mut std::fmt::Formatter<'_>, value: f64, parts: f64) -> std::fmt::Result {
    // Adding 0 turns -0 into 0.
    write!(f, "{}", (value * parts).round() / parts + 0.0)
}

/// Formats a number for people, with a true minus sign.
#[must_use]
pub fn signed(value: f64) -> String {
    Number(value).to_string().replace('-', "−")
}

/// Returns path data through points.
pub fn path(points: impl IntoIterator<Item = [f64; 2]>, closed: bool) -> String {
    let mut pen = Pen::default();
    for (nth, point) in points.into_iter().enumerate() {
        pen.go(nth == 0, point);
    }
    if closed {
        pen.data.push('z');
    }
    pen.data
}

/// Returns path data of separate segments.
pub fn segments(ends: impl IntoIterator<Item = [[f64; 2]; 2]>) -> String {
    let mut pen = Pen::default();
    for [from, to] in ends {
        pen.go(true, from);
        pen.go(false, to);
    }
    pen.data
}

/// Returns path data along several polylines.
pub fn lines<'p>(
    lines: impl IntoIterator<Item = &'p [[f64; 2]]>,
    at: impl Fn([f64; 2]) -> [f64; 2],
) -> String {
    let mut pen = Pen::default();
    for line in lines {
        for (nth, point) in line.iter().enumerate() {
            pen.go(nth == 0, at(*point));
        }
        if line.len() == 1 {
            // A zero-length line with round caps is a dot.
            pen.data.push_str("h0");
        }
    }
    pen.data
}

/// Returns path data with micrometre precision in absolute coordinates, so that it can be read
/// back.
pub fn fine_path(points: impl IntoIterator<Item = [f64; 2]>) -> String {
    let mut data = String::new();
    let mut count = 0;
    for (nth, [x, y]) in points.into_iter().enumerate() {
        let word = if nth == 0 { 'M' } else { 'L' };
        // Writing to a string cannot fail.
        let _ = write!(data, "{word}{} {}", Fine(x), Fine(y));
        count = nth + 1;
    }
    if count == 1 {
        data.push_str("h0");
    }
    data
}

/// Writes relative path data in whole hundredths of a millimetre. Differences of rounded positions
/// keep rounding errors from accumulating.
#[derive(Default)]
struct Pen {
    data: String,
    at: [i64; 2],
    /// True if a bare pair of numbers continues the line.
    continues_line: bool,
}

impl Pen {
    fn go(&mut self, begins: bool, point: [f64; 2]) {
        // A cast from float saturates.
        let to = point.map(|value| (value * 100.0).round() as i64);
        let [dx, dy] = [
            to[0].saturating_sub(self.at[0]),
            to[1].saturating_sub(self.at[1]),
        ];
        if begins {
            // SVG reads the first moveto of a path as absolute, even in lower case.
            self.data.push('m');
        } else if !self.continues_line {
            self.data.push('l');
        }
        self.hundredths(dx, begins || !self.continues_line);
        self.hundredths(dy, false);
        (self.at, self.continues_line) = (to, true);
    }

    /// Writes a number, preceded by a blank if needed.
    fn hundredths(&mut self, value: i64, first: bool) {
        if value < 0 {
            self.data.push('-');
        } else if !first {
            self.data.push(' ');
        }
        let (whole, part) = (value.unsigned_abs() / 100, value.unsigned_abs() % 100);
        if whole > 0 || part == 0 {
            let _ = write!(self.data, "{whole}");
        }
        match (part / 10, part % 10) {
            (0, 0) => {}
            (tens, 0) => drop(write!(self.data, ".{tens}")),
            (tens, ones) => drop(write!(self.data, ".{tens}{ones}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_closed_and_text_is_escaped() {
        let mut svg = Svg::page([10.0, 5.5], "mm", "a & b\u{7}");
        svg.group("g", &[("class", "a\"b")]);
        let text = svg.finish();
        assert!(text.contains("width=\"10mm\" height=\"5.5mm\" viewBox=\"0 0 10 5.5\""));
        assert!(
            text.contains("a&quot;b") && text.contains("a &amp; b\\u{7}<"),
            "{text}"
        );
        assert!(text.trim_end().ends_with("</g>\n</svg>"), "{text}");
    }

    #[test]
    fn path_is_short_without_accumulated_rounding() {
        let points = [[1.0, 2.0], [1.5, 1.99], [1.55, 1.98], [0.0, 0.0]];
        assert_eq!(path(points, true), "m1 2 .5-.01 .05-.01-1.55-1.98z");
        let cross = segments([[[0.0, 0.0], [2.0, 2.0]], [[2.0, 0.0], [0.0, 2.0]]]);
        assert_eq!(cross, "m0 0 2 2m0-2-2 2");
        let many = (0..=300).map(|nth| [f64::from(nth) / 300.0, 0.0]);
        let end: f64 = path(many, false)
            .trim_start_matches("m0 0 ")
            .split(" 0")
            .filter_map(|step| step.trim().parse::<f64>().ok())
            .sum();
        assert!((end - 1.0).abs() < 1e-9, "{end}");
    }
}
