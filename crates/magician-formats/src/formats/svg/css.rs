//! Translation of modern CSS to what usvg understands, which is CSS 2: custom properties, colour
//! functions, keywords in any case. Strokes of width 0, which CAD programs write as hairlines, get
//! a width.
//!
//! usvg silently drops a line whose paint it cannot parse. So every paint that is neither `none`
//! nor readable is replaced by black here, with a note.

use magician_host::{Message, message};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

use roxmltree::{Document, Node};

use super::families::quote_before;
use super::source::is;

/// Properties whose value is a paint or a colour.
const PAINT_PROPERTIES: [&str; 4] = ["fill", "stroke", "color", "stop-color"];
/// Elements that serve as paints.
const PAINT_SERVERS: [&str; 3] = ["linearGradient", "radialGradient", "pattern"];
const WIDTH: &str = "stroke-width";
/// Largest nesting of variables. More is taken for a cycle.
const MAX_VARIABLE_DEPTH: usize = 16;
/// Largest length of a value after expanding variables, bytes. It bounds exponential growth.
const MAX_VALUE_LENGTH: usize = 4096;

/// A replacement for a value, with a note about it.
pub(super) struct Edit {
    pub(super) range: Range<usize>,
    pub(super) value: String,
    pub(super) remark: Option<Message>,
}

/// Custom properties of a drawing.
pub(super) struct Variables {
    /// Values set by style sheets, by name.
    sheets: HashMap<String, String>,
    /// True if the drawing contains `use`, which provides context paints.
    has_use: bool,
    /// Ids of gradients and patterns.
    servers: HashSet<String>,
}

impl Variables {
    /// Collects the custom properties of the style sheets. A value for the whole drawing (`:root`)
    /// takes precedence over one for a part.
    pub(super) fn of(document: &Document<'_>) -> Self {
        let mut sheets = HashMap::new();
        let mut others = HashMap::new();
        for sheet in document.descendants().filter(|node| is(node, "style")) {
            let text = sheet.text().unwrap_or_default();
            for (selectors, declarations) in rules(text) {
                let root = [":root", "svg", "*", "html", ":host"];
                let of_all = text[selectors]
                    .split(',')
                    .any(|selector| root.iter().any(|root| selector.trim().ends_with(root)));
                let all = if of_all { &mut sheets } else { &mut others };
                for (name, value) in custom(text, declarations) {
                    all.insert(name, value);
                }
            }
        }
        for (name, value) in others {
            sheets.entry(name).or_insert(value);
        }
        Self {
            sheets,
            servers: document
                .descendants()
                .filter(|node| PAINT_SERVERS.iter().any(|tag| is(node, tag)))
                .filter_map(|node| node.attribute("id").map(str::to_owned))
                .collect(),
            has_use: document.descendants().any(|node| is(&node, "use")),
        }
    }

    /// Returns the value of a property at an element: from the nearest `style` that sets it, else
    /// from the style sheets.
    fn value(&self, name: &str, at: &Node<'_, '_>) -> Option<String> {
        let styles = at.ancestors().filter_map(|node| node.attribute("style"));
        let mut own = styles
            .filter(|style| style.contains("--"))
            .flat_map(|style| {
                custom(style, 0..style.len())
                    .collect::<Vec<_>>()
                    .into_iter()
                    .rev()
            });
        let own = own.find(|(own, _)| own == name).map(|(_, value)| value);
        own.or_else(|| self.sheets.get(name).cloned())
    }

    /// Expands the variables in a value. The error is the name of an unset one.
    fn resolved(&self, value: &str, at: &Node<'_, '_>, depth: usize) -> Result<String, String> {
        let Some((before, rest)) = value.split_once("var(") else {
            return Ok(value.to_owned());
        };
        let end = closing(rest).unwrap_or(rest.len());
        let inside = rest.get(..end).unwrap_or_default();
        let after = rest.get(end + 1..).unwrap_or_default();
        let (name, fallback) = match inside.split_once(',') {
            Some((name, fallback)) => (name.trim(), Some(fallback.trim())),
            None => (inside.trim(), None),
        };
        if depth >= MAX_VARIABLE_DEPTH || value.len() > MAX_VALUE_LENGTH {
            return Err(name.to_owned());
        }
        let set = self.value(name, at);
        let set = set.and_then(|set| self.resolved(&set, at, depth + 1).ok());
        let set = match (set, fallback) {
            (Some(set), _) => set,
            (None, Some(fallback)) => self.resolved(fallback, at, depth + 1)?,
            (None, None) => return Err(name.to_owned()),
        };
        self.resolved(&format!("{before}{set}{after}"), at, depth + 1)
    }

