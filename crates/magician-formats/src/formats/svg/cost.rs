//! Estimate of the work that a drawing causes, before it is parsed further.
//!
//! A few nested `use` elements can expand to more elements than there is memory (a billion laughs).
//! usvg expands them without limits, so the expanded size and depth are computed here on the
//! unexpanded document, with memoisation.

use magician_host::message;
use std::collections::HashMap;

use roxmltree::{Document, Node, NodeId};

use super::cycles::find_cycle;
use super::source::is;
use crate::{Diagnostic, Origin};

/// Largest number of elements after expanding all references. It bounds memory and time.
const MAX_ELEMENTS: f64 = 2_000_000.0;
/// Largest nesting depth, including references. It protects the stack of recursive functions in
/// usvg.
const MAX_DEPTH: u32 = 250;
/// Cost of a character of text, in elements.
const CHARACTER_COST: f64 = 4.0;
/// Largest product of style rules and elements, because usvg tests each rule on each element.
const MAX_STYLING: f64 = 2e8;

/// Refuses a drawing that is too much work.
pub(super) fn check(document: &Document<'_>) -> Result<(), Diagnostic> {
    let mut ids = HashMap::new();
    let mut depths: HashMap<NodeId, u32> = HashMap::new();
    for node in document.descendants().filter(Node::is_element) {
        let above = node.parent().and_then(|parent| depths.get(&parent.id()));
        let depth = above.map_or(1, |above| above + 1);
        if depth > MAX_DEPTH {
            return Err(too_deep(document, &node));
        }
        depths.insert(node.id(), depth);
        if let Some(id) = node.attribute("id") {
            ids.entry(id).or_insert(node);
        }
    }
    if let Some(node) = find_cycle(document) {
        return Err(too_deep(document, &node));
    }
    let sheets = style_sheets(document);
    let rules = sheets.matches('{').count();
    if rules as f64 * depths.len() as f64 > MAX_STYLING {
        let message = message!(
            "too many style rules: {rules} for {depths} elements",
            rules,
            depths = depths.len()
        );
        return Err(Diagnostic::of_file(message));
    }
    let costly = |id: &&str| ids.get(id).is_some_and(is_followed);
    let mut everywhere: Vec<&str> = references(&sheets).filter(costly).collect();
    everywhere.sort_unstable();
    everywhere.dedup();
    let marker = markers(document);
    let mut costs = Costs {
        ids,
        everywhere,
        marker,
        known: HashMap::new(),
    };
    let (work, depth) = costs
        .of(document.root_element(), 0)
        .map_err(|at| too_deep(document, &at))?;
    if depth > MAX_DEPTH {
        return Err(too_deep(document, &document.root_element()));
    }
    if work > MAX_ELEMENTS {
        let message = message!(
            "with all references expanded it has {work:.0} elements, limit {most:.0}",
            work,
            most = MAX_ELEMENTS
        );
        return Err(Diagnostic::of_file(message));
    }
    Ok(())
}

/// Returns the text of all style sheets.
pub(super) fn style_sheets(document: &Document<'_>) -> String {
    let sheets = document.descendants().filter(|node| is(node, "style"));
    sheets.filter_map(|node| node.text()).collect()
}

/// True if an element is expanded wherever it is referenced.
fn is_followed(node: &Node<'_, '_>) -> bool {
    is(node, "clipPath") || is(node, "mask")
}

fn too_deep(document: &Document<'_>, node: &Node<'_, '_>) -> Diagnostic {
    let at = document.text_pos_at(node.range().start);
    // Ids inserted before parsing have shifted the columns of the line.
    let origin = Origin {
        line: at.row,
        ..Origin::NONE
    };
    let message = message!(
        "elements are nested more than {deepest} deep here, or refer to each other in a circle",
        deepest = MAX_DEPTH
    );
    Diagnostic::new(origin, message)
}

/// Number of elements of the largest marker.
fn markers(document: &Document<'_>) -> f64 {
    let markers = document.descendants().filter(|node| is(node, "marker"));
    markers
        .map(|node| node.descendants().count() as f64)
        .fold(0.0, f64::max)
}

/// Iterates over the ids in `url(#id)` of a style.
pub(super) fn references(style: &str) -> impl Iterator<Item = &str> {
    style.split("url(").skip(1).filter_map(|rest| {
        let inner = rest.split(')').next()?;
        inner
            .trim_matches(|c: char| c.is_whitespace() || c == '"' || c == '\'')
            .strip_prefix('#')
    })
}

struct Costs<'a, 'i> {
    ids: HashMap<&'a str, Node<'a, 'i>>,
    /// Ids of clip paths and masks in style sheets, which may apply to any element.
    everywhere: Vec<&'a str>,
    /// Cost of each vertex, because any vertex may get the largest marker.
    marker: f64,
    /// Work and depth per element; `None` while they are being computed.
    known: HashMap<NodeId, Option<(f64, u32)>>,
}

impl<'a, 'i> Costs<'a, 'i> {
    /// Returns number of elements and depth after expansion. The error is the element that is
    /// nested too deep.
    fn of(&mut self, node: Node<'a, 'i>, depth: u32) -> Result<(f64, u32), Node<'a, 'i>> {
        if depth > 2 * MAX_DEPTH {
            return Err(node);
        }
        match self.known.get(&node.id()) {
            // A cycle, which usvg breaks.
            Some(None) => return Ok((0.0, 0)),
            Some(Some(known)) => return Ok(*known),
            None => {}
        }
        self.known.insert(node.id(), None);
        let written = if is(&node, "text") {
            CHARACTER_COST * corners(&node)
        } else {
            0.0
        };
        let (mut work, mut deepest) = (1.0 + self.marker * corners(&node) + written, 0);
        for next in node
            .children()
            .filter(Node::is_element)
            .chain(self.referred(&node))
        {
            let (own, below) = self.of(next, depth + 1)?;
            work += own;
            deepest = deepest.max(below);
        }
        let found = (work, deepest + 1);
        self.known.insert(node.id(), Some(found));
        Ok(found)
    }

    /// Returns the elements that are expanded for an element.
    fn referred(&self, node: &Node<'a, 'i>) -> Vec<Node<'a, 'i>> {
        let mut names: Vec<&str> = Vec::new();
        if is(node, "use") || is(node, "textPath") {
            let links = node
                .attributes()
                .filter(|attribute| attribute.name() == "href");
            names.extend(links.filter_map(|link| link.value().trim().strip_prefix('#')));
        }
        let clips = ["clip-path", "mask", "style"].map(|name| node.attribute(name));
        let clips = clips.into_iter().flatten().flat_map(references);
        names.extend(clips.filter(|id| self.ids.get(id).is_some_and(is_followed)));
        names.extend(&self.everywhere);
        names
            .iter()
            .filter_map(|id| self.ids.get(*id).copied())
            .collect()
    }
}

/// Upper bound for the number of vertices of a path, by the length of its data.
fn corners(node: &Node<'_, '_>) -> f64 {
    let length = |name| node.attribute(name).map_or(0, str::len);
    match (length("d"), length("points")) {
        // Text referenced many times is laid out as often.
        (0, 0) if is(node, "text") => {
            let texts = node.descendants().filter(Node::is_text);
            let lengths = texts.filter_map(|text| text.text()).map(str::len);
            2.0 + lengths.sum::<usize>() as f64
        }
        (0, 0) => 2.0,
        (path, points) => 2.0 + (path + points) as f64 / 2.0,
    }
}
