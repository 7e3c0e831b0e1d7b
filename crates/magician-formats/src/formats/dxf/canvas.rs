//! Walk over the entities of a drawing and the blocks that they insert, and collection of the
//! result.
//!
//! Blocks may insert blocks, so the work is bounded: by depth, by the number of pairs read
//! including repetitions, and by the number of points.

use std::collections::HashMap;
use std::ops::Range;

use kurbo::{Affine, Point, Vec2};
use magician_host::{Message, Setting, SettingValue, message};

use super::color;
use super::drawing::{Block, Drawing, Hidden};
use super::entity;
use super::join::joined;
use super::pairs::Record;
use super::text::{Style as TextStyle, rotation_to};
use super::xclip::Clip;
use crate::artwork::{Layer, Style, index_or_push};
use crate::fill::{Area, FillRule};
use crate::formats::{Chords, Fills, ReadOptions};
use crate::lettering::{Glyph, Lettering};
use crate::{Artwork, Color, Diagnostic, DiagnosticCode, FilledArea, Origin, Stroke};

/// Largest number of points of all lines. It bounds memory.
pub(super) const MAX_POINTS: usize = 2_000_000;
/// Largest number of pairs to read, counting those of blocks once per insertion. It bounds time for
/// nested blocks.
const MAX_PAIRS: usize = 5_000_000;
/// Largest nesting depth of blocks. It protects the stack; real drawings nest a few levels.
const MAX_DEPTH: usize = 32;
/// Largest number of notes. An arbitrary limit: users do not read more.
const MAX_NOTES: usize = 50;

/// Lines and areas collected so far.
pub(super) struct Canvas<'p> {
    drawing: &'p Drawing<'p>,
    /// Tolerance of curves.
    pub(super) chords: &'p Chords,
    options: &'p ReadOptions,
    /// True if paper space (the sheet of a layout) is drawn instead of model space.
    on_sheet: bool,
    pub(super) has_sheet: bool,
    strokes: Vec<Stroke>,
    /// Lines of letters, which are not joined to others.
    letters: Vec<Stroke>,
    areas: Vec<FilledArea>,
    names: Vec<String>,
    /// Font, loaded at the first text.
    lettering: Option<Lettering>,
    missing: Vec<(char, Diagnostic)>,
    /// Clip boundaries of the enclosing blocks.
    clips: Vec<Clip>,
    colors: Vec<Color>,
    /// Index of each layer's name.
    layers: HashMap<&'p str, usize>,
    /// Entities left out, by kind and text of the reason: number, first place and reason.
    left_out: HashMap<(&'p str, String), (usize, Origin, Message)>,
    /// Number of entities whose heights are lost, and the place of the first.
    flattened: Option<(usize, Origin)>,
    points: usize,
    pairs: usize,
}

/// Transform of entities, and what they inherit from the blocks around them.
#[derive(Clone)]
pub(super) struct InsertContext<'p> {
    /// Transform from their coordinates to mm.
    pub(super) map: Affine,
    /// Layer that replaces layer 0 within a block.
    layer: Option<&'p str>,
    /// Names of the enclosing blocks.
    blocks: Vec<&'p str>,
}

impl InsertContext<'_> {
    pub(super) fn is_in_block(&self) -> bool {
        !self.blocks.is_empty()
    }
}

impl<'p> Canvas<'p> {
    pub(super) fn new(
        drawing: &'p Drawing<'p>,
        options: &'p ReadOptions,
        chords: &'p Chords,
    ) -> Self {
        Self {
            drawing,
            chords,
            options,
            on_sheet: false,
            has_sheet: false,
            strokes: Vec::new(),
            letters: Vec::new(),
            areas: Vec::new(),
            lettering: None,
            missing: Vec::new(),
            clips: Vec::new(),
            names: Vec::new(),
            colors: Vec::new(),
            layers: HashMap::new(),
            left_out: HashMap::new(),
            flattened: None,
            points: 0,
            pairs: 0,
        }
    }

