//! Canned drilling cycles (G73, G81 to G83, G85, G86, G89). The pen moves to each hole, down and up
//! again; pecking, dwelling and spindle actions are ignored.

use super::arc::Plane;
use super::block::Block;
use super::machine::{Machine, Mode};
use super::motion::AXES;
use crate::formats::span::SpanDiagnostic;
use crate::{DiagnosticCode, Origin};

/// Largest number of holes per line. A choice above any program, so that a damaged L cannot fill
/// the memory.
const MAX_HOLES: f64 = 1000.0;

/// State shared by the lines of a cycle: values as commanded, mm in program coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle {
    z: Option<f64>,
    r: Option<f64>,
    /// Height of the tool at the start of a series of cycles.
    from: Option<f64>,
    /// True for G98: retract to the initial height instead of R.
    pub(super) back: bool,
}

impl Default for Cycle {
    fn default() -> Self {
        Self {
            z: None,
            r: None,
            from: None,
            back: true,
        }
    }
}

impl Cycle {
    /// Begins a series of cycles, which forgets the previous values.
    pub(super) fn begin(&mut self) {
        (self.z, self.r, self.from) = (None, None, None);
    }
}

/// True if the tool is fed up instead of retracted at rapid speed.
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
        let error = |message: String| SpanDiagnostic::new(block.range.clone(), message);
        let name = format!("G{}", cycle / 10);
        if self.laser || self.lifts || self.plane != Plane::Xy {
            let message = format!("{name} drills, which needs a pen and the plane of G17");
            return Err(error(message));
        }
        let zero = self.offsets.zero();
        let place = |axis: usize| self.at[axis].map(|at| at - zero[axis]);
        let [x, y, now] = [0, 1, 2].map(place);
        let (unit, relative) = (self.unit, self.relative);
        let word = |letter: u8| block.number(letter).map(|number| number * unit);
        let from = |at: Option<f64>| if relative { at } else { Some(0.0) };
        let first = self.cycle.from.or(now);
        let r = match word(b'R') {
            Some(r) => from(first).map(|first| first + r),
            None => self.cycle.r,
        };
        // Without R the cycle begins at the current height.
        let Some(r) = r.or(now) else {
            return Err(error(format!(
                "{name} needs R: the height that it begins at"
            )));
        };
        let z = match word(b'Z') {
            Some(z) => Some(if relative { r + z } else { z }),
            None => self.cycle.z,
        };
        let Some(z) = z.filter(|z| *z <= r) else {
            return Err(error(format!("{name} needs Z: how deep it goes, below R")));
        };
        (self.cycle.z, self.cycle.r, self.cycle.from) = (Some(z), Some(r), first);
        let holes = if relative {
            block.number(b'L').unwrap_or(1.0)
        } else {
            1.0
        };
        if !(0.0..=MAX_HOLES).contains(&holes) {
            return Err(error(format!(
                "{name} makes {holes} holes, limit {MAX_HOLES}"
            )));
        }
        let message = format!("{name} becomes one move down and up for each hole");
        self.notes.add(DiagnosticCode::Assumed, origin, &message);
        let up = first.filter(|first| self.cycle.back && *first > r);
        let up = up.unwrap_or(r);
        let (mut at, mut height) = ([x, y], now);
        for _ in 0..holes as u32 {
            for (axis, letter) in AXES[..2].iter().enumerate() {
                if let Some(to) = word(*letter) {
                    at[axis] = from(at[axis]).map(|from| from + to);
                }
            }
            let [Some(x), Some(y)] = at else {
                return Err(error(format!("{name} drills, but X and Y are unknown")));
            };
            if height.is_none_or(|height| height < r) {
                self.leg(Mode::Travel, &[(b'Z', r)], block, origin)?;
            }
            self.leg(Mode::Travel, &[(b'X', x), (b'Y', y)], block, origin)?;
            self.leg(Mode::Travel, &[(b'Z', r)], block, origin)?;
            self.leg(Mode::Line, &[(b'Z', z)], block, origin)?;
            let mode = if feeds_up(cycle) {
                Mode::Line
            } else {
                Mode::Travel
            };
            self.leg(mode, &[(b'Z', up)], block, origin)?;
            height = Some(up);
        }
        Ok(())
    }

    /// Executes one straight move of a cycle as if it were a separate line.
    fn leg(
        &mut self,
        mode: Mode,
        to: &[(u8, f64)],
        block: &Block,
        origin: Origin,
    ) -> Result<(), SpanDiagnostic> {
        let before = (self.mode, self.relative, self.unit);
        (self.mode, self.relative, self.unit) = (mode, false, 1.0);
        let done = self.straight(&block.with_numbers(to), origin);
        (self.mode, self.relative, self.unit) = before;
        done
    }
}
