//! Multi-line texts (MTEXT) with inline formatting codes.

use kurbo::{Affine, Vec2};
use magician_host::message;

use super::canvas::{Canvas, InsertContext};
use super::entity::plane;
use super::pairs::Record;
use super::text::{DESCENDER_DEPTH, Row, bounded, decoded, rotation_to};
use crate::Diagnostic;

/// Distance of baselines at a factor of 1, in heights of a capital.
const BASELINE_DISTANCE: f64 = 5.0 / 3.0;
/// Size of numerator and denominator relative to the text.
const FRACTION_SCALE: f64 = 0.7;
/// Height of an underline above the baseline, in heights of a capital.
const UNDERLINE_HEIGHT: f64 = -0.2;
/// Height of a strike-through, in heights of a capital.
const STRIKE_THROUGH_HEIGHT: f64 = 0.5;
/// Height of an overline, in heights of a capital.
const OVERLINE_HEIGHT: f64 = 1.2;

/// A run of characters with the same format.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    pub(super) text: String,
    /// Size relative to the whole text.
    pub(super) size: f64,
    pub(super) width: f64,
    pub(super) spacing: f64,
    pub(super) oblique: f64,
    /// Height above the baseline, relative to its own size.
    pub(super) raise: f64,
    /// Underline, strike-through and overline: their heights, relative to its own size.
    pub(super) bars: [Option<f64>; 3],
    /// True if the next run begins at the same position.
    pub(super) back: bool,
}

impl Run {
    pub(super) fn plain(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            size: 1.0,
            width: 1.0,
            spacing: 1.0,
            oblique: 0.0,
            raise: 0.0,
            bars: [None; 3],
            back: false,
        }
    }
}

/// Draws an MTEXT.
pub(super) fn draw<'p>(
    canvas: &mut Canvas<'p>,
    record: &'p Record<'p>,
    layer: &'p str,
    context: &InsertContext<'p>,
) -> Result<(), Diagnostic> {
    // After this code follow values of embedded objects with the same codes.
    let own = record.until(101);
    let pieces = own.pairs.iter().filter(|pair| matches!(pair.code, 1 | 3));
    let content: String = pieces.map(|pair| pair.verbatim).collect();
    let content = bounded(record, content)?;
    let style = canvas.style(own.text(7));
    let height = own.number(40)?.unwrap_or(style.height);
    let [x, y, _] = own.point(10)?;
    let turned = own
        .pairs
        .iter()
        .rev()
        .find(|pair| matches!(pair.code, 50 | 11));
    let turn = match turned.map(|pair| pair.code) {
        Some(50) => Affine::rotate(own.number(50)?.unwrap_or(0.0).to_radians()),
        Some(_) => {
            let [x, y, _] = own.point(11)?;
            rotation_to(Vec2::new(x, y))
        }
        None => Affine::IDENTITY,
    };
    // Position and direction are in coordinates of the drawing, not of the entity's plane.
    let at = context.map * Affine::translate((x, y));
    let map = match turned.map(|pair| pair.code) {
        Some(11) => at * turn,
        // An angle (code 50), or no direction: relative to the x axis of the entity's plane.
        _ => at * plane(&own, 0.0)? * turn,
    };
    let paragraph = Paragraph {
        height,
        width: own.number(41)?.unwrap_or(0.0),
        attachment: own.integer(71)?,
        spacing: own.number(44)?.unwrap_or(1.0),
        stretch: style.width,
        oblique: style.oblique,
    };
    paragraph.draw(canvas, &content, &map, record, layer)
}

/// Layout of a multi-line text.
pub(super) struct Paragraph {
    pub(super) height: f64,
    /// Width at which lines are wrapped; 0 for none.
    pub(super) width: f64,
    /// Attachment point of its box: 1 to 3 on the upper edge from left to right, 4 to 6 in the
    /// middle, 7 to 9 on the lower edge.
    pub(super) attachment: i64,
    pub(super) spacing: f64,
    pub(super) stretch: f64,
    pub(super) oblique: f64,
}

