//! Preparation of the text of an SVG for usvg.
//!
//! usvg keeps no places in the text, only ids. So every drawing element without an id gets one, and
//! the places are kept in a map by id. All changes are edits of the text, collected in one pass:
//! ids, CSS in the syntax of usvg ([`css`](super::css)), quoted font names, and emptied patterns,
//! which would cost time and draw no line.

use magician_host::{Message, message};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

use roxmltree::{Document, Node, ParsingOptions};

use super::cost;
use super::notes::Notes;
use super::{css, families, numbers, values};
use crate::artwork::Layer;
use crate::{Diagnostic, DiagnosticCode, Lines, Origin};

/// Elements that a stroke can come from.
const DRAWING_ELEMENTS: [&str; 13] = [
    "path", "rect", "circle", "ellipse", "line", "polyline", "polygon", "text", "use", "g", "a",
    "svg", "switch",
];
/// Elements of [`DRAWING_ELEMENTS`] that draw lines themselves.
const SHAPE_ELEMENTS: [&str; 8] = [
    "path", "rect", "circle", "ellipse", "line", "polyline", "polygon", "text",
];
/// Elements that draw, but not lines.
const OMITTED_ELEMENTS: [(&str, &str); 2] = [
    ("image", OMITTED_IMAGES_NOTE),
    ("foreignObject", "elements that are not SVG are left out"),
];
const OMITTED_IMAGES_NOTE: &str = "images in the drawing are left out";
/// Properties that are ignored with a note.
const IGNORED_PROPERTIES: [(&str, &str); 1] = [("filter", "filters are left out")];
/// Largest number of elements to parse, including definitions.
const MAX_NODES: u32 = 2_000_000;
/// Largest number of characters in all texts. Layout in usvg costs about 75 us and 5 kB for each.
const MAX_CHARACTERS: usize = 50_000;
const INKSCAPE_NAMESPACE: &str = "http://www.inkscape.org/namespaces/inkscape";
const SVG_NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// A prepared text, and the places of its elements in the original.
pub(super) struct Source {
    pub(super) text: String,
    /// Number of shapes and texts, and how many of them are hidden.
    pub(super) shapes: [usize; 2],
    /// True if it contains the glyphs of a font.
    pub(super) is_font: bool,
    /// Elements by id.
    pub(super) elements: HashMap<String, Element>,
    /// Layers: those of Inkscape, else the outermost groups with an id.
    pub(super) layers: Vec<Layer>,
    /// Source of the page size.
    pub(super) page: Page,
}

/// Source of the page size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Page {
    /// Width or height, in any unit.
    Sized,
    /// Only the `viewBox`.
    ViewBox,
    /// None.
    Unknown,
}

/// Element of the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Element {
    pub(super) origin: Origin,
    /// Id of the element, or its tag.
    pub(super) name: String,
    /// Index of its outermost layer from 1; 0 outside all layers.
    pub(super) layer: usize,
}

impl Element {
    pub(super) fn diagnostic(&self, message: impl Into<Message>) -> Diagnostic {
        Diagnostic::new(self.origin, message).named(self.name.clone())
    }
}

