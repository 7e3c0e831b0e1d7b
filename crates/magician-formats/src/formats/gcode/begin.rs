//! The start of a program: moves before X, Y and Z are all known.
//!
//! A program may move a single axis before it has named all three. Three cases exist: the arm's
//! position is known ([`GcodeOptions::start`](super::GcodeOptions::start)), it is unknown, or the
//! program is placed and starts at its own origin. In each case nothing is drawn from a position
//! that the program does not mean, and the tool is lowered only where the program wants it low.

use magician_host::{Message, message};

use super::block::Block;
use super::machine::{Machine, Mode};
use super::motion::AXES;
use crate::formats::span::SpanDiagnostic;
use crate::{DiagnosticCode, Origin};

fn feed_first() -> Message {
    message!(
        "the program begins with a feed move (G1) from an unknown position: the arm first goes to \
        the end of that move and draws from there"
    )
}

/// State of the program's start.
#[derive(Debug, Default)]
pub(super) struct ProgramStart {
    /// True for X and Y if the program itself has defined it. Otherwise the value is the arm's
    /// position.
    own: [bool; 2],
    /// Origin of a move that waits for X and Y, because the arm's position is unknown.
    pub(super) waiting: Option<Origin>,
    /// Actual height of the tool if it is above the commanded one. It is lowered once X and Y are
    /// known.
    held: Option<(f64, Origin)>,
    /// True once a placed program has given Z.
    says_z: bool,
    /// True while the pen of a program without Z is lifted.
    lifted: bool,
    /// True once a step has moved the tool.
    moved: bool,
}

impl ProgramStart {
    pub(super) fn new(placed: bool) -> Self {
        Self {
            own: [placed; 2],
            ..Self::default()
        }
    }

    /// True if the program has defined X and Y.
    pub(super) fn is_own(&self) -> bool {
        self.own == [true; 2]
    }

    /// True once a step has moved the tool.
    pub(super) fn moved(&self) -> bool {
        self.moved
    }

    /// Marks the position along X or Y as not defined by the program.
    pub(super) fn forget_axis(&mut self, axis: usize) {
        if let Some(own) = self.own.get_mut(axis) {
            *own = false;
        }
    }

    /// Marks the position along an axis as defined by the program (G92).
    pub(super) fn claim_axis(&mut self, axis: usize) {
        if let Some(own) = self.own.get_mut(axis) {
            *own = true;
        }
    }
}

