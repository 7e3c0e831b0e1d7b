//! Filled areas: rectangles, wedges and polygons, with the fill type of FT.

use super::lexer::Instruction;
use super::plotter::Plotter;
use crate::fill::{Area, FillRule, LineFamily};
use crate::formats::Fills;
use crate::{DiagnosticCode, FilledArea, Stroke};

use magician_host::{Setting, SettingValue, message};

/// Fill type.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum FillType {
    #[default]
    Solid,
    /// Lines with a spacing (plotter units; `None` for a share of the frame), a direction, and true
    /// for a second set across.
    Lines {
        spacing: Option<f64>,
        angle: f64,
        crossed: bool,
    },
}

/// Default spacing of hatch lines, as a share of the frame's diagonal.
const DEFAULT_SPACING_SHARE: f64 = 0.01;

impl Plotter<'_> {
    /// Handles FT: 3 and 4 are lines; all other types, including shades and patterns, are solid.
    pub(super) fn fill_type(&mut self, instruction: &Instruction) {
        let number = |nth: usize| instruction.numbers.get(nth).copied();
        self.fill_type = match number(0).unwrap_or(1.0) {
            kind @ (3.0 | 4.0) => FillType::Lines {
                spacing: number(1).filter(|spacing| *spacing > 0.0),
                angle: number(2).unwrap_or(0.0),
                crossed: kind == 4.0,
            },
            // Shades and patterns are raster fills, so they count as solid.
            _ => FillType::Solid,
        };
    }

    /// True if solid fills are drawn as outlines.
    pub(super) fn outlines(&self) -> bool {
        self.fills == Fills::Outline && self.fill_type == FillType::Solid
    }

    /// Fills rings (mm) of one shape.
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
                None => libm::hypot(width, height) * DEFAULT_SPACING_SHARE,
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
                None => self.note(by, message!("a hatch of too many lines is left out")),
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
                let message = message!("filled shapes are drawn as outlines");
                self.notes
                    .add_with(DiagnosticCode::Assumed, origin, message, |note| {
                        note.remedy((Setting::Fill, SettingValue::Word("hatch")), "fills them")
                    });
            }
        }
    }

    /// Returns hatch lines. They count from the origin of the plot, so that lines of adjacent areas
    /// align.
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
