//! XML parsing for the readers of this crate: document types are refused, and errors carry their
//! place.

use magician_host::message;
use roxmltree::{Document, Node, ParsingOptions};

use crate::{Diagnostic, Origin};

/// Largest number of nodes. A choice above any real file; it bounds memory.
const MAX_NODES: u32 = 8_000_000;

/// Parses a document.
pub(super) fn parse(text: &str) -> Result<Document<'_>, Diagnostic> {
    let options = ParsingOptions {
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options).map_err(|error| {
        let at = error.pos();
        let place = Origin {
            line: at.row,
            column: at.col,
            length: 1,
            name: 0,
        };
        Diagnostic::new(
            place,
            message!("this is not XML: {error}", error = error.to_string()),
        )
    })
}

/// Iterates over the child elements of a node.
pub(super) fn elements<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(Node::is_element)
}

/// Returns the text directly inside an element, without that of its child elements.
pub(super) fn content<'a>(node: Node<'a, '_>) -> std::borrow::Cow<'a, str> {
    let mut texts = node
        .children()
        .filter_map(|child| if child.is_text() { child.text() } else { None });
    match (texts.next(), texts.next()) {
        (None, _) => "".into(),
        (Some(only), None) => only.into(),
        (Some(first), Some(second)) => {
            let rest: String = texts.collect();
            format!("{first}{second}{rest}").into()
        }
    }
}
