//! Text layout: the position of each character.
//!
//! Characters become cells with a scaled glyph. Paragraphs are broken into rows where the script
//! allows it, rows are aligned, and the result is moved so that its bounding box starts at the
//! origin. There is no kerning and no shaping of right-to-left text.

use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use magician_host::message;
use magician_host::{Setting, SettingValue};

use super::compose::precomposed;
use super::glyph::Bounds;
use super::{Align, Glyph, Glyphs, LoadedFont, TextOptions};
use crate::{Diagnostic, Lines};

/// Tolerance of line widths, mm. It absorbs rounding, so that a row exactly as wide as the limit
/// fits.
const WIDTH_TOLERANCE: f64 = 1e-9;
/// Width of a tab, in spaces.
const TAB_SPACES: u8 = 4;
/// Characters that must not begin a line in Chinese and Japanese.
const FORBIDDEN_FIRST: &str =
    "、。，．・：；？！）］｝」』】〉》”’ゝゞ々ーぁぃぅぇぉっゃゅょァィゥェォッャュョ";
/// Characters that must not end a line in Chinese and Japanese.
const FORBIDDEN_LAST: &str = "（［｛「『【〈《“‘";

/// A polyline of a character, and the bytes of the character in the text.
pub(crate) struct LetterStroke {
    pub(crate) points: Vec<[f64; 2]>,
    pub(crate) range: Range<usize>,
}

/// Text after layout, mm: x to the right, y up, from the lower left corner of its bounding box.
pub(crate) struct LaidText {
    pub(crate) lines: Vec<LetterStroke>,
    /// Characters that no font has, each once, with its first place.
    pub(crate) missing: Vec<(char, Range<usize>)>,
    /// Characters taken from the fallback font, each once.
    pub(crate) substituted: Vec<(char, Range<usize>)>,
}

/// A character of the text at its size.
struct Cell {
    character: char,
    range: Range<usize>,
    glyph: Rc<Glyph>,
    bounds: Option<Bounds>,
}

impl Cell {
    fn is_space(&self) -> bool {
        self.character == ' '
    }
}

/// Lays out text.
///
/// # Errors
/// A [`Diagnostic`] if a character is wider than the wrap width.
pub(crate) fn lay_out(
    text: &str,
    font: &LoadedFont,
    options: &TextOptions,
    tolerance: f64,
) -> Result<LaidText, Diagnostic> {
    let mut setter = GlyphSetter::new(font, options.size, tolerance);
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut at = 0;
    for paragraph in text.split('\n') {
        let cells = setter.cells(paragraph, at);
        at += paragraph.len() + 1;
        match options.wrap {
            Some(width) => wrapped(cells, width, text, &mut rows)?,
            None => rows.push(cells),
        }
    }
    let extents: Vec<[f64; 2]> = rows.iter().map(|row| extent(row)).collect();
    let widest = extents.iter().map(|[from, to]| to - from);
    let width = options.wrap.unwrap_or(widest.fold(0.0, f64::max));
    let mut lines = Vec::new();
    for (nth, (row, [from, to])) in rows.into_iter().zip(extents).enumerate() {
        let free = width - (to - from);
        let mut x = match options.align {
            Align::Left => 0.0,
            Align::Center => free / 2.0,
            Align::Right => free,
        } - from;
        let y = -(nth as f64) * options.line_height * options.size;
        for cell in row {
            lines.extend(cell.glyph.lines.iter().map(|line| LetterStroke {
                points: line.iter().map(|[dx, dy]| [x + dx, y + dy]).collect(),
                range: cell.range.clone(),
            }));
            x += cell.glyph.advance;
        }
    }
    let mut laid = LaidText {
        lines,
        missing: setter.missing,
        substituted: setter.substituted,
    };
    laid.move_to_corner();
    Ok(laid)
}

