//! Motion of a program: targets, arcs, curves, homing and origins.

use magician_host::{Action, Message, SettingValue, message};

use super::arc::{Arc, ArcForm, Ends, Plane};
use super::begin::ProgramStart;
use super::block::{Block, Code};
use super::emit::CutSettings;
use super::machine::{Machine, Mode};
use super::offsets::Setting;
use super::settings::MAX_SPEED;
use crate::formats::span::SpanDiagnostic;
use crate::{DiagnosticCode, Origin};

pub(super) const AXES: [u8; 3] = *b"XYZ";
/// Word of an arc's centre along each axis.
const CENTRES: [u8; 3] = *b"IJK";
/// Largest coordinate, mm. Beyond it 32-bit coordinates cannot resolve a thousandth of a
/// millimetre.
const MAX_COORDINATE: f64 = 1e6;
/// Largest difference of both radii of an arc even at a coarse tolerance, mm. More is an error in
/// the program and not rounding.
pub(super) const MAX_RADIUS_DIFFERENCE: f64 = 0.5;
/// Largest number of chords per curve. It bounds memory for curves far larger than the arm.
const MAX_CHORDS: f64 = 10_000.0;
/// Largest number of turns of an arc. A choice above any drawing.
const MAX_TURNS: f64 = 100.0;