    /// Creates a canvas for paper space, because some programs draw only there.
    pub(super) fn of_sheet(
        drawing: &'p Drawing<'p>,
        options: &'p ReadOptions,
        chords: &'p Chords,
    ) -> Self {
        Self {
            on_sheet: true,
            ..Self::new(drawing, options, chords)
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.strokes.is_empty() && self.letters.is_empty() && self.areas.is_empty()
    }

    /// Draws the whole drawing.
    pub(super) fn draw(&mut self) -> Result<(), Diagnostic> {
        let context = InsertContext {
            map: Affine::scale(self.drawing.unit.unwrap_or(1.0)),
            layer: None,
            blocks: Vec::new(),
        };
        self.records(self.drawing.entities.clone(), &context)
    }

    /// Returns the artwork, with lines joined where they meet, and the notes in the order of the
    /// file.
    pub(super) fn finish(self) -> (Artwork, Vec<Diagnostic>) {
        let left_out = self.left_out.into_iter();
        let mut notes: Vec<Diagnostic> = left_out
            .map(|((kind, _), (count, origin, why))| {
                let what = match count {
                    1 => message!("{kind} is left out: {why}", kind, why),
                    _ => message!("{kind} is left out {count} times: {why}", kind, count, why),
                };
                Diagnostic::new(origin, what).coded(DiagnosticCode::LeftOut)
            })
            .collect();
        // Hash maps have no order, and notes shall appear in that of the file.
        notes.sort_by(|one, other| {
            (one.origin, one.message.as_str()).cmp(&(other.origin, other.message.as_str()))
        });
        notes.truncate(MAX_NOTES);
        if self.drawing.unit.is_none() {
            let why = message!("the drawing has no unit: mm is used");
            notes.insert(
                0,
                Diagnostic::of_file(why)
                    .coded(DiagnosticCode::Assumed)
                    .remedy(
                        (Setting::Scale, SettingValue::Any("FACTOR")),
                        "corrects the size",
                    ),
            );
        }
        if let Some((count, origin)) = self.flattened {
            let why = message!(
                "{count} polylines vary in z: they are drawn as seen from above",
                count
            );
            notes.push(Diagnostic::new(origin, why).coded(DiagnosticCode::Assumed));
        }
        if self.on_sheet {
            let why = message!(
                "the drawing itself is empty: what lies on the sheet of its layout is drawn"
            );
            notes.push(Diagnostic::of_file(why).coded(DiagnosticCode::Assumed));
        }
        if let Some(origin) = self.drawing.cut {
            let why = message!("the file does not end with EOF: it may be cut short");
            notes.push(Diagnostic::new(origin, why).coded(DiagnosticCode::Assumed));
        }
        notes.extend(self.missing.into_iter().map(|(_, note)| note));
        // Letters are added after joining, so that their lines are not joined to the drawing's.
        let mut strokes = joined(self.strokes);
        strokes.extend(self.letters);
        let layers = self.names.iter().map(|name| Layer {
            name: Some(name.clone()),
            inkscape: false,
        });
        let artwork = Artwork {
            title: self.options.title.clone(),
            strokes,
            areas: self.areas,
            layers: layers.collect(),
            colors: self.colors,
            names: self.names,
            ..Artwork::default()
        };
        (artwork, notes)
    }

    fn records(
        &mut self,
        range: Range<usize>,
        context: &InsertContext<'p>,
    ) -> Result<(), Diagnostic> {
        let mut rest = self.drawing.records.get(range).unwrap_or_default();
        while let Some((record, after)) = rest.split_first() {
            self.count(record)?;
            let vertices = after.iter().take_while(|next| next.kind == "VERTEX");
            let (vertices, after) = after.split_at(vertices.count());
            rest = after;
            self.record(record, vertices, context)?;
        }
        Ok(())
    }

    fn count(&mut self, record: &Record<'p>) -> Result<(), Diagnostic> {
        self.pairs += record.pairs.len() + 1;
        if self.pairs > MAX_PAIRS {
            let why = message!("the blocks of the drawing expand to more than can be drawn");
            return Err(Diagnostic::new(record.origin, why));
        }
        Ok(())
    }

    fn record(
        &mut self,
        record: &'p Record<'p>,
        vertices: &'p [Record<'p>],
        context: &InsertContext<'p>,
    ) -> Result<(), Diagnostic> {
        if matches!(record.kind, "VERTEX" | "SEQEND" | "VIEWPORT" | "EOF") {
            return Ok(());
        }
        if record.integer(60)? == 1 {
            return self.leave_out(record, message!("it is invisible"));
        }
        // Code 67 marks entities in paper space. It is ignored within a block, whose entities are
        // drawn wherever the block is inserted.
        if !context.is_in_block() && (record.integer(67)? == 1) != self.on_sheet {
            if self.on_sheet {
                return Ok(());
            }
            self.has_sheet = true;
            let why = message!("it is on the sheet of a layout, not in the drawing");
            return self.leave_out(record, why);
        }
        let own = record.text(8).unwrap_or("0");
        let layer = context.layer.filter(|_| own == "0").unwrap_or(own);
        match (self.drawing.hides(layer), record.kind) {
            (Some(Hidden::Frozen), _) => self.leave_out(record, message!("its layer is frozen")),
            (_, "INSERT") => self.insert(record, layer, context),
            (None, "DIMENSION" | "ARC_DIMENSION" | "LARGE_RADIAL_DIMENSION") => {
                self.draw_stored_block(record, layer, context, context.map)
            }
            (None, "ACAD_TABLE") => {
                let [x, y, _] = record.point(10)?;
                let direction = match record.text(11) {
                    Some(_) => record.point(11)?,
                    None => [0.0; 3],
                };
                let turn = rotation_to(Vec2::new(direction[0], direction[1]));
                self.draw_stored_block(
                    record,
                    layer,
                    context,
                    context.map * Affine::translate((x, y)) * turn,
                )
            }
            (Some(Hidden::Off), _) => {
                self.leave_out(record, message!("its layer is off or not plotted"))
            }
            (None, _) => entity::draw(self, record, vertices, layer, context),
        }
    }