    /// Returns the edits of an element's attributes, or of a style sheet.
    pub(super) fn edits(&self, text: &str, node: &Node<'_, '_>) -> Vec<Edit> {
        let mut edits = Vec::new();
        if is(node, "style") {
            for child in node.children().filter(Node::is_text) {
                let range = child.range();
                // Text from an entity is not in the file at this place.
                let Some(sheet) = text.get(range.clone()) else {
                    continue;
                };
                for (_, declarations) in rules(sheet) {
                    self.declarations(sheet, declarations, range.start, node, &mut edits);
                }
            }
            return edits;
        }
        for attribute in node.attributes().filter(|one| one.namespace().is_none()) {
            let range = attribute.range_value();
            let Some(raw) = text.get(range.clone()) else {
                continue;
            };
            if quote_before(text, &range).is_none() || raw != attribute.value() {
                continue;
            }
            match attribute.name() {
                "style" => self.declarations(raw, 0..raw.len(), range.start, node, &mut edits),
                "font-family" => {}
                name => {
                    let whole = 0..raw.len();
                    edits.extend(self.edit(name, raw, whole, range.start, node));
                }
            }
        }
        edits
    }

    fn declarations(
        &self,
        text: &str,
        range: Range<usize>,
        start: usize,
        node: &Node<'_, '_>,
        edits: &mut Vec<Edit>,
    ) {
        for (name, value) in declarations(text, range) {
            let name = text[name].trim();
            if !name.starts_with("--") && name != "font-family" {
                edits.extend(self.edit(name, text, value, start, node));
            }
        }
    }

    /// Returns the replacement for the value of a property, if it needs one.
    fn edit(
        &self,
        name: &str,
        text: &str,
        range: Range<usize>,
        start: usize,
        node: &Node<'_, '_>,
    ) -> Option<Edit> {
        let raw = text.get(range.clone())?;
        let is_paint = PAINT_PROPERTIES.contains(&name);
        if !(is_paint || name == WIDTH || raw.contains("var(")) {
            return None;
        }
        let plain = raw.split('!').next().unwrap_or(raw).trim();
        let important = raw.get(plain.len()..).filter(|rest| rest.contains('!'));
        let (value, remark) = match self.resolved(plain, node, 0) {
            Ok(value) if is_paint => self.paint(name, value.trim(), node),
            Ok(value) if name == WIDTH => width(value.trim()),
            Ok(value) => (value, None),
            Err(missing) if is_paint => {
                let remark = message!("the colour {missing} is not set: black is used", missing);
                ("black".to_owned(), Some(remark))
            }
            Err(missing) => {
                let remark = message!(
                    "{missing} is not set: {name} is as if it were not there",
                    missing,
                    name
                );
                (String::new(), Some(remark))
            }
        };
        let suffix = important.map_or("", |_| " !important");
        (value != plain).then(|| Edit {
            range: start + range.start..start + range.end,
            value: format!("{value}{suffix}"),
            remark,
        })
    }

    /// Converts a paint to usvg's syntax.
    fn paint(&self, name: &str, value: &str, node: &Node<'_, '_>) -> (String, Option<Message>) {
        let word = value.to_ascii_lowercase();
        let same = match word.as_str() {
            // An empty value is ignored, as usvg does.
            "" => return (value.to_owned(), None),
            "currentcolor" if name == "color" => "inherit",
            "currentcolor" => "currentColor",
            "none" | "inherit" => &word,
            "unset" | "revert" | "revert-layer" if name != "stop-color" => "inherit",
            "initial" if name == "stroke" => "none",
            "initial" => "black",
            "context-stroke" | "context-fill" => {
                let in_marker = node.ancestors().any(|node| is(&node, "marker"));
                if in_marker || self.has_use || is(node, "style") {
                    return (word, None);
                }
                let remark = message!(
                    "{word} means nothing outside of markers: black is used",
                    word
                );
                return ("black".to_owned(), Some(remark));
            }
            _ => {
                if let Ok(svgtypes::Paint::FuncIRI(id, None)) = svgtypes::Paint::from_str(value)
                    && !self.servers.contains(id)
                {
                    let remark = message!("there is no paint #{id} in the file: black is used", id);
                    return ("black".to_owned(), Some(remark));
                }
                return match color(value) {
                    Some(color) => (color, None),
                    None => {
                        let shown: String = value.chars().take(40).collect();
                        let remark =
                            message!("the colour '{shown}' cannot be read: black is used", shown);
                        ("black".to_owned(), Some(remark))
                    }
                };
            }
        };
        (same.to_owned(), None)
    }
}

