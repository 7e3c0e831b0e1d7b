//! User units (IP, IR, SC) and how the coordinate system is turned (RO).

use super::lexer::Instruction;
use crate::formats::span::SpanDiagnostic;

/// Plotter units of a millimetre.
const UNITS: f64 = 40.0;

/// The default P1 and P2 on a sheet of A4, plotter units: those of the HP 7475A, whose manual has
/// them in the table "Default Coordinate Values for Scaling Points P1 and P2".
const A4: [f64; 4] = [603.0, 521.0, 10_603.0, 7721.0];

/// How coordinates become millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// The frame that P1 and P2 are the corners of by default, plotter units: x and y of each corner.
    frame: [f64; 4],
    /// Whether the file says how large the sheet is (PS).
    sized: bool,
    /// P1 and P2, plotter units: x and y of each.
    corners: [f64; 4],
    /// Whether the file says where they are.
    said: bool,
    /// Quarter turns to the left.
    turns: u8,
    /// What SC says.
    user: Option<Units>,
    /// Plotter units of a user unit, and where the user units begin, plotter units.
    factor: [f64; 2],
    shift: [f64; 2],
}

/// What SC says.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Units {
    /// These coordinates are at P1 and P2: from and to across, from and to along.
    Corners([f64; 4]),
    /// The same with square units: the shares of what is left over that are to the left and below.
    Square([f64; 4], [f64; 2]),
    /// P1 has these coordinates, and a unit is so many plotter units.
    Factors([f64; 2], [f64; 2]),
}

impl Default for Scale {
    fn default() -> Self {
        Self {
            frame: A4,
            sized: false,
            corners: A4,
            said: false,
            turns: 0,
            user: None,
            factor: [1.0; 2],
            shift: [0.0; 2],
        }
    }
}

