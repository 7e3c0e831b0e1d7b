//! The plotter: where its pen is, and what it has drawn.

use std::ops::Range;

use super::Notes;
use super::curves;
use super::lexer::{Flaw, Instruction};
use super::scale::Scale;
use crate::artwork::distance;
use crate::{Artwork, Lines, Problem, Stroke};

/// No sheet is as large, mm.
const LARGEST: f64 = 1e5;
/// More turns than this are no arc of a drawing, degrees.
const WIDEST: f64 = 36_000.0;

/// A stroke that is being drawn.
#[derive(Debug)]
struct Open {
    points: Vec<[f64; 2]>,
    range: Range<usize>,
    /// It is to be a dot if the pen goes nowhere.
    dot: bool,
}

#[derive(Debug)]
pub(super) struct Plotter<'t> {
    artwork: Artwork,
    tolerance: f64,
    lines: &'t Lines<'t>,
    notes: Notes,
    scale: Scale,
    /// In the plot's units.
    at: [f64; 2],
    down: bool,
    relative: bool,
    /// 0 is none.
    pen: f64,
    /// The pens that have drawn.
    pens: Vec<f64>,
    open: Option<Open>,
    /// Within a polygon strokes are gathered and not drawn.
    polygon: Option<usize>,
    /// The strokes of the last one.
    edges: Vec<Stroke>,
}