impl Machine<'_> {
    pub(super) fn motion(&mut self, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        if block.has_any(b"ABCUVW") {
            let message = message!("axes beyond X, Y and Z (A, B, C, U, V, W) are left out");
            self.notes.add(DiagnosticCode::LeftOut, origin, message);
        }
        for code in block.codes.iter().filter(|code| code.letter == b'G') {
            match code.tenths {
                280 | 282 | 300 => self.home(code, block, origin),
                920 => self.set_origin(block, origin),
                921..=923 => self.offsets.reset(code.tenths),
                520 => self.shift(block),
                100 if Setting::of(block).is_some() => return self.set_system(block, origin),
                40 | 281 | 301 => {}
                // All other codes are modal, and `settings` has handled them.
                _ => continue,
            }
            return Ok(());
        }
        if block.has(b'G', 53) && self.options.placed && block.has_any(&AXES) {
            return self.machine_place(block, origin);
        }
        let axes = block.has_any(&AXES);
        match self.mode {
            Mode::None if axes => Err(SpanDiagnostic::new(
                block.range.clone(),
                message!("the line has coordinates but no motion: G80 has ended the last one"),
            )),
            Mode::Travel | Mode::Line if axes => self.straight(block, origin),
            Mode::Curve { cubic } if axes => self.curve(block, cubic, origin),
            Mode::Cycle(cycle) if axes => self.drill(block, cycle, origin),
            Mode::Arc(clockwise) if axes || block.has_any(b"IJKR") => {
                self.arc(block, clockwise, origin)
            }
            _ => Ok(()),
        }
    }

    /// Handles G28 and G30.
    fn home(&mut self, code: &Code, block: &Block, origin: Origin) {
        if self.options.home && code.is(b'G', 28) {
            self.out.home(origin);
            (self.at, self.begin) = ([None; 3], ProgramStart::default());
            return;
        }
        let message = message!(
            "homing ({code}) is left out: the arm stays where it is",
            code = code.to_string()
        );
        self.notes
            .add_with(DiagnosticCode::LeftOut, origin, message, |note| {
                note.remedy(Action::Home, "homes it before the program")
            });
        if self.options.placed && (block.number(b'Z').is_some() || !block.has_any(&AXES)) {
            self.rise(origin);
        }
    }

    /// Handles G53 in a placed program. The machine's origin is unknown, but a move in Z means to
    /// get out of the way.
    fn machine_place(&mut self, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        if self.mode != Mode::Travel {
            let message = message!(
                "G53 uses machine coordinates, which are unknown when a program is placed"
            );
            return Err(SpanDiagnostic::new(block.range.clone(), message)
                .help(message!("use the program's own coordinates"))
                .remedy(
                    (magician_host::Setting::Raw, SettingValue::On),
                    "takes its coordinates as the arm's",
                ));
        }
        let message = message!(
            "machine coordinates (G53) are left out when a program is placed: Z goes to the \
            highest Z of the program"
        );
        self.notes.add(DiagnosticCode::LeftOut, origin, message);
        if block.number(b'Z').is_some() {
            self.rise(origin);
        }
        for (axis, letter) in AXES[..2].iter().enumerate() {
            if block.number(*letter).is_some() {
                self.begin.forget_axis(axis);
            }
        }
        Ok(())
    }

    /// Lifts a pen to the highest Z of the program, unless it is higher.
    fn rise(&mut self, origin: Origin) {
        let is_pen = !self.laser && !self.lifts && self.begin.moved();
        let highest = self.survey.highest_z.filter(|_| is_pen);
        if let (Some(highest), [Some(x), Some(y), Some(z)]) = (highest, self.at)
            && z < highest
        {
            self.out.travel([x, y, highest], origin);
            self.arrive([x, y, highest]);
        }
    }

    /// Handles G92: the current position gets new coordinates.
    fn set_origin(&mut self, block: &Block, origin: Origin) {
        let bare = !block.has_any(b"XYZE");
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(number) = block.number(letter).or(bare.then_some(0.0)) else {
                continue;
            };
            match self.at[axis] {
                Some(at) => {
                    self.offsets.call(axis, at, number * self.unit);
                    self.begin.claim_axis(axis);
                }
                None => self.notes.add_without_start(
                    origin,
                    message!(
                        "G92 is left out where the arm's position is unknown: coordinates stay the arm's"
                    ),
                ),
            }
        }
    }

    /// Handles G52: offset from the origin of the coordinate system.
    fn shift(&mut self, block: &Block) {
        for (axis, letter) in AXES.into_iter().enumerate() {
            if let Some(number) = block.number(letter) {
                self.offsets.shift(axis, number * self.unit);
            }
        }
    }

    /// Handles G10: origin of a coordinate system.
    fn set_system(&mut self, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        let Some(setting) = Setting::of(block).filter(|setting| *setting != Setting::Tool) else {
            let message = message!("the table of tools (G10 L1, L10, L11) is left out");
            self.notes.add(DiagnosticCode::LeftOut, origin, message);
            return Ok(());
        };
        let missing = self.offsets.set(setting, block, self.unit, self.at)?;
        if missing.contains(&true) {
            let message = message!(
                "G10 L20 is left out where the arm's position is unknown: coordinates stay the arm's"
            );
            self.notes.add_without_start(origin, message);
        }
        if setting == Setting::Here {
            for (axis, letter) in AXES.into_iter().enumerate() {
                if block.number(letter).is_some() && !missing[axis] {
                    self.begin.claim_axis(axis);
                }
            }
        }
        Ok(())
    }

    /// Returns the target of a line, as far as known.
    pub(super) fn target(&self, block: &Block) -> Result<[Option<f64>; 3], SpanDiagnostic> {
        let mut to = self.at;
        let zero = self.offsets.zero();
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(number) = block.number(letter) else {
                continue;
            };
            let number = number * self.unit;
            let place = if block.has(b'G', 53) {
                number
            } else if !self.relative {
                number + zero[axis]
            } else if let Some(at) = self.at[axis] {
                at + number
            } else {
                let letter = char::from(letter);
                let message = message!(
                    "{letter} is relative to the arm's position, which is unknown",
                    letter
                );
                let error = SpanDiagnostic::new(block.range_of(AXES[axis]), message);
                return Err(error.without_start());
            };
            if place.abs() > MAX_COORDINATE {
                let axis = char::from(letter);
                let message = message!("{axis} would be at {place:.0} mm", axis, place);
                return Err(SpanDiagnostic::new(block.range_of(letter), message));
            }
            to[axis] = Some(place);
        }
        Ok(to)
    }

    pub(super) fn work(&mut self, origin: Origin) -> CutSettings {
        let power = self.percent();
        let feed = self.feed_of_work(origin);
        CutSettings {
            feed: feed.map(|feed| feed.min(MAX_SPEED)),
            power,
            follows: feed.filter(|_| self.follows_speed && power > 0.0),
        }
    }

    fn arc(
        &mut self,
        block: &Block,
        clockwise: bool,
        origin: Origin,
    ) -> Result<(), SpanDiagnostic> {
        let refused = |message: Message| SpanDiagnostic::new(block.range.clone(), message);
        if self.plane != Plane::Xy {
            self.check_known_height(block, origin)?;
        }
        self.note_z(block, origin);
        self.note_first_z(block);
        self.check_defined_start(block)?;
        self.lower();
        self.put_down(origin);
        let from = self.place(self.at, true, origin);
        let from = from.ok_or_else(|| unknown_start(block))?;
        let to = self.target(block)?;
        let to = self.place(to, true, origin).unwrap_or(from);
        let round = self.round(block, from)?;
        let ends = Ends {
            plane: self.plane,
            from,
            to,
            clockwise,
        };
        let turns = turns(block)?;
        let arc = Arc::new(&ends, round, turns, self.tolerance).map_err(refused)?;
        let work = self.work(origin);
        self.out.arc(&arc, work, origin).map_err(refused)?;
        self.arrive(to);
        Ok(())
    }

    /// Executes G5, a cubic Bézier curve with the control points I, J from its start and P, Q from
    /// its end, or G5.1, a quadratic one with the control point I, J. It lies in X and Y; Z changes
    /// linearly.
    fn curve(&mut self, block: &Block, cubic: bool, origin: Origin) -> Result<(), SpanDiagnostic> {
        let refused = |message: Message| Err(SpanDiagnostic::new(block.range.clone(), message));
        if self.plane != Plane::Xy {
            return refused(message!("a curve (G5) lies in the plane of G17 only"));
        }
        self.note_z(block, origin);
        self.note_first_z(block);
        self.check_defined_start(block)?;
        self.lower();
        self.put_down(origin);
        let from = self.place(self.at, true, origin);
        let from = from.ok_or_else(|| unknown_start(block))?;
        let to = self.target(block)?;
        let to = self.place(to, true, origin).unwrap_or(from);
        let handle = |words: [u8; 2]| {
            let given = block.has_any(&words);
            given.then(|| words.map(|word| block.number(word).unwrap_or_default() * self.unit))
        };
        let goes_on = self.curve.filter(|(_, end)| *end == from);
        let first = handle(*b"IJ").or_else(|| {
            let (last, _) = goes_on.filter(|_| cubic)?;
            Some(last.map(|way| -way))
        });
        let Some(first) = first else {
            return refused(message!("the curve does not say how it begins (I, J)"));
        };
        let plus = |at: [f64; 3], way: [f64; 2]| [at[0] + way[0], at[1] + way[1]];
        let [begin, end] = [[from[0], from[1]], [to[0], to[1]]];
        let controls = if cubic {
            let Some(last) = handle(*b"PQ") else {
                return refused(message!("the curve does not say how it ends (P, Q)"));
            };
            self.curve = Some((last, to));
            [plus(from, first), plus(to, last)]
        } else {
            // Degree elevation: the equal cubic curve.
            let middle = plus(from, first);
            let third = |from: f64, to: f64| from + (to - from) * 2.0 / 3.0;
            [begin, end].map(|side| [third(side[0], middle[0]), third(side[1], middle[1])])
        };
        let points = [begin, controls[0], controls[1], end];
        let work = self.work(origin);
        for (share, [x, y]) in bezier(points, self.out.tolerance_of_curve()) {
            let z = from[2] + (to[2] - from[2]) * share;
            self.out.line([x, y, z], work, origin);
        }
        self.arrive(to);
        Ok(())
    }

    /// Checks that Z is known before an arc through Z, whose shape depends on it.
    fn check_known_height(&mut self, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        if self.lifts {
            let message = message!("an arc of G18 or G19 needs Z, and a servo lifts this pen");
            return Err(SpanDiagnostic::new(block.range.clone(), message)
                .help(message!("write it as lines, or in the plane of G17")));
        }
        self.lower_to_draw(origin);
        match self.at[2] {
            Some(_) => Ok(()),
            None => Err(unknown_start(block)),
        }
    }

    fn round(&self, block: &Block, from: [f64; 3]) -> Result<ArcForm, SpanDiagnostic> {
        let [first, second, _] = self.plane.axes();
        let words = [first, second].map(|axis| CENTRES[axis]);
        let centre = block.has_any(&words);
        if let Some(radius) = block.number(b'R') {
            if centre {
                let words = self.plane.centre_words();
                let message = message!(
                    "the arc has both a centre ({words}) and a radius (R)",
                    words
                );
                return Err(SpanDiagnostic::new(block.range.clone(), message));
            }
            return Ok(ArcForm::Radius(radius * self.unit));
        }
        if !centre {
            let words = self.plane.centre_words();
            let message = message!(
                "the arc has neither a centre ({words}) nor a radius (R)",
                words
            );
            return Err(SpanDiagnostic::new(block.range.clone(), message));
        }
        let zero = if self.absolute_centres {
            self.offsets.zero()
        } else {
            from
        };
        let centre = |axis: usize| match block.number(CENTRES[axis]) {
            Some(way) => zero[axis] + way * self.unit,
            None => from[axis],
        };
        Ok(ArcForm::Centre([centre(first), centre(second)]))
    }

    /// Height of a servo-lifted pen over a point.
    pub(super) fn pen_height(&self, point: [f64; 2]) -> f64 {
        let surface = self
            .options
            .surface
            .map_or(0.0, |surface| surface.at(point));
        surface
            + if self.pen_is_down {
                0.0
            } else {
                self.options.lift
            }
    }

    /// Moves a servo-lifted pen up or down.
    pub(super) fn move_pen(&mut self, origin: Origin) {
        if !self.begin.is_own() {
            return;
        }
        if let Some(place) = self.place(self.at, false, origin) {
            self.out.travel(place, origin);
            self.arrive(place);
        }
    }

    pub(super) fn note_z(&mut self, block: &Block, origin: Origin) {
        if self.lifts && block.number(b'Z').is_some() {
            let message =
                message!("Z is left out: a servo lifts the pen, to the heights of the surface");
            self.notes.add(DiagnosticCode::LeftOut, origin, message);
        }
    }
}

