//! Syntax of point lists: column names, separators and numbers.

use std::borrow::Cow;
use std::ops::Range;

/// Magic bytes of an MCAP recording.
pub(in crate::formats) const MCAP_MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Separators of cells, the most common first.
const CELL_SEPARATORS: [char; 3] = [',', ';', '\t'];

/// True if a file with this head is a binary recording.
pub(super) fn is_recording(head: &[u8]) -> bool {
    head.starts_with(MCAP_MAGIC)
}

/// True if a text with this head is a list of points.
pub(super) fn is_point_list(text: &str) -> bool {
    if text.starts_with('{') {
        is_json(text)
    } else {
        is_csv(text) || is_strokes(text) && text.lines().nth(1).is_some()
    }
}

/// True if the first line of a CSV file names x, y and z.
fn is_csv(text: &str) -> bool {
    let Some((_, first)) = lines(text).next() else {
        return false;
    };
    let between = separator(first);
    let cells = cells(first, 0, between);
    let fields: Vec<_> = cells.filter_map(|(_, cell)| Field::named(&cell)).collect();
    (0..3).all(|axis| fields.contains(&Field::Place(axis)))
}

/// True if a text consists of strokes: its first line has three numbers, and its second line too if
/// it exists.
pub(in crate::formats) fn is_strokes(text: &str) -> bool {
    // Two lines are enough, and the head of a file may end within a later one.
    let whole = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let mut few = whole.take(2).peekable();
    few.peek().is_some() && few.all(|line| numbers(line).is_some())
}

/// True if the head of a JSON text contains rows (`"row0"` and so on).
fn is_json(text: &str) -> bool {
    let row = |at: usize| {
        text.get(at + 4..)?
            .chars()
            .next()
            .map(|next| next.is_ascii_digit())
    };
    text.match_indices("\"row")
        .any(|(at, _)| row(at) == Some(true))
}

/// Meaning of a column or a member.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::formats) enum Field {
    /// Axis of the position x, y, z, r: 0 to 3.
    Place(usize),
    /// Axis of the end of an arc: 0 to 3.
    End(usize),
    Style,
    Name,
    Pause,
    Gripper,
    Suction,
    /// Speed or acceleration, which is ignored with a note.
    Speed,
    /// Time of a reading, s (recordings).
    Time,
    /// Angle of J4, deg (recordings).
    J4,
    /// Position of the rail's carriage, mm.
    Rail,
    /// Known and ignored.
    Idle,
}

impl Field {
    /// Finds the field of a column name, ignoring case and a unit in brackets.
    pub(in crate::formats) fn named(name: &str) -> Option<Self> {
        let name = name.split(['(', '[']).next().unwrap_or(name);
        let plain = name.trim().to_ascii_lowercase().replace([' ', '-'], "");
        Some(match plain.as_str() {
            "x" => Self::Place(0),
            "y" => Self::Place(1),
            "z" => Self::Place(2),
            "r" => Self::Place(3),
            "_x" => Self::End(0),
            "_y" => Self::End(1),
            "_z" => Self::End(2),
            "_r" => Self::End(3),
            "motionstyle" | "motion" | "mode" | "action" => Self::Style,
            "name" | "pointname" => Self::Name,
            "pause" | "pausetime" => Self::Pause,
            "gripper" => Self::Gripper,
            "suction" | "suctioncup" => Self::Suction,
            "velocity" | "acceleration" | "speed" => Self::Speed,
            "t" => Self::Time,
            "j4" => Self::J4,
            "l" | "rail" | "posel" => Self::Rail,
            "j1" | "j2" | "j3" | "left_space" | "alarms" | "time" => Self::Idle,
            "step" | "line" | "index" | "no" | "" => Self::Idle,
            _ => return None,
        })
    }
}

/// Iterates over lines that are neither empty nor comments, with their byte offsets.
pub(in crate::formats) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    let lines = text.split_inclusive('\n').map(move |line| {
        let start = at;
        at += line.len();
        (start, line.trim_end_matches(['\n', '\r']))
    });
    lines.filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
}

/// Returns the separator that occurs most often in a header.
pub(in crate::formats) fn separator(header: &str) -> char {
    let count = |sign: &char| header.matches(*sign).count();
    let most = CELL_SEPARATORS.into_iter().rev().max_by_key(count);
    most.unwrap_or(',')
}

/// Iterates over the cells of a line with their byte ranges in the text; the line begins at
/// `start`. A quoted cell may contain separators, but not a line end.
pub(in crate::formats) fn cells(
    line: &str,
    start: usize,
    between: char,
) -> impl Iterator<Item = (Range<usize>, Cow<'_, str>)> {
    let mut rest = Some((0, line));
    std::iter::from_fn(move || {
        let (at, text) = rest?;
        let mut quoted = false;
        let end = text.find(|sign| {
            quoted ^= sign == '"';
            sign == between && !quoted
        });
        let end = end.unwrap_or(text.len());
        let (cell, after) = text.split_at(end);
        rest = after
            .strip_prefix(between)
            .map(|after| (at + end + between.len_utf8(), after));
        let space = cell.len() - cell.trim_start().len();
        let place = start + at + space..start + at + cell.trim_end().len().max(space);
        Some((place, unquoted(cell.trim())))
    })
}

fn unquoted(cell: &str) -> Cow<'_, str> {
    let inner = cell
        .strip_prefix('"')
        .and_then(|cell| cell.strip_suffix('"'));
    match inner {
        Some(inner) => inner.replace("\"\"", "\"").into(),
        None => cell.into(),
    }
}

/// Parses three numbers separated by commas, semicolons or blanks.
pub(in crate::formats) fn numbers(line: &str) -> Option<[f32; 3]> {
    let words = line.split([',', ';']).flat_map(str::split_whitespace);
    let numbers: Option<Vec<f32>> = words.take(4).map(number).collect();
    numbers?.try_into().ok()
}

/// Parses a finite number.
pub(in crate::formats) fn number(text: &str) -> Option<f32> {
    let plain = text.parse().ok();
    let value = plain.or_else(|| Some(crate::encoding::number(text)? as f32));
    value.filter(|value: &f32| value.is_finite())
}