    /// Notes that an entity is not drawn.
    pub(super) fn leave_out(
        &mut self,
        record: &Record<'p>,
        why: Message,
    ) -> Result<(), Diagnostic> {
        let kind = record.kind.char_indices().nth(40);
        let kind = kind.and_then(|(end, _)| record.kind.get(..end));
        let key = (kind.unwrap_or(record.kind), why.as_str().to_owned());
        let entry = self.left_out.entry(key);
        let (count, ..) = entry.or_insert((0, record.origin, why));
        *count += 1;
        Ok(())
    }

    /// Notes that an entity is drawn as if it were flat.
    pub(super) fn flattened(&mut self, record: &Record<'p>) {
        let (count, _) = self.flattened.get_or_insert((0, record.origin));
        *count += 1;
    }

    /// Returns the block that an entity names. `None`, with a note, if it is missing, contains
    /// itself or is nested too deep.
    fn block_of(
        &mut self,
        record: &'p Record<'p>,
        context: &InsertContext<'p>,
    ) -> Result<Option<(&'p Block, Vec<&'p str>)>, Diagnostic> {
        let name = record.text(2).unwrap_or_default();
        let Some(block) = self.drawing.block(name) else {
            self.leave_out(record, message!("its block is not in the file"))?;
            return Ok(None);
        };
        let is_in = |block: &&str| block.to_uppercase() == name.to_uppercase();
        if context.blocks.iter().any(is_in) {
            self.leave_out(record, message!("its block contains itself"))?;
            return Ok(None);
        }
        if context.blocks.len() >= MAX_DEPTH {
            let why = message!("blocks are nested more than {most} deep", most = MAX_DEPTH);
            self.leave_out(record, why)?;
            return Ok(None);
        }
        Ok(Some((block, [context.blocks.as_slice(), &[name]].concat())))
    }

