//! Polygon mode: strokes are collected first, then drawn or filled.

use magician_host::message;

use super::lexer::Instruction;
use super::plotter::Plotter;
use crate::fill::FillRule;
use crate::{DiagnosticCode, Origin};

impl Plotter<'_> {
    /// Handles PM: 0 begins a polygon, 1 begins another part, 2 ends it.
    pub(super) fn polygon(&mut self, instruction: &Instruction) {
        match instruction.numbers.first().copied().unwrap_or(0.0) {
            0.0 => {
                self.end_stroke();
                self.edges.clear();
                self.outlined = false;
                self.rings = vec![vec![self.scale.place(self.at)]];
                self.polygon = Some(0);
                if self.draws() {
                    self.begin(instruction.range.clone(), false);
                }
            }
            1.0 => {
                self.close_part();
                self.rings.push(Vec::new());
            }
            // PM2, and any unknown number: the plot must not stay in polygon mode.
            _ => {
                self.close_part();
                self.polygon = None;
            }
        }
    }

    /// Closes the current part of the polygon.
    fn close_part(&mut self) {
        self.end_stroke();
        let Some(first) = self.polygon else {
            return;
        };
        let part = self.edges.get(first..).unwrap_or_default();
        let ends = part.first().zip(part.last()).and_then(|(begin, end)| {
            begin
                .points
                .first()
                .copied()
                .zip(end.points.last().copied())
        });
        if let (Some((begin, end)), Some(last)) = (ends, self.edges.last_mut())
            && begin != end
        {
            last.points.push(begin);
        }
        self.polygon = Some(self.edges.len());
    }

    pub(super) fn end_polygon(&mut self) {
        if self.polygon.take().is_some() && !self.edges.is_empty() {
            self.notes.add(
                DiagnosticCode::LeftOut,
                Origin::NONE,
                message!("a polygon (PM) that is not closed is left out"),
            );
        }
    }

    /// Handles EP (draw the outline) and FP (fill). The polygon stays defined, because a plot may
    /// use both.
    pub(super) fn edge(&mut self, instruction: &Instruction) {
        if &instruction.name == b"EP" {
            if std::mem::replace(&mut self.outlined, true) {
                return;
            }
            for edge in self.edges.clone() {
                self.put(edge);
            }
            return;
        }
        let rule = match instruction.numbers.first() {
            Some(1.0) => FillRule::NonZero,
            // HP-GL/2: even-odd by default.
            _ => FillRule::EvenOdd,
        };
        // Programs usually also draw the outline of what they fill, so do not draw it twice.
        if self.outlines() && std::mem::replace(&mut self.outlined, true) {
            return;
        }
        let rings = self.rings.iter().filter(|ring| ring.len() > 2);
        self.fill(rings.cloned().collect(), rule, instruction);
    }
}
