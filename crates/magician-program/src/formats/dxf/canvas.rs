//! The way through a drawing: entities and what they insert, and what is left out.

use std::collections::HashMap;
use std::ops::Range;

use kurbo::{Affine, Point};
use magician_host::{Given, Setting};

use super::color;
use super::drawing::{Drawing, Hidden};
use super::entity;
use super::pairs::Record;
use crate::artwork::{Style, numbered};
use crate::{Color, Diagnostic, DiagnosticCode, Origin, Stroke};

/// Points of all lines together, at most.
pub(super) const MOST_POINTS: usize = 2_000_000;
/// Pairs that are read to draw, those of blocks as often as they are inserted, at most.
const MOST_PAIRS: usize = 5_000_000;
/// As deep blocks may be nested.
const MOST_DEPTH: usize = 32;
/// Notes, at most.
const MOST_NOTES: usize = 50;
/// A tolerance that is none becomes this, mm.
const TOLERANCE: f64 = 0.05;

/// What is drawn, as far as it is.
pub(super) struct Canvas<'p> {
    drawing: &'p Drawing<'p>,
    /// How far a line may be from its curve, mm.
    pub(super) tolerance: f64,
    strokes: Vec<Stroke>,
    names: Vec<String>,
    colors: Vec<Color>,
    /// Where in the names each layer is.
    layers: HashMap<&'p str, usize>,
    /// Why what kind was left out, how often, and where first.
    left_out: HashMap<(&'p str, String), (usize, Origin)>,
    /// How many entities have heights that are lost, and where the first is.
    flattened: Option<(usize, Origin)>,
    points: usize,
    pairs: usize,
}

/// Where entities come to lie, and what they inherit.
#[derive(Clone)]
pub(super) struct InsertContext<'p> {
    /// From their coordinates to mm.
    pub(super) map: Affine,
    /// The layer that layer 0 stands for within a block.
    layer: Option<&'p str>,
    /// The blocks that they are in.
    blocks: Vec<&'p str>,
}

impl<'p> Canvas<'p> {
    pub(super) fn new(drawing: &'p Drawing<'p>, tolerance: f64) -> Self {
        let usable = tolerance > 0.0 && tolerance.is_finite();
        Self {
            drawing,
            tolerance: if usable { tolerance } else { TOLERANCE },
            strokes: Vec::new(),
            names: Vec::new(),
            colors: Vec::new(),
            layers: HashMap::new(),
            left_out: HashMap::new(),
            flattened: None,
            points: 0,
            pairs: 0,
        }
    }

    /// Draws everything.
    pub(super) fn draw(&mut self) -> Result<(), Diagnostic> {
        let place = InsertContext {
            map: Affine::scale(self.drawing.unit.unwrap_or(1.0)),
            layer: None,
            blocks: Vec::new(),
        };
        self.records(self.drawing.entities.clone(), &place)
    }

    /// The lines, the names of their layers, their colours, and the notes in the order of the file.
    pub(super) fn finish(self) -> (Vec<Stroke>, Vec<String>, Vec<Color>, Vec<Diagnostic>) {
        let left_out = self.left_out.into_iter();
        let mut notes: Vec<Diagnostic> = left_out
            .map(|((kind, why), (count, origin))| {
                let times = match count {
                    1 => String::new(),
                    _ => format!(" {count} times"),
                };
                let what = format!("{kind} is left out{times}: {why}");
                Diagnostic::new(origin, what).coded(DiagnosticCode::LeftOut)
            })
            .collect();
        notes.sort_by(|one, other| (one.origin, &one.message).cmp(&(other.origin, &other.message)));
        notes.truncate(MOST_NOTES);
        if self.drawing.unit.is_none() {
            let why = "the drawing has no unit: mm is used";
            notes.insert(
                0,
                Diagnostic::of_file(why)
                    .coded(DiagnosticCode::Assumed)
                    .remedy((Setting::Scale, Given::Any("FACTOR")), "corrects the size"),
            );
        }
        if let Some((count, origin)) = self.flattened {
            let why = format!("{count} polylines vary in z: they are drawn as seen from above");
            notes.push(Diagnostic::new(origin, why).coded(DiagnosticCode::Assumed));
        }
        if let Some(origin) = self.drawing.cut {
            let why = "the file does not end with EOF: it may be cut short";
            notes.push(Diagnostic::new(origin, why).coded(DiagnosticCode::Assumed));
        }
        (self.strokes, self.names, self.colors, notes)
    }

    fn records(
        &mut self,
        range: Range<usize>,
        place: &InsertContext<'p>,
    ) -> Result<(), Diagnostic> {
        let mut rest = self.drawing.records.get(range).unwrap_or_default();
        while let Some((record, after)) = rest.split_first() {
            self.count(record)?;
            let vertices = after.iter().take_while(|next| next.kind == "VERTEX");
            let (vertices, after) = after.split_at(vertices.count());
            rest = after;
            self.record(record, vertices, place)?;
        }
        Ok(())
    }

    fn count(&mut self, record: &Record<'p>) -> Result<(), Diagnostic> {
        self.pairs += record.pairs.len() + 1;
        if self.pairs > MOST_PAIRS {
            let why = "the blocks of the drawing expand to more than can be drawn";
            return Err(Diagnostic::new(record.origin, why));
        }
        Ok(())
    }