impl Machine<'_> {
    /// True if a line names a target in X or Y, while the program has not defined where it starts.
    fn moves_before_definition(&self, block: &Block) -> bool {
        let absolute = !self.relative || block.has(b'G', 53);
        let mut axes = AXES.iter().zip(self.begin.own);
        absolute && axes.any(|(letter, own)| !own && block.number(*letter).is_some())
    }

    /// Marks the coordinates of a line as defined by the program.
    fn claim(&mut self, block: &Block) {
        if self.relative && !block.has(b'G', 53) {
            return;
        }
        for (letter, own) in AXES.iter().zip(&mut self.begin.own) {
            *own |= block.number(*letter).is_some();
        }
    }

    pub(super) fn straight(&mut self, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        self.note_z(block, origin);
        self.note_first_z(block);
        let stray = self.moves_before_definition(block);
        let (from, to) = (self.at, self.target(block)?);
        self.claim(block);
        // One axis is still unknown: remember the known ones and move once both are given.
        if to[0].is_none() || to[1].is_none() {
            self.at = to;
            self.begin.waiting.get_or_insert(origin);
            return Ok(());
        }
        let waited = self.begin.waiting.is_some();
        let says_z_later = to[2].is_none() && self.survey.highest_z.is_some();
        let feeds = self.mode == Mode::Line;
        let Some(place) = self.place(to, feeds, origin) else {
            return Ok(());
        };
        // The program defines X and Y here for the first time, so the tool comes from above and not
        // from wherever the arm is.
        if stray && self.begin.is_own() && (feeds || waited || says_z_later || self.lifts) {
            if waited {
                let message = message!(
                    "the first moves do not give all of X, Y and Z, and the arm's position is \
                    unknown: the arm comes from above instead"
                );
                self.notes.add_without_start(origin, message);
            }
            if feeds && (self.pen_is_down || !self.lifts) {
                self.notes
                    .add(DiagnosticCode::Assumed, origin, feed_first());
            }
            self.begin.held = None;
            self.out.enter(place, origin);
        } else if stray || !self.begin.is_own() && !self.relative && !block.has_any(b"XY") {
            self.move_before_definition(from, place, (stray, feeds), origin);
        } else {
            self.lower();
            // A feed to where a placed program starts draws nothing, and must not lower the pen.
            if self.options.placed && !self.begin.moved && feeds && self.at == place.map(Some) {
                return Ok(());
            }
            if feeds {
                self.feed(place, origin)
            } else {
                self.go(place, origin)
            }
        }
        self.arrive(place);
        Ok(())
    }

    /// Executes a move from the arm's own position, before the program has defined X and Y. Nothing
    /// is drawn, and the tool is lowered only at its end.
    fn move_before_definition(
        &mut self,
        from: [Option<f64>; 3],
        [x, y, z]: [f64; 3],
        (stray, feeds): (bool, bool),
        origin: Origin,
    ) {
        if stray && feeds {
            self.notes
                .add(DiagnosticCode::Assumed, origin, feed_first());
        }
        // Only a descent is delayed: going up at once is safe.
        let height = self.begin.held.map(|(height, _)| height).or(from[2]);
        let lower = height.filter(|height| *height > z);
        match lower {
            // Everything is known, so one straight move does it.
            Some(_) if self.begin.is_own() && self.begin.held.is_none() => {
                self.out.travel([x, y, z], origin);
            }
            Some(height) if stray => {
                self.out.travel([x, y, height], origin);
                self.begin.held = Some((height, origin));
            }
            Some(height) => {
                self.begin.held = Some((height, origin));
                let message = message!(
                    "the program lowers the tool before it gives X and Y: it is lowered at the \
                    first X and Y, not at the arm's position"
                );
                self.notes.add(DiagnosticCode::Assumed, origin, message);
            }
            None => {
                self.begin.held = None;
                self.out.travel([x, y, z], origin);
            }
        }
        if self.begin.is_own() && self.begin.held.take().is_some() {
            self.out.travel([x, y, z], origin);
        }
    }

    /// Refuses an arc that starts at a position the program does not define, because its shape
    /// would depend on it.
    pub(super) fn check_defined_start(&self, block: &Block) -> Result<(), SpanDiagnostic> {
        let about = self.absolute_centres && block.has_any(b"IJK") && !self.begin.is_own();
        if self.at[0].is_none()
            || self.at[1].is_none()
            || !(self.moves_before_definition(block) || about)
        {
            return Ok(());
        }
        let message =
            message!("this arc begins at the arm's position, which the program does not give");
        let help = message!("put a move (G0 X Y) to its begin before it");
        Err(SpanDiagnostic::new(block.range.clone(), message).help(help))
    }

    /// Lowers a held tool to its commanded height.
    pub(super) fn lower(&mut self) {
        if let Some((_, origin)) = self.begin.held.take()
            && let [Some(x), Some(y), Some(z)] = self.at
        {
            self.out.travel([x, y, z], origin);
        }
    }

    /// Adds a line of the tool.
    fn feed(&mut self, place: [f64; 3], origin: Origin) {
        self.put_down(origin);
        let work = self.work(origin);
        self.out.line(place, work, origin);
    }

    /// Adds a rapid move. A pen that nothing else lifts is lifted for it.
    fn go(&mut self, place: [f64; 3], origin: Origin) {
        if let (Some(up), [Some(x), Some(y), Some(z)]) = (self.lift(), self.at)
            && self.begin.moved
            && z < up
        {
            self.out.travel([x, y, up], origin);
        }
        self.begin.lifted = self.lift().is_some();
        self.out.travel(place, origin);
    }

    /// Lowers the pen that was lifted for a move.
    pub(super) fn put_down(&mut self, origin: Origin) {
        if std::mem::take(&mut self.begin.lifted)
            && let [Some(x), Some(y), _] = self.at
        {
            self.out.travel([x, y, 0.0], origin);
        }
    }

    /// Lowers the pen as [`put_down`](Self::put_down) does, for a motion that leaves the surface
    /// from there: the commanded height is 0.
    pub(super) fn lower_to_draw(&mut self, origin: Origin) {
        if self.begin.lifted {
            self.put_down(origin);
            self.at[2] = Some(0.0);
        }
    }

    /// Height of the pen between lines of a placed program that has not given Z. `None` for any
    /// other program.
    fn lift(&self) -> Option<f64> {
        let says = self.begin.says_z || self.laser || self.lifts;
        let highest = self.survey.highest_z.unwrap_or(0.0);
        (self.options.placed && !says).then_some(self.options.lift.max(highest))
    }

    /// Records the first Z of a placed program. Until then relative heights count from 0.
    pub(super) fn note_first_z(&mut self, block: &Block) {
        if self.options.placed && !self.begin.says_z && block.number(b'Z').is_some() {
            if self.begin.lifted && self.relative {
                self.at[2] = Some(0.0);
            }
            self.begin.says_z = true;
            self.begin.lifted = false;
        }
    }

    /// Returns the position once X and Y are known. A missing Z becomes the highest Z of the
    /// program, because too high is the safe side.
    pub(super) fn place(
        &mut self,
        to: [Option<f64>; 3],
        feeds: bool,
        origin: Origin,
    ) -> Option<[f64; 3]> {
        let [Some(x), Some(y), z] = to else {
            return None;
        };
        if self.lifts {
            return Some([x, y, self.pen_height([x, y])]);
        }
        if let Some(up) = self.lift() {
            return Some([x, y, if feeds { 0.0 } else { up }]);
        }
        let z = z.unwrap_or_else(|| {
            let message = match self.survey.highest_z {
                Some(_) => {
                    message!("the first moves have no Z: the highest Z of the program is used")
                }
                None => message!("the program has no Z: 0 is used"),
            };
            self.notes.add_without_start(origin, message);
            self.survey.highest_z.unwrap_or(0.0)
        });
        Some([x, y, z])
    }

    pub(super) fn arrive(&mut self, place: [f64; 3]) {
        self.at = place.map(Some);
        self.begin.waiting = None;
        self.begin.moved = true;
    }
}