    /// Draws an entity whose appearance is stored in a separate block: a dimension or a table.
    fn draw_stored_block(
        &mut self,
        record: &'p Record<'p>,
        layer: &'p str,
        context: &InsertContext<'p>,
        map: Affine,
    ) -> Result<(), Diagnostic> {
        let Some((block, blocks)) = self.block_of(record, context)? else {
            return Ok(());
        };
        self.count(record)?;
        let inner = InsertContext {
            map: map * Affine::translate((-block.base[0], -block.base[1])),
            layer: Some(layer),
            blocks,
        };
        self.records(block.records.clone(), &inner)
    }

    /// Draws a block once, or in rows and columns.
    fn insert(
        &mut self,
        record: &'p Record<'p>,
        layer: &'p str,
        context: &InsertContext<'p>,
    ) -> Result<(), Diagnostic> {
        let Some((block, blocks)) = self.block_of(record, context)? else {
            return Ok(());
        };
        let [x, y, z] = record.point(10)?;
        let number = |code, default| record.number(code).map(|found| found.unwrap_or(default));
        let scale = Affine::scale_non_uniform(number(41, 1.0)?, number(42, 1.0)?);
        let turn = Affine::rotate(number(50, 0.0)?.to_radians());
        let (columns, rows) = (record.integer(70)?.max(1), record.integer(71)?.max(1));
        let (across, up) = (number(44, 0.0)?, number(45, 0.0)?);
        let first_cell = context.map * entity::plane(record, z)? * Affine::translate((x, y)) * turn;
        for row in 0..rows {
            for column in 0..columns {
                // Counted per cell, because an empty block in a huge array would never reach the
                // limit.
                self.count(record)?;
                let cell = Affine::translate((column as f64 * across, row as f64 * up));
                let from_base = Affine::translate((-block.base[0], -block.base[1]));
                let inner = InsertContext {
                    map: first_cell * cell * scale * from_base,
                    layer: Some(layer),
                    blocks: blocks.clone(),
                };
                let clip = Clip::of(self.drawing, record, &inner.map)?;
                let outer = self.clips.len();
                self.clips.extend(clip);
                self.records(block.records.clone(), &inner)?;
                self.clips.truncate(outer);
            }
        }
        Ok(())
    }

    /// Adds a line of a letter.
    pub(super) fn letter(
        &mut self,
        points: Vec<Point>,
        record: &Record<'p>,
        layer: &'p str,
    ) -> Result<(), Diagnostic> {
        let before = self.strokes.len();
        self.stroke(points, record, layer)?;
        self.letters.extend(self.strokes.drain(before..));
        Ok(())
    }

    /// Adds a filled shape: as an area on request, else as its outline.
    pub(super) fn area(
        &mut self,
        rings: Vec<Vec<Point>>,
        record: &Record<'p>,
        layer: &'p str,
    ) -> Result<(), Diagnostic> {
        match self.options.fills {
            Fills::Ignore => Ok(()),
            Fills::Outline => rings.into_iter().try_for_each(|mut ring| {
                ring.extend(ring.first().copied());
                self.stroke(ring, record, layer)
            }),
            Fills::Areas => {
                let rings = rings.into_iter();
                let rings = rings
                    .map(|ring| self.points(ring, record))
                    .collect::<Result<_, _>>()?;
                let whole = Area {
                    rings,
                    rule: FillRule::EvenOdd,
                };
                let area = self.clips.iter().fold(whole, |area, clip| clip.area(&area));
                let (origin, style) = self.origin_and_style(record, layer);
                if !area.rings.is_empty() {
                    self.areas.push(FilledArea {
                        area,
                        origin,
                        style,
                    });
                }
                Ok(())
            }
        }
    }