/// Converts a stroke width. usvg draws no stroke of width 0.
fn width(value: &str) -> (String, Option<Message>) {
    use std::str::FromStr as _;
    let word = value.to_ascii_lowercase();
    if ["", "inherit", "unset", "initial"].contains(&word.as_str()) {
        return (value.to_owned(), None);
    }
    match svgtypes::Length::from_str(&word) {
        Ok(length) if length.number > 0.0 => (value.to_owned(), None),
        Ok(length) if length.number == 0.0 => {
            let remark = message!("lines of width 0 are drawn as hairlines");
            ("1".to_owned(), Some(remark))
        }
        _ => {
            let shown: String = value.chars().take(40).collect();
            let remark = message!(
                "the width '{shown}' of a line cannot be read: it is drawn as a hairline",
                shown
            );
            ("1".to_owned(), Some(remark))
        }
    }
}

/// Converts a colour, or `url(..)` with a fallback colour, to usvg's syntax; `None` if it is
/// unreadable.
fn color(value: &str) -> Option<String> {
    if svgtypes::Paint::from_str(value).is_ok() {
        return Some(value.to_owned());
    }
    if let Some(rest) = value.strip_prefix("url(") {
        let end = closing(rest)?;
        let fallback = rest.get(end + 1..)?.trim();
        let fallback = match fallback.to_ascii_lowercase().as_str() {
            "currentcolor" => "currentColor".to_owned(),
            "none" => "none".to_owned(),
            _ => color(fallback)?,
        };
        return Some(format!("url({}) {fallback}", rest.get(..end)?));
    }
    let lower = value.to_ascii_lowercase();
    // Paper is light, so take the first colour.
    if let Some(both) = lower.strip_prefix("light-dark(") {
        let end = closing(both)?;
        let inside = both.get(..end)?;
        return color(inside.get(..comma(inside)?)?.trim());
    }
    let [red, green, blue, alpha] = csscolorparser::parse(&lower).ok()?.to_rgba8();
    Some(match alpha {
        u8::MAX => format!("#{red:02x}{green:02x}{blue:02x}"),
        _ => format!("#{red:02x}{green:02x}{blue:02x}{alpha:02x}"),
    })
}

/// Index of the parenthesis that closes one opened before `text`.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0_u32;
    text.bytes().position(|byte| {
        match byte {
            b'(' => depth += 1,
            b')' if depth == 0 => return true,
            b')' => depth -= 1,
            _ => {}
        }
        false
    })
}

/// Index of the first comma outside parentheses.
fn comma(text: &str) -> Option<usize> {
    let mut depth = 0_i32;
    text.bytes().position(|byte| {
        depth += i32::from(byte == b'(') - i32::from(byte == b')');
        byte == b',' && depth == 0
    })
}

/// Returns the ranges of selectors and declarations of each rule. Conditional rules (`@media`) are
/// skipped, as usvg does.
fn rules(sheet: &str) -> Vec<(Range<usize>, Range<usize>)> {
    let mut rules = Vec::new();
    let bytes = sheet.as_bytes();
    let (mut at, mut start) = (0, 0);
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'/' if bytes.get(at + 1) == Some(&b'*') => {
                let end = sheet.get(at + 2..).and_then(|rest| rest.find("*/"));
                at = end.map_or(sheet.len(), |end| at + 2 + end + 2);
                // A comment before a selector is not part of it.
                if sheet
                    .get(start..at)
                    .is_some_and(|text| text.trim_start().starts_with("/*"))
                {
                    start = at;
                }
            }
            b';' => {
                at += 1;
                start = at;
            }
            b'{' => {
                let selectors = start..at;
                let mut depth = 1_u32;
                let begin = at + 1;
                at = begin;
                while depth > 0 {
                    match bytes.get(at) {
                        Some(b'{') => depth += 1,
                        Some(b'}') => depth -= 1,
                        Some(_) => {}
                        None => break,
                    }
                    at += 1;
                }
                let end = if depth == 0 { at - 1 } else { at };
                let text = sheet
                    .get(selectors.clone())
                    .unwrap_or_default()
                    .trim_start();
                let text = text.strip_prefix("<![CDATA[").unwrap_or(text).trim_start();
                if !text.starts_with('@') {
                    rules.push((selectors, begin..end));
                }
                start = at;
            }
            _ => at += 1,
        }
    }
    rules
}

