//! Coordinate frame of a plot: defaults, scaling instructions and the window.

use magician_host::{Setting, SettingValue, message};

use super::lexer::Instruction;
use super::plotter::Plotter;
use crate::formats::span::SpanDiagnostic;
use crate::{DiagnosticCode, Stroke};

impl Plotter<'_> {
    pub(super) fn reset(&mut self, moves: bool) {
        self.lift();
        self.end_polygon();
        self.edges.clear();
        (self.relative, self.window) = (false, None);
        self.tick = super::figures::DEFAULT_TICK_LENGTHS;
        (self.labels, self.fill_type, self.symbol) = Default::default();
        if moves {
            self.scale.reset();
            self.at = [0.0; 2];
        } else {
            let place = self.scale.place(self.at);
            self.scale.unscale();
            self.keep_pen_at(place);
        }
    }

    /// Handles an instruction that changes the coordinate system. The pen does not move.
    pub(super) fn scaled(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        self.end_stroke();
        let place = self.scale.place(self.at);
        match &instruction.name {
            b"IP" => self.scale.corners(instruction),
            b"IR" => self.scale.relative_corners(instruction),
            b"PS" => self.scale.sized(instruction),
            b"RO" => self.scale.rotate(instruction),
            _ => self.scale.units(instruction),
        }?;
        self.keep_pen_at(place);
        if &instruction.name == b"SC" && self.scale.assumes_frame() {
            let [width, height] = self.scale.frame();
            let message = message!(
                "SC without IP scales to the plotter's own frame: A4 is assumed, {width:.0} by \
                    {height:.0} mm",
                width,
                height
            );
            let origin = self.lines.origin(instruction.range.clone());
            self.notes
                .add_with(DiagnosticCode::Assumed, origin, message, |note| {
                    let note = note.help(message!("give it by IP before SC"));
                    let note =
                        note.remedy((Setting::Width, SettingValue::Any("MM")), "sets its width");
                    note.remedy((Setting::Scale, SettingValue::Any("FACTOR")), "scales it")
                });
        }
        Ok(())
    }

    /// Handles IW: nothing outside a rectangle is drawn.
    pub(super) fn windowed(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        self.end_stroke();
        self.window = match instruction.numbers[..] {
            [] => None,
            [x1, y1, x2, y2] => {
                let [a, b] = [[x1, y1], [x2, y2]].map(|corner| self.scale.place(corner));
                Some([
                    [a[0].min(b[0]), a[1].min(b[1])],
                    [a[0].max(b[0]), a[1].max(b[1])],
                ])
            }
            _ => {
                let message = message!("IW needs two points or nothing");
                return Err(SpanDiagnostic::new(instruction.range.clone(), message));
            }
        };
        Ok(())
    }

    /// Keeps the pen at a place of the sheet, whose coordinates have changed.
    fn keep_pen_at(&mut self, place: [f64; 2]) {
        self.at = self.scale.at(place);
    }

    /// Adds the part of a stroke within the window.
    pub(super) fn put(&mut self, stroke: Stroke) {
        match self.window {
            None => self.artwork.strokes.push(stroke),
            Some(window) => self.artwork.strokes.extend(stroke.within(window)),
        }
    }
}