impl<'t> Plotter<'t> {
    pub(super) fn new(title: &str, tolerance: f64, lines: &'t Lines<'t>) -> Self {
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
            pens: Vec::new(),
            open: None,
            polygon: None,
            edges: Vec::new(),
        }
    }

    pub(super) fn finish(mut self) -> (Artwork, Vec<Problem>) {
        self.lift();
        self.end_polygon();
        if self.pens.len() > 1 {
            let pens: Vec<_> = self.pens.iter().map(ToString::to_string).collect();
            let message = format!("pens {} draw alike: there is one", pens.join(", "));
            self.notes.add(crate::Origin::NONE, &message);
        }
        (self.artwork, self.notes.into_problems())
    }

    fn note(&mut self, instruction: &Instruction, message: &str) {
        self.notes
            .add(self.lines.origin(instruction.range.clone()), message);
    }

    pub(super) fn take(&mut self, instruction: &Instruction) -> Result<(), Flaw> {
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
                self.lift_for_a_moment();
                self.pen = instruction.numbers.first().copied().unwrap_or(0.0);
            }
            b"IN" | b"DF" => self.reset(&instruction.name == b"IN"),
            b"IP" => self.scale.corners(instruction)?,
            b"SC" => {
                // What has been drawn of a stroke is on the sheet; the pen's place has other numbers now.
                self.lift_for_a_moment();
                self.scale.units(instruction)?;
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
    fn other(&mut self, instruction: &Instruction) -> Result<(), Flaw> {
        let name = instruction.name();
        match name.as_str() {
            "LB" => {
                self.note(instruction, "text (LB) is left out: write it as curves");
            }
            "LT" if !instruction.numbers.is_empty() => {
                self.note(
                    instruction,
                    "line types (LT) are left out: all lines are drawn through",
                );
            }
            "PE" => {
                return Err(Flaw::new(
                    instruction.range.clone(),
                    "encoded polylines (PE) are not read",
                )
                .help("write the plot as plain HPGL, with PU and PD"));
            }
            "RO" if instruction
                .numbers
                .first()
                .is_none_or(|angle| *angle == 0.0) => {}
            "RO" | "AT" | "RT" => {
                let message = format!("{name} is not done here");
                return Err(Flaw::new(instruction.range.clone(), message));
            }
            // Pen speed and force, widths, colours, label styles, fills, the plotter and its paper.
            "LT" | "VS" | "VA" | "VN" | "FS" | "AS" | "PW" | "WU" | "PT" | "PC" | "NP" | "CR"
            | "CO" | "LA" | "LO" | "DI" | "DR" | "DV" | "SI" | "SR" | "SL" | "SD" | "AD" | "CS"
            | "CA" | "SS" | "SA" | "CP" | "ES" | "DT" | "FT" | "AC" | "UL" | "SV" | "TR" | "MC"
            | "PG" | "AF" | "AH" | "EC" | "BP" | "PS" | "QL" | "MG" | "MT" | "ST" | "NR" | "RP"
            | "IW" | "OE" | "OI" | "OS" | "OA" | "OH" | "OP" => {}
            _ => self.note(instruction, &format!("{name} is left out")),
        }
        Ok(())
    }

    fn reset(&mut self, moves: bool) {
        self.lift();
        self.end_polygon();
        self.edges.clear();
        (self.scale, self.relative) = (Scale::default(), false);
        if moves {
            self.at = [0.0; 2];
        }
    }

    fn draws(&self) -> bool {
        self.down && self.pen != 0.0
    }

    fn lower(&mut self, instruction: &Instruction) {
        self.down = true;
        if self.draws() && self.open.is_none() {
            self.begin(instruction.range.clone(), true);
        }
    }

    fn begin(&mut self, range: Range<usize>, dot: bool) {
        if !self.pens.contains(&self.pen) && self.pens.len() < 100 {
            self.pens.push(self.pen);
        }
        let points = vec![self.scale.place(self.at)];
        self.open = Some(Open { points, range, dot });
    }

    fn lift(&mut self) {
        self.down = false;
        self.lift_for_a_moment();
    }

    /// Ends the stroke; the next one begins with the next line.
    fn lift_for_a_moment(&mut self) {
        if let Some(open) = self
            .open
            .take()
            .filter(|open| open.dot || open.points.len() > 1)
        {
            let origin = self.lines.origin(open.range);
            let points = open.points;
            self.add(Stroke { points, origin });
        }
    }

    fn add(&mut self, stroke: Stroke) {
        if self.polygon.is_some() {
            self.edges.push(stroke);
        } else {
            self.artwork.strokes.push(stroke);
        }
    }

    /// To each of the points of an instruction.
    fn go(&mut self, instruction: &Instruction) -> Result<(), Flaw> {
        for to in pairs(instruction, self.relative.then_some(&mut self.at.clone()))? {
            self.line(to, instruction)?;
        }
        Ok(())
    }

    /// Goes to a point, with the pen as it is.
    fn line(&mut self, to: [f64; 2], instruction: &Instruction) -> Result<(), Flaw> {
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
    fn fits(&self, to: [f64; 2], instruction: &Instruction) -> Result<(), Flaw> {
        let [x, y] = self.scale.place(to);
        if x.abs().max(y.abs()) <= LARGEST {
            return Ok(());
        }
        let message = format!("the pen would be at {x:.0}, {y:.0} mm");
        Err(Flaw::new(instruction.range.clone(), message))
    }

    /// Arcs, circles, rectangles, wedges and curves.
    fn figure(&mut self, instruction: &Instruction) -> Result<(), Flaw> {
        let numbers = &instruction.numbers[..];
        let needs = |what: &str| {
            let message = format!("{} needs {what}", instruction.name());
            Flaw::new(instruction.range.clone(), message)
        };
        let [x, y] = self.at;
        let relative = matches!(&instruction.name, b"AR" | b"ER" | b"RR" | b"BR");
        let from = if relative { self.at } else { [0.0; 2] };
        match &instruction.name {
            b"CI" => {
                let radius = *numbers.first().ok_or_else(|| needs("a radius"))?;
                let start = [x + radius, y];
                let circle = self.arc([x, y], start, 360.0, instruction)?;
                self.outline(start, circle, instruction)?;
            }
            b"AA" | b"AR" => {
                let [cx, cy, sweep, ..] = *numbers else {
                    return Err(needs("a centre and an angle"));
                };
                let centre = [from[0] + cx, from[1] + cy];
                for corner in self.arc(centre, self.at, sweep, instruction)? {
                    self.line(corner, instruction)?;
                }
            }
            b"EW" | b"WG" => {
                let [radius, start, sweep, ..] = *numbers else {
                    return Err(needs("a radius and two angles"));
                };
                let (sin, cos) = start.to_radians().sin_cos();
                let first = [x + radius * cos, y + radius * sin];
                let mut wedge = vec![first];
                wedge.extend(self.arc([x, y], first, sweep, instruction)?);
                wedge.push([x, y]);
                self.outline([x, y], wedge, instruction)?;
            }
            b"BZ" | b"BR" => {
                let points = pairs(instruction, None)?;
                for three in points.chunks(3) {
                    let &[a, b, c] = three else {
                        return Err(needs("three points for each curve"));
                    };
                    // Relative ones count from where each curve begins.
                    let from = if relative { self.at } else { [0.0; 2] };
                    let [a, b, c] = [a, b, c].map(|[x, y]| [from[0] + x, from[1] + y]);
                    [a, b, c]
                        .iter()
                        .try_for_each(|point| self.fits(*point, instruction))?;
                    let tolerance = self.tolerance / self.scale.most();
                    for corner in curves::curve([self.at, a, b, c], tolerance) {
                        self.line(corner, instruction)?;
                    }
                }
            }
            _ => {
                let [dx, dy, ..] = *numbers else {
                    return Err(needs("a corner"));
                };
                let [to_x, to_y] = [from[0] + dx, from[1] + dy];
                let corners = vec![[to_x, y], [to_x, to_y], [x, to_y], [x, y]];
                self.outline([x, y], corners, instruction)?;
            }
        }
        if matches!(&instruction.name, b"RA" | b"RR" | b"WG") {
            self.note(instruction, "nothing is filled: filled shapes are outlines");
        }
        Ok(())
    }

    fn arc(
        &self,
        centre: [f64; 2],
        from: [f64; 2],
        sweep: f64,
        instruction: &Instruction,
    ) -> Result<Vec<[f64; 2]>, Flaw> {
        let radius = distance(centre, from);
        let span = |sign: f64| [centre[0] + sign * radius, centre[1] + sign * radius];
        self.fits(span(1.0), instruction)?;
        self.fits(span(-1.0), instruction)?;
        if sweep.abs() > WIDEST {
            let message = format!("an arc of {sweep} degrees goes round too often");
            return Err(Flaw::new(instruction.range.clone(), message));
        }
        let tolerance = self.tolerance / self.scale.most();
        Ok(curves::arc(centre, from, sweep, tolerance))
    }

    /// A closed line of its own; then the pen is where it was, as it was.
    fn outline(
        &mut self,
        start: [f64; 2],
        mut corners: Vec<[f64; 2]>,
        instruction: &Instruction,
    ) -> Result<(), Flaw> {
        // A curve comes back to its first point but for a rounding error.
        if let Some(last) = corners.last_mut() {
            *last = start;
        }
        if let Some(open) = &mut self.open {
            open.dot = false;
        }
        self.lift_for_a_moment();
        if self.pen == 0.0 {
            return Ok(());
        }
        let (at, down) = (self.at, self.down);
        (self.at, self.down) = (start, true);
        let mut corners = corners.into_iter();
        let drawn = corners.try_for_each(|corner| self.line(corner, instruction));
        self.lift_for_a_moment();
        (self.at, self.down) = (at, down);
        drawn
    }

    /// PM: 0 begins a polygon, 1 another part of it, 2 ends it.
    fn polygon(&mut self, instruction: &Instruction) {
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
        if let (Some((begin, end)), Some(last)) = (ends, self.edges.last_mut()) {
            if begin != end {
                last.points.push(begin);
            }
        }
        self.polygon = Some(self.edges.len());
    }

    fn end_polygon(&mut self) {
        if self.polygon.take().is_some() && !self.edges.is_empty() {
            self.notes.add(
                crate::Origin::NONE,
                "a polygon (PM) without an end is left out",
            );
        }
    }

    /// EP and FP: the polygon's outline.
    fn edge(&mut self, instruction: &Instruction) {
        if &instruction.name == b"FP" {
            self.note(instruction, "nothing is filled: filled shapes are outlines");
            // Programs draw the edge of what they fill, too.
            if self.edges.is_empty() {
                return;
            }
        }
        self.artwork.strokes.append(&mut self.edges);
    }
}

/// The points of an instruction. Relative ones count from the one before, `from` at first.
fn pairs(
    instruction: &Instruction,
    mut from: Option<&mut [f64; 2]>,
) -> Result<Vec<[f64; 2]>, Flaw> {
    let (pairs, rest) = instruction.numbers.as_chunks::<2>();
    if !rest.is_empty() {
        let message = format!("{} has an x without a y", instruction.name());
        return Err(Flaw::new(instruction.range.clone(), message));
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