impl Paragraph {
    /// Draws a text; the transform maps the origin to its attachment point.
    pub(super) fn draw<'p>(
        &self,
        canvas: &mut Canvas<'p>,
        content: &str,
        map: &Affine,
        record: &'p Record<'p>,
        layer: &'p str,
    ) -> Result<(), Diagnostic> {
        if content.trim().is_empty() {
            return Ok(());
        }
        if self.height <= 0.0 {
            return canvas.leave_out(record, message!("it has no height"));
        }
        let mut rows = Vec::new();
        for line in parsed(content, self.height) {
            self.broken(canvas, &line, record, &mut rows)?;
        }
        let step = BASELINE_DISTANCE * self.height * self.spacing;
        let top = rows
            .first()
            .map_or(self.height, |row: &Row| row.height.max(self.height));
        let below = (rows.len().saturating_sub(1)) as f64 * step + DESCENDER_DEPTH * self.height;
        let column = (self.attachment - 1).rem_euclid(3);
        let first = match self.attachment {
            4..=6 => (below - DESCENDER_DEPTH * self.height - top) / 2.0,
            7..=9 => below,
            _ => -top,
        };
        for (nth, row) in rows.into_iter().enumerate() {
            let left = row.width * [0.0, -0.5, -1.0][usize::try_from(column).unwrap_or(0).min(2)];
            let to = *map * Affine::translate((left, first - nth as f64 * step));
            row.draw(canvas, &to, record, layer)?;
        }
        Ok(())
    }

    fn row(
        &self,
        canvas: &mut Canvas<'_>,
        runs: &[Run],
        record: &Record<'_>,
    ) -> Result<Row, Diagnostic> {
        Row::of(
            canvas,
            runs,
            self.height,
            record,
            self.stretch,
            self.oblique,
        )
    }

    /// Wraps a line between words.
    fn broken(
        &self,
        canvas: &mut Canvas<'_>,
        runs: &[Run],
        record: &Record<'_>,
        rows: &mut Vec<Row>,
    ) -> Result<(), Diagnostic> {
        let whole = self.row(canvas, runs, record)?;
        if self.width <= 0.0 || whole.width <= self.width {
            rows.push(whole);
            return Ok(());
        }
        let (mut line, mut wide): (Vec<Run>, f64) = (Vec::new(), 0.0);
        for word in words(runs) {
            let own = self.row(canvas, &word, record)?.width;
            let bare = self.row(canvas, &trimmed(&word), record)?.width;
            if !line.is_empty() && wide + bare > self.width {
                rows.push(self.row(canvas, &trimmed(&line), record)?);
                (line, wide) = (Vec::new(), 0.0);
            }
            line.extend(word);
            wide += own;
        }
        rows.push(self.row(canvas, &trimmed(&line), record)?);
        Ok(())
    }
}

/// Removes trailing blanks.
fn trimmed(runs: &[Run]) -> Vec<Run> {
    let mut runs = runs.to_vec();
    if let Some(last) = runs.last_mut() {
        last.text.truncate(last.text.trim_end_matches(' ').len());
    }
    runs
}

/// Splits runs into words, each with its trailing blanks.
fn words(runs: &[Run]) -> Vec<Vec<Run>> {
    let mut words: Vec<Vec<Run>> = vec![Vec::new()];
    for run in runs {
        for piece in run.text.split_inclusive(' ') {
            let ends = piece.ends_with(' ');
            let run = Run {
                text: piece.to_owned(),
                ..run.clone()
            };
            if let Some(word) = words.last_mut() {
                word.push(run);
            }
            if ends {
                words.push(Vec::new());
            }
        }
    }
    words
}

/// Parses the formatting codes and returns the lines.
pub(super) fn parsed(content: &str, height: f64) -> Vec<Vec<Run>> {
    let mut reader = Reader {
        rest: content,
        look: Run::plain(""),
        outer: Vec::new(),
        lines: vec![Vec::new()],
        height,
    };
    while let Some(sign) = reader.next() {
        match sign {
            '\\' => reader.code(),
            '{' => reader.outer.push(reader.look.clone()),
            '}' => reader.look = reader.outer.pop().unwrap_or(reader.look.clone()),
            '\n' => reader.lines.push(Vec::new()),
            '\r' => {}
            '^' if reader.rest.starts_with('J') => {
                reader.next();
                reader.lines.push(Vec::new());
            }
            sign => reader.write(sign),
        }
    }
    for run in reader.lines.iter_mut().flatten() {
        run.text = decoded(&run.text);
    }
    reader.lines
}

struct Reader<'t> {
    rest: &'t str,
    look: Run,
    outer: Vec<Run>,
    lines: Vec<Vec<Run>>,
    height: f64,
}

