//! How much work a drawing is, found out before it is done: a few lines of `use` can stand for more elements than there is
//! memory.

use magician_host::message;
use std::collections::HashMap;

use roxmltree::{Document, Node, NodeId};

use super::circles::in_a_circle;
use super::source::is;
use crate::{Diagnostic, Origin};

/// Elements that a drawing may come to when everything it refers to is written out.
const MOST: f64 = 2_000_000.0;
/// Elements within elements, those reached through references included.
const DEEPEST: u32 = 250;
/// A character of a text costs as much as so many elements.
const PER_CHARACTER: f64 = 4.0;
/// Rules of style sheets times elements.
const MOST_STYLING: f64 = 2e8;

/// Refuses what is too much work.
pub(super) fn check(document: &Document<'_>) -> Result<(), Diagnostic> {
    let mut ids = HashMap::new();
    let mut depths: HashMap<NodeId, u32> = HashMap::new();
    for node in document.descendants().filter(Node::is_element) {
        let above = node.parent().and_then(|parent| depths.get(&parent.id()));
        let depth = above.map_or(1, |above| above + 1);
        if depth > DEEPEST {
            return Err(too_deep(document, &node));
        }
        depths.insert(node.id(), depth);
        if let Some(id) = node.attribute("id") {
            ids.entry(id).or_insert(node);
        }
    }
    if let Some(node) = in_a_circle(document) {
        return Err(too_deep(document, &node));
    }
    let sheets = style_sheets(document);
    let rules = sheets.matches('{').count();
    if rules as f64 * depths.len() as f64 > MOST_STYLING {
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
    if depth > DEEPEST {
        return Err(too_deep(document, &document.root_element()));
    }
    if work > MOST {
        let message = message!(
            "with all references expanded it has {work:.0} elements, limit {most:.0}",
            work,
            most = MOST
        );
        return Err(Diagnostic::of_file(message));
    }
    Ok(())
}

/// All style sheets of a drawing.
pub(super) fn style_sheets(document: &Document<'_>) -> String {
    let sheets = document.descendants().filter(|node| is(node, "style"));
    sheets.filter_map(|node| node.text()).collect()
}

/// Whether an element is written out wherever another one refers to it.
fn is_followed(node: &Node<'_, '_>) -> bool {
    is(node, "clipPath") || is(node, "mask")
}

fn too_deep(document: &Document<'_>, node: &Node<'_, '_>) -> Diagnostic {
    let at = document.text_pos_at(node.range().start);
    // Ids that were added have moved what follows on the line.
    let origin = Origin {
        line: at.row,
        ..Origin::NONE
    };
    let message = message!(
        "elements are nested more than {deepest} deep here, or refer to each other in a circle",
        deepest = DEEPEST
    );
    Diagnostic::new(origin, message)
}

/// The elements of the largest marker.
fn markers(document: &Document<'_>) -> f64 {
    let markers = document.descendants().filter(|node| is(node, "marker"));
    markers
        .map(|node| node.descendants().count() as f64)
        .fold(0.0, f64::max)
}

/// `url(#id)` in a style.
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
    /// What any element may be clipped by.
    everywhere: Vec<&'a str>,
    /// What each corner may cost.
    marker: f64,
    /// Work and depth of each; nothing while it is being found out.
    known: HashMap<NodeId, Option<(f64, u32)>>,
}

impl<'a, 'i> Costs<'a, 'i> {
    /// How many elements one comes to, and how deep it goes; the element at which it is too deep.
    fn of(&mut self, node: Node<'a, 'i>, depth: u32) -> Result<(f64, u32), Node<'a, 'i>> {
        if depth > 2 * DEEPEST {
            return Err(node);
        }
        match self.known.get(&node.id()) {
            // A circle: it is broken up.
            Some(None) => return Ok((0.0, 0)),
            Some(Some(known)) => return Ok(*known),
            None => {}
        }
        self.known.insert(node.id(), None);
        let written = if is(&node, "text") {
            PER_CHARACTER * corners(&node)
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

    /// What an element refers to and is written out for it.
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

/// As many corners a path has at most.
fn corners(node: &Node<'_, '_>) -> f64 {
    let length = |name| node.attribute(name).map_or(0, str::len);
    match (length("d"), length("points")) {
        // One that is used many times is laid out as often.
        (0, 0) if is(node, "text") => {
            let texts = node.descendants().filter(Node::is_text);
            let lengths = texts.filter_map(|text| text.text()).map(str::len);
            2.0 + lengths.sum::<usize>() as f64
        }
        (0, 0) => 2.0,
        (path, points) => 2.0 + (path + points) as f64 / 2.0,
    }
}