/// Returns the ranges of names and values of declarations.
fn declarations(text: &str, range: Range<usize>) -> Vec<(Range<usize>, Range<usize>)> {
    let mut found = Vec::new();
    let inside = text.get(range.clone()).unwrap_or_default();
    let (mut start, mut depth, mut quote, mut comment) = (0, 0_i32, None, false);
    let bytes = inside.as_bytes();
    for at in 0..=bytes.len() {
        let byte = bytes.get(at).copied();
        if comment {
            if at > 1 && bytes.get(at - 2..at) == Some(b"*/") {
                comment = false;
                start = at;
            } else {
                continue;
            }
        }
        match (byte, quote) {
            (Some(b'/'), None) if bytes.get(at + 1) == Some(&b'*') => comment = true,
            (Some(sign), Some(open)) if sign == open => quote = None,
            (Some(_), Some(_)) => {}
            (Some(sign @ (b'"' | b'\'')), None) => quote = Some(sign),
            (Some(b'('), None) => depth += 1,
            (Some(b')'), None) => depth -= 1,
            (Some(b';'), None) if depth > 0 => {}
            (Some(b';') | None, _) => {
                let declaration = inside.get(start..at).unwrap_or_default();
                if let Some(colon) = declaration.find(':') {
                    let name = range.start + start..range.start + start + colon;
                    let value = declaration.get(colon + 1..).unwrap_or_default();
                    let blank = value.len() - value.trim_start().len();
                    let from = name.end + 1 + blank;
                    found.push((name, from..from + value.trim().len()));
                }
                start = at + 1;
            }
            _ => {}
        }
    }
    found
}

/// Iterates over the custom properties that declarations set.
fn custom(text: &str, range: Range<usize>) -> impl Iterator<Item = (String, String)> + '_ {
    let found = declarations(text, range).into_iter();
    found.filter_map(|(name, value)| {
        let name = text.get(name)?.trim();
        let value = text.get(value)?;
        name.starts_with("--")
            .then(|| (name.to_owned(), value.to_owned()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn css_4_colours_become_css_2_colours() {
        for (value, expected) in [
            ("RED", "RED"),
            ("rgb(0 0 0 / 80%)", "#000000cc"),
            ("rgb(100% 0% 0% / 1)", "rgb(100% 0% 0% / 1)"),
            ("oklch(62.8% 0.2577 29.23)", "#ff0000"),
            ("oklab(0 0 0)", "#000000"),
            ("light-dark(rgb(0, 0, 0), #fff)", "rgb(0, 0, 0)"),
            ("light-dark(oklab(0 0 0), white)", "#000000"),
            ("url(#a) CurrentColor", "url(#a) currentColor"),
            ("url(#a) oklab(0 0 0)", "url(#a) #000000"),
        ] {
            assert_eq!(color(value).as_deref(), Some(expected), "{value}");
        }
        for value in [
            "color(display-p3 1 0 0)",
            "url(#a) hue",
            "light-dark(red)",
            "no colour",
        ] {
            assert_eq!(color(value), None, "{value}");
        }
    }

    #[test]
    fn rules_and_declarations_are_found_between_comments_and_conditions() {
        let sheet = "@import url(a;b); /* {x} */ .a{fill:url(\"d;x\");stroke : red ! important}@media print{.b{fill:red}} .c{}";
        let found: Vec<_> = rules(sheet).into_iter().map(|(_, range)| range).collect();
        assert_eq!(found.len(), 2);
        let names = declarations(sheet, found[0].clone());
        let texts: Vec<_> = names
            .into_iter()
            .map(|(name, value)| (sheet[name].trim().to_owned(), sheet[value].to_owned()))
            .collect();
        let expected = [("fill", "url(\"d;x\")"), ("stroke", "red ! important")];
        assert_eq!(
            texts,
            expected.map(|(name, value)| (name.to_owned(), value.to_owned()))
        );
        for broken in ["a{", "a{b:c", "}", "{{", "/*", "a{b:'c", "a{b:(}", "é{ü:ß"] {
            for (_, range) in rules(broken) {
                declarations(broken, range);
            }
        }
    }
}
