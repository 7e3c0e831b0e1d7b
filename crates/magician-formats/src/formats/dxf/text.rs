//! Single-line texts: TEXT and the attributes of blocks. Multi-line texts are in `mtext`.

use kurbo::{Affine, Point, Vec2};
use magician_host::message;

use super::canvas::{Canvas, InsertContext};
use super::entity::plane;
use super::mtext::Run;
use super::pairs::Record;
use crate::Diagnostic;

type DrawResult = Result<(), Diagnostic>;

/// Depth of descenders below the baseline, as a share of the capital height.
pub(super) const DESCENDER_DEPTH: f64 = 1.0 / 3.0;
/// Largest number of characters of a text. It bounds the work for damaged files.
pub(super) const MAX_CHARACTERS: usize = 100_000;

/// Text style.
#[derive(Clone, Copy, Debug)]
pub(super) struct Style {
    pub(super) height: f64,
    pub(super) width: f64,
    pub(super) oblique: f64,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            height: 0.0,
            width: 1.0,
            oblique: 0.0,
        }
    }
}

/// Draws a single-line text (TEXT, ATTRIB, ATTDEF).
pub(super) fn text<'p>(
    canvas: &mut Canvas<'p>,
    record: &'p Record<'p>,
    layer: &'p str,
    context: &InsertContext<'p>,
) -> DrawResult {
    let code = if record.kind == "ATTDEF" { 2 } else { 1 };
    let content = bounded(record, decoded(record.verbatim(code).unwrap_or_default()))?;
    if content.trim().is_empty() {
        return Ok(());
    }
    let style = canvas.style(record.text(7));
    let number = |code, default| record.number(code).map(|found| found.unwrap_or(default));
    let height = number(40, style.height)?;
    let oblique = number(51, style.oblique)?;
    let mut stretch = number(41, style.width)?;
    let mut rotation = number(50, 0.0)?;
    let [x, y, z] = record.point(10)?;
    let mut at = Point::new(x, y);
    let alignment_point = match record.text(11) {
        Some(_) => record.point(11).map(|[x, y, _]| Point::new(x, y))?,
        None => at,
    };
    // ATTRIB and ATTDEF store the vertical alignment under another code.
    let vertical_code = if record.kind == "TEXT" { 73 } else { 74 };
    let (horizontal, vertical) = (record.integer(72)?, record.integer(vertical_code)?);
    if height <= 0.0 || stretch == 0.0 {
        return canvas.leave_out(record, message!("it has no height or no width"));
    }
    let mut size = height;
    let row = Row::of(
        canvas,
        &[Run::plain(&content)],
        size,
        record,
        stretch,
        oblique,
    )?;
    let natural_width = row.width;
    let mut row = row;
    // Aligned and fitted texts extend between two points.
    if let (3 | 5, baseline) = (horizontal, alignment_point - at)
        && baseline.hypot() > 0.0
        && natural_width > 0.0
    {
        rotation = baseline.atan2().to_degrees();
        let share = baseline.hypot() / natural_width;
        if horizontal == 3 {
            size *= share;
        } else {
            stretch *= share;
        }
        row = Row::of(
            canvas,
            &[Run::plain(&content)],
            size,
            record,
            stretch,
            oblique,
        )?;
    } else if horizontal != 0 || vertical != 0 {
        at = alignment_point;
    }
    let left = match horizontal {
        1 | 4 => -row.width / 2.0,
        2 => -row.width,
        _ => 0.0,
    };
    let down = match (horizontal, vertical) {
        (4, 0) | (_, 2) => -size / 2.0,
        (_, 1) => size * DESCENDER_DEPTH,
        (_, 3) => -size,
        _ => 0.0,
    };
    let flags = record.integer(71)?;
    let mirror = |bit: i64| if flags & bit != 0 { -1.0 } else { 1.0 };
    let map = context.map
        * plane(record, z)?
        * Affine::translate(at.to_vec2())
        * Affine::rotate(rotation.to_radians())
        * Affine::scale_non_uniform(mirror(2), mirror(4))
        * Affine::translate((left, down));
    row.draw(canvas, &map, record, layer)
}

/// A laid-out line of text, from the start of its baseline, in drawing units.
#[derive(Default)]
pub(super) struct Row {
    lines: Vec<Vec<[f64; 2]>>,
    pub(super) width: f64,
    /// Height of its highest character.
    pub(super) height: f64,
}

