//! Text in aligned columns; the last column is wrapped to the terminal's width.

use std::fmt::Display;

use magician_protocol::visible;

use crate::failure::Failure;
use crate::output::Output;

/// Spaces between two columns.
const COLUMN_GAP: usize = 2;

/// Rows of cells.
#[derive(Debug, Default)]
pub(crate) struct Columns {
    indent: usize,
    rows: Vec<Vec<String>>,
}

impl Columns {
    /// Creates an empty table whose rows are indented by this many spaces.
    pub(crate) fn indented(indent: usize) -> Self {
        Self {
            indent,
            rows: Vec::new(),
        }
    }

    /// Adds a row. Line breaks and terminal control characters are made visible before widths are
    /// measured.
    pub(crate) fn row<C: Display>(&mut self, cells: impl IntoIterator<Item = C>) {
        let cells = cells.into_iter().map(|cell| visible(cell).to_string());
        self.rows.push(cells.collect());
    }

    /// Width of a column, in characters. Cells that end their row do not count: they may be
    /// wrapped.
    fn width(&self, column: usize) -> usize {
        let inner = self.rows.iter().filter(|row| row.len() > column + 1);
        inner
            .filter_map(|row| row.get(column))
            .map(|cell| count(cell))
            .max()
            .unwrap_or(0)
    }

    /// Writes the rows, the first column highlighted.
    pub(crate) fn write(&self, out: &mut Output) -> Result<(), Failure> {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let widths: Vec<_> = (0..columns).map(|column| self.width(column)).collect();
        for row in &self.rows {
            self.write_row(row, &widths, out)?;
        }
        Ok(())
    }

    fn write_row(&self, row: &[String], widths: &[usize], out: &mut Output) -> Result<(), Failure> {
        let Some((last, head)) = row.split_last() else {
            return out.line("");
        };
        let mut line = " ".repeat(self.indent);
        let mut used = self.indent;
        for (at, (cell, width)) in head.iter().zip(widths).enumerate() {
            let pad = " ".repeat((width + COLUMN_GAP).saturating_sub(count(cell)));
            match at {
                0 => line.push_str(&format!("{}{pad}", out.paint.name(cell))),
                _ => line.push_str(&format!("{cell}{pad}")),
            }
            used += width + COLUMN_GAP;
        }
        let room = out.width().saturating_sub(used).max(24);
        for (at, part) in wrap(last, room).iter().enumerate() {
            match at {
                0 => out.line(format!("{line}{part}").trim_end())?,
                _ => out.line(format!("{}{part}", " ".repeat(used)))?,
            }
        }
        Ok(())
    }
}

fn count(text: &str) -> usize {
    text.chars().count()
}

/// Writes a remark about a list, dimmed and wrapped to the terminal's width.
pub(crate) fn note(text: &str, out: &mut Output) -> Result<(), Failure> {
    let paint = out.paint;
    wrap(text, out.width())
        .iter()
        .try_for_each(|line| out.line(paint.dim(line)))
}

/// Breaks text between words into lines of at most `room` characters. A longer word gets a line of
/// its own.
pub(crate) fn wrap(text: &str, room: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines
            .last_mut()
            .filter(|line| line.is_empty() || count(line).saturating_add(1 + count(word)) <= room);
        match line {
            Some(line) => {
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(word);
            }
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::wrap;

    #[test]
    fn wrapping_keeps_words_whole_and_lines_short() {
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert_eq!(wrap("incomprehensible", 4), ["incomprehensible"]);
        assert_eq!(wrap("", 4), [""]);
    }
}
