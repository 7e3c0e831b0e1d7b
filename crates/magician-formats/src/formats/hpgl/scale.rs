//! Coordinate system of a plot: scaling points and user units (IP, IR, SC), and rotation (RO).

use magician_host::{Message, message};

use super::lexer::Instruction;
use crate::formats::span::SpanDiagnostic;

/// Plotter units per millimetre.
const UNITS_PER_MM: f64 = 40.0;

/// Default P1 and P2 on A4, plotter units. From the HP 7475A's manual, table "Default Coordinate
/// Values for Scaling Points P1 and P2".
const A4_SCALING_POINTS: [f64; 4] = [603.0, 521.0, 10_603.0, 7721.0];

/// Transform from coordinates of the plot to millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// Default P1 and P2, plotter units: x and y of each.
    frame: [f64; 4],
    /// True if the file gives the size of the sheet (PS).
    sized: bool,
    /// Current P1 and P2, plotter units: x and y of each.
    corners: [f64; 4],
    /// True if the file defines P1 and P2.
    said: bool,
    /// Quarter turns counter-clockwise.
    turns: u8,
    /// User units, as given by SC.
    user: Option<Units>,
    /// Plotter units per user unit, and origin of user units, plotter units.
    factor: [f64; 2],
    shift: [f64; 2],
}

/// User units, as given by SC.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Units {
    /// Coordinates at P1 and P2: from and to in x, from and to in y.
    Corners([f64; 4]),
    /// The same with square units, and the shares of the remaining space to the left and below.
    Square([f64; 4], [f64; 2]),
    /// Coordinates at P1, and plotter units per unit.
    Factors([f64; 2], [f64; 2]),
}

impl Default for Scale {
    fn default() -> Self {
        Self {
            frame: A4_SCALING_POINTS,
            sized: false,
            corners: A4_SCALING_POINTS,
            said: false,
            turns: 0,
            user: None,
            factor: [1.0; 2],
            shift: [0.0; 2],
        }
    }
}

impl Scale {
    /// Converts a point of the plot to the sheet, mm.
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
        turned.map(|side| side / UNITS_PER_MM)
    }

    /// Converts a point of the sheet, mm, to the plot.
    pub(super) fn at(&self, place: [f64; 2]) -> [f64; 2] {
        let [x, y] = place.map(|side| side * UNITS_PER_MM);
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

    /// Larger scale factor of both axes, mm per unit.
    pub(super) fn most(&self) -> f64 {
        self.factor[0].abs().max(self.factor[1].abs()) / UNITS_PER_MM
    }

    /// Converts a direction of the plot to the sheet.
    pub(super) fn turned(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.turns {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        }
    }

    /// Distance from P1 to P2 in x and y, mm.
    pub(super) fn span(&self) -> [f64; 2] {
        let [px, py, qx, qy] = self.corners;
        [(qx - px) / UNITS_PER_MM, (qy - py) / UNITS_PER_MM]
    }

    /// Scale factor in x, mm per unit.
    pub(super) fn unit(&self) -> f64 {
        self.factor[0].abs() / UNITS_PER_MM
    }

    /// Width and height of the sheet. Its frame is assumed to be centred.
    fn sheet(&self) -> [f64; 2] {
        let [px, py, qx, qy] = self.frame;
        [px + qx, py + qy]
    }

    /// Returns the page size given by the file (PS), mm.
    pub(super) fn page(&self) -> Option<[f64; 2]> {
        self.sized
            .then(|| self.sheet().map(|side| side / UNITS_PER_MM))
    }

    /// Frame along the rotated axes.
    fn turned_frame(&self) -> [f64; 4] {
        let [px, py, qx, qy] = self.frame;
        match self.turns % 2 {
            0 => [px, py, qx, qy],
            _ => [py, px, qy, qx],
        }
    }

    /// True if user units depend on scaling points that the file does not define.
    pub(super) fn assumes_frame(&self) -> bool {
        self.user.is_some() && !self.said && !self.sized
    }

    /// Size of the assumed frame, mm.
    pub(super) fn frame(&self) -> [f64; 2] {
        let [px, py, qx, qy] = self.frame;
        [(qx - px) / UNITS_PER_MM, (qy - py) / UNITS_PER_MM]
    }

    /// Handles PS: length and width of the sheet.
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

    /// Handles RO: rotates the axes counter-clockwise, together with P1 and P2.
    pub(super) fn rotate(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let angle = instruction.numbers.first().copied().unwrap_or(0.0);
        let turns = [0.0, 90.0, 180.0, 270.0]
            .iter()
            .position(|known| angle.rem_euclid(360.0) == *known);
        let Some(turns) = turns else {
            let message = message!(
                "RO {angle}: the rotation must be 0, 90, 180 or 270 degrees",
                angle
            );
            return Err(SpanDiagnostic::new(instruction.range.clone(), message));
        };
        // P1 and P2 keep their coordinates. IP and IR bring them back onto the sheet.
        self.turns = u8::try_from(turns).unwrap_or_default();
        Ok(())
    }

    /// Handles IP: position of P1 and P2. P2 follows a P1 given alone.
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
                    message!("IP needs one point, two points or nothing"),
                ));
            }
        };
        self.rescale(instruction)
    }

    /// Handles IR: position of P1 and P2 in percent of the sheet.
    pub(super) fn relative_corners(
        &mut self,
        instruction: &Instruction,
    ) -> Result<(), SpanDiagnostic> {
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

    /// Handles SC: coordinates of P1 and P2.
    pub(super) fn units(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        let refused =
            |message: Message| Err(SpanDiagnostic::new(instruction.range.clone(), message));
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
                kind => {
                    return refused(message!("unknown type {kind} of SC: it is 0, 1 or 2", kind));
                }
            },
            _ => return refused(message!("SC needs four numbers or none")),
        };
        self.rescale(instruction)
    }

    /// Handles DF: back to plotter units; P1, P2 and rotation stay.
    pub(super) fn unscale(&mut self) {
        (self.user, self.factor, self.shift) = (None, [1.0; 2], [0.0; 2]);
    }

    /// Handles IN: also resets P1, P2 and rotation.
    pub(super) fn reset(&mut self) {
        *self = Self {
            frame: self.frame,
            corners: self.frame,
            sized: self.sized,
            ..Self::default()
        };
    }

    /// Recomputes user units after a change of P1 or P2.
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
            let message = message!("the scale of SC is not a finite number");
            return Err(SpanDiagnostic::new(instruction.range.clone(), message));
        }
        (self.factor, self.shift) = (factor, shift);
        Ok(())
    }
}