    fn record(
        &mut self,
        record: &'p Record<'p>,
        vertices: &'p [Record<'p>],
        place: &InsertContext<'p>,
    ) -> Result<(), Diagnostic> {
        if matches!(record.kind, "VERTEX" | "SEQEND" | "VIEWPORT" | "EOF") {
            return Ok(());
        }
        if record.integer(60)? == 1 {
            return self.leave_out(record, "it is invisible");
        }
        if record.integer(67)? == 1 {
            return self.leave_out(record, "it is on the sheet of a layout, not in the drawing");
        }
        let own = record.text(8).unwrap_or("0");
        let layer = place.layer.filter(|_| own == "0").unwrap_or(own);
        match (self.drawing.hides(layer), record.kind) {
            (Some(Hidden::Frozen), _) => self.leave_out(record, "its layer is frozen"),
            (_, "INSERT") => self.insert(record, layer, place),
            (Some(Hidden::Off), _) => self.leave_out(record, "its layer is off or not plotted"),
            (None, _) => entity::draw(self, record, vertices, layer, place),
        }
    }

    /// Notes that something is not drawn.
    pub(super) fn leave_out(
        &mut self,
        record: &Record<'p>,
        why: impl Into<String>,
    ) -> Result<(), Diagnostic> {
        let kind = record.kind.char_indices().nth(40);
        let kind = kind.and_then(|(end, _)| record.kind.get(..end));
        let key = (kind.unwrap_or(record.kind), why.into());
        let (count, _) = self.left_out.entry(key).or_insert((0, record.origin));
        *count += 1;
        Ok(())
    }

    /// Notes that an entity is drawn as if it lay flat.
    pub(super) fn flattened(&mut self, record: &Record<'p>) {
        let (count, _) = self.flattened.get_or_insert((0, record.origin));
        *count += 1;
    }

    /// Draws a block, once or in rows and columns.
    fn insert(
        &mut self,
        record: &'p Record<'p>,
        layer: &'p str,
        place: &InsertContext<'p>,
    ) -> Result<(), Diagnostic> {
        let name = record.text(2).unwrap_or_default();
        let drawing = self.drawing;
        let Some(block) = drawing.block(name) else {
            return self.leave_out(record, "its block is not in the file");
        };
        let name = name.to_owned();
        let is_in = |block: &&str| block.to_uppercase() == name.to_uppercase();
        if place.blocks.iter().any(is_in) {
            return self.leave_out(record, "its block contains itself");
        }
        if place.blocks.len() >= MOST_DEPTH {
            let why = format!("blocks are nested more than {MOST_DEPTH} deep");
            return self.leave_out(record, why);
        }
        let [x, y, z] = record.point(10)?;
        let number = |code, default| record.number(code).map(|found| found.unwrap_or(default));
        let scale = Affine::scale_non_uniform(number(41, 1.0)?, number(42, 1.0)?);
        let turn = Affine::rotate(number(50, 0.0)?.to_radians());
        let (columns, rows) = (record.integer(70)?.max(1), record.integer(71)?.max(1));
        let (across, up) = (number(44, 0.0)?, number(45, 0.0)?);
        let spot = place.map * entity::plane(record, z)? * Affine::translate((x, y)) * turn;
        let blocks = [
            place.blocks.as_slice(),
            &[record.text(2).unwrap_or_default()],
        ]
        .concat();
        for row in 0..rows {
            for column in 0..columns {
                self.count(record)?;
                let cell = Affine::translate((column as f64 * across, row as f64 * up));
                let from_base = Affine::translate((-block.base[0], -block.base[1]));
                let inner = InsertContext {
                    map: spot * cell * scale * from_base,
                    layer: Some(layer),
                    blocks: blocks.clone(),
                };
                self.records(block.records.clone(), &inner)?;
            }
        }
        Ok(())
    }

    /// Adds a line through points in mm; points that follow one another in one place are one.
    pub(super) fn stroke(
        &mut self,
        points: Vec<Point>,
        record: &Record<'p>,
        layer: &'p str,
    ) -> Result<(), Diagnostic> {
        if points.iter().any(|point| !point.is_finite()) {
            let why = format!("{} has no finite coordinates", record.kind);
            return Err(Diagnostic::new(record.origin, why));
        }
        let mut points: Vec<[f64; 2]> = points.iter().map(|point| [point.x, point.y]).collect();
        points.dedup();
        self.points += points.len();
        if self.points > MOST_POINTS {
            let why = format!("the drawing has more than {MOST_POINTS} points");
            let tolerance = (Setting::Tolerance, Given::Any("MM"));
            return Err(Diagnostic::new(record.origin, why)
                .remedy(tolerance, "needs fewer if it is larger"));
        }
        if points.is_empty() {
            return Ok(());
        }
        let index = *self.layers.entry(layer).or_insert_with(|| {
            self.names.push(layer.to_owned());
            self.names.len() - 1
        });
        let color = self.color(record, layer);
        self.strokes.push(Stroke {
            points,
            origin: record.origin.named(index),
            style: Style {
                layer: u32::try_from(index + 1).unwrap_or(0),
                color,
                ..Style::default()
            },
        });
        Ok(())
    }

    /// The place of a line's colour in the list, from 1; 0 without one.
    fn color(&mut self, record: &Record<'p>, layer: &str) -> u32 {
        let own = color::of(record);
        let color = own.unwrap_or_else(|| self.drawing.color(layer));
        color.map_or(0, |color| numbered(&mut self.colors, &color))
    }

    /// As many points may still be added.
    pub(super) fn room(&self) -> usize {
        MOST_POINTS.saturating_sub(self.points)
    }
}
