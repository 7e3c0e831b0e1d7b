//! Labels (LB): letters at the size, slant, direction and position given by the plot.
//!
//! A plotter's letters all have the same width. So each letter of our font is centred in a cell of
//! that width, and whatever the plot aligns with characters stays aligned.

use magician_host::message;

use super::lexer::Instruction;
use super::plotter::Plotter;
use crate::formats::span::SpanDiagnostic;
use crate::{DiagnosticCode, Stroke};

/// Distance of characters, in widths of a character.
const CHARACTER_ADVANCE: f64 = 1.5;
/// Distance of lines, in heights of a character.
const LINE_DISTANCE: f64 = 2.0;
/// Default width and height of a character, percent of the distance between P1 and P2 (HP 7475A).
const DEFAULT_RELATIVE_SIZE: [f64; 2] = [0.75, 1.5];
/// Size of a character after SI without numbers on A4, cm.
const DEFAULT_ABSOLUTE_SIZE: [f64; 2] = [0.187, 0.269];
/// Width of a capital of the font, in its heights: an H is 14 by 21 units.
const CAPITAL_WIDTH: f64 = 14.0 / 21.0;
/// Largest stretch of a letter beyond the width of a capital. A choice: wider letters look odd.
const MAX_STRETCH: f64 = 1.3;
/// Largest number of characters of a label. It bounds memory if the terminator is missing.
const MAX_LABEL_LENGTH: usize = 10_000;

