//! Detection of values that usvg cannot parse. usvg silently drops such an element, or ends a path
//! at the flaw, so this module reports it in a note.

use magician_host::{Message, message};
use std::collections::HashSet;
use std::str::FromStr as _;

use roxmltree::{Document, Node};
use svgtypes::{Length, NumberListParser, PathParser, Transform};

use super::source::is;

/// Elements that SVG defines, whether they are drawn or not.
const KNOWN_ELEMENTS: [&str; 62] = [
    "a",
    "animate",
    "animateMotion",
    "animateTransform",
    "circle",
    "clipPath",
    "color-profile",
    "cursor",
    "defs",
    "desc",
    "ellipse",
    "feBlend",
    "feFlood",
    "filter",
    "font",
    "font-face",
    "font-face-format",
    "font-face-name",
    "font-face-src",
    "font-face-uri",
    "foreignObject",
    "g",
    "glyph",
    "glyphRef",
    "hatch",
    "hatchpath",
    "hkern",
    "image",
    "line",
    "linearGradient",
    "marker",
    "mask",
    "mesh",
    "meshgradient",
    "meshpatch",
    "meshrow",
    "metadata",
    "missing-glyph",
    "mpath",
    "path",
    "pattern",
    "polygon",
    "polyline",
    "radialGradient",
    "rect",
    "script",
    "set",
    "solidcolor",
    "stop",
    "style",
    "svg",
    "switch",
    "symbol",
    "text",
    "textPath",
    "title",
    "tref",
    "tspan",
    "use",
    "view",
    "vkern",
    "altGlyph",
];

/// Ids in a drawing.
pub(super) struct Ids<'a>(HashSet<&'a str>);

impl<'a> Ids<'a> {
    pub(super) fn of(document: &'a Document<'_>) -> Self {
        let ids = document
            .descendants()
            .filter_map(|node| node.attribute("id"));
        Self(ids.collect())
    }

    /// Returns messages about parts of an element that are omitted or drawn differently.
    pub(super) fn remarks(&self, node: &Node<'_, '_>) -> Vec<Message> {
        let tag = node.tag_name().name();
        if node
            .tag_name()
            .namespace()
            .is_none_or(|space| space.ends_with("/svg"))
            && !KNOWN_ELEMENTS.contains(&tag)
            && !tag.starts_with("fe")
            && !within(
                node,
                &["metadata", "foreignObject", "defs", "font", "filter"],
            )
        {
            return vec![message!(
                "the element <{tag}> is unknown: it is left out",
                tag
            )];
        }
        let mut remarks = Vec::new();
        // Values with CSS variables are not checked here: they are expanded later.
        let value = |name: &str| {
            let value = node.attribute(name).map(str::trim);
            value.filter(|value| !value.contains("var("))
        };
        if let Some(transform) =
            value("transform").filter(|value| !value.is_empty() && *value != "none")
            && Transform::from_str(transform).is_err()
        {
            remarks.push(unreadable_value(
                "transform",
                transform,
                message!("it is left out"),
            ));
        }
        for name in lengths(tag) {
            let Some(length) = value(name) else { continue };
            let automatic = ["rx", "ry"].contains(name) && length == "auto";
            if !automatic && Length::from_str(length).is_err() {
                remarks.push(unreadable_value(
                    name,
                    length,
                    message!("the shape is drawn without it, or not at all"),
                ));
            }
        }
        match tag {
            "path" => {
                let data = value("d").unwrap_or_default();
                if data.is_empty() && value("style").is_none_or(|style| !style.contains("d:")) {
                    remarks.push(message!("a path without data (d) is left out"));
                } else if PathParser::from(data).any(|segment| segment.is_err()) {
                    remarks.push(unreadable_value(
                        "d",
                        data,
                        message!("the path is drawn up to the first flaw"),
                    ));
                }
            }
            "polyline" | "polygon" => {
                let points = value("points").unwrap_or_default();
                let numbers: Result<Vec<f64>, _> = NumberListParser::from(points).collect();
                match numbers {
                    Err(_) => remarks.push(unreadable_value(
                        "points",
                        points,
                        message!("the shape is drawn up to the first flaw"),
                    )),
                    Ok(numbers) if numbers.len() < 4 => {
                        remarks.push(message!("a shape with fewer than two points is left out"));
                    }
                    Ok(numbers) if numbers.len() % 2 == 1 => {
                        remarks.push(message!("the last x of a shape has no y: it is left out"));
                    }
                    Ok(_) => {}
                }
            }
            "rect" | "circle" | "ellipse" => {
                let sizes: &[&str] = match tag {
                    "rect" => &["width", "height"],
                    "circle" => &["r"],
                    _ => &["rx", "ry"],
                };
                let styled = value("style")
                    .is_some_and(|style| sizes.iter().any(|size| style.contains(size)));
                let none = |size: &&str| match value(size) {
                    Some(length) => {
                        Length::from_str(length).is_ok_and(|length| length.number <= 0.0)
                    }
                    None => tag != "ellipse" && !styled,
                };
                if let Some(size) = sizes.iter().find(|size| none(size)) {
                    remarks.push(message!(
                        "a {tag} without size ({size}) is left out",
                        tag,
                        size
                    ));
                }
            }
            "use" => {
                let mut links = node.attributes().filter(|link| link.name() == "href");
                let target = links.next().map(|link| link.value().trim());
                match target {
                    None => remarks.push(message!("a use without a target (href) is left out")),
                    Some(target) if !self.has(target.strip_prefix('#')) => {
                        let shown: String = target.chars().take(40).collect();
                        let message = message!(
                            "use of {shown}, which is not in the file, is left out",
                            shown
                        );
                        remarks.push(message);
                    }
                    Some(_) => {}
                }
            }
            _ => {}
        }
        remarks
    }

    /// True if an element with this id exists.
    pub(super) fn has(&self, id: Option<&str>) -> bool {
        id.is_some_and(|id| self.0.contains(id))
    }
}

fn within(node: &Node<'_, '_>, tags: &[&str]) -> bool {
    node.ancestors()
        .skip(1)
        .any(|above| tags.iter().any(|tag| is(&above, tag)))
}

/// Attributes of a shape that are lengths.
fn lengths(tag: &str) -> &'static [&'static str] {
    match tag {
        "rect" => &["x", "y", "width", "height", "rx", "ry"],
        "circle" => &["cx", "cy", "r"],
        "ellipse" => &["cx", "cy", "rx", "ry"],
        "line" => &["x1", "y1", "x2", "y2"],
        _ => &[],
    }
}

fn unreadable_value(name: &str, value: &str, what: Message) -> Message {
    let shown: String = value.chars().take(40).collect();
    let more = if shown.len() < value.len() { ".." } else { "" };
    let shown = format!("{shown}{more}");
    message!("{name} '{shown}' cannot be read: {what}", name, shown, what)
}