/// Prepares a text.
pub(super) fn prepare(text: &str, notes: &mut Notes) -> Result<Source, Diagnostic> {
    let document = parse(text)?;
    let root = document.root_element();
    if !is(&root, "svg") {
        let message = message!(
            "the outermost element is <{tag_name}>, not <svg>",
            tag_name = root.tag_name().name()
        );
        return Err(Diagnostic::new(
            Origin {
                line: 1,
                column: 1,
                ..Origin::NONE
            },
            message,
        ));
    }
    let prefix = unused_prefix(text);
    let mut place = Places::new(text);
    let mut elements = HashMap::new();
    let mut edits = Vec::new();
    let mut emptied = 0..0;
    let mut layers = LayerTracker::of(&root);
    let mut shapes = [0; 2];
    let mut characters = 0;
    let variables = css::Variables::of(&document);
    let ids = values::Ids::of(&document);
    for (nth, node) in root.descendants().enumerate() {
        let range = node.range();
        let within = root.range().contains(&range.start) && range.start >= emptied.end;
        if !node.is_element() || !within {
            continue;
        }
        let layer = layers.at(&node);
        // The content of a pattern would cost time and draw no line, so replace it.
        if is(&node, "pattern")
            && let Some(inside) = inside(&node)
        {
            emptied = inside.clone();
            edits.push((inside, r#"<rect width="1" height="1"/>"#.to_owned()));
        }
        if let Some(number) = numbers::excessive_number(&node) {
            let diagnostic = Diagnostic::new(
                place.origin(start_tag(text, &node)),
                format!("a number is out of range: {number}"),
            );
            return Err(diagnostic.named(node.attribute("id").unwrap_or(node.tag_name().name())));
        }
        edits.extend(families::quoted(text, &node));
        for edit in variables.edits(text, &node) {
            if let Some(remark) = edit.remark {
                let name = node.attribute("id").unwrap_or(node.tag_name().name());
                // The place in the sheet for a style sheet, else the whole start tag.
                let around = if is(&node, "style") {
                    edit.range.clone()
                } else {
                    start_tag(text, &node)
                };
                let note = Diagnostic::new(place.origin(around), remark).named(name);
                notes.add(note.coded(DiagnosticCode::Assumed));
            }
            edits.push((edit.range, edit.value));
        }
        let drawing = DRAWING_ELEMENTS.iter().any(|tag| is(&node, tag));
        if SHAPE_ELEMENTS.iter().any(|tag| is(&node, tag)) {
            shapes[0] += 1;
            shapes[1] += usize::from(node.ancestors().any(|node| is_hidden(&node)));
        }
        let remarks: Vec<Message> = remarks(&node).chain(ids.remarks(&node)).collect();
        if !drawing && remarks.is_empty() {
            continue;
        }
        let own = node.attribute("id").map(str::to_owned);
        let element = Element {
            origin: place.origin(start_tag(text, &node)),
            name: own
                .clone()
                .unwrap_or_else(|| node.tag_name().name().to_owned()),
            layer,
        };
        for remark in remarks {
            let note = element.diagnostic(remark).coded(DiagnosticCode::LeftOut);
            notes.add(match note.message.as_str() {
                OMITTED_IMAGES_NOTE => note.help(message!(
                    "save the image as a file of its own, and draw or burn that"
                )),
                _ => note,
            });
        }
        if is(&node, "text") {
            let texts = node.descendants().filter(Node::is_text);
            characters += texts
                .filter_map(|text| text.text())
                .map(|text| text.chars().count())
                .sum::<usize>();
            if characters > MAX_CHARACTERS {
                let message = message!(
                    "the texts of the drawing have {characters} characters up to here, limit \
                    {most_characters}",
                    characters,
                    most_characters = MAX_CHARACTERS
                );
                let help = message!("split the drawing, or write the text by itself");
                return Err(element.diagnostic(message).help(help));
            }
        }
        let id = own.unwrap_or_else(|| {
            let id = format!("{prefix}{nth}");
            if let Some(at) = after_name(text, &node) {
                edits.push((at..at, format!(r#" id="{id}""#)));
            }
            id
        });
        // The first element with an id counts, as in a browser.
        elements.entry(id).or_insert(element);
    }
    let page = page_of(&root);
    let is_font = root.descendants().any(|node| is(&node, "glyph"));
    let ready = edited(text, edits);
    // Estimated on the edited text, which is what usvg expands.
    cost::check(&parse(&ready)?)?;
    Ok(Source {
        text: ready,
        shapes,
        is_font,
        elements,
        layers: layers.layers,
        page,
    })
}

/// Tracks the layer of nodes visited in document order.
struct LayerTracker {
    layers: Vec<Layer>,
    /// Parent of the outermost groups: the root, or the single anonymous group around everything.
    within: roxmltree::NodeId,
    /// True if the layers are Inkscape's.
    inkscape: bool,
    /// End of the current layer.
    ends: usize,
}

impl LayerTracker {
    fn of(root: &Node<'_, '_>) -> Self {
        let inkscape = root.descendants().any(|node| is_inkscape_layer(&node));
        let mut within = *root;
        while let Some(group) = wrapper(&within) {
            within = group;
        }
        Self {
            layers: Vec::new(),
            within: within.id(),
            inkscape,
            ends: 0,
        }
    }

    /// Returns the index from 1 of the outermost layer that contains a node or is it; 0 if there is
    /// none.
    fn at(&mut self, node: &Node<'_, '_>) -> usize {
        let range = node.range();
        if range.start < self.ends {
            return self.layers.len();
        }
        let outermost = || {
            let parent = node.parent_element();
            is(node, "g") && parent.is_some_and(|parent| parent.id() == self.within)
        };
        let id = node.attribute("id");
        let name = if self.inkscape && is_inkscape_layer(node) {
            node.attribute((INKSCAPE_NAMESPACE, "label")).or(id)
        } else if !self.inkscape && outermost() {
            id
        } else {
            return 0;
        };
        if !self.inkscape && name.is_none() {
            return 0;
        }
        self.layers.push(Layer {
            name: name.map(str::to_owned),
            inkscape: self.inkscape,
        });
        self.ends = range.end;
        self.layers.len()
    }
}

/// Returns the anonymous group that contains everything an element draws. Some programs put one
/// around their layers.
fn wrapper<'a, 'i>(node: &Node<'a, 'i>) -> Option<Node<'a, 'i>> {
    let mut drawing = node
        .children()
        .filter(|child| DRAWING_ELEMENTS.iter().any(|tag| is(child, tag)));
    let (only, None) = (drawing.next()?, drawing.next()) else {
        return None;
    };
    (is(&only, "g") && only.attribute("id").is_none()).then_some(only)
}

fn is_inkscape_layer(node: &Node<'_, '_>) -> bool {
    is(node, "g") && node.attribute((INKSCAPE_NAMESPACE, "groupmode")) == Some("layer")
}

/// Enlarges the page of a drawing, so that one unit has more pixels; coordinates stay. `size` is
/// its width and height in pixels. `None` if an entity supplies the root element.
pub(super) fn enlarged(
    text: &str,
    size: [f32; 2],
    times: f32,
) -> Result<Option<String>, Diagnostic> {
    let document = parse(text)?;
    let root = document.root_element();
    let Some(at) = after_name(text, &root) else {
        return Ok(None);
    };
    let sizes = root.attributes().filter(|attribute| {
        attribute.namespace().is_none() && matches!(attribute.name(), "width" | "height")
    });
    let mut edits: Vec<_> = sizes.map(|size| (size.range(), String::new())).collect();
    let [width, height] = size;
    let view_box = match root.attribute("viewBox") {
        Some(_) => String::new(),
        None => format!(r#" viewBox="0 0 {width} {height}""#),
    };
    let [wide, high] = size.map(|side| side * times);
    edits.push((
        at..at,
        format!(r#" width="{wide}" height="{high}"{view_box}"#),
    ));
    Ok(Some(edited(text, edits)))
}

pub(super) fn parse(text: &str) -> Result<Document<'_>, Diagnostic> {
    let options = ParsingOptions {
        allow_dtd: true,
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options).map_err(|error| {
        let at = error.pos();
        let origin = Origin {
            line: at.row,
            column: at.col,
            length: 1,
            name: 0,
        };
        // The message of the library ends with the place, which the diagnostic has itself.
        let message = error.to_string();
        let message = message.split(" at ").next().unwrap_or(&message);
        Diagnostic::new(
            origin,
            message!("the XML cannot be read: {message}", message),
        )
    })
}

/// True for an SVG element with this tag.
pub(super) fn is(node: &Node<'_, '_>, tag: &str) -> bool {
    let name = node.tag_name();
    node.is_element()
        && name.name() == tag
        && matches!(name.namespace(), None | Some(SVG_NAMESPACE))
}

/// True if an element hides itself.
fn is_hidden(node: &Node<'_, '_>) -> bool {
    const HIDDEN: [(&str, &str); 3] = [
        ("display", "none"),
        ("visibility", "hidden"),
        ("opacity", "0"),
    ];
    let style = node.attribute("style").unwrap_or_default();
    let mut hidden = HIDDEN.iter();
    hidden.any(|(name, value)| {
        let declared = style.split(';').any(|one| {
            let parts = one.split_once(':');
            parts.is_some_and(|(own, says)| own.trim() == *name && says.trim() == *value)
        });
        node.attribute(*name).map(str::trim) == Some(*value) || declared
    })
}

/// Iterates over messages about undrawn parts of an element.
fn remarks(node: &Node<'_, '_>) -> impl Iterator<Item = Message> {
    let tag = OMITTED_ELEMENTS.iter().filter(|(tag, _)| is(node, tag));
    let style = node.attribute("style").unwrap_or_default();
    let ignored = IGNORED_PROPERTIES.iter().filter(move |(property, _)| {
        let value = node.attribute(*property);
        value.is_some_and(|value| value.trim_start().starts_with("url"))
            || style.contains(&format!("{property}:url"))
    });
    tag.chain(ignored)
        .map(|(_, remark)| Message::word(remark))
        .collect::<Vec<_>>()
        .into_iter()
}

fn page_of(root: &Node<'_, '_>) -> Page {
    let says = |name| {
        root.attribute(name)
            .is_some_and(|value| !value.trim_end().ends_with('%'))
    };
    if says("width") || says("height") {
        Page::Sized
    } else if root.attribute("viewBox").is_some() {
        Page::ViewBox
    } else {
        Page::Unknown
    }
}

/// Returns a prefix that no id in the text has.
fn unused_prefix(text: &str) -> String {
    let used: HashSet<usize> = text
        .split("element-")
        .skip(1)
        .filter_map(|rest| rest.split('-').next()?.parse().ok())
        .collect();
    let free = (0..=used.len()).find(|number| !used.contains(number));
    format!("element-{}-", free.unwrap_or_default())
}

/// Returns the offset behind `<name`. `None` if the element comes from an entity.
fn after_name(text: &str, node: &Node<'_, '_>) -> Option<usize> {
    let start = node.range().start;
    let tag = text.get(start..)?.strip_prefix('<')?;
    let end = tag.find(|c: char| c.is_whitespace() || c == '/' || c == '>')?;
    let name = tag.get(..end)?;
    let local = name.rsplit(':').next()?;
    (local == node.tag_name().name()).then_some(start + 1 + end)
}

/// Range of the start tag, from `<` to `>`.
fn start_tag(text: &str, node: &Node<'_, '_>) -> Range<usize> {
    let range = node.range();
    let last = node
        .attributes()
        .map(|attribute| attribute.range().end)
        .max();
    let from = last.unwrap_or(range.start).clamp(range.start, range.end);
    let close = text.get(from..range.end).and_then(|rest| rest.find('>'));
    range.start..close.map_or(range.end, |at| from + at + 1)
}

/// Range of the content of an element; `None` if it has no children.
fn inside(node: &Node<'_, '_>) -> Option<Range<usize>> {
    let (first, last) = (node.first_child()?, node.last_child()?);
    let (start, end) = (first.range().start, last.range().end);
    (node.range().start < start && start < end && end < node.range().end).then_some(start..end)
}

fn edited(text: &str, mut edits: Vec<(Range<usize>, String)>) -> String {
    edits.sort_by_key(|(range, _)| range.start);
    let mut ready = String::with_capacity(text.len() + edits.len() * 24);
    let mut done = 0;
    for (range, new) in edits {
        ready += text.get(done..range.start).unwrap_or_default();
        ready += &new;
        done = range.end.max(done);
    }
    ready + text.get(done..).unwrap_or_default()
}

/// Converter of offsets that mostly increase to lines and columns, without rescanning the text.
struct Places<'t> {
    text: &'t str,
    lines: Lines<'t>,
    at: usize,
    line: u32,
    column: u32,
}

impl<'t> Places<'t> {
    fn new(text: &'t str) -> Self {
        Self {
            text,
            lines: Lines::new(text),
            at: 0,
            line: 1,
            column: 1,
        }
    }

    fn origin(&mut self, range: Range<usize>) -> Origin {
        let Some(way) = self.text.get(self.at..range.start) else {
            return self.lines.origin(range);
        };
        for character in way.chars() {
            match character {
                '\n' => (self.line, self.column) = (self.line.saturating_add(1), 1),
                _ => self.column = self.column.saturating_add(1),
            }
        }
        self.at = range.start;
        let length = self.text.get(range).map_or(0, |tag| tag.chars().count());
        Origin {
            line: self.line,
            column: self.column,
            length: u32::try_from(length).unwrap_or(u32::MAX),
            name: 0,
        }
    }
}
