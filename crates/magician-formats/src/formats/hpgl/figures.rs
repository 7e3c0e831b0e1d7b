//! Figures: arcs, circles, rectangles, wedges, curves and tick marks.

use magician_host::{Message, message};

use super::curves;
use super::lexer::Instruction;
use super::plotter::{Plotter, pairs};
use crate::Stroke;
use crate::artwork::{circle_through, distance};
use crate::fill::FillRule;
use crate::formats::span::SpanDiagnostic;

/// Largest sweep of an arc, degrees: a hundred turns. A choice that bounds memory.
const MAX_SWEEP: f64 = 36_000.0;

/// Default length of tick marks in both directions, percent of the distance between P1 and P2.
pub(super) const DEFAULT_TICK_LENGTHS: [f64; 2] = [0.5, 0.5];

/// Parses TL. A single number applies to the positive direction only.
pub(super) fn ticks(instruction: &Instruction) -> [f64; 2] {
    match instruction.numbers[..] {
        [] => DEFAULT_TICK_LENGTHS,
        [forth] => [forth, 0.0],
        [forth, back, ..] => [forth, back],
    }
}

fn needs(instruction: &Instruction, what: Message) -> SpanDiagnostic {
    let message = message!("{name} needs {what}", name = instruction.name(), what);
    SpanDiagnostic::new(instruction.range.clone(), message)
}

