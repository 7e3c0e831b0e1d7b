//! User units (IP, SC).

use super::lexer::Instruction;
use crate::formats::flaw::Flaw;

/// Plotter units of a millimetre.
const UNITS: f64 = 40.0;

/// How coordinates become millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// P1 and P2, plotter units: x and y of each.
    corners: Option<[f64; 4]>,
    /// Plotter units of a user unit, and where the user units begin, plotter units.
    factor: [f64; 2],
    shift: [f64; 2],
    /// Whether coordinates are user units.
    user: bool,
}

impl Default for Scale {
    fn default() -> Self {
        Self {
            corners: None,
            factor: [1.0; 2],
            shift: [0.0; 2],
            user: false,
        }
    }
}

impl Scale {
    /// A point of the plot on the sheet, mm.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            (self.factor[0] * x + self.shift[0]) / UNITS,
            (self.factor[1] * y + self.shift[1]) / UNITS,
        ]
    }

    /// The point of the plot that is there on the sheet, mm.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            (x * UNITS - self.shift[0]) / self.factor[0],
            (y * UNITS - self.shift[1]) / self.factor[1],
        ]
    }

    /// The greatest that a length of 1 becomes, mm.
    pub(super) fn most(&self) -> f64 {
        self.factor[0].abs().max(self.factor[1].abs()) / UNITS
    }

    /// IP: where P1 and P2 are.
    pub(super) fn corners(&mut self, instruction: &Instruction) -> Result<(), Flaw> {
        self.corners = match instruction.numbers[..] {
            [] => None,
            [x1, y1, x2, y2] => Some([x1, y1, x2, y2]),
            _ => {
                return Err(Flaw::new(
                    instruction.range.clone(),
                    "IP needs two points or nothing",
                ));
            }
        };
        if self.user {
            let message = "IP after SC changes the scale of what follows, which is not done";
            return Err(Flaw::new(instruction.range.clone(), message).help("put IP before SC"));
        }
        Ok(())
    }

    /// SC: which coordinates P1 and P2 have.
    pub(super) fn units(&mut self, instruction: &Instruction) -> Result<(), Flaw> {
        let refused = |message: &str| Err(Flaw::new(instruction.range.clone(), message));
        let numbers = &instruction.numbers[..];
        let (numbers, kind) = match numbers {
            [] => {
                let corners = self.corners;
                *self = Self {
                    corners,
                    ..Self::default()
                };
                return Ok(());
            }
            [x1, x2, y1, y2] => ([*x1, *x2, *y1, *y2], 0.0),
            [x1, x2, y1, y2, kind, ..] => ([*x1, *x2, *y1, *y2], *kind),
            _ => return refused("SC needs four numbers or none"),
        };
        let Some([px, py, qx, qy]) = self.corners else {
            let message =
                "SC scales to the plotter's own frame, and the file does not say which (IP)";
            return Err(Flaw::new(instruction.range.clone(), message)
                .help("write the plot without scaling, in plotter units"));
        };
        let [x1, x2, y1, y2] = numbers;
        let factor = if kind == 0.0 {
            [(qx - px) / (x2 - x1), (qy - py) / (y2 - y1)]
        } else if kind == 2.0 {
            [x2, y2]
        } else {
            return refused("SC with one scale for both axes (type 1) is not done");
        };
        if !factor
            .iter()
            .all(|factor| factor.is_finite() && *factor != 0.0)
        {
            return refused("the scale of SC is no number");
        }
        self.factor = factor;
        self.shift = [px - factor[0] * x1, py - factor[1] * y1];
        self.user = true;
        Ok(())
    }
}
