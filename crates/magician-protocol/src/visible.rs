//! Safe display of text from outside: control characters escaped, markup quoted.
//!
//! A device name, a file name or a line of a file could otherwise clear the user's terminal, hide
//! text or reverse its direction.

use core::fmt::{self, Display, Write};

/// True if a terminal obeys this character or shows the text around it differently.
///
/// These are control characters (C0, DEL, C1), marks that change the writing direction, and
/// zero-width characters. The zero-width non-joiner and joiner (U+200C, U+200D) are excluded: words
/// and emoji are spelt with them.
///
/// ```
/// use magician_protocol::is_deceptive;
///
/// assert!(is_deceptive('\u{1b}') && is_deceptive('\u{202e}'));
/// assert!(!is_deceptive('ä') && !is_deceptive('中'));
/// ```
#[must_use]
pub const fn is_deceptive(character: char) -> bool {
    matches!(
        character,
        '\0'..='\u{1f}'
            | '\u{7f}'..='\u{9f}'
            | '\u{ad}'
            | '\u{61c}'
            | '\u{180e}'
            | '\u{200b}'
            | '\u{200e}'..='\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}'
            | '\u{feff}'
            | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e007f}'
    )
}

/// Text from outside (an arm, a file, a network) in a form that is safe to show: each
/// [`is_deceptive`] character becomes an escape like `\u{1b}`.
///
/// Every place that shows such text uses this.
#[derive(Clone, Copy, Debug)]
pub struct Visible<T> {
    text: T,
    lines: bool,
}

/// Shows text on one line: line feeds and tabs are escaped as well.
///
/// ```
/// use magician_protocol::visible;
///
/// assert_eq!(visible("arm\x1b]0;mine\x07\n").to_string(), r"arm\u{1b}]0;mine\u{7}\u{a}");
/// ```
pub const fn visible<T: Display>(text: T) -> Visible<T> {
    Visible { text, lines: false }
}

/// Shows text of several lines: line feeds and tabs are kept.
pub const fn visible_lines<T: Display>(text: T) -> Visible<T> {
    Visible { text, lines: true }
}

impl<T: Display> Display for Visible<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            Filter {
                to: f,
                keep_lines: self.lines
            },
            "{}",
            self.text
        )
    }
}

// Filters while the text is formatted, because this crate does not allocate.
struct Filter<'a, 'f> {
    to: &'a mut fmt::Formatter<'f>,
    keep_lines: bool,
}

impl Write for Filter<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let lines = self.keep_lines;
        let is_shown =
            |character| !is_deceptive(character) || lines && matches!(character, '\n' | '\t');
        let mut rest = text;
        while let Some(at) = rest.find(|character| !is_shown(character)) {
            let (plain, from) = rest.split_at(at);
            self.to.write_str(plain)?;
            let mut characters = from.chars();
            if let Some(character) = characters.next() {
                write!(self.to, "{}", character.escape_unicode())?;
            }
            rest = characters.as_str();
        }
        self.to.write_str(rest)
    }
}

/// Text escaped for HTML and XML, in an element or a double-quoted attribute.
#[derive(Clone, Copy, Debug)]
pub struct Markup<T>(T);

/// Escapes text so that HTML and XML show it unchanged.
///
/// Control characters, which XML does not allow, must be escaped with [`visible`] first.
///
/// ```
/// use magician_protocol::markup;
///
/// assert_eq!(markup("<b> & \"c\"").to_string(), "&lt;b&gt; &amp; &quot;c&quot;");
/// ```
pub const fn markup<T: Display>(text: T) -> Markup<T> {
    Markup(text)
}

impl<T: Display> Display for Markup<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(Escape(f), "{}", self.0)
    }
}

struct Escape<'a, 'f>(&'a mut fmt::Formatter<'f>);

impl Write for Escape<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for piece in text.split_inclusive(['&', '<', '>', '"']) {
            let character = piece.chars().next_back().unwrap_or_default();
            let escaped = match character {
                '&' => "&amp;",
                '<' => "&lt;",
                '>' => "&gt;",
                '"' => "&quot;",
                // The last piece need not end at a character to escape.
                _ => {
                    self.0.write_str(piece)?;
                    continue;
                }
            };
            self.0
                .write_str(piece.strip_suffix(character).unwrap_or_default())?;
            self.0.write_str(escaped)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        for code in (0..0x20).chain(0x7f..0xa0) {
            let character = char::from(code);
            let shown = visible(character).to_string();
            assert_eq!(shown, std::format!("\\u{{{code:x}}}"));
        }
        for character in [
            '\u{202e}',
            '\u{2066}',
            '\u{200f}',
            '\u{2028}',
            '\u{e0041}',
            '\u{feff}',
        ] {
            assert!(
                visible(character).to_string().starts_with("\\u{"),
                "{character:?}"
            );
        }
    }

    #[test]
    fn text_field_is_escaped_when_displayed_and_raw_as_bytes() {
        let name = crate::Text::new("a\x1b[2Jb").unwrap();
        assert_eq!(name.to_string(), r"a\u{1b}[2Jb");
        assert_eq!(name.lossy().to_string(), "a\x1b[2Jb");
        let value = crate::FieldValue::Text(b"a\x1b\xff");
        assert_eq!(value.to_string(), "a\\u{1b}\u{fffd}");
    }

    #[test]
    fn ordinary_text_is_shown_unchanged() {
        for text in [
            "",
            "Dobot Magician",
            r"C:\arm.svg",
            "Größe 中文 العربية",
            "👩\u{200d}🔧",
        ] {
            assert_eq!(visible(text).to_string(), text);
        }
        assert_eq!(visible_lines("a\tb\nc\rd").to_string(), "a\tb\nc\\u{d}d");
        assert_eq!(visible("a\tb\nc").to_string(), r"a\u{9}b\u{a}c");
    }
}