impl Reader<'_> {
    fn next(&mut self) -> Option<char> {
        let mut signs = self.rest.chars();
        let sign = signs.next();
        self.rest = signs.as_str();
        sign
    }

    /// Returns the argument of a code, up to the semicolon.
    fn argument(&mut self) -> &str {
        let (said, rest) = self.rest.split_once(';').unwrap_or((self.rest, ""));
        self.rest = rest;
        said
    }

    fn write(&mut self, sign: char) {
        let Some(line) = self.lines.last_mut() else {
            return;
        };
        match line.last_mut() {
            Some(run) if looks_alike(run, &self.look) => run.text.push(sign),
            _ => line.push(Run {
                text: sign.into(),
                ..self.look.clone()
            }),
        }
    }

    fn code(&mut self) {
        let Some(code) = self.next() else { return };
        match code {
            '\\' | '{' | '}' => self.write(code),
            '~' => self.write('\u{A0}'),
            'P' | 'X' | 'N' => self.lines.push(Vec::new()),
            'U' if self.rest.starts_with('+') => {
                self.write('\\');
                self.write('U');
            }
            'M' if self.rest.starts_with('+') => {
                // A character of a code page in five digits, which is not decoded here.
                self.rest = self.rest.get(6..).unwrap_or_default();
                self.write('?');
            }
            'L' => self.look.bars[0] = Some(UNDERLINE_HEIGHT),
            'l' => self.look.bars[0] = None,
            'K' => self.look.bars[1] = Some(STRIKE_THROUGH_HEIGHT),
            'k' => self.look.bars[1] = None,
            'O' => self.look.bars[2] = Some(OVERLINE_HEIGHT),
            'o' => self.look.bars[2] = None,
            'H' => {
                let usual = self.look.size;
                let said = self.argument();
                let is_factor = said.ends_with(['x', 'X']);
                let told = number(said, f64::NAN);
                self.look.size = match (told.is_finite(), is_factor) {
                    (false, _) => usual,
                    (true, true) => usual * told,
                    (true, false) => told / self.height,
                };
            }
            'W' => {
                let usual = self.look.width;
                self.look.width = number(self.argument(), usual);
            }
            'T' => {
                let usual = self.look.spacing;
                self.look.spacing = number(self.argument(), usual);
            }
            'Q' => {
                let said = self.argument().parse::<f64>();
                self.look.oblique = said.unwrap_or(self.look.oblique);
            }
            'S' => self.stacked(),
            // Colour, font, alignment within the line, indents and tabs are ignored.
            'A' | 'C' | 'c' | 'f' | 'F' | 'p' => {
                self.argument();
            }
            other => self.write(other),
        }
    }

    /// Parses a stacked fraction or tolerance.
    fn stacked(&mut self) {
        let said = self.argument().to_owned();
        let Some(at) = said.find(['^', '/', '#']) else {
            said.chars().for_each(|sign| self.write(sign));
            return;
        };
        let (upper, lower) = (said.get(..at), said.get(at + 1..));
        let [upper, lower] = [upper, lower].map(|part| part.unwrap_or_default().trim().to_owned());
        let is_bar = said.get(at..=at) == Some("/");
        let part = |text: String, raise: f64, back: bool| Run {
            text,
            size: self.look.size * FRACTION_SCALE,
            raise,
            back,
            bars: [None; 3],
            ..self.look.clone()
        };
        if said.get(at..=at) == Some("#") {
            let whole = format!("{upper}/{lower}");
            whole.chars().for_each(|sign| self.write(sign));
            return;
        }
        // The wider part comes last, so that the next run begins after both.
        let (above, below) = (1.0, -0.35);
        let mut parts = [part(upper, above, false), part(lower, below, false)];
        if is_bar {
            parts[0].bars[0] = Some(-0.2);
        }
        if parts[0].text.chars().count() > parts[1].text.chars().count() {
            parts.reverse();
        }
        parts[0].back = true;
        if let Some(line) = self.lines.last_mut() {
            line.extend(parts);
        }
    }
}

fn number(said: &str, usual: f64) -> f64 {
    let number = said.trim_end_matches(['x', 'X']).parse::<f64>();
    number
        .ok()
        .filter(|number| *number > 0.0 && number.is_finite())
        .unwrap_or(usual)
}

fn looks_alike(one: &Run, other: &Run) -> bool {
    let plain = |run: &Run| Run {
        text: String::new(),
        ..run.clone()
    };
    !one.back && plain(one) == plain(other)
}
