//! Quoting of font names such as `Source Sans 3`. Unquoted, a word that begins with a digit is
//! invalid CSS, but people write it and browsers accept it.

use std::ops::Range;

use roxmltree::Node;

const PROPERTY: &str = "font-family";

/// Returns the edits that add quotes to such names, in the attribute or the style of an element.
pub(super) fn quoted(text: &str, node: &Node<'_, '_>) -> Vec<(Range<usize>, String)> {
    let mut edits = Vec::new();
    for attribute in node.attributes().filter(|one| one.namespace().is_none()) {
        let value = attribute.range_value();
        let (Some(raw), Some(around)) = (text.get(value.clone()), quote_before(text, &value))
        else {
            continue;
        };
        let lists = match attribute.name() {
            PROPERTY => std::iter::once(0..raw.len()).collect(),
            "style" => in_style(raw),
            _ => continue,
        };
        let quote = if around == '"' { '\'' } else { '"' };
        for list in lists {
            edits.extend(names(raw, list).map(|name| {
                let new = format!("{quote}{}{quote}", raw[name.clone()].trim_end());
                (value.start + name.start..value.start + name.end, new)
            }));
        }
    }
    edits
}

/// Returns the quotation mark around a value; `None` if the value comes from an entity.
pub(super) fn quote_before(text: &str, value: &Range<usize>) -> Option<char> {
    let before = text.get(..value.start)?.chars().next_back()?;
    matches!(before, '"' | '\'').then_some(before)
}

/// Returns the ranges of font lists in a style.
fn in_style(style: &str) -> Vec<Range<usize>> {
    let mut lists = Vec::new();
    let mut at = 0;
    for declaration in style.split(';') {
        if let Some((property, value)) = declaration.split_once(':')
            && property.trim() == PROPERTY
        {
            let end = at + declaration.len();
            lists.push(end - value.len()..end);
        }
        at += declaration.len() + 1;
    }
    lists
}

/// Iterates over the names that need quotes, including trailing blanks, which must not remain
/// before a comma.
fn names(raw: &str, list: Range<usize>) -> impl Iterator<Item = Range<usize>> + '_ {
    let mut at = list.start;
    raw[list].split(',').filter_map(move |part| {
        let start = at + (part.len() - part.trim_start().len());
        at += part.len() + 1;
        let name = part.trim();
        let digit = |word: &str| word.starts_with(|sign: char| sign.is_ascii_digit());
        let plain = !name.contains(['\'', '"', '&', '!', '\\', '(']);
        (plain && name.split_whitespace().any(digit)).then(|| start..at - 1)
    })
}
