//! Detection of clip paths and masks that refer to each other in a cycle.
//!
//! usvg breaks cycles of up to two elements of one kind, but follows longer ones without end. So
//! the graph of references is built here, including those made by style sheets, and its strongly
//! connected components are searched for such cycles.

use std::collections::{HashMap, HashSet};

use roxmltree::{Document, Node};

use super::cost::{references, style_sheets};
use super::source::is;

/// Elements that usvg follows wherever they are referenced.
const FOLLOWED_ELEMENTS: [&str; 2] = ["clipPath", "mask"];
/// Longest cycle of one kind that usvg breaks itself.
const MAX_HANDLED_CYCLE: usize = 2;

/// Returns a clip path or mask in a cycle that usvg does not break.
pub(super) fn find_cycle<'a, 'i>(document: &'a Document<'i>) -> Option<Node<'a, 'i>> {
    let followed = |node: &Node<'_, '_>| FOLLOWED_ELEMENTS.iter().any(|tag| is(node, tag));
    if document.descendants().filter(followed).count() < MAX_HANDLED_CYCLE {
        return None;
    }
    let graph = Graph::of(document);
    for component in graph.components() {
        let nodes = component
            .iter()
            .filter_map(|index| document.get_node((*index as u32).into()));
        let circle: Vec<_> = nodes.filter(|node| followed(node)).collect();
        let of_one_kind = FOLLOWED_ELEMENTS
            .iter()
            .any(|tag| circle.iter().all(|node| is(node, tag)));
        if circle.len() > MAX_HANDLED_CYCLE || !of_one_kind {
            return circle.into_iter().next();
        }
    }
    None
}

/// Graph of elements: edges to child elements and to referenced ones.
struct Graph {
    edges: Vec<Vec<usize>>,
}

impl Graph {
    fn of(document: &Document<'_>) -> Self {
        let mut ids: HashMap<&str, usize> = HashMap::new();
        let mut count = 0;
        for node in document.descendants().filter(Node::is_element) {
            count = count.max(node.id().get_usize() + 1);
            if let Some(id) = node.attribute("id") {
                ids.entry(id).or_insert(node.id().get_usize());
            }
        }
        let mut edges = vec![Vec::new(); count];
        // Each rule of a style sheet is a node, and so is each class and id in its selector.
        let sheets = style_sheets(document);
        let mut meant: HashMap<SelectorSubject<'_>, usize> = HashMap::new();
        for rule in sheets.split('}') {
            let Some((selector, body)) = rule.split_once('{') else {
                continue;
            };
            let refers_to: Vec<usize> = references(body)
                .filter_map(|name| ids.get(name).copied())
                .collect();
            if refers_to.is_empty() {
                continue;
            }
            let style = edges.len();
            edges.push(refers_to);
            for who in selector.split(',').flat_map(SelectorSubject::by) {
                let place = *meant.entry(who).or_insert_with(|| {
                    edges.push(Vec::new());
                    edges.len() - 1
                });
                if let Some(way) = edges.get_mut(place) {
                    way.push(style);
                }
            }
        }
        for node in document.descendants().filter(Node::is_element) {
            let mut names: Vec<&str> = Vec::new();
            for attribute in node.attributes() {
                match attribute.name() {
                    "href" => names.extend(attribute.value().trim().strip_prefix('#')),
                    _ => names.extend(references(attribute.value())),
                }
            }
            let classes = node.attribute("class").unwrap_or_default();
            let classes = classes.split_whitespace().map(SelectorSubject::Class);
            let own = node.attribute("id").map(SelectorSubject::Id);
            let styled = classes
                .chain(own)
                .chain([SelectorSubject::All])
                .filter_map(|who| meant.get(&who).copied());
            let referred = names.iter().filter_map(|name| ids.get(name).copied());
            let within = node.children().filter(Node::is_element);
            let within = within.map(|child| child.id().get_usize());
            if let Some(way) = edges.get_mut(node.id().get_usize()) {
                way.extend(referred.chain(styled).chain(within));
            }
        }
        Self { edges }
    }

    /// Strongly connected components of more than one node (Kosaraju).
    fn components(&self) -> Vec<Vec<usize>> {
        let mut back = vec![Vec::new(); self.edges.len()];
        for (from, edges) in self.edges.iter().enumerate() {
            for to in edges {
                if let Some(back) = back.get_mut(*to) {
                    back.push(from);
                }
            }
        }
        let mut order = Vec::with_capacity(self.edges.len());
        let mut seen = HashSet::new();
        for start in 0..self.edges.len() {
            collector(&self.edges, start, &mut seen, &mut order);
        }
        seen.clear();
        let mut components = Vec::new();
        for start in order.into_iter().rev() {
            let mut component = Vec::new();
            collector(&back, start, &mut seen, &mut component);
            if component.len() > 1 {
                components.push(component);
            }
        }
        components
    }
}

/// Depth-first search: appends all reachable unseen nodes in post-order.
fn collector(
    edges: &[Vec<usize>],
    start: usize,
    seen: &mut HashSet<usize>,
    order: &mut Vec<usize>,
) {
    if !seen.insert(start) {
        return;
    }
    let mut stack = vec![(start, 0)];
    while let Some((node, next)) = stack.last_mut() {
        match edges.get(*node).and_then(|edges| edges.get(*next)) {
            Some(to) => {
                *next += 1;
                if seen.insert(*to) {
                    stack.push((*to, 0));
                }
            }
            None => {
                order.push(*node);
                stack.pop();
            }
        }
    }
}

/// Elements that a selector may match.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum SelectorSubject<'s> {
    All,
    Class(&'s str),
    Id(&'s str),
}

impl<'s> SelectorSubject<'s> {
    /// Returns the classes and ids in a selector, or all elements if it has none. This
    /// over-approximates: it may find a cycle that no element takes part in, but misses none.
    fn by(selector: &'s str) -> Vec<Self> {
        let name = |from: usize| {
            let rest = selector.get(from..).unwrap_or_default();
            let ends = |sign: char| !(sign.is_alphanumeric() || sign == '-' || sign == '_');
            rest.get(..rest.find(ends).unwrap_or(rest.len()))
        };
        let named: Vec<Self> = selector
            .match_indices(['.', '#'])
            .filter_map(|(at, sign)| match sign {
                "." => name(at + 1).map(Self::Class),
                _ => name(at + 1).map(Self::Id),
            })
            .collect();
        if named.is_empty() {
            vec![Self::All]
        } else {
            named
        }
    }
}
