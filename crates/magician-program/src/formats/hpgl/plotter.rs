//! The plotter: where its pen is, and what it has drawn.

use std::ops::Range;

use super::Notes;
use super::lexer::Instruction;
use super::scale::Scale;
use super::text::Texts;
use crate::artwork::{Layer, Style};
use crate::formats::span::SpanDiagnostic;
use crate::{Artwork, Diagnostic, DiagnosticCode, Lines, Stroke};

/// As many pens are told apart.
const MOST_PENS: usize = 100;
/// No sheet is as large, mm.
const LARGEST: f64 = 1e5;

/// A stroke that is being drawn.
#[derive(Debug)]
pub(super) struct Open {
    points: Vec<[f64; 2]>,
    range: Range<usize>,
    style: Style,
    /// It is to be a dot if the pen goes nowhere.
    pub(super) dot: bool,
}

#[derive(Debug)]
pub(super) struct Plotter<'t> {
    pub(super) artwork: Artwork,
    pub(super) tolerance: f64,
    pub(super) lines: &'t Lines<'t>,
    pub(super) notes: Notes,
    pub(super) scale: Scale,
    /// In the plot's units.
    pub(super) at: [f64; 2],
    pub(super) down: bool,
    pub(super) relative: bool,
    /// 0 is none.
    pub(super) pen: f64,
    pub(super) open: Option<Open>,
    /// Within a polygon strokes are gathered and not drawn.
    pub(super) polygon: Option<usize>,
    /// The strokes of the last one.
    pub(super) edges: Vec<Stroke>,
    pub(super) texts: Texts,
    /// What is outside of this is not drawn (IW), mm.
    pub(super) window: Option<[[f64; 2]; 2]>,
    /// Whether characters above 127 are single bytes of the file.
    latin: bool,
}

impl<'t> Plotter<'t> {
    pub(super) fn new(title: &str, tolerance: f64, lines: &'t Lines<'t>, latin: bool) -> Self {
        let artwork = Artwork {
            title: title.to_owned(),
            ..Artwork::default()
        };
        Self {
            artwork,
            tolerance,
            lines,
            notes: Notes::default(),
            scale: Scale::default(),
            at: [0.0; 2],
            down: false,
            relative: false,
            pen: 1.0,
            open: None,
            polygon: None,
            edges: Vec::new(),
            texts: Texts::default(),
            window: None,
            latin,
        }
    }

    /// A text of the file as the bytes that it is there.
    pub(super) fn bytes_of(&self, text: &str) -> Vec<u8> {
        match self.latin {
            true => text
                .chars()
                .filter_map(|sign| u8::try_from(u32::from(sign)).ok())
                .collect(),
            false => text.as_bytes().to_vec(),
        }
    }

    pub(super) fn finish(mut self) -> (Artwork, Vec<Diagnostic>) {
        self.lift();
        self.end_polygon();
        self.tell_texts();
        self.artwork.page = self.scale.page();
        (self.artwork, self.notes.into_diagnostics())
    }

    pub(super) fn note(&mut self, instruction: &Instruction, message: &str) {
        let origin = self.lines.origin(instruction.range.clone());
        self.notes.add(DiagnosticCode::LeftOut, origin, message);
    }

    pub(super) fn take(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        match &instruction.name {
            b"PU" => {
                self.lift();
                self.go(instruction)?;
            }
            b"PD" => {
                self.lower(instruction);
                self.go(instruction)?;
            }
            b"PA" | b"PR" => {
                self.relative = &instruction.name == b"PR";
                self.go(instruction)?;
            }
            b"SP" => {
                self.select(instruction.numbers.first().copied().unwrap_or(0.0));
            }
            b"PE" => self.encoded(instruction)?,
            // Every plot begins anew, as IN does (HP-GL/2).
            b"IN" | b"BP" => self.reset(true),
            b"DF" => self.reset(false),
            b"IP" | b"IR" | b"PS" | b"RO" | b"SC" => self.scaled(instruction)?,
            b"IW" => self.windowed(instruction)?,
            b"LB" => self.text(instruction),
            b"AT" | b"RT" => {
                let from = if &instruction.name == b"RT" {
                    self.at
                } else {
                    [0.0; 2]
                };
                self.arc_through(from, instruction)?;
            }
            b"CI" | b"AA" | b"AR" | b"EA" | b"ER" | b"RA" | b"RR" | b"EW" | b"WG" | b"BZ"
            | b"BR" => {
                self.figure(instruction)?;
            }
            b"PM" => self.polygon(instruction),
            b"EP" | b"FP" => self.edge(instruction),
            _ => self.other(instruction)?,
        }
        Ok(())
    }