impl Row {
    /// Lays out runs of characters at a size, which each run may scale.
    pub(super) fn of(
        canvas: &mut Canvas<'_>,
        runs: &[Run],
        size: f64,
        record: &Record<'_>,
        stretch: f64,
        oblique: f64,
    ) -> Result<Self, Diagnostic> {
        let mut row = Self::default();
        for run in runs {
            let size = size * run.size;
            let shear = libm::tan((oblique + run.oblique).clamp(-85.0, 85.0).to_radians());
            let x_scale = stretch * run.width;
            let (begin, raise) = (row.width, size * run.raise);
            for character in run.text.chars().filter(|character| !character.is_control()) {
                let Some(glyph) = canvas.glyph(character, size, record)? else {
                    continue;
                };
                let at = row.width;
                row.lines.extend(glyph.lines.iter().map(|line| {
                    let point = |[x, y]: &[f64; 2]| [at + (x + shear * y) * x_scale, y + raise];
                    line.iter().map(point).collect()
                }));
                row.width += glyph.advance * x_scale * run.spacing;
            }
            for height in run.bars.iter().flatten() {
                let y = raise + height * size;
                row.lines.push(vec![[begin, y], [row.width, y]]);
            }
            row.height = row.height.max(size + raise);
            if run.back {
                row.width = begin;
            }
        }
        Ok(row)
    }

    pub(super) fn draw<'p>(
        self,
        canvas: &mut Canvas<'p>,
        map: &Affine,
        record: &'p Record<'p>,
        layer: &'p str,
    ) -> DrawResult {
        for line in self.lines {
            let points = line.into_iter().map(|[x, y]| *map * Point::new(x, y));
            canvas.letter(points.collect(), record, layer)?;
        }
        Ok(())
    }
}

/// Rotation from the x axis to a direction; the identity for a zero vector.
pub(super) fn rotation_to(direction: Vec2) -> Affine {
    if direction.hypot() > 0.0 && direction.is_finite() {
        Affine::rotate(direction.atan2())
    } else {
        Affine::IDENTITY
    }
}

/// Refuses a text with too many characters.
pub(super) fn bounded(record: &Record<'_>, text: String) -> Result<String, Diagnostic> {
    let count = text.chars().count();
    if count <= MAX_CHARACTERS {
        return Ok(text);
    }
    let message = message!(
        "the text has {count} characters, limit {limit}",
        count,
        limit = MAX_CHARACTERS
    );
    Err(Diagnostic::new(record.origin, message))
}

/// Replaces control codes by their characters: `%%d`, `%%c`, `%%p`, `%%065`, `\U+00E9`, `^I`. Codes
/// for underline and overline are dropped.
pub(super) fn decoded(text: &str) -> String {
    let mut decoded = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let (symbol, length) = code(rest).unwrap_or((Some(first), first.len_utf8()));
        decoded.extend(symbol);
        rest = rest.get(length..).unwrap_or_default();
    }
    decoded
}

/// Parses a control code at the start of a text. Returns its character, if it has one, and its
/// length in bytes.
fn code(text: &str) -> Option<(Option<char>, usize)> {
    if let Some(code) = text.strip_prefix("%%") {
        let letter = code.chars().next()?;
        if let Some(digits) = code.get(..3)
            && let Ok(number) = digits.parse::<u8>()
        {
            return Some((Some(char::from(number)), 5));
        }
        let symbol = match letter.to_ascii_lowercase() {
            'd' => Some('°'),
            'c' => Some('Ø'),
            'p' => Some('±'),
            '%' => Some('%'),
            'u' | 'o' | 'k' => None,
            _ => return None,
        };
        return Some((symbol, 3));
    }
    if let Some(digits) = text.strip_prefix("\\U+").and_then(|rest| rest.get(..4)) {
        let symbol = char::from_u32(u32::from_str_radix(digits, 16).ok()?)?;
        return Some((Some(symbol), 7));
    }
    let caret = text.strip_prefix('^')?;
    let symbol = match caret.chars().next()? {
        ' ' => '^',
        'I' | 'J' | 'M' => ' ',
        _ => return None,
    };
    Some((Some(symbol), 2))
}