/// Iterates over points along a cubic Bézier curve, without the first, each with its parameter.
/// Chords stay within the tolerance.
fn bezier(points: [[f64; 2]; 4], tolerance: f64) -> impl Iterator<Item = (f64, [f64; 2])> {
    let [a, b, c, d] = points;
    let bend = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        let side = |axis: usize| a[axis] - 2.0 * b[axis] + c[axis];
        libm::hypot(side(0), side(1))
    };
    // A chord over a parameter range h deviates by at most h * h / 8 times the second derivative,
    // which is at most 6 times the second difference of the control points.
    let bent = bend(a, b, c).max(bend(b, c, d));
    let count = (0.75 * bent / tolerance).sqrt().ceil();
    let count = count.clamp(1.0, MAX_CHORDS) as u32;
    (1..=count).map(move |nth| {
        let t = f64::from(nth) / f64::from(count);
        let u = 1.0 - t;
        let weights = [u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t];
        let at = [0, 1].map(|axis| (0..4).map(|of| weights[of] * points[of][axis]).sum());
        (t, at)
    })
}

/// Number of additional turns of an arc.
fn turns(block: &Block) -> Result<u32, SpanDiagnostic> {
    match block.number(b'P') {
        None => Ok(0),
        Some(turns) if (1.0..=MAX_TURNS).contains(&turns) && turns.fract() == 0.0 => {
            Ok(turns as u32 - 1)
        }
        Some(turns) => {
            let message = message!(
                "the arc makes {turns} turns, it must be 1 to {most}",
                turns,
                most = MAX_TURNS
            );
            Err(SpanDiagnostic::new(block.range_of(b'P'), message))
        }
    }
}

fn unknown_start(block: &Block) -> SpanDiagnostic {
    let message = message!("this begins at the arm's position, which is unknown");
    SpanDiagnostic::new(block.range.clone(), message).without_start()
}
