//! Where the zero of a program lies: its coordinate systems (G54 to G59.3, G10) and the offset on top of them (G52, G92).

use super::block::Block;
use super::motion::AXES;
use crate::formats::span::SpanDiagnostic;

/// How many coordinate systems there are.
const SYSTEMS: usize = 9;

/// Zeros of a program in the coordinates of the machine, mm.
#[derive(Clone, Debug, Default)]
pub(super) struct Offsets {
    systems: [[f64; 3]; SYSTEMS],
    /// The one in force: 0 is that of G54.
    active: usize,
    /// Those whose zero the program has set itself.
    set: [bool; SYSTEMS],
    /// The first that was chosen or worked in.
    first: Option<usize>,
    /// What G52 or G92 have put on top.
    local: [f64; 3],
    /// G92.2 has taken it off, until G92.3.
    suspended: bool,
}

/// What a G10 sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Setting {
    /// L2: the zero is there.
    Zero,
    /// L20: where the tool is has these coordinates.
    Here,
    /// L1, L10, L11: an entry of the tool table.
    Tool,
}

impl Setting {
    /// What a G10 of this line sets; nothing if that is no setting known here.
    pub(super) fn of(block: &Block) -> Option<Self> {
        match block.number(b'L')? {
            2.0 => Some(Self::Zero),
            20.0 => Some(Self::Here),
            1.0 | 10.0 | 11.0 => Some(Self::Tool),
            _ => None,
        }
    }
}

impl Offsets {
    /// The program's zero in the coordinates of the machine.
    pub(super) fn zero(&self) -> [f64; 3] {
        let local = self.local();
        let system = self.systems[self.active];
        [0, 1, 2].map(|axis| system[axis] + local[axis])
    }

    /// What is on top of the coordinate system.
    pub(super) fn local(&self) -> [f64; 3] {
        if self.suspended { [0.0; 3] } else { self.local }
    }

    /// The number of the coordinate system in force, 1 being that of G54.
    pub(super) fn system(&self) -> usize {
        self.active + 1
    }

    /// Where the zero of a coordinate system is.
    pub(super) fn zero_of(&self, system: usize) -> Option<[f64; 3]> {
        self.systems.get(system.checked_sub(1)?).copied()
    }

    /// The coordinate system that a code (in tenths) is of.
    pub(super) fn system_of(tenths: u32) -> Option<usize> {
        match tenths {
            540 | 550 | 560 | 570 | 580 | 590 => Some((tenths / 10 - 54) as usize),
            591..=593 => Some((tenths - 590) as usize + 5),
            _ => None,
        }
    }

    /// Chooses a coordinate system. Whether it is a second one whose zero the program does not say.
    pub(super) fn select(&mut self, system: usize) -> bool {
        self.active = system.min(SYSTEMS - 1);
        let first = *self.first.get_or_insert(self.active);
        first != self.active && !self.set[self.active]
    }

    /// G10 L2 and L20; `at` is where the tool is. Which axes stay as they were because that is not known.
    pub(super) fn set(
        &mut self,
        setting: Setting,
        block: &Block,
        unit: f64,
        at: [Option<f64>; 3],
    ) -> Result<[bool; 3], SpanDiagnostic> {
        let system = match block.number(b'P').unwrap_or(0.0) {
            0.0 => self.active,
            number if (1.0..=SYSTEMS as f64).contains(&number) && number.fract() == 0.0 => {
                number as usize - 1
            }
            number => {
                let message = format!("unknown coordinate system P{number}; P is 0 to 9");
                return Err(SpanDiagnostic::new(block.range_of(b'P'), message));
            }
        };
        if let Some(turn) = block.number(b'R').filter(|turn| *turn != 0.0) {
            let message = format!("rotated coordinate systems (R{turn}) are not supported");
            let help = "export the file with rotated coordinates";
            return Err(SpanDiagnostic::new(block.range_of(b'R'), message).help(help));
        }
        let local = self.local();
        let mut missing = [false; 3];
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = block.number(letter).map(|value| value * unit) else {
                continue;
            };
            let zero = match setting {
                Setting::Here => at[axis].map(|at| at - local[axis] - value),
                _ => Some(value),
            };
            match zero {
                Some(zero) => self.systems[system][axis] = zero,
                None => missing[axis] = true,
            }
        }
        self.set[system] = true;
        Ok(missing)
    }

    /// G92: a place along an axis has this coordinate from now on.
    pub(super) fn call(&mut self, axis: usize, at: f64, coordinate: f64) {
        self.resume();
        self.local[axis] = at - self.systems[self.active][axis] - coordinate;
    }

    /// G52: the offset itself.
    pub(super) fn shift(&mut self, axis: usize, by: f64) {
        self.resume();
        self.local[axis] = by;
    }

    fn resume(&mut self) {
        if std::mem::take(&mut self.suspended) {
            self.local = [0.0; 3];
        }
    }

    /// G92.1, G92.2, G92.3.
    pub(super) fn reset(&mut self, tenths: u32) {
        match tenths {
            921 => (self.local, self.suspended) = ([0.0; 3], false),
            922 => self.suspended = true,
            _ => self.suspended = false,
        }
    }
}
