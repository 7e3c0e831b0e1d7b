//! Canned drilling cycles (G73, G81 to G83, G85, G86, G89). The pen moves to each hole, down and up
//! again; pecking, dwelling and spindle actions are ignored.

use magician_host::{Message, message};

use super::arc::Plane;
use super::block::Block;
use super::machine::{Machine, Mode};
use super::motion::AXES;
use crate::formats::span::SpanDiagnostic;
use crate::{DiagnosticCode, Origin};

/// Largest number of holes per line. An arbitrary limit above that of real programs, so that a
/// damaged L word cannot exhaust the memory.
const MAX_HOLES: f64 = 1000.0;

/// State shared by the lines of a cycle: values as commanded, mm in program coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle {
    z: Option<f64>,
    r: Option<f64>,
    /// Height of the tool at the start of a series of cycles.
    start_height: Option<f64>,
    /// True for G98: retract to the initial height instead of R.
    pub(super) retracts_to_start: bool,
}

impl Default for Cycle {
    fn default() -> Self {
        Self {
            z: None,
            r: None,
            start_height: None,
            retracts_to_start: true,
        }
    }
}

impl Cycle {
    /// Begins a series of cycles, which forgets the previous values.
    pub(super) fn begin(&mut self) {
        (self.z, self.r, self.start_height) = (None, None, None);
    }
}

/// True if the cycle raises the tool at feed speed instead of rapid speed.
fn feeds_up(cycle: u32) -> bool {
    matches!(cycle, 850 | 890)
}

impl Machine<'_> {
    pub(super) fn drill(
        &mut self,
        block: &Block,
        cycle: u32,
        origin: Origin,
    ) -> Result<(), SpanDiagnostic> {
        let error = |message: Message| SpanDiagnostic::new(block.range.clone(), message);
        let name = format!("G{}", cycle / 10);
        if self.laser || self.lifts || self.plane != Plane::Xy {
            let message = message!(
                "{name} drills, which needs a pen and the plane of G17",
                name
            );
            return Err(error(message));
        }
        let zero = self.offsets.zero();
        let place = |axis: usize| self.at[axis].map(|at| at - zero[axis]);
        let [x, y, current_z] = [0, 1, 2].map(place);
        let (unit, relative) = (self.unit, self.relative);
        let word = |letter: u8| block.number(letter).map(|number| number * unit);
        let base = |at: Option<f64>| if relative { at } else { Some(0.0) };
        let first = self.cycle.start_height.or(current_z);
        let r = match word(b'R') {
            Some(r) => base(first).map(|first| first + r),
            None => self.cycle.r,
        };
        // Without R the cycle begins at the current height.
        let Some(r) = r.or(current_z) else {
            return Err(error(message!(
                "{name} needs R: the height that it begins at",
                name
            )));
        };
        let z = match word(b'Z') {
            Some(z) => Some(if relative { r + z } else { z }),
            None => self.cycle.z,
        };
        let Some(z) = z.filter(|z| *z <= r) else {
            return Err(error(message!(
                "{name} needs Z: how deep it goes, below R",
                name
            )));
        };
        (self.cycle.z, self.cycle.r, self.cycle.start_height) = (Some(z), Some(r), first);
        let holes = if relative {
            block.number(b'L').unwrap_or(1.0)
        } else {
            1.0
        };
        if !(0.0..=MAX_HOLES).contains(&holes) {
            return Err(error(message!(
                "{name} makes {holes} holes, limit {limit}",
                name,
                holes,
                limit = MAX_HOLES
            )));
        }
        let message = message!("{name} becomes one move down and up for each hole", name);
        self.notes.add(DiagnosticCode::Assumed, origin, message);
        let retract_height = first.filter(|first| self.cycle.retracts_to_start && *first > r);
        let retract_height = retract_height.unwrap_or(r);
        let (mut at, mut height) = ([x, y], current_z);
        for _ in 0..holes as u32 {
            for (axis, letter) in AXES[..2].iter().enumerate() {
                if let Some(to) = word(*letter) {
                    at[axis] = base(at[axis]).map(|from| from + to);
                }
            }
            let [Some(x), Some(y)] = at else {
                return Err(error(message!(
                    "{name} drills, but X and Y are unknown",
                    name
                )));
            };
            if height.is_none_or(|height| height < r) {
                self.straight_move(Mode::Travel, &[(b'Z', r)], block, origin)?;
            }
            self.straight_move(Mode::Travel, &[(b'X', x), (b'Y', y)], block, origin)?;
            self.straight_move(Mode::Travel, &[(b'Z', r)], block, origin)?;
            self.straight_move(Mode::Line, &[(b'Z', z)], block, origin)?;
            let mode = if feeds_up(cycle) {
                Mode::Line
            } else {
                Mode::Travel
            };
            self.straight_move(mode, &[(b'Z', retract_height)], block, origin)?;
            height = Some(retract_height);
        }
        Ok(())
    }

    /// Executes one straight move of a cycle as if it were a separate line.
    fn straight_move(
        &mut self,
        mode: Mode,
        to: &[(u8, f64)],
        block: &Block,
        origin: Origin,
    ) -> Result<(), SpanDiagnostic> {
        let before = (self.mode, self.relative, self.unit);
        (self.mode, self.relative, self.unit) = (mode, false, 1.0);
        let result = self.straight(&block.with_numbers(to), origin);
        (self.mode, self.relative, self.unit) = before;
        result
    }
}
