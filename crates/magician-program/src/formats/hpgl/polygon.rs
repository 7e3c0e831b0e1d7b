//! Polygons: strokes that are gathered first and drawn later.

use super::figures::UNFILLED;
use super::lexer::Instruction;
use super::plotter::Plotter;
use crate::{DiagnosticCode, Origin};

impl Plotter<'_> {
    /// PM: 0 begins a polygon, 1 another part of it, 2 ends it.
    pub(super) fn polygon(&mut self, instruction: &Instruction) {
        match instruction.numbers.first().copied().unwrap_or(0.0) {
            0.0 => {
                self.lift_for_a_moment();
                self.edges.clear();
                self.polygon = Some(0);
                if self.draws() {
                    self.begin(instruction.range.clone(), false);
                }
            }
            1.0 => self.close_part(),
            _ => {
                self.close_part();
                self.polygon = None;
            }
        }
    }

    /// A part of a polygon ends where it began.
    fn close_part(&mut self) {
        self.lift_for_a_moment();
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
                "a polygon (PM) that is not closed is left out",
            );
        }
    }

    /// EP and FP: the polygon's outline.
    pub(super) fn edge(&mut self, instruction: &Instruction) {
        if &instruction.name == b"FP" {
            self.note(instruction, UNFILLED);
            // Programs draw the edge of what they fill, too.
            if self.edges.is_empty() {
                return;
            }
        }
        for edge in std::mem::take(&mut self.edges) {
            self.put(edge);
        }
    }
}
