//! Origins of a program: coordinate systems (G54 to G59.3, G10) and the local offset (G52, G92).

use magician_host::message;

use super::block::Block;
use super::motion::AXES;
use crate::formats::span::SpanDiagnostic;

/// Number of coordinate systems.
const SYSTEM_COUNT: usize = 9;

/// Origins in machine coordinates, mm.
#[derive(Clone, Debug, Default)]
pub(super) struct Offsets {
    systems: [[f64; 3]; SYSTEM_COUNT],
    /// Index of the active system; 0 is G54.
    active: usize,
    /// True for systems whose origin the program has set.
    set: [bool; SYSTEM_COUNT],
    /// First system selected or used.
    first: Option<usize>,
    /// Local offset of G52 or G92.
    local: [f64; 3],
    /// True while G92.2 suspends the local offset, until G92.3.
    suspended: bool,
}

/// Kind of a G10.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Setting {
    /// L2: sets the origin.
    Zero,
    /// L20: sets the coordinates of the current position.
    Here,
    /// L1, L10, L11: sets an entry of the tool table.
    Tool,
}

impl Setting {
    /// Returns the kind of G10 of a line; `None` if it is unknown.
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
    /// Returns the program's origin in machine coordinates.
    pub(super) fn zero(&self) -> [f64; 3] {
        let local = self.local();
        let system = self.systems[self.active];
        [0, 1, 2].map(|axis| system[axis] + local[axis])
    }

    /// Returns the local offset in force.
    pub(super) fn local(&self) -> [f64; 3] {
        if self.suspended { [0.0; 3] } else { self.local }
    }

    /// Returns the number of the active system; 1 is G54.
    pub(super) fn system(&self) -> usize {
        self.active + 1
    }

    /// Returns the origin of a system.
    pub(super) fn zero_of(&self, system: usize) -> Option<[f64; 3]> {
        self.systems.get(system.checked_sub(1)?).copied()
    }

    /// Returns the system selected by a code in tenths.
    pub(super) fn system_of(tenths: u32) -> Option<usize> {
        match tenths {
            540 | 550 | 560 | 570 | 580 | 590 => Some((tenths / 10 - 54) as usize),
            591..=593 => Some((tenths - 590) as usize + 5),
            _ => None,
        }
    }

    /// Selects a system. Returns true if it is a second one whose origin the program has not set.
    pub(super) fn select(&mut self, system: usize) -> bool {
        self.active = system.min(SYSTEM_COUNT - 1);
        let first = *self.first.get_or_insert(self.active);
        first != self.active && !self.set[self.active]
    }

    /// Executes G10 L2 or L20; `at` is the position of the tool. Returns true for the axes that
    /// stay unchanged because the position is unknown.
    pub(super) fn set(
        &mut self,
        setting: Setting,
        block: &Block,
        unit: f64,
        at: [Option<f64>; 3],
    ) -> Result<[bool; 3], SpanDiagnostic> {
        let system = match block.number(b'P').unwrap_or(0.0) {
            0.0 => self.active,
            number if (1.0..=SYSTEM_COUNT as f64).contains(&number) && number.fract() == 0.0 => {
                number as usize - 1
            }
            number => {
                let message = message!("unknown coordinate system P{number}; P is 0 to 9", number);
                return Err(SpanDiagnostic::new(block.range_of(b'P'), message));
            }
        };
        if let Some(turn) = block.number(b'R').filter(|turn| *turn != 0.0) {
            let message = message!(
                "rotated coordinate systems (R{turn}) are not supported",
                turn
            );
            let help = message!("export the file with rotated coordinates");
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

    /// Sets the coordinate of a position along an axis (G92).
    pub(super) fn call(&mut self, axis: usize, at: f64, coordinate: f64) {
        self.resume();
        self.local[axis] = at - self.systems[self.active][axis] - coordinate;
    }

    /// Sets the local offset along an axis (G52).
    pub(super) fn shift(&mut self, axis: usize, by: f64) {
        self.resume();
        self.local[axis] = by;
    }

    fn resume(&mut self) {
        if std::mem::take(&mut self.suspended) {
            self.local = [0.0; 3];
        }
    }

    /// Executes G92.1, G92.2 or G92.3.
    pub(super) fn reset(&mut self, tenths: u32) {
        match tenths {
            921 => (self.local, self.suspended) = ([0.0; 3], false),
            922 => self.suspended = true,
            _ => self.suspended = false,
        }
    }
}
