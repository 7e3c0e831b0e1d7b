//! State of the plotter: pen, position, and the drawing so far.

use std::ops::Range;

use magician_host::{Message, message};

use super::Notes;
use super::areas::FillType;
use super::figures::{DEFAULT_TICK_LENGTHS, ticks};
use super::lexer::Instruction;
use super::scale::Scale;
use super::text::LabelStyle;
use crate::artwork::{Layer, Style};
use crate::formats::span::SpanDiagnostic;
use crate::formats::{Chords, Fills, ReadOptions};
use crate::lettering::Lettering;
use crate::{Artwork, Diagnostic, DiagnosticCode, Lines, Stroke};

/// Largest number of pens that become layers. A choice above any plotter; further pens have no
/// layer.
const MAX_PENS: usize = 100;
/// Largest coordinate, mm. A choice above any sheet, which detects damaged files.
const MAX_COORDINATE: f64 = 1e5;

/// Stroke being drawn.
#[derive(Debug)]
pub(super) struct OpenStroke {
    points: Vec<[f64; 2]>,
    range: Range<usize>,
    style: Style,
    /// True if the stroke becomes a dot unless the pen moves.
    pub(super) dot: bool,
}

pub(super) struct Plotter<'t> {
    options: &'t ReadOptions,
    pub(super) fills: Fills,
    pub(super) artwork: Artwork,
    pub(super) chords: &'t Chords,
    pub(super) lines: &'t Lines<'t>,
    pub(super) notes: Notes,
    pub(super) scale: Scale,
    /// Position, in units of the plot.
    pub(super) at: [f64; 2],
    pub(super) down: bool,
    pub(super) relative: bool,
    /// Pen number; 0 is no pen.
    pub(super) pen: f64,
    pub(super) open: Option<OpenStroke>,
    /// Within a polygon: index of the current part's first stroke. Strokes are then collected
    /// instead of drawn.
    pub(super) polygon: Option<usize>,
    /// Strokes of the last polygon.
    pub(super) edges: Vec<Stroke>,
    /// Vertices of the last polygon, including those reached with the pen up.
    pub(super) rings: Vec<Vec<[f64; 2]>>,
    /// True if the outline of the last polygon was drawn.
    pub(super) outlined: bool,
    pub(super) fill_type: FillType,
    pub(super) labels: LabelStyle,
    /// Symbol drawn at each point (SM).
    pub(super) symbol: Option<char>,
    /// Length of tick marks in both directions, percent of the distance between P1 and P2.
    pub(super) tick: [f64; 2],
    /// Buffered label (BL).
    buffered_label: String,
    /// Font of labels, loaded at the first one.
    lettering: Option<Lettering>,
    /// Clip window (IW), mm.
    pub(super) window: Option<[[f64; 2]; 2]>,
    /// True if characters above 127 are single bytes in the file.
    latin: bool,
}

impl<'t> Plotter<'t> {
    pub(super) fn new(
        options: &'t ReadOptions,
        chords: &'t Chords,
        lines: &'t Lines<'t>,
        latin: bool,
    ) -> Self {
        let artwork = Artwork {
            title: options.title.clone(),
            ..Artwork::default()
        };
        Self {
            options,
            fills: options.fills,
            artwork,
            chords,
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
            rings: Vec::new(),
            outlined: false,
            fill_type: FillType::default(),
            labels: LabelStyle::default(),
            symbol: None,
            tick: DEFAULT_TICK_LENGTHS,
            buffered_label: String::new(),
            lettering: None,
            window: None,
            latin,
        }
    }

    /// Returns a text as the bytes that it has in the file.
    pub(super) fn bytes_of(&self, text: &str) -> Vec<u8> {
        if self.latin {
            text.chars()
                .filter_map(|sign| u8::try_from(u32::from(sign)).ok())
                .collect()
        } else {
            text.as_bytes().to_vec()
        }
    }

    pub(super) fn finish(mut self) -> (Artwork, Vec<Diagnostic>) {
        self.lift();
        self.end_polygon();
        self.artwork.page = self.scale.page();
        (self.artwork, self.notes.into_diagnostics())
    }