    /// What draws nothing, and what is not understood.
    fn other(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let name = instruction.name();
        match name.as_str() {
            "LT" if !instruction.numbers.is_empty() => {
                self.note(
                    instruction,
                    "line types (LT) are left out: all lines are solid",
                );
            }
            // Pen speed and force, widths, colours, label styles, fills, the plotter and its paper.
            "LT" | "VS" | "VA" | "VN" | "FS" | "AS" | "PW" | "WU" | "PT" | "PC" | "NP" | "CR"
            | "CO" | "LA" | "LO" | "LM" | "DI" | "DR" | "DV" | "SI" | "SR" | "SL" | "SD" | "AD"
            | "CS" | "CA" | "SS" | "SA" | "CP" | "ES" | "DT" | "FT" | "AC" | "UL" | "SV" | "TR"
            | "MC" | "PP" | "RF" | "SB" | "TD" | "DL" | "PG" | "AF" | "AH" | "EC" | "QL" | "MG"
            | "MT" | "ST" | "NR" | "RP" | "CM" | "CT" | "CV" | "CF" | "IM" | "IV" | "FI" | "FN"
            | "GM" | "TL" | "BL" | "WD" | "OA" | "OB" | "OC" | "OD" | "OE" | "OF" | "OG" | "OH"
            | "OI" | "OK" | "OL" | "OO" | "OP" | "OS" | "OT" | "OW" => {}
            // SM switches off symbols at each point.
            "SM" if matches!(instruction.text.as_str(), "" | ";") => {}
            _ => self.note(instruction, &format!("{name} is left out")),
        }
        Ok(())
    }

    pub(super) fn select(&mut self, pen: f64) {
        self.lift_for_a_moment();
        self.pen = pen;
    }

    pub(super) fn draws(&self) -> bool {
        self.down && self.pen != 0.0
    }

    fn lower(&mut self, instruction: &Instruction) {
        self.down = true;
        if self.draws() && self.open.is_none() {
            self.begin(instruction.range.clone(), true);
        }
    }

    pub(super) fn begin(&mut self, range: Range<usize>, dot: bool) {
        let layer = Layer {
            name: Some(format!("pen {}", self.pen)),
            inkscape: false,
        };
        let layer = match self.artwork.layers.len() < MOST_PENS {
            true => self.artwork.layer(&layer),
            false => 0,
        };
        let points = vec![self.scale.place(self.at)];
        self.open = Some(Open {
            points,
            range,
            style: Style {
                layer,
                ..Style::default()
            },
            dot,
        });
    }

    pub(super) fn lift(&mut self) {
        self.down = false;
        self.lift_for_a_moment();
    }

    /// Ends the stroke; the next one begins with the next line.
    pub(super) fn lift_for_a_moment(&mut self) {
        if let Some(open) = self
            .open
            .take()
            .filter(|open| open.dot || open.points.len() > 1)
        {
            let origin = self.lines.origin(open.range);
            let points = open.points;
            self.add(Stroke {
                points,
                origin,
                style: open.style,
            });
        }
    }

    fn add(&mut self, stroke: Stroke) {
        if self.polygon.is_some() {
            self.edges.push(stroke);
        } else {
            self.put(stroke);
        }
    }

    /// To each of the points of an instruction.
    fn go(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        for to in pairs(instruction, self.relative.then_some(&mut self.at.clone()))? {
            self.line(to, instruction)?;
        }
        Ok(())
    }

    /// Goes to a point, with the pen as it is.
    pub(super) fn line(
        &mut self,
        to: [f64; 2],
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        self.fits(to, instruction)?;
        let place = self.scale.place(to);
        if self.draws() {
            if self.open.is_none() {
                self.begin(instruction.range.clone(), false);
            }
            if let Some(open) = &mut self.open {
                open.range.end = instruction.range.end;
                if open.points.last() != Some(&place) {
                    open.points.push(place);
                }
            }
        }
        self.at = to;
        Ok(())
    }

    /// Whether a point is on any sheet.
    pub(super) fn fits(
        &self,
        to: [f64; 2],
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        let [x, y] = self.scale.place(to);
        if x.abs().max(y.abs()) <= LARGEST {
            return Ok(());
        }
        let message = format!("the pen would be at {x:.0}, {y:.0} mm");
        Err(SpanDiagnostic::new(instruction.range.clone(), message))
    }
}

/// The points of an instruction. Relative ones count from the one before, `from` at first.
pub(super) fn pairs(
    instruction: &Instruction,
    mut from: Option<&mut [f64; 2]>,
) -> Result<Vec<[f64; 2]>, SpanDiagnostic> {
    let (pairs, rest) = instruction.numbers.as_chunks::<2>();
    if !rest.is_empty() {
        let message = format!("{} has an x without a y", instruction.name());
        return Err(SpanDiagnostic::new(instruction.range.clone(), message));
    }
    let places = pairs.iter().map(|[x, y]| match &mut from {
        Some(from) => {
            **from = [from[0] + x, from[1] + y];
            **from
        }
        None => [*x, *y],
    });
    Ok(places.collect())
}
