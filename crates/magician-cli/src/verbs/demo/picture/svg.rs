//! Just enough SVG: elements with attributes, nested, escaped.

use std::fmt::{Display, Write};

/// A picture as it is written.
#[derive(Debug)]
pub(super) struct Svg {
    text: String,
    open: Vec<&'static str>,
}

impl Svg {
    /// Begins a picture of this size on a background.
    pub(super) fn new(width: f64, height: f64, background: &str) -> Self {
        let mut svg = Self {
            text: String::new(),
            open: Vec::new(),
        };
        let view = format!("0 0 {width} {height}");
        let size = (width.to_string(), height.to_string());
        svg.group(
            "svg",
            &[
                ("xmlns", "http://www.w3.org/2000/svg"),
                ("viewBox", &view),
                ("width", &size.0),
                ("height", &size.1),
                ("font-family", "Helvetica, Arial, 'DejaVu Sans', sans-serif"),
            ],
        );
        svg.leaf(
            "rect",
            &[
                ("width", &size.0),
                ("height", &size.1),
                ("fill", background),
            ],
        );
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
            let _ = writeln!(self.text, "</{name}>");
        }
    }

    /// An element without content.
    pub(super) fn leaf(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.tag(name, attributes, "/>");
    }

    /// A line of text.
    pub(super) fn text(&mut self, at: (f64, f64), text: impl Display, attributes: &[(&str, &str)]) {
        let (x, y) = (number(at.0), number(at.1));
        let mut all = vec![("x", x.as_str()), ("y", y.as_str())];
        all.extend_from_slice(attributes);
        self.tag("text", &all, ">");
        self.text.truncate(self.text.trim_end().len());
        escape(&text.to_string(), &mut self.text);
        self.text.push_str("</text>\n");
    }

    fn tag(&mut self, name: &str, attributes: &[(&str, &str)], end: &str) {
        let _ = write!(self.text, "{:indent$}<{name}", "", indent = self.open.len());
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"");
            escape(value, &mut self.text);
            self.text.push('"');
        }
        let _ = writeln!(self.text, "{end}");
    }

    /// The finished picture.
    pub(super) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.end();
        }
        self.text
    }
}

fn escape(text: &str, to: &mut String) {
    for letter in text.chars() {
        match letter {
            '&' => to.push_str("&amp;"),
            '<' => to.push_str("&lt;"),
            '>' => to.push_str("&gt;"),
            '"' => to.push_str("&quot;"),
            letter => to.push(letter),
        }
    }
}

/// A coordinate, to a hundredth.
pub(super) fn number(value: f64) -> String {
    let rounded = (value * 100.0).round() / 100.0;
    (rounded + 0.0).to_string()
}

/// A path through points.
pub(super) fn path(points: impl IntoIterator<Item = (f64, f64)>, closed: bool) -> String {
    let mut data = String::new();
    for (x, y) in points {
        let step = if data.is_empty() { 'M' } else { 'L' };
        let _ = write!(data, "{step}{} {}", number(x), number(y));
    }
    if closed {
        data.push('Z');
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_opened_is_closed_and_escaped() {
        let mut svg = Svg::new(10.0, 5.0, "white");
        svg.group("g", &[("class", "a\"b")]);
        svg.text((1.0, 2.345), "x < y & z", &[]);
        let text = svg.finish();
        assert!(
            text.contains("a&quot;b") && text.contains("x &lt; y &amp; z"),
            "{text}"
        );
        assert!(text.trim_end().ends_with("</g>\n</svg>"), "{text}");
        assert!(
            text.contains(r#"y="2.35""#) || text.contains(r#"y="2.34""#),
            "{text}"
        );
    }

    #[test]
    fn a_path_names_its_points() {
        assert_eq!(path([(0.0, -0.001), (1.5, 2.0)], true), "M0 0L1.5 2Z");
    }
}
