//! Places in a source file, and the conversion between byte offsets and places.

use std::ops::Range;

/// A place in a source file.
///
/// Lines and columns count from 1, columns in characters. Line 0 is no place: the item was added by
/// this crate. For an image the line is the row of pixels and the column is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Origin {
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1, in characters.
    pub column: u32,
    /// Length in characters.
    pub length: u32,
    /// Index of the item's name (an element's id, a point's name) in the list of names beside it,
    /// plus 1; 0 if it has no name.
    pub name: u32,
}

impl Origin {
    /// No place in a file.
    pub const NONE: Self = Self {
        line: 0,
        column: 0,
        length: 0,
        name: 0,
    };

    /// Sets the name by its index in the list of names beside it.
    #[must_use]
    pub fn named(self, index: usize) -> Self {
        let name = u32::try_from(index.saturating_add(1)).unwrap_or(0);
        Self { name, ..self }
    }

    /// Returns the index of the name, or `None` if it has no name.
    #[must_use]
    pub fn name_index(&self) -> Option<usize> {
        (self.name as usize).checked_sub(1)
    }

    /// True if this is a place in a file.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.line > 0
    }
}

/// Index of the lines of a text, for converting byte offsets to origins and back.
#[derive(Clone, Debug)]
pub struct Lines<'t> {
    text: &'t str,
    /// Number of characters that begin before each multiple of [`INDEX_INTERVAL`] bytes.
    ///
    /// A file may be one long line, and counting its columns from the beginning each time would be
    /// quadratic. Empty if the text is ASCII, where every byte is a character.
    counts: Vec<usize>,
    /// Byte offset of each line.
    starts: Vec<usize>,
}

/// Distance between the precomputed character counts, bytes. A choice: a lookup counts at most this
/// many bytes, and the index stays below 1 % of the text.
const INDEX_INTERVAL: usize = 1024;

impl<'t> Lines<'t> {
    /// Indexes a text.
    #[must_use]
    pub fn new(text: &'t str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let starts = std::iter::once(0).chain(ends.map(|(at, _)| at + 1));
        let mut before = 0;
        let pieces = text.as_bytes().chunks(INDEX_INTERVAL).map(|piece| {
            let count = before;
            before += characters(piece);
            count
        });
        Self {
            text,
            counts: if text.is_ascii() {
                Vec::new()
            } else {
                pieces.collect()
            },
            starts: starts.collect(),
        }
    }

    /// Number of characters that begin before a byte offset.
    fn characters_before(&self, at: usize) -> usize {
        // An offset at the very end of the text may lie behind the last piece.
        let piece = (at / INDEX_INTERVAL).min(self.counts.len().saturating_sub(1));
        match self.counts.get(piece) {
            Some(count) => {
                let rest = self.text.as_bytes().get(piece * INDEX_INTERVAL..at);
                count + characters(rest.unwrap_or_default())
            }
            None => at,
        }
    }

    /// Returns the origin of a range of bytes. A range beyond the text, or within a character, is
    /// moved to the nearest character boundary before it.
    #[must_use]
    pub fn origin(&self, range: Range<usize>) -> Origin {
        let start = self.floor_char_boundary(range.start);
        let end = self.floor_char_boundary(range.end).max(start);
        let line = self.starts.partition_point(|begin| *begin <= start).max(1);
        let begin = self.starts.get(line - 1).copied().unwrap_or(0);
        let count = |from, to| self.characters_before(to) - self.characters_before(from);
        let number = |value: usize| u32::try_from(value).unwrap_or(u32::MAX);
        Origin {
            line: number(line),
            column: number(count(begin, start) + 1),
            length: number(count(start, end)),
            name: 0,
        }
    }

    /// Returns the bytes of an origin, or `None` if the text has no such line.
    #[must_use]
    pub fn range(&self, origin: &Origin) -> Option<Range<usize>> {
        let begin = *self.starts.get((origin.line as usize).checked_sub(1)?)?;
        let column = (origin.column as usize).saturating_sub(1);
        let start = begin + byte_offset(self.text.get(begin..)?, column);
        let end = start + byte_offset(self.text.get(start..)?, origin.length as usize);
        Some(start..end)
    }

    fn floor_char_boundary(&self, at: usize) -> usize {
        let mut at = at.min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        at
    }
}

/// Number of characters that begin in a piece of UTF-8.
fn characters(piece: &[u8]) -> usize {
    piece.iter().filter(|byte| **byte & 0xC0 != 0x80).count()
}

/// Number of bytes that the first `characters` characters take.
fn byte_offset(text: &str, characters: usize) -> usize {
    let nth = text.char_indices().nth(characters);
    nth.map_or(text.len(), |(at, _)| at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_and_origins_are_inverse() {
        let text = "G0 X1\nG1 Y2 ; größe\n\nM2";
        let lines = Lines::new(text);
        for start in 0..=text.len() {
            for end in start..=text.len() {
                if text.get(start..end).is_none() {
                    continue;
                }
                let origin = lines.origin(start..end);
                assert_eq!(lines.range(&origin), Some(start..end), "{origin:?}");
            }
        }
        let second = lines.origin(9..11);
        assert_eq!((second.line, second.column, second.length), (2, 4, 2));
        assert_eq!(lines.origin(0..99).length, text.chars().count() as u32);
        assert_eq!(lines.range(&Origin { line: 9, ..second }), None);
    }

    #[test]
    fn columns_of_long_lines_are_counted_in_characters() {
        for length in [
            INDEX_INTERVAL - 1,
            INDEX_INTERVAL,
            2 * INDEX_INTERVAL,
            5 * INDEX_INTERVAL + 3,
        ] {
            let text: String = "ab\u{e9}\u{4f60}\u{1f600}"
                .chars()
                .cycle()
                .take(length)
                .collect();
            let lines = Lines::new(&text);
            for (nth, (at, character)) in text.char_indices().enumerate() {
                let origin = lines.origin(at..at + character.len_utf8());
                assert_eq!((origin.column as usize, origin.length), (nth + 1, 1));
            }
            assert_eq!(lines.origin(0..text.len()).length as usize, length);
        }
    }
}