impl LaidText {
    fn move_to_corner(&mut self) {
        let points = self.lines.iter().flat_map(|line| &line.points);
        let least = points.fold([f64::INFINITY; 2], |least, at| {
            [least[0].min(at[0]), least[1].min(at[1])]
        });
        let points = self.lines.iter_mut().flat_map(|line| &mut line.points);
        for point in points {
            *point = [point[0] - least[0], point[1] - least[1]];
        }
    }
}

/// A scaled glyph and its bounding box.
type SizedGlyph = (Rc<Glyph>, Option<Bounds>);

/// Cache of scaled glyphs.
struct GlyphSetter<'f> {
    font: &'f LoadedFont,
    size: f64,
    scale: f64,
    tolerance: f64,
    known: HashMap<char, Option<SizedGlyph>>,
    missing: Vec<(char, Range<usize>)>,
    substituted: Vec<(char, Range<usize>)>,
}

impl<'f> GlyphSetter<'f> {
    fn new(font: &'f LoadedFont, size: f64, tolerance: f64) -> Self {
        let scale = size / font.cap_height();
        Self {
            font,
            size,
            scale,
            tolerance: tolerance / scale,
            known: HashMap::new(),
            missing: Vec::new(),
            substituted: Vec::new(),
        }
    }

    /// Returns the cells of a paragraph that begins at byte `at` of the text.
    fn cells(&mut self, paragraph: &str, at: usize) -> Vec<Cell> {
        let mut cells: Vec<Cell> = Vec::new();
        for (offset, character) in paragraph.char_indices() {
            let range = at + offset..at + offset + character.len_utf8();
            if is_ignored(character) {
                continue;
            }
            if let Some(before) = cells.last()
                && let Some(both) = precomposed(before.character, character)
                && let Some(cell) = self.cell(both, (before.range.start)..range.end)
            {
                cells.pop();
                cells.push(cell);
                continue;
            }
            let (character, times) = match character {
                '\t' => (' ', TAB_SPACES),
                // Non-breaking spaces stay, because a row must not end at them.
                '\u{A0}' | '\u{202F}' => (character, 1),
                space if space.is_whitespace() => (' ', 1),
                other => (other, 1),
            };
            for _ in 0..times {
                match self.cell(character, range.clone()) {
                    Some(cell) => cells.push(cell),
                    None => self.lacks(character, range.clone()),
                }
            }
        }
        cells
    }

    fn lacks(&mut self, character: char, range: Range<usize>) {
        if self.missing.iter().all(|(known, _)| *known != character) {
            self.missing.push((character, range));
        }
    }

    fn cell(&mut self, character: char, range: Range<usize>) -> Option<Cell> {
        let Self {
            font,
            size,
            scale,
            tolerance,
            substituted,
            ..
        } = self;
        let glyph = self.known.entry(character).or_insert_with(|| {
            let own = font.glyph(character, *tolerance);
            let glyph = match own.map(|glyph| glyph.scaled([*scale; 2])) {
                Some(glyph) => glyph,
                None => {
                    let other = font.fallback()?;
                    let glyph = other.glyph(character, *tolerance)?;
                    // A blank from another font looks the same, so it is not reported.
                    if !character.is_whitespace() {
                        substituted.push((character, range.clone()));
                    }
                    glyph.scaled([*size / other.cap_height(); 2])
                }
            };
            let bounds = glyph.bounds();
            Some((Rc::new(glyph), bounds))
        });
        let (glyph, bounds) = glyph.as_ref()?;
        Some(Cell {
            character,
            range,
            glyph: Rc::clone(glyph),
            bounds: *bounds,
        })
    }
}

/// True for invisible control characters: directional marks, joiners, soft hyphens, variation
/// selectors, byte order marks, carriage returns.
const fn is_ignored(character: char) -> bool {
    matches!(
        character,
        '\r' | '\u{AD}' | '\u{200B}'..='\u{200F}' | '\u{2060}' | '\u{FE00}'..='\u{FE0F}' | '\u{FEFF}'
    )
}

