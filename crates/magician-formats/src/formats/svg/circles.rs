//! Clip paths and masks that refer to one another in a circle: the library follows those of three and more without end.

use std::collections::{HashMap, HashSet};

use roxmltree::{Document, Node};

use super::cost::{references, style_sheets};
use super::source::is;

/// What is followed wherever it is referred to.
const FOLLOWED: [&str; 2] = ["clipPath", "mask"];
/// The library itself breaks up circles of so many of a kind.
const BROKEN_UP: usize = 2;

/// A clip path or mask that is in a circle which is not broken up.
pub(super) fn in_a_circle<'a, 'i>(document: &'a Document<'i>) -> Option<Node<'a, 'i>> {
    let followed = |node: &Node<'_, '_>| FOLLOWED.iter().any(|tag| is(node, tag));
    if document.descendants().filter(followed).count() < BROKEN_UP {
        return None;
    }
    let graph = Graph::of(document);
    for component in graph.components() {
        let nodes = component
            .iter()
            .filter_map(|index| document.get_node((*index as u32).into()));
        let circle: Vec<_> = nodes.filter(|node| followed(node)).collect();
        let of_one_kind = FOLLOWED
            .iter()
            .any(|tag| circle.iter().all(|node| is(node, tag)));
        if circle.len() > BROKEN_UP || !of_one_kind {
            return circle.into_iter().next();
        }
    }
    None
}

/// Which elements lead to which: to those within them, and to those that they refer to.
struct Graph {
    ways: Vec<Vec<usize>>,
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
        let mut ways = vec![Vec::new(); count];
        // A rule of a style sheet is a place of its own, and so is each class and id that it speaks of.
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
            let style = ways.len();
            ways.push(refers_to);
            for who in selector.split(',').flat_map(SelectorSubject::by) {
                let place = *meant.entry(who).or_insert_with(|| {
                    ways.push(Vec::new());
                    ways.len() - 1
                });
                if let Some(way) = ways.get_mut(place) {
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
            if let Some(way) = ways.get_mut(node.id().get_usize()) {
                way.extend(referred.chain(styled).chain(within));
            }
        }
        Self { ways }
    }

    /// Those that lead to one another (Kosaraju), without those of a single element.
    fn components(&self) -> Vec<Vec<usize>> {
        let mut back = vec![Vec::new(); self.ways.len()];
        for (from, ways) in self.ways.iter().enumerate() {
            for to in ways {
                if let Some(back) = back.get_mut(*to) {
                    back.push(from);
                }
            }
        }
        let mut order = Vec::with_capacity(self.ways.len());
        let mut seen = HashSet::new();
        for start in 0..self.ways.len() {
            collector(&self.ways, start, &mut seen, &mut order);
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

/// All that can be reached and was not seen, each after what it leads to.
fn collector(ways: &[Vec<usize>], start: usize, seen: &mut HashSet<usize>, order: &mut Vec<usize>) {
    if !seen.insert(start) {
        return;
    }
    let mut stack = vec![(start, 0)];
    while let Some((node, next)) = stack.last_mut() {
        match ways.get(*node).and_then(|ways| ways.get(*next)) {
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

/// The elements that a selector of a style sheet may match.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum SelectorSubject<'s> {
    All,
    Class(&'s str),
    Id(&'s str),
}

impl<'s> SelectorSubject<'s> {
    /// All that have one of its classes or ids; all elements if it asks for neither.
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