impl Scale {
    /// A point of the plot on the sheet, mm.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [x, y] = [
            self.factor[0] * x + self.shift[0],
            self.factor[1] * y + self.shift[1],
        ];
        let [width, height] = self.sheet();
        let turned = match self.turns {
            0 => [x, y],
            1 => [width - y, x],
            2 => [width - x, height - y],
            _ => [y, height - x],
        };
        turned.map(|side| side / UNITS)
    }

    /// The point of the plot that is there on the sheet, mm.
    pub(super) fn at(&self, place: [f64; 2]) -> [f64; 2] {
        let [x, y] = place.map(|side| side * UNITS);
        let [width, height] = self.sheet();
        let [x, y] = match self.turns {
            0 => [x, y],
            1 => [y, width - x],
            2 => [width - x, height - y],
            _ => [height - y, x],
        };
        [
            (x - self.shift[0]) / self.factor[0],
            (y - self.shift[1]) / self.factor[1],
        ]
    }

    /// The greatest that a length of 1 becomes, mm.
    pub(super) fn most(&self) -> f64 {
        self.factor[0].abs().max(self.factor[1].abs()) / UNITS
    }

    /// A direction of the plot as one of the sheet.
    pub(super) fn turned(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.turns {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        }
    }

    /// From P1 to P2, mm.
    pub(super) fn span(&self) -> [f64; 2] {
        let [px, py, qx, qy] = self.corners;
        [(qx - px) / UNITS, (qy - py) / UNITS]
    }

    /// What a length of 1 across becomes, mm.
    pub(super) fn unit(&self) -> f64 {
        self.factor[0].abs() / UNITS
    }

    /// Width and height of the sheet: as much is beside its frame on the right and above as on the left and below.
    fn sheet(&self) -> [f64; 2] {
        let [px, py, qx, qy] = self.frame;
        [px + qx, py + qy]
    }

    /// What the file says of the size of its page (PS), mm.
    pub(super) fn page(&self) -> Option<[f64; 2]> {
        self.sized.then(|| self.sheet().map(|side| side / UNITS))
    }

    /// The frame as the turned axes have it.
    fn turned_frame(&self) -> [f64; 4] {
        let [px, py, qx, qy] = self.frame;
        match self.turns % 2 {
            0 => [px, py, qx, qy],
            _ => [py, px, qy, qx],
        }
    }

    /// Whether user units are counted from corners that the file says nothing of.
    pub(super) fn assumes_frame(&self) -> bool {
        self.user.is_some() && !self.said && !self.sized
    }

    /// The frame that is assumed then, mm.
    pub(super) fn frame(&self) -> [f64; 2] {
        let [px, py, qx, qy] = self.frame;
        [(qx - px) / UNITS, (qy - py) / UNITS]
    }

    /// PS: how long and how wide the sheet is.
    pub(super) fn sized(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let [length, width] = match instruction.numbers[..] {
            [length] => [length, length],
            [length, width, ..] => [length, width],
            [] => return Ok(()),
        };
        if length > 0.0 && width > 0.0 {
            self.frame = [0.0, 0.0, length, width];
            self.sized = true;
            if !self.said {
                self.corners = self.turned_frame();
            }
        }
        self.rescale(instruction)
    }

    /// RO: the axes are turned to the left, P1 and P2 with them.
    pub(super) fn rotate(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let angle = instruction.numbers.first().copied().unwrap_or(0.0);
        let turns = [0.0, 90.0, 180.0, 270.0]
            .iter()
            .position(|known| angle.rem_euclid(360.0) == *known);
        let Some(turns) = turns else {
            let message = format!("RO {angle}: the rotation must be 0, 90, 180 or 270 degrees");
            return Err(SpanDiagnostic::new(instruction.range.clone(), message));
        };
        // P1 and P2 keep their coordinates: IP and IR bring them back onto the sheet.
        self.turns = u8::try_from(turns).unwrap_or_default();
        Ok(())
    }

    /// IP: where P1 and P2 are. P2 follows a P1 that is told alone.
    pub(super) fn corners(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let [px, py, qx, qy] = self.corners;
        self.said = !instruction.numbers.is_empty();
        self.corners = match instruction.numbers[..] {
            [] => self.turned_frame(),
            [x, y] => [x, y, x + qx - px, y + qy - py],
            [x1, y1, x2, y2] => [x1, y1, x2, y2],
            _ => {
                return Err(SpanDiagnostic::new(
                    instruction.range.clone(),
                    "IP needs one point, two points or nothing",
                ));
            }
        };
        self.rescale(instruction)
    }

    /// IR: where P1 and P2 are, in percent of the sheet.
    pub(super) fn shares(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let [px, py, qx, qy] = self.turned_frame();
        let at = |x: f64, y: f64| [px + (qx - px) * x / 100.0, py + (qy - py) * y / 100.0];
        let numbers: Vec<f64> = instruction
            .numbers
            .as_chunks::<2>()
            .0
            .iter()
            .flat_map(|[x, y]| at(*x, *y))
            .collect();
        let placed = Instruction {
            numbers,
            ..instruction.clone()
        };
        self.corners(&placed)
    }

    /// SC: which coordinates P1 and P2 have.
    pub(super) fn units(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let refused = |message: &str| Err(SpanDiagnostic::new(instruction.range.clone(), message));
        let share = |nth: usize| {
            instruction
                .numbers
                .get(nth)
                .map_or(0.5, |share| share / 100.0)
        };
        self.user = match instruction.numbers[..] {
            [] => None,
            [x1, x2, y1, y2, ref kind @ ..] => match kind.first().copied().unwrap_or(0.0) {
                0.0 => Some(Units::Corners([x1, x2, y1, y2])),
                1.0 => Some(Units::Square([x1, x2, y1, y2], [share(5), share(6)])),
                2.0 => Some(Units::Factors([x1, y1], [x2, y2])),
                kind => return refused(&format!("unknown type {kind} of SC: it is 0, 1 or 2")),
            },
            _ => return refused("SC needs four numbers or none"),
        };
        self.rescale(instruction)
    }

    /// DF: plotter units; P1, P2 and the turn stay.
    pub(super) fn unscale(&mut self) {
        (self.user, self.factor, self.shift) = (None, [1.0; 2], [0.0; 2]);
    }

    /// IN: P1, P2 and the turn as well.
    pub(super) fn reset(&mut self) {
        *self = Self {
            frame: self.frame,
            corners: self.frame,
            sized: self.sized,
            ..Self::default()
        };
    }

    /// User units follow P1 and P2.
    fn rescale(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let [px, py, qx, qy] = self.corners;
        let across = [qx - px, qy - py];
        let (factor, shift) = match self.user {
            None => ([1.0; 2], [0.0; 2]),
            Some(Units::Corners([x1, x2, y1, y2])) => {
                let factor = [across[0] / (x2 - x1), across[1] / (y2 - y1)];
                (factor, [px - factor[0] * x1, py - factor[1] * y1])
            }
            Some(Units::Square([x1, x2, y1, y2], shares)) => {
                let units = [x2 - x1, y2 - y1];
                let size = [0, 1].map(|axis| (across[axis] / units[axis]).abs());
                let unit = size[0].min(size[1]);
                let factor = [0, 1].map(|axis| unit * (across[axis] / units[axis]).signum());
                let left = [0, 1].map(|axis| across[axis] - factor[axis] * units[axis]);
                let begin = [px + left[0] * shares[0], py + left[1] * shares[1]];
                (
                    factor,
                    [begin[0] - factor[0] * x1, begin[1] - factor[1] * y1],
                )
            }
            Some(Units::Factors([x1, y1], factor)) => {
                (factor, [px - factor[0] * x1, py - factor[1] * y1])
            }
        };
        if !factor
            .iter()
            .all(|factor| factor.is_finite() && *factor != 0.0)
        {
            let message = "the scale of SC is not a finite number";
            return Err(SpanDiagnostic::new(instruction.range.clone(), message));
        }
        (self.factor, self.shift) = (factor, shift);
        Ok(())
    }
}