/// Style of labels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LabelStyle {
    size: Size,
    direction: Direction,
    /// Slant: tangent of the angle of uprights, positive to the right.
    slant: f64,
    /// Label origin (LO).
    origin: f64,
    /// Extra space between characters and lines (ES), in cells.
    extra: [f64; 2],
    /// True if characters are stacked downwards.
    downwards: bool,
    /// Start of the line, to which a carriage return leads, mm.
    start: Option<[f64; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Size {
    /// Width and height, cm.
    Absolute([f64; 2]),
    /// Percent of the distance between P1 and P2.
    Relative([f64; 2]),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Direction {
    Absolute([f64; 2]),
    /// Shares of the distance between P1 and P2.
    Relative([f64; 2]),
}

impl Default for LabelStyle {
    fn default() -> Self {
        Self {
            size: Size::Relative(DEFAULT_RELATIVE_SIZE),
            direction: Direction::Absolute([1.0, 0.0]),
            slant: 0.0,
            origin: 1.0,
            extra: [0.0; 2],
            downwards: false,
            start: None,
        }
    }
}

impl LabelStyle {
    /// Forgets the start of the line, because the pen was moved.
    pub(super) const fn moved(&mut self) {
        self.start = None;
    }
}

/// Cell of a character on the sheet, mm: its size and its axes.
#[derive(Clone, Copy)]
struct Cell {
    width: f64,
    height: f64,
    along: [f64; 2],
    up: [f64; 2],
}

impl Cell {
    fn at(&self, from: [f64; 2], x: f64, y: f64) -> [f64; 2] {
        [0, 1].map(|side| from[side] + self.along[side] * x + self.up[side] * y)
    }
}

impl Plotter<'_> {
    /// Handles SI, SR, DI, DR, DV, SL, LO and ES: style of the following labels.
    pub(super) fn label_style(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let style = &mut self.labels;
        let numbers = &instruction.numbers[..];
        match (&instruction.name, numbers) {
            (b"SI", []) => style.size = Size::Absolute(DEFAULT_ABSOLUTE_SIZE),
            (b"SI", &[width, height, ..]) => style.size = Size::Absolute([width, height]),
            (b"SR", []) => style.size = Size::Relative(DEFAULT_RELATIVE_SIZE),
            (b"SR", &[width, height, ..]) => style.size = Size::Relative([width, height]),
            (b"DI" | b"DR", []) => style.direction = Direction::Absolute([1.0, 0.0]),
            (b"DI", &[run, rise, ..]) => style.direction = Direction::Absolute([run, rise]),
            (b"DR", &[run, rise, ..]) => style.direction = Direction::Relative([run, rise]),
            (b"DV", numbers) => style.downwards = numbers.first().is_some_and(|way| *way != 0.0),
            (b"SL", numbers) => style.slant = numbers.first().copied().unwrap_or(0.0),
            (b"LO", numbers) => style.origin = numbers.first().copied().unwrap_or(1.0),
            (b"ES", numbers) => {
                style.extra = [0, 1].map(|nth| numbers.get(nth).copied().unwrap_or(0.0));
            }
            _ => {
                let message = message!(
                    "{name} needs two numbers or none",
                    name = instruction.name()
                );
                return Err(SpanDiagnostic::new(instruction.range.clone(), message));
            }
        }
        Ok(())
    }

    fn cell(&self) -> Cell {
        let frame = self.scale.span();
        let [width, height] = match self.labels.size {
            Size::Absolute(size) => size.map(|side| side * 10.0),
            Size::Relative(share) => [0, 1].map(|side| frame[side].abs() * share[side] / 100.0),
        };
        let [run, rise] = match self.labels.direction {
            Direction::Absolute(way) => way,
            Direction::Relative(way) => [0, 1].map(|side| frame[side] * way[side]),
        };
        let length = libm::hypot(run, rise);
        let [run, rise] = if length > 0.0 && length.is_finite() {
            [run / length, rise / length]
        } else {
            [1.0, 0.0]
        };
        Cell {
            width,
            height,
            along: self.scale.turned([run, rise]),
            up: self.scale.turned([-rise, run]),
        }
    }

    /// Offsets to the next character and to the next line.
    fn steps(&self, cell: &Cell) -> [[f64; 2]; 2] {
        let [across, along] = self.labels.extra;
        let forth = [cell.width * CHARACTER_ADVANCE * (1.0 + across), 0.0];
        let down = [0.0, -cell.height * LINE_DISTANCE * (1.0 + along)];
        if self.labels.downwards {
            [down, [-forth[0], 0.0]]
        } else {
            [forth, down]
        }
    }

    /// Handles CP: moves by characters to the right and lines up; without numbers to the next line.
    pub(super) fn character_plot(
        &mut self,
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        self.end_stroke();
        let cell = self.cell();
        let [forth, down] = self.steps(&cell);
        let place = self.scale.place(self.at);
        let to = match instruction.numbers[..] {
            [] => {
                let start = self.labels.start.unwrap_or(place);
                // The new position is one line below the current one, at the start of the line.
                let along = |from: [f64; 2], way: [f64; 2]| from[0] * way[0] + from[1] * way[1];
                let apart = [place[0] - start[0], place[1] - start[1]];
                let row = if self.labels.downwards {
                    along(apart, cell.along)
                } else {
                    along(apart, cell.up)
                };
                let start = if self.labels.downwards {
                    cell.at(start, row, 0.0)
                } else {
                    cell.at(start, 0.0, row)
                };
                self.labels.start = Some(start);
                cell.at(start, down[0], down[1])
            }
            [spaces] => cell.at(place, forth[0] * spaces, forth[1] * spaces),
            [spaces, lines, ..] => cell.at(
                place,
                forth[0] * spaces - down[0] * lines,
                forth[1] * spaces - down[1] * lines,
            ),
        };
        let start = self.labels.start;
        self.jump(to, instruction)?;
        self.labels.start = start;
        Ok(())
    }

    /// Moves the pen without drawing.
    fn jump(&mut self, place: [f64; 2], instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let at = self.scale.at(place);
        self.check_point(at, instruction)?;
        self.at = at;
        Ok(())
    }

    /// Handles LB: writes a label. Afterwards the pen is at the next character's position.
    pub(super) fn label(
        &mut self,
        text: &str,
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        if let Some(open) = &mut self.open {
            open.dot = false;
        }
        self.end_stroke();
        let cell = self.cell();
        let [forth, down] = self.steps(&cell);
        let from = self.scale.place(self.at);
        let start = *self.labels.start.get_or_insert(from);
        let count = text.chars().count();
        if count > MAX_LABEL_LENGTH {
            let message = message!(
                "the label has {count} characters, limit {limit}",
                count,
                limit = MAX_LABEL_LENGTH
            );
            return Err(SpanDiagnostic::new(instruction.range.clone(), message));
        }
        let rows: Vec<&str> = text.split('\n').collect();
        let origin = self.labels.origin;
        let begin = self.shifted(
            &cell,
            rows.first().copied().unwrap_or_default(),
            origin,
            forth,
        );
        let (mut at, mut row) = ([begin[0], begin[1]], 0.0);
        for character in text.chars() {
            match character {
                '\n' => {
                    row += 1.0;
                    at = [at[0] + down[0], at[1] + down[1]];
                }
                '\r' => {
                    // Centred and right-aligned rows are placed one by one.
                    let next = rows.get(row as usize + 1).copied().unwrap_or_default();
                    let [x, y] = self.shifted(&cell, next, origin, forth);
                    let back = [0, 1].map(|side| start[side] - from[side]);
                    let along = back[0] * cell.along[0] + back[1] * cell.along[1];
                    at = [x + along + down[0] * row, y + down[1] * row];
                }
                '\u{8}' => at = [at[0] - forth[0], at[1] - forth[1]],
                control if control.is_control() => {}
                sign => {
                    self.draw_character(sign, cell.at(from, at[0], at[1]), &cell, instruction)?;
                    at = [at[0] + forth[0], at[1] + forth[1]];
                }
            }
        }
        let end = cell.at(from, at[0], at[1]);
        let start = self.labels.start;
        self.jump(end, instruction)?;
        self.labels.start = start;
        Ok(())
    }

    /// Returns the start of a row relative to the pen. LO 1 to 9 go from bottom to top and from
    /// left to right; 11 to 19 are the same with half a character in between.
    fn shifted(&self, cell: &Cell, row: &str, origin: f64, forth: [f64; 2]) -> [f64; 2] {
        let nth = origin as i64;
        let (place, apart) = if nth > 10 {
            (nth - 10, 0.5)
        } else {
            (nth, 0.0)
        };
        if !(1..=9).contains(&place) {
            return [0.0; 2];
        }
        let (column, level) = ((place - 1) / 3, (place - 1) % 3);
        let row = row.trim_end_matches('\r');
        let count = row.chars().filter(|sign| !sign.is_control()).count() as f64;
        // No gap follows the last character.
        let long = (forth[0] * count - (forth[0] - cell.width)).max(0.0);
        let x = -long * column as f64 / 2.0 + apart * cell.width * (1 - column) as f64;
        let y = -cell.height * level as f64 / 2.0 + apart * cell.height * (1 - level) as f64;
        [x, y]
    }

    /// Draws a character in its cell, from the left end of its baseline.
    fn draw_character(
        &mut self,
        sign: char,
        from: [f64; 2],
        cell: &Cell,
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        if sign == ' ' || self.pen == 0.0 {
            return Ok(());
        }
        let origin = self.lines.origin(instruction.range.clone());
        let height = cell.height.abs();
        let Some(glyph) = self.lettering()?.glyph(sign, height) else {
            return self.note_missing_character(sign, instruction);
        };
        let Some([least, most]) = glyph.bounds() else {
            return Ok(());
        };
        let drawn = most[0] - least[0];
        let usual = cell.width.abs() / (CAPITAL_WIDTH * height);
        let wide = usual.min(cell.width.abs() * MAX_STRETCH / drawn.max(f64::MIN_POSITIVE));
        let left = (cell.width.abs() - drawn * wide) / 2.0;
        let slant = self.labels.slant;
        for line in &glyph.lines {
            let points: Vec<[f64; 2]> = { line.iter() }
                .map(|[x, y]| {
                    let x = (x - least[0]) * wide + left + slant * y;
                    cell.at(from, x * cell.width.signum(), y * cell.height.signum())
                })
                .collect();
            for point in &points {
                self.check_on_sheet(*point, instruction)?;
            }
            let style = self.style();
            self.put(Stroke {
                points,
                origin,
                style,
            });
        }
        Ok(())
    }

    /// Draws the symbol (SM) centred at the pen's position.
    pub(super) fn symbol(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let Some(symbol) = self.symbol else {
            return Ok(());
        };
        let cell = self.cell();
        let at = self.scale.place(self.at);
        let from = cell.at(at, -cell.width / 2.0, -cell.height / 2.0);
        self.draw_character(symbol, from, &cell, instruction)
    }

    fn note_missing_character(
        &mut self,
        sign: char,
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        let origin = self.lines.origin(instruction.range.clone());
        match self.lettering()?.lacks(sign, origin) {
            Ok(note) => {
                let remedies = note.remedies.clone();
                self.notes
                    .add_with(DiagnosticCode::LeftOut, origin, note.message, |mut note| {
                        note.remedies = remedies;
                        note
                    });
                Ok(())
            }
            Err(refused) => Err(SpanDiagnostic::of(instruction.range.clone(), refused)),
        }
    }
}
