//! What lists of points look like: which columns name what, and what is between the numbers.

use std::borrow::Cow;
use std::ops::Range;

/// What a recording as MCAP begins with.
pub(in crate::formats) const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Between cells, the usual one first.
const BETWEEN: [char; 3] = [',', ';', '\t'];

/// Whether bytes, of which this is the head, are a recording that is no text.
pub(super) fn is_recording(head: &[u8]) -> bool {
    head.starts_with(MAGIC)
}

/// Whether a text, of which this is the head, is a list of points.
pub(super) fn is_one(text: &str) -> bool {
    if text.starts_with('{') {
        is_json(text)
    } else {
        is_csv(text) || is_strokes(text) && text.lines().nth(1).is_some()
    }
}

/// Whether the first line of a CSV file names x, y and z.
fn is_csv(text: &str) -> bool {
    let Some((_, first)) = lines(text).next() else {
        return false;
    };
    let between = between(first);
    let cells = cells(first, 0, between);
    let fields: Vec<_> = cells.filter_map(|(_, cell)| Field::named(&cell)).collect();
    (0..3).all(|axis| fields.contains(&Field::Place(axis)))
}

/// Whether a text is strokes: its first line has three numbers, and its second, if there is one.
pub(in crate::formats) fn is_strokes(text: &str) -> bool {
    // The head of a file may end within a line.
    let whole = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let mut few = whole.take(2).peekable();
    few.peek().is_some() && few.all(|line| numbers(line).is_some())
}

/// Whether the head of a JSON text has rows.
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

/// What a column or a member says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::formats) enum Field {
    /// x, y, z, r: 0 to 3.
    Place(usize),
    /// Where an arc ends.
    End(usize),
    Style,
    Name,
    Pause,
    Gripper,
    Suction,
    /// Not what it is called.
    Speed,
    /// Of a recording: when, s.
    Time,
    /// Of a recording: the angle of J4.
    J4,
    /// Where the carriage on the rail is, mm.
    Rail,
    /// Of no use here.
    Idle,
}

impl Field {
    /// By its name, whatever its case and with or without a unit behind it.
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

/// The lines with something in them, and where they begin.
pub(in crate::formats) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    let lines = text.split_inclusive('\n').map(move |line| {
        let start = at;
        at += line.len();
        (start, line.trim_end_matches(['\n', '\r']))
    });
    lines.filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
}

/// What is between the cells of a header.
pub(in crate::formats) fn between(header: &str) -> char {
    let count = |sign: &char| header.matches(*sign).count();
    let most = BETWEEN.into_iter().rev().max_by_key(count);
    most.unwrap_or(',')
}

/// The cells of a line that begins there in the text, with where they stand. A cell in quotes may have anything in it but the
/// end of the line.
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

/// Three numbers with commas, semicolons or space between them.
pub(in crate::formats) fn numbers(line: &str) -> Option<[f32; 3]> {
    let words = line.split([',', ';']).flat_map(str::split_whitespace);
    let numbers: Option<Vec<f32>> = words.take(4).map(number).collect();
    numbers?.try_into().ok()
}

/// A number that an arm can use.
pub(in crate::formats) fn number(text: &str) -> Option<f32> {
    let plain = text.parse().ok();
    let value = plain.or_else(|| Some(crate::encoding::number(text)? as f32));
    value.filter(|value: &f32| value.is_finite())
}