    /// Returns a text style.
    pub(super) fn style(&self, name: Option<&str>) -> TextStyle {
        self.drawing.style(name.unwrap_or("STANDARD"))
    }

    /// Length of arrows in a dimension style.
    pub(super) fn arrow_size(&self, style: Option<&str>) -> f64 {
        self.drawing.arrow(style.unwrap_or("STANDARD"))
    }

    /// Returns the glyph of a character, at the size at which capitals are `size` drawing units
    /// high. `None`, with a note, if no font has the character.
    pub(super) fn glyph(
        &mut self,
        character: char,
        size: f64,
        record: &Record<'_>,
    ) -> Result<Option<Glyph>, Diagnostic> {
        let lettering = match self.lettering.take() {
            Some(lettering) => lettering,
            None => Lettering::new(self.options, self.chords.for_curve())?,
        };
        let glyph = lettering.glyph(character, size);
        if glyph.is_none() && self.missing.iter().all(|(known, _)| *known != character) {
            let note = lettering.lacks(character, record.origin)?;
            if self.missing.len() < MAX_NOTES {
                self.missing.push((character, note));
            }
        }
        self.lettering = Some(lettering);
        Ok(glyph)
    }

    /// Adds a line through points in mm, clipped to the boundaries of the enclosing blocks.
    pub(super) fn stroke(
        &mut self,
        points: Vec<Point>,
        record: &Record<'p>,
        layer: &'p str,
    ) -> Result<(), Diagnostic> {
        let mut lines = vec![points];
        for clip in &self.clips {
            let within: Option<Vec<_>> = lines.iter().map(|line| clip.line(line)).collect();
            let Some(within) = within else {
                return self.leave_out(record, message!("it is too long to be clipped"));
            };
            lines = within.into_iter().flatten().collect();
        }
        for line in lines {
            let points = self.points(line, record)?;
            if !points.is_empty() {
                let (origin, style) = self.origin_and_style(record, layer);
                self.strokes.push(Stroke {
                    points,
                    origin,
                    style,
                });
            }
        }
        Ok(())
    }

    /// Checks points, merges consecutive equal ones, and counts them.
    fn points(
        &mut self,
        points: Vec<Point>,
        record: &Record<'p>,
    ) -> Result<Vec<[f64; 2]>, Diagnostic> {
        if points.iter().any(|point| !point.is_finite()) {
            let why = message!("{kind} has no finite coordinates", kind = record.kind);
            return Err(Diagnostic::new(record.origin, why));
        }
        let mut points: Vec<[f64; 2]> = points.iter().map(|point| [point.x, point.y]).collect();
        points.dedup();
        self.points += points.len();
        if self.points > MAX_POINTS {
            let why = message!("the drawing has more than {most} points", most = MAX_POINTS);
            let tolerance = (Setting::Tolerance, SettingValue::Any("MM"));
            return Err(Diagnostic::new(record.origin, why)
                .remedy(tolerance, "needs fewer if it is larger"));
        }
        Ok(points)
    }

    /// Returns the origin of an entity, named after its layer, and the style of the entity.
    fn origin_and_style(&mut self, record: &Record<'p>, layer: &'p str) -> (Origin, Style) {
        let index = *self.layers.entry(layer).or_insert_with(|| {
            self.names.push(layer.to_owned());
            self.names.len() - 1
        });
        let style = Style {
            layer: u32::try_from(index + 1).unwrap_or(0),
            color: self.color(record, layer),
            ..Style::default()
        };
        (record.origin.named(index), style)
    }

    /// Index of an entity's colour from 1; 0 if it has none.
    fn color(&mut self, record: &Record<'p>, layer: &str) -> u32 {
        let own = color::of(record);
        let color = own.unwrap_or_else(|| self.drawing.color(layer));
        color.map_or(0, |color| index_or_push(&mut self.colors, &color))
    }

    /// Number of points that may still be added.
    pub(super) fn room(&self) -> usize {
        MAX_POINTS.saturating_sub(self.points)
    }
}
