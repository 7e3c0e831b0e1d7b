//! Citations of errata (`E07`) and of sections of the model (`model section 7`): finds them in
//! texts and turns them into links.
//!
//!
//! Pages that are generated from tables get their links from here. A test compares every citation
//! in the repository with the anchors of `docs/reference/ERRATA.md` and `docs/reference/MODEL.md`.

use std::ops::Range;

/// Target of a citation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// Erratum to the vendor's document, such as `E07`.
    Erratum(String),
    /// Section of the model, such as `7` or `15a`.
    Section(String),
}

impl Target {
    /// Returns the page in `docs` and the anchor.
    pub(crate) fn page_and_anchor(&self) -> (&'static str, String) {
        match self {
            Self::Erratum(number) => ("ERRATA.md", number.to_lowercase()),
            Self::Section(number) => ("MODEL.md", format!("section-{number}")),
        }
    }
}

/// Citation in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Citation {
    /// Bytes of the number.
    pub(crate) range: Range<usize>,
    pub(crate) target: Target,
}

/// Returns the text with every citation as a link, for a page in `docs`.
pub(crate) fn with_links(text: &str) -> String {
    let mut page = String::with_capacity(text.len());
    let mut done = 0;
    for Citation { range, target } in citations(text) {
        let (file, anchor) = target.page_and_anchor();
        page += &text[done..range.start];
        page += &format!("[{}]({file}#{anchor})", &text[range.clone()]);
        done = range.end;
    }
    page + &text[done..]
}

/// Finds all citations of a text in order: `E07`, `erratum 7`, `model 7`, `model sections 4, 6 and
/// 7`, across line breaks and in comments. Numbers as in `E10.5`, `0xE10` or `1E10` do not count.
pub(crate) fn citations(text: &str) -> Vec<Citation> {
    let words = words(text);
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(word) = words.get(at) {
        at += 1;
        let subject: fn(&str) -> Option<Target> = if is_one_of(word, &["model"]) {
            |number| Some(Target::Section(number.to_owned()))
        } else if is_one_of(word, &["erratum", "errata"]) {
            |number| {
                Some(Target::Erratum(format!(
                    "E{:02}",
                    number.parse::<u32>().ok()?
                )))
            }
        } else {
            collect_errata(word, &mut found);
            continue;
        };
        let section = words.get(at);
        if section.is_some_and(|word| is_one_of(word, &["section", "sections"])) {
            at += 1;
        }
        at = collect_numbers(&words, at, subject, &mut found);
    }
    found
}

/// Run of characters without a space, with its start.
struct Word<'a> {
    start: usize,
    text: &'a str,
}

/// Returns the words of a text without the markers of comment lines.
fn words(text: &str) -> Vec<Word<'_>> {
    const COMMENT_MARKERS: [&str; 7] = ["///", "//!", "//", "#", "*", "--", "|"];
    let base = text.as_ptr().addr();
    let words = text.split_whitespace();
    let words = words.filter(|word| !COMMENT_MARKERS.contains(word));
    let place = |word: &str| word.as_ptr().addr() - base;
    words
        .map(|text| Word {
            start: place(text),
            text,
        })
        .collect()
}

/// True if a word is one of these, after any brackets and quotes.
fn is_one_of(word: &Word<'_>, names: &[&str]) -> bool {
    let bare = (word.text).trim_start_matches(|c: char| !c.is_alphanumeric());
    names.iter().any(|name| bare.eq_ignore_ascii_case(name))
}

/// Collects the numbers behind their subject: one, or several with commas, `and`, `or`, `to`
/// between them. Returns the index of the following word.
fn collect_numbers(
    words: &[Word<'_>],
    mut at: usize,
    subject: fn(&str) -> Option<Target>,
    found: &mut Vec<Citation>,
) -> usize {
    while let Some(word) = words.get(at) {
        let number = word.text.trim_start_matches(['(', '[']);
        let start = word.start + word.text.len() - number.len();
        let Some(length) = section_number_len(number) else {
            break;
        };
        let (number, rest) = number.split_at(length);
        let Some(target) = subject(number) else { break };
        found.push(Citation {
            range: start..start + length,
            target,
        });
        at += 1;
        // In a link the target follows the number.
        let rest = rest
            .split_once(')')
            .filter(|_| rest.starts_with("]("))
            .map_or(rest, |(_, rest)| rest);
        let joined = (words.get(at)).is_some_and(|word| ["and", "or", "to"].contains(&word.text));
        match rest {
            "" if joined => at += 1,
            "," => at += usize::from(joined),
            _ => break,
        }
    }
    at
}

/// Returns the length of a section number at the start of a word: one or two digits and optionally
/// a letter, without decimals or a unit behind them. `None` for any other word.
fn section_number_len(word: &str) -> Option<usize> {
    let digits = word.bytes().take_while(u8::is_ascii_digit).count();
    let letter = word[digits..]
        .bytes()
        .take_while(u8::is_ascii_lowercase)
        .count();
    let rest = &word[digits + letter..];
    let more = rest.starts_with(char::is_alphanumeric)
        || rest.starts_with('.') && rest[1..].starts_with(|c: char| c.is_ascii_digit());
    ((1..=2).contains(&digits) && letter <= 1 && !more).then_some(digits + letter)
}

/// Collects errata in the form `E07`.
fn collect_errata(word: &Word<'_>, found: &mut Vec<Citation>) {
    // Fast path: most words contain no `E`.
    if !word.text.as_bytes().contains(&b'E') {
        return;
    }
    for (number, range) in find_numbered(word.text, &['E']) {
        if range.len() == 3 {
            found.push(Citation {
                range: word.start + range.start..word.start + range.end,
                target: Target::Erratum(number.to_owned()),
            });
        }
    }
}

/// Finds these letters followed by a number of one or two digits, standing alone.
pub(crate) fn find_numbered<'a>(text: &'a str, letters: &[char]) -> Vec<(&'a str, Range<usize>)> {
    let alone = |c: Option<char>| !c.is_some_and(|c| c.is_alphanumeric() || "_.-+%$\\".contains(c));
    let found = text.match_indices(letters).filter_map(|(at, letter)| {
        let from = at + letter.len();
        let digits = text[from..].bytes().take_while(u8::is_ascii_digit).count();
        let (before, behind) = (&text[..at], &text[from + digits..]);
        let decimals =
            behind.starts_with('.') && behind[1..].starts_with(|c: char| c.is_ascii_digit());
        let end = behind.chars().next();
        let ends = !end.is_some_and(|c| c.is_alphanumeric() || c == '_') && !decimals;
        ((1..=2).contains(&digits) && alone(before.chars().next_back()) && ends)
            .then(|| (&text[at..from + digits], at..from + digits))
    });
    found.collect()
}

#[cfg(test)]
mod tests;
