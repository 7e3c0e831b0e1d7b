//! Just enough SVG: elements with attributes, nested, escaped; one unit a millimetre.

use std::fmt::{Display, Write};

use magician_protocol::visible;

use super::track::Track;

/// A picture as it is written.
#[derive(Debug)]
pub(super) struct Svg {
    text: String,
    open: Vec<&'static str>,
}

/// Which way a line of text goes from its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a line of text looks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Type {
    pub(super) size: f64,
    pub(super) colour: &'static str,
    pub(super) anchor: Anchor,
    /// Legible on lines: with a rim of white.
    pub(super) rim: bool,
}

impl Svg {
    /// Begins a picture of this size, in mm, on white.
    pub(super) fn new([width, height]: [f64; 2], title: &str) -> Self {
        let [width, height] = [width, height].map(Number);
        let mut svg = Self {
            text: String::new(),
            open: Vec::new(),
        };
        let view = format!("0 0 {width} {height}");
        let size = [width, height].map(|side| format!("{side}mm"));
        let attributes = [
            ("xmlns", "http://www.w3.org/2000/svg"),
            ("width", &size[0]),
            ("height", &size[1]),
            ("viewBox", &view),
            (
                "font-family",
                "Roboto, 'DejaVu Sans', Helvetica, Arial, sans-serif",
            ),
        ];
        svg.group("svg", &attributes);
        svg.group("title", &[]);
        escape(title, &mut svg.text);
        svg.end();
        let ground = [("width", "100%"), ("height", "100%"), ("fill", "#fff")];
        svg.leaf("rect", &ground);
        svg
    }

    /// Opens an element; [`end`](Self::end) closes it.
    pub(super) fn group(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.tag(name, attributes, ">");
        self.open.push(name);
    }

    /// Closes the element opened last.
    pub(super) fn end(&mut self) {
        if let Some(name) = self.open.pop() {
            // Writing to a string does not fail.
            let _ = writeln!(self.text, "</{name}>");
        }
    }

    /// An element without content.
    pub(super) fn leaf(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.tag(name, attributes, "/>");
        self.text.push('\n');
    }

    /// Lines through points that are in the picture's own coordinates.
    pub(super) fn path(&mut self, data: &str, attributes: &[(&str, &str)]) {
        let data = [("d", data)];
        self.leaf("path", &[&data, attributes].concat());
    }

    /// A circle.
    pub(super) fn circle(&mut self, [x, y]: [f64; 2], radius: f64, attributes: &[(&str, &str)]) {
        let [x, y, radius] = [x, y, radius].map(|value| Number(value).to_string());
        let round = [("cx", x.as_str()), ("cy", &y), ("r", &radius)];
        self.leaf("circle", &[&round, attributes].concat());
    }

    /// A rectangle from one corner to the opposite one.
    pub(super) fn rectangle(&mut self, corners: [[f64; 2]; 2], attributes: &[(&str, &str)]) {
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

    /// A line of text.
    pub(super) fn text(&mut self, [x, y]: [f64; 2], text: impl Display, look: &Type) {
        let [x, y, size] = [x, y, look.size].map(|value| Number(value).to_string());
        let mut attributes = vec![
            ("x", x.as_str()),
            ("y", &y),
            ("font-size", &size),
            ("fill", look.colour),
        ];
        match look.anchor {
            Anchor::Start => {}
            Anchor::Middle => attributes.push(("text-anchor", "middle")),
            Anchor::End => attributes.push(("text-anchor", "end")),
        }
        if look.rim {
            attributes.extend([
                ("stroke", "#fff"),
                ("stroke-width", "0.9"),
                ("stroke-linejoin", "round"),
                ("paint-order", "stroke"),
            ]);
        }
        self.tag("text", &attributes, ">");
        escape(&text.to_string(), &mut self.text);
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

    /// The finished picture.
    pub(super) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.end();
        }
        self.text
    }
}

/// What XML has no place for, and what would turn the text around, is [`visible`].
fn escape(text: &str, to: &mut String) {
    for letter in visible(text).to_string().chars() {
        match letter {
            '&' => to.push_str("&amp;"),
            '<' => to.push_str("&lt;"),
            '>' => to.push_str("&gt;"),
            '"' => to.push_str("&quot;"),
            letter => to.push(letter),
        }
    }
}

/// A length to a hundredth of a millimetre, as short as can be.
#[derive(Clone, Copy)]
pub(super) struct Number(pub(super) f64);

impl Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Adding 0 turns -0 into 0.
        write!(f, "{}", (self.0 * 100.0).round() / 100.0 + 0.0)
    }
}

/// A number for people, with a minus that can be seen.
pub(super) fn signed(value: f64) -> String {
    Number(value).to_string().replace('-', "−")
}

/// The data of a path through points.
pub(super) fn path(points: impl IntoIterator<Item = [f64; 2]>, closed: bool) -> String {
    let mut pen = Pen::default();
    for (nth, point) in points.into_iter().enumerate() {
        pen.go(nth == 0, point);
    }
    if closed {
        pen.data.push('z');
    }
    pen.data
}

/// The data of straight lines, each from one point to another.
pub(super) fn segments(ends: impl IntoIterator<Item = [[f64; 2]; 2]>) -> String {
    let mut pen = Pen::default();
    for [from, to] in ends {
        pen.go(true, from);
        pen.go(false, to);
    }
    pen.data
}

/// The data of a path along a track, where `at` puts its points.
pub(super) fn tracks(track: &Track, at: impl Fn([f64; 2]) -> [f64; 2]) -> String {
    let mut pen = Pen::default();
    pen.data.reserve(track.len() * 8);
    for line in track.lines() {
        for (nth, point) in line.iter().enumerate() {
            pen.go(nth == 0, at(*point));
        }
        if line.len() == 1 {
            // A line of no length with round ends is a dot.
            pen.data.push_str("h0");
        }
    }
    pen.data
}

/// Writes a path in whole hundredths of a millimetre, each point from the last, so that nothing adds up.
#[derive(Default)]
struct Pen {
    data: String,
    at: [i64; 2],
    /// Whether a bare pair of numbers would be a line to a point.
    lining: bool,
}

impl Pen {
    fn go(&mut self, begins: bool, point: [f64; 2]) {
        // A conversion of a float saturates.
        let to = point.map(|value| (value * 100.0).round() as i64);
        let [dx, dy] = [
            to[0].saturating_sub(self.at[0]),
            to[1].saturating_sub(self.at[1]),
        ];
        if begins {
            // The first is taken as absolute whatever its case.
            self.data.push('m');
        } else if !self.lining {
            self.data.push('l');
        }
        self.hundredths(dx, begins || !self.lining);
        self.hundredths(dy, false);
        (self.at, self.lining) = (to, true);
    }

    /// A number, with a space before it if it needs one.
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
    fn what_is_opened_is_closed_and_escaped() {
        let mut svg = Svg::new([10.0, 5.5], "a & b\u{7}");
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
    fn a_path_is_short_and_adds_nothing_up() {
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
