//! Parsing of a workspace: blocks from XML.

use magician_host::{Message, message};
use roxmltree::Node;

use crate::formats::xml;
use crate::{Diagnostic, Lines, Origin};

/// Blocks of a workspace. They refer to each other by index.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub(super) blocks: Vec<Block>,
    /// Top-level blocks in execution order.
    pub(super) tops: Vec<usize>,
}

#[derive(Debug, Default)]
pub(super) struct Block {
    pub(super) kind: String,
    pub(super) id: String,
    /// Place of its start tag.
    pub(super) origin: Origin,
    pub(super) disabled: bool,
    fields: Vec<(String, String)>,
    /// Blocks in its value and statement inputs.
    inputs: Vec<(String, usize)>,
    pub(super) next: Option<usize>,
    at: [f64; 2],
}

impl Block {
    pub(super) fn field(&self, name: &str) -> Option<&str> {
        let mut fields = self.fields.iter();
        let found = fields.find(|(own, _)| own.eq_ignore_ascii_case(name));
        found.map(|(_, text)| text.trim())
    }

    pub(super) fn input(&self, name: &str) -> Option<usize> {
        let mut inputs = self.inputs.iter();
        let found = inputs.find(|(own, _)| own.eq_ignore_ascii_case(name));
        found.map(|(_, block)| *block)
    }

    /// Returns the sorted numbers N of inputs named by one of these prefixes followed by N.
    pub(super) fn numbered_inputs(&self, prefixes: [&str; 2]) -> Vec<u32> {
        let number = |name: &str| {
            let mut rest = prefixes
                .iter()
                .filter_map(|prefix| name.strip_prefix(prefix));
            rest.find_map(|digits| digits.parse().ok())
        };
        let mut numbers: Vec<u32> = (self.inputs.iter())
            .filter_map(|(name, _)| number(name))
            .collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }

    /// Name in messages: its id, or its kind.
    pub(super) fn name(&self) -> &str {
        if self.id.is_empty() {
            &self.kind
        } else {
            &self.id
        }
    }

    pub(super) fn diagnostic(&self, message: impl Into<Message>) -> Diagnostic {
        Diagnostic::new(self.origin, message).named(self.name())
    }
}

/// Attachment of a block.
#[derive(Clone, Copy)]
enum Hook<'a> {
    Top,
    After(usize),
    In(usize, &'a str),
}

impl Tree {
    pub(super) fn read(text: &str) -> Result<Self, Diagnostic> {
        let document = xml::parse(text)?;
        let lines = Lines::new(text);
        let root = document.root_element();
        if root.tag_name().name() != "xml" {
            let name = root.tag_name().name();
            let place = start_of(root, text, &lines);
            let message = message!(
                "this is not a Blockly workspace: its outermost element is '{name}'",
                name
            );
            let help = message!("that of a workspace is 'xml'");
            return Err(Diagnostic::new(place, message).help(help));
        }
        let mut tree = Self::default();
        let mut open: Vec<_> = blocks_in(root).map(|node| (node, Hook::Top)).collect();
        open.reverse();
        // An explicit stack instead of recursion, because chains of blocks nest as deep as they are
        // long.
        while let Some((node, hook)) = open.pop() {
            let index = tree.blocks.len();
            tree.blocks.push(block(node, start_of(node, text, &lines)));
            tree.hang(index, hook);
            tree.open(index, node, &mut open);
        }
        if tree.blocks.is_empty() {
            let place = start_of(root, text, &lines);
            return Err(Diagnostic::new(
                place,
                message!("the workspace has no blocks"),
            ));
        }
        tree.order();
        Ok(tree)
    }

    fn hang(&mut self, index: usize, hook: Hook<'_>) {
        match hook {
            Hook::Top => self.tops.push(index),
            Hook::After(before) => {
                if let Some(before) = self.blocks.get_mut(before) {
                    before.next = Some(index);
                }
            }
            Hook::In(around, input) => {
                if let Some(around) = self.blocks.get_mut(around) {
                    around.inputs.push((input.to_owned(), index));
                }
            }
        }
    }

    fn open<'a, 'i>(
        &mut self,
        index: usize,
        node: Node<'a, 'i>,
        open: &mut Vec<(Node<'a, 'i>, Hook<'a>)>,
    ) {
        for child in xml::elements(node) {
            let name = child.attribute("name").unwrap_or_default();
            let hook = match child.tag_name().name() {
                "field" | "title" => {
                    let text = xml::content(child).into_owned();
                    if let Some(block) = self.blocks.get_mut(index) {
                        block.fields.push((name.to_owned(), text));
                    }
                    continue;
                }
                "value" | "statement" => Hook::In(index, name),
                "next" => Hook::After(index),
                // Comments, mutations and positions have no effect on the program.
                _ => continue,
            };
            // A block in a value input replaces its shadow.
            let shadow = || xml::elements(child).find(|node| node.tag_name().name() == "shadow");
            let inner = blocks_in(child).next().or_else(shadow);
            open.extend(inner.map(|node| (node, hook)));
        }
    }

    /// Sorts stacks as Blockly does: from top to bottom, at equal heights from the left. A slope of
    /// 3 degrees breaks ties.
    fn order(&mut self) {
        let slope = libm::sin(3.0_f64.to_radians());
        let height = |index: &usize| {
            let [x, y] = self.blocks.get(*index).map_or([0.0; 2], |block| block.at);
            y + slope * x
        };
        let mut tops = std::mem::take(&mut self.tops);
        tops.sort_by(|a, b| height(a).total_cmp(&height(b)));
        self.tops = tops;
    }
}

fn blocks_in<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    xml::elements(node).filter(|child| child.tag_name().name() == "block")
}

fn start_of(node: Node<'_, '_>, text: &str, lines: &Lines<'_>) -> Origin {
    let whole = node.range();
    // An id may contain `>`, so search behind the last attribute.
    let last = node
        .attributes()
        .map(|attribute| attribute.range().end)
        .max();
    let from = last.unwrap_or(whole.start);
    let rest = text.get(from..whole.end).unwrap_or_default();
    let end = from + rest.find('>').map_or(rest.len(), |at| at + 1);
    lines.origin(whole.start..end)
}

fn block(node: Node<'_, '_>, origin: Origin) -> Block {
    let attribute = |name| node.attribute(name).unwrap_or_default();
    let number = |name| attribute(name).trim().parse::<f64>().unwrap_or_default();
    Block {
        kind: attribute("type").to_owned(),
        id: attribute("id").to_owned(),
        origin,
        disabled: attribute("disabled") == "true" || attribute("enabled") == "false",
        at: [number("x"), number("y")],
        ..Block::default()
    }
}