    pub(super) fn note(&mut self, instruction: &Instruction, message: Message) {
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
            // Every plot begins with defaults, as after IN (HP-GL/2).
            b"IN" | b"BP" => self.reset(true),
            b"DF" => self.reset(false),
            b"IP" | b"IR" | b"PS" | b"RO" | b"SC" => self.scaled(instruction)?,
            b"IW" => self.windowed(instruction)?,
            b"LB" => self.label(&instruction.text, instruction)?,
            b"BL" => self.buffered_label.clone_from(&instruction.text),
            b"PB" => self.label(&self.buffered_label.clone(), instruction)?,
            b"SI" | b"SR" | b"DI" | b"DR" | b"DV" | b"SL" | b"LO" | b"ES" => {
                self.label_style(instruction)?;
            }
            b"TL" => self.tick = ticks(instruction),
            b"XT" | b"YT" => self.tick_mark(instruction)?,
            b"CP" => self.character_plot(instruction)?,
            b"FT" => self.fill_type(instruction),
            b"SM" => {
                let symbol = instruction.text.trim_end_matches(';').chars().next();
                self.symbol = symbol.filter(|symbol| !symbol.is_whitespace());
            }
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

    /// Handles instructions that draw nothing, and unknown ones.
    fn other(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let name = instruction.name();
        match name.as_str() {
            "LT" if !instruction.numbers.is_empty() => {
                self.note(
                    instruction,
                    message!("line types (LT) are left out: all lines are solid"),
                );
            }
            // Pen speed and force, widths, colours, label styles, fills, the plotter and its paper:
            // no effect on lines.
            "LT" | "VS" | "VA" | "VN" | "FS" | "AS" | "PW" | "WU" | "PT" | "PC" | "NP" | "CR"
            | "CO" | "LA" | "LM" | "SD" | "AD" | "CS" | "CA" | "SS" | "SA" | "DT" | "AC" | "UL"
            | "SV" | "TR" | "MC" | "PP" | "RF" | "SB" | "TD" | "DL" | "PG" | "AF" | "AH" | "EC"
            | "QL" | "MG" | "MT" | "ST" | "NR" | "RP" | "CM" | "CT" | "CV" | "CF" | "IM" | "IV"
            | "FI" | "FN" | "GM" | "WD" | "OA" | "OB" | "OC" | "OD" | "OE" | "OF" | "OG" | "OH"
            | "OI" | "OK" | "OL" | "OO" | "OP" | "OS" | "OT" | "OW" => {}
            _ if name.starts_with('!') => {
                let message = message!(
                    "{text}, an instruction of Roland's own, is left out",
                    text = instruction.text
                );
                self.note(instruction, message);
            }
            _ => self.note(instruction, message!("{name} is left out", name)),
        }
        Ok(())
    }

    pub(super) fn select(&mut self, pen: f64) {
        self.end_stroke();
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
        let style = self.style();
        let points = vec![self.scale.place(self.at)];
        self.open = Some(OpenStroke {
            points,
            range,
            style,
            dot,
        });
    }

    /// Returns the style of a stroke drawn now. The pen is its layer.
    pub(super) fn style(&mut self) -> Style {
        let layer = Layer {
            name: Some(format!("pen {}", self.pen)),
            inkscape: false,
        };
        let layer = if self.artwork.layers.len() < MAX_PENS {
            self.artwork.layer(&layer)
        } else {
            0
        };
        Style {
            layer,
            ..Style::default()
        }
    }

    /// Returns the font of labels.
    pub(super) fn lettering(&mut self) -> Result<&Lettering, SpanDiagnostic> {
        if self.lettering.is_none() {
            let lettering = Lettering::new(self.options, self.chords.for_curve());
            self.lettering = Some(lettering.map_err(|wrong| SpanDiagnostic::of(0..0, wrong))?);
        }
        self.lettering
            .as_ref()
            .ok_or_else(|| SpanDiagnostic::new(0..0, message!("there is no font")))
    }

    pub(super) fn lift(&mut self) {
        self.down = false;
        self.end_stroke();
    }

    /// Ends the stroke; the next one begins with the next line.
    pub(super) fn end_stroke(&mut self) {
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

    /// Moves to each point of an instruction.
    fn go(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        for to in pairs(instruction, self.relative.then_some(&mut self.at.clone()))? {
            self.line(to, instruction)?;
            self.labels.moved();
            self.symbol(instruction)?;
        }
        Ok(())
    }

    /// Moves to a point with the pen in its current state.
    pub(super) fn line(
        &mut self,
        to: [f64; 2],
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        self.check_point(to, instruction)?;
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
        if self.polygon.is_some()
            && let Some(ring) = self.rings.last_mut()
        {
            ring.push(place);
        }
        self.at = to;
        Ok(())
    }

    /// Checks that a point is within any sheet.
    pub(super) fn check_point(
        &self,
        to: [f64; 2],
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        self.check_on_sheet(self.scale.place(to), instruction)
    }

    pub(super) fn check_on_sheet(
        &self,
        [x, y]: [f64; 2],
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        if x.abs().max(y.abs()) <= MAX_COORDINATE {
            return Ok(());
        }
        let message = message!("the pen would be at {x:.0}, {y:.0} mm", x, y);
        Err(SpanDiagnostic::new(instruction.range.clone(), message))
    }
}

/// Returns the points of an instruction. Relative ones count from the previous point, the first
/// from `from`.
pub(super) fn pairs(
    instruction: &Instruction,
    mut from: Option<&mut [f64; 2]>,
) -> Result<Vec<[f64; 2]>, SpanDiagnostic> {
    let (pairs, rest) = instruction.numbers.as_chunks::<2>();
    if !rest.is_empty() {
        let message = message!("{name} has an x without a y", name = instruction.name());
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