/// Left and right end of what a row draws, from the origin of its first character. Leading spaces
/// count, trailing ones do not.
fn extent(cells: &[Cell]) -> [f64; 2] {
    let mut measure = Measure::default();
    for cell in cells {
        measure.take(cell);
    }
    measure.extent()
}

/// Width of a row while it grows.
#[derive(Default)]
struct Measure {
    pen: f64,
    indented: bool,
    drawn: Option<[f64; 2]>,
}

impl Measure {
    fn take(&mut self, cell: &Cell) {
        self.indented |= self.pen == 0.0 && cell.is_space();
        if let Some([least, most]) = cell.bounds {
            let [from, to] = [self.pen + least[0], self.pen + most[0]];
            let [first, last] = self.drawn.unwrap_or([from, to]);
            self.drawn = Some([first.min(from), last.max(to)]);
        }
        self.pen += cell.glyph.advance;
    }

    fn extent(&self) -> [f64; 2] {
        match self.drawn {
            Some([from, to]) if self.indented => [from.min(0.0), to],
            Some(drawn) => drawn,
            None => [0.0; 2],
        }
    }

    fn width(&self) -> f64 {
        let [from, to] = self.extent();
        to - from
    }
}

/// Breaks a paragraph into rows at allowed positions, or anywhere if a row has none.
fn wrapped(
    cells: Vec<Cell>,
    width: f64,
    text: &str,
    rows: &mut Vec<Vec<Cell>>,
) -> Result<(), Diagnostic> {
    let mut rest = cells;
    loop {
        let mut measure = Measure::default();
        let mut end = 0;
        let mut allowed = None;
        for (nth, cell) in rest.iter().enumerate() {
            measure.take(cell);
            if measure.width() > width + WIDTH_TOLERANCE {
                break;
            }
            end = nth + 1;
            if may_break(cell, rest.get(end)) {
                allowed = Some(end);
            }
        }
        if end == rest.len() {
            rows.push(rest);
            return Ok(());
        }
        let end = match allowed {
            Some(end) => end,
            // No allowed position: break within the word.
            None if end > 0 => end,
            None => return Err(too_wide_error(rest.first(), width, text)),
        };
        let mut next = rest.split_off(end);
        // Blanks after a break do not begin the next row.
        let spaces = next.iter().take_while(|cell| cell.is_space()).count();
        next.drain(..spaces);
        rows.push(rest);
        if next.is_empty() {
            return Ok(());
        }
        rest = next;
    }
}

/// True if a row may end between two characters.
fn may_break(cell: &Cell, next: Option<&Cell>) -> bool {
    let Some(next) = next.map(|next| next.character) else {
        return true;
    };
    match cell.character {
        ' ' => true,
        _ if next == ' ' => true,
        '-' | '‐' | '–' | '—' => next.is_alphabetic(),
        here => {
            (is_wide(here) || is_wide(next))
                && !FORBIDDEN_LAST.contains(here)
                && !FORBIDDEN_FIRST.contains(next)
        }
    }
}

/// True for characters of Chinese, Japanese and Korean, which are written without spaces.
const fn is_wide(character: char) -> bool {
    matches!(character, '\u{2E80}'..='\u{9FFF}' | '\u{F900}'..='\u{FAFF}' | '\u{FF00}'..='\u{FFEF}' | '\u{20000}'..='\u{3FFFF}')
}

fn too_wide_error(cell: Option<&Cell>, width: f64, text: &str) -> Diagnostic {
    let (range, [from, to], character) = cell.map_or((0..0, [0.0; 2], ' '), |cell| {
        (
            cell.range.clone(),
            extent(std::slice::from_ref(cell)),
            cell.character,
        )
    });
    let message = message!(
        "'{character}' is {from:.1} mm wide, and lines are {width:.1} mm wide at most",
        character,
        from = to - from,
        width
    );
    Diagnostic::new(Lines::new(text).origin(range), message)
        .remedy((Setting::Size, SettingValue::Any("MM")), "makes it smaller")
        .remedy(
            (Setting::Wrap, SettingValue::Any("MM")),
            "makes lines wider",
        )
}
