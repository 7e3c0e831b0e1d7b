//! What is filled: rectangles, wedges, polygons, as FT says.

use super::lexer::Instruction;
use super::plotter::Plotter;
use crate::fill::{Area, FillRule, LineFamily};
use crate::formats::Fills;
use crate::{DiagnosticCode, FilledArea, Stroke};

use magician_host::{Given, Setting};

/// What is filled is filled with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum FillType {
    #[default]
    Solid,
    /// Lines at a distance (plotter units; a share of the frame if it says none) in a direction, and whether others cross them.
    Lines {
        spacing: Option<f64>,
        angle: f64,
        crossed: bool,
    },
}

/// The distance of the lines of a hatch that says none, in diagonals of the frame.
const SHARE: f64 = 0.01;

impl Plotter<'_> {
    /// FT: 3 and 4 are lines; all others, shades and patterns of printers too, are an area.
    pub(super) fn fill_type(&mut self, instruction: &Instruction) {
        let number = |nth: usize| instruction.numbers.get(nth).copied();
        self.fill_type = match number(0).unwrap_or(1.0) {
            kind @ (3.0 | 4.0) => FillType::Lines {
                spacing: number(1).filter(|spacing| *spacing > 0.0),
                angle: number(2).unwrap_or(0.0),
                crossed: kind == 4.0,
            },
            _ => FillType::Solid,
        };
    }

    /// Whether what is filled is outlined instead.
    pub(super) fn outlines(&self) -> bool {
        self.fills == Fills::Outline && self.fill_type == FillType::Solid
    }

    /// Fills rings (mm) that belong together; which of them are drawn otherwise too is up to the plot.
    pub(super) fn fill(&mut self, rings: Vec<Vec<[f64; 2]>>, rule: FillRule, by: &Instruction) {
        let origin = self.lines.origin(by.range.clone());
        if self.pen == 0.0 || rings.is_empty() {
            return;
        }
        let style = self.style();
        if let FillType::Lines {
            spacing,
            angle,
            crossed,
        } = self.fill_type
        {
            let [width, height] = self.scale.span();
            let spacing = match spacing {
                Some(spacing) => spacing * self.scale.unit(),
                None => libm::hypot(width, height) * SHARE,
            };
            let mut lines = self.hatched(&rings, spacing, angle);
            if crossed {
                let others = self.hatched(&rings, spacing, angle + 90.0);
                lines = lines.and_then(|lines| Some([lines, others?].concat()));
            }
            match lines {
                Some(lines) => lines.into_iter().for_each(|line| {
                    let points = line.to_vec();
                    self.put(Stroke {
                        points,
                        origin,
                        style,
                    });
                }),
                None => self.note(by, "a hatch of too many lines is left out"),
            }
            return;
        }
        match self.fills {
            Fills::Ignore => {}
            Fills::Areas => {
                let whole = Area { rings, rule };
                let area = match self.window {
                    Some(window) => whole.within(window),
                    None => whole,
                };
                self.artwork.areas.push(FilledArea {
                    area,
                    origin,
                    style,
                });
            }
            Fills::Outline => {
                for mut points in rings {
                    points.extend(points.first().copied());
                    points.dedup();
                    self.put(Stroke {
                        points,
                        origin,
                        style,
                    });
                }
                let message = "filled shapes are drawn as outlines";
                self.notes
                    .add_with(DiagnosticCode::Assumed, origin, message, |note| {
                        note.remedy((Setting::Fill, Given::Word("hatch")), "fills them")
                    });
            }
        }
    }

    /// Lines in a direction of the plot; counted from its origin, so that those of neighbours go on.
    fn hatched(
        &self,
        rings: &[Vec<[f64; 2]>],
        spacing: f64,
        angle: f64,
    ) -> Option<Vec<[[f64; 2]; 2]>> {
        let (sin, cos) = libm::sincos(angle.to_radians());
        let [along, up] = [[cos, sin], [-sin, cos]].map(|way| self.scale.turned(way));
        let family = LineFamily {
            angle: libm::atan2(along[1], along[0]).to_degrees(),
            base: self.scale.place([0.0; 2]),
            offset: up.map(|side| side * spacing),
            dashes: Vec::new(),
        };
        family.within(rings)
    }
}
