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
        let sheets = style_sheets(document);
        let rules: Vec<Rule<'_>> = sheets.split('}').filter_map(Rule::of).collect();
        let mut ways = vec![Vec::new(); count];
        for node in document.descendants().filter(Node::is_element) {
            let mut names: Vec<&str> = Vec::new();
            for attribute in node.attributes() {
                match attribute.name() {
                    "href" => names.extend(attribute.value().trim().strip_prefix('#')),
                    _ => names.extend(references(attribute.value())),
                }
            }
            for rule in rules.iter().filter(|rule| rule.may_be_of(&node)) {
                names.extend(&rule.refers_to);
            }
            let referred = names.iter().filter_map(|name| ids.get(name).copied());
            let within = node.children().filter(Node::is_element);
            let within = within.map(|child| child.id().get_usize());
            if let Some(way) = ways.get_mut(node.id().get_usize()) {
                way.extend(referred.chain(within));
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
            walk(&self.ways, start, &mut seen, &mut order);
        }
        seen.clear();
        let mut components = Vec::new();
        for start in order.into_iter().rev() {
            let mut component = Vec::new();
            walk(&back, start, &mut seen, &mut component);
            if component.len() > 1 {
                components.push(component);
            }
        }
        components
    }
}

/// All that can be reached and was not seen, each after what it leads to.
fn walk(ways: &[Vec<usize>], start: usize, seen: &mut HashSet<usize>, order: &mut Vec<usize>) {
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

/// A rule of a style sheet that refers to elements.
struct Rule<'s> {
    selector: &'s str,
    refers_to: Vec<&'s str>,
}

impl<'s> Rule<'s> {
    fn of(text: &'s str) -> Option<Self> {
        let (selector, body) = text.split_once('{')?;
        let refers_to: Vec<&str> = references(body).collect();
        (!refers_to.is_empty()).then_some(Self {
            selector,
            refers_to,
        })
    }

    /// Whether an element may be meant: it has a class or the id of the selector, or the selector asks for neither.
    fn may_be_of(&self, node: &Node<'_, '_>) -> bool {
        let named = |sign: char, name: &str| {
            let mut parts = self.selector.split(sign).skip(1);
            parts.any(|part| {
                part.strip_prefix(name).is_some_and(|rest| {
                    !rest.starts_with(|next: char| next.is_alphanumeric() || "-_".contains(next))
                })
            })
        };
        let classes = node.attribute("class").unwrap_or_default();
        !self.selector.contains(['.', '#'])
            || classes.split_whitespace().any(|class| named('.', class))
            || node.attribute("id").is_some_and(|id| named('#', id))
    }
}