impl Plotter<'_> {
    /// Draws a figure.
    pub(super) fn figure(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let relative = matches!(&instruction.name, b"AR" | b"ER" | b"RR" | b"BR");
        let from = if relative { self.at } else { [0.0; 2] };
        match &instruction.name {
            b"CI" => self.circle(instruction)?,
            b"AA" | b"AR" => self.arc_on(from, instruction)?,
            b"EW" | b"WG" => self.wedge(instruction)?,
            b"BZ" | b"BR" => self.curves(relative, instruction)?,
            _ => self.rectangle(from, instruction)?,
        }
        Ok(())
    }

    /// Handles XT and YT: a tick mark across an axis at the pen's position.
    pub(super) fn tick_mark(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let [width, height] = self.scale.span();
        let way = match &instruction.name {
            b"XT" => self.scale.turned([0.0, height / 100.0]),
            _ => self.scale.turned([width / 100.0, 0.0]),
        };
        let place = self.scale.place(self.at);
        let at = |share: f64| [0, 1].map(|side| place[side] + way[side] * share);
        let points = vec![at(self.tick[0]), at(-self.tick[1])];
        for point in &points {
            self.check_on_sheet(*point, instruction)?;
        }
        if self.pen != 0.0 && points[0] != points[1] {
            let style = self.style();
            let origin = self.lines.origin(instruction.range.clone());
            self.put(Stroke {
                points,
                origin,
                style,
            });
        }
        Ok(())
    }

    fn circle(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let &[radius, ..] = &instruction.numbers[..] else {
            return Err(needs(instruction, message!("a radius")));
        };
        let [x, y] = self.at;
        let start = [x + radius, y];
        let circle = self.arc([x, y], start, 360.0, instruction)?;
        self.outline(start, circle, instruction)
    }

    /// Draws an arc from the pen's position.
    fn arc_on(&mut self, from: [f64; 2], instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let &[x, y, sweep, ..] = &instruction.numbers[..] else {
            return Err(needs(instruction, message!("a centre and an angle")));
        };
        let centre = [from[0] + x, from[1] + y];
        let corners = self.arc(centre, self.at, sweep, instruction)?;
        let mut corners = corners.into_iter();
        corners.try_for_each(|corner| self.line(corner, instruction))
    }

    /// Draws an arc from the pen's position through a second point to a third: a full circle if the
    /// third equals the start, a line if they are collinear.
    pub(super) fn arc_through(
        &mut self,
        from: [f64; 2],
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        let &[x1, y1, x2, y2, ..] = &instruction.numbers[..] else {
            return Err(needs(instruction, message!("two points")));
        };
        let begin = self.at;
        let [through, end] = [[x1, y1], [x2, y2]].map(|[x, y]| [from[0] + x, from[1] + y]);
        let circle = if begin == end {
            // The second point is opposite on the circle.
            (begin != through).then(|| {
                let centre = [0, 1].map(|axis| f64::midpoint(begin[axis], through[axis]));
                (centre, 360.0)
            })
        } else {
            circle_through(begin, through, end)
        };
        let Some((centre, sweep)) = circle else {
            self.line(through, instruction)?;
            return self.line(end, instruction);
        };
        for corner in self.arc(centre, begin, sweep, instruction)? {
            self.line(corner, instruction)?;
        }
        self.line(end, instruction)
    }

    fn wedge(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let &[radius, start, sweep, ..] = &instruction.numbers[..] else {
            return Err(needs(instruction, message!("a radius and two angles")));
        };
        let ([x, y], (sin, cos)) = (self.at, libm::sincos(start.to_radians()));
        let first = [x + radius * cos, y + radius * sin];
        let mut wedge = vec![first];
        wedge.extend(self.arc([x, y], first, sweep, instruction)?);
        wedge.push([x, y]);
        self.outline([x, y], wedge, instruction)
    }

    fn rectangle(
        &mut self,
        from: [f64; 2],
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        let &[across, along, ..] = &instruction.numbers[..] else {
            return Err(needs(instruction, message!("a corner")));
        };
        let [x, y] = self.at;
        let [to_x, to_y] = [from[0] + across, from[1] + along];
        let corners = vec![[to_x, y], [to_x, to_y], [x, to_y], [x, y]];
        self.outline([x, y], corners, instruction)
    }

    /// Draws Bézier curves from the pen's position. Relative ones count from the start of each.
    fn curves(&mut self, relative: bool, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        for three in pairs(instruction, None)?.chunks(3) {
            let &[a, b, c] = three else {
                return Err(needs(instruction, message!("three points for each curve")));
            };
            let from = if relative { self.at } else { [0.0; 2] };
            let [a, b, c] = [a, b, c].map(|[x, y]| [from[0] + x, from[1] + y]);
            for point in [a, b, c] {
                self.check_point(point, instruction)?;
            }
            let tolerance = self.chords.for_curve() / self.scale.most();
            for corner in curves::curve([self.at, a, b, c], tolerance) {
                self.line(corner, instruction)?;
            }
        }
        Ok(())
    }

    fn arc(
        &self,
        centre: [f64; 2],
        from: [f64; 2],
        sweep: f64,
        instruction: &Instruction,
    ) -> Result<Vec<[f64; 2]>, SpanDiagnostic> {
        let radius = distance(centre, from);
        let span = |sign: f64| [centre[0] + sign * radius, centre[1] + sign * radius];
        self.check_point(span(1.0), instruction)?;
        self.check_point(span(-1.0), instruction)?;
        if sweep.abs() > MAX_SWEEP {
            let message = message!("an arc of {sweep} degrees has too many turns", sweep);
            return Err(SpanDiagnostic::new(instruction.range.clone(), message));
        }
        let tolerance = self.chords.for_curve() / self.scale.most();
        Ok(curves::arc(centre, from, sweep, tolerance))
    }

    /// Draws a closed outline; afterwards the pen is where it was, up or down as before.
    fn outline(
        &mut self,
        start: [f64; 2],
        mut corners: Vec<[f64; 2]>,
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
        // Rounding keeps a curve from ending exactly at its first point.
        if let Some(last) = corners.last_mut() {
            *last = start;
        }
        if let Some(open) = &mut self.open {
            open.dot = false;
        }
        self.end_stroke();
        if self.pen == 0.0 {
            return Ok(());
        }
        let filled = matches!(&instruction.name, b"RA" | b"RR" | b"WG");
        if filled || self.polygon.is_some() {
            for corner in &corners {
                self.check_point(*corner, instruction)?;
            }
            let ring: Vec<_> = corners
                .iter()
                .map(|corner| self.scale.place(*corner))
                .collect();
            if self.polygon.is_none() {
                self.fill(vec![ring], FillRule::NonZero, instruction);
                return Ok(());
            }
            // The circle is a separate part of the polygon.
            self.rings.insert(0, ring);
        }
        let (at, down, rings) = (self.at, self.down, std::mem::take(&mut self.rings));
        (self.at, self.down) = (start, true);
        let mut corners = corners.into_iter();
        let drawn = corners.try_for_each(|corner| self.line(corner, instruction));
        self.end_stroke();
        (self.at, self.down, self.rings) = (at, down, rings);
        drawn
    }
}
