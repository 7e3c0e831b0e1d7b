//! Messages of a program to the person it waits for.

use super::block::Block;

/// Largest length of a message, characters. A choice that fits a display; the rest is cut off.
const MAX_MESSAGE_LENGTH: usize = 200;

/// Returns the pause code of a line, if it has one.
pub(super) fn pause_code(block: &Block) -> Option<&'static str> {
    let codes = [(0, "M0"), (1, "M1")];
    let found = codes
        .into_iter()
        .find(|(number, _)| block.has(b'M', *number));
    found.map(|(_, name)| name)
}

/// Returns the comment of a pausing line, or the text after its code.
pub(super) fn pause_message(line: &str, block: &Block) -> Option<String> {
    let end = block.codes.last().map_or(0, |code| code.range.end);
    let text = match (line.find('('), line.find(';')) {
        (Some(open), semicolon) if semicolon.is_none_or(|at| open < at) => {
            let comment = line.get(open + 1..)?;
            comment.split(')').next()?
        }
        (_, Some(semicolon)) => line.get(semicolon + 1..)?,
        _ if pause_code(block).is_some() => {
            let words = line.get(end..)?.split_whitespace();
            let is_time = |word: &&str| {
                let time = word.strip_prefix(['P', 'S', 'p', 's']);
                time.is_some_and(|time| time.parse::<f64>().is_ok())
            };
            let words: Vec<&str> = words.skip_while(is_time).collect();
            return shortened(&words.join(" "));
        }
        _ => return None,
    };
    let text = text.trim();
    let message = text
        .get(..3)
        .filter(|word| word.eq_ignore_ascii_case("msg"));
    let text = match message {
        Some(_) => text.get(3..).unwrap_or_default(),
        None => text,
    };
    shortened(text.trim_start_matches([',', ':']))
}

fn shortened(text: &str) -> Option<String> {
    let shown = text.trim().chars().filter(|sign| !sign.is_control());
    let shown: String = shown.take(MAX_MESSAGE_LENGTH).collect();
    (!shown.is_empty()).then_some(shown)
}
