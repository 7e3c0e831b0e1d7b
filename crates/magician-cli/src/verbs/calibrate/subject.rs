//! Subjects of calibration, the points that each needs, and their evaluation.

use magician_program::artwork::Sheet;
use magician_program::{Diagnostic, Tip, Tool};

use crate::config::{Config, Key};
use crate::failure::Failure;

/// Subject of a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Subject {
    Sheet,
    Surface,
    Tool,
}

/// Pose of the arm while the tip touched a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// x, y, z in mm and r in deg.
    pub(super) pose: [f64; 4],
}

impl Touch {
    pub(super) fn from_point([x, y, z]: [f64; 3]) -> Self {
        let pose = [x, y, z, 0.0];
        Self { pose }
    }

    pub(super) fn from_rotation([x, y, r]: [f64; 3]) -> Self {
        let pose = [x, y, 0.0, r];
        Self { pose }
    }

    fn point(&self) -> [f64; 3] {
        let [x, y, z, _] = self.pose;
        [x, y, z]
    }

    fn turn(&self) -> [f64; 3] {
        let [x, y, _, r] = self.pose;
        [x, y, r]
    }
}

/// Result of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum CalibrationResult {
    Sheet(Sheet),
    /// Height of a level surface, mm.
    Surface(f64),
    Tip(Tip),
}

impl Subject {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Sheet => "sheet",
            Self::Surface => "surface",
            Self::Tool => "tool",
        }
    }

    /// Returns the names of the points, in the order of touching.
    pub(super) fn points(self) -> &'static [&'static str] {
        match self {
            Self::Sheet => &["lower left", "lower right", "upper left"],
            Self::Surface => &["anywhere"],
            Self::Tool => &["the point", "turned"],
        }
    }

    /// Returns the instruction for the user.
    pub(super) fn instruction(self) -> &'static str {
        match self {
            Self::Sheet => {
                "Touch three corners of the paper with the tip: by hand with the arm's unlock button, or with the keys. \
                 Enter takes each."
            }
            Self::Surface => {
                "Touch the paper or the table with the tip: by hand with the arm's unlock button, or with the keys. Enter takes \
                 it."
            }
            Self::Tool => {
                "Touch a mark on the table with the tip and press Enter. Lift the tool (w), turn it by about half a turn (a, d), \
                 touch the same mark again, Enter."
            }
        }
    }

    pub(super) fn without_terminal_hint(self) -> &'static str {
        match self {
            Self::Sheet => {
                "--points X,Y,Z X,Y,Z X,Y,Z gives the corners, as `magician pose` shows them"
            }
            Self::Surface => "--height Z gives it, as `magician pose` shows it",
            Self::Tool => "--poses X,Y,R X,Y,R gives both touches, as `magician pose` shows them",
        }
    }

    /// Returns a sentence about the verbs that use the result.
    pub(super) fn used_by(self) -> &'static str {
        match self {
            Self::Sheet => {
                "`magician draw` and `engrave` place a page on it, aligned with its corners"
            }
            Self::Surface => "`magician draw` and `engrave` use it as the height of the paper",
            Self::Tool => "`magician draw`, `engrave` and `run` use this bias",
        }
    }

    /// Evaluates the touched points. Fails if they contradict each other or are too close.
    pub(super) fn evaluate(
        self,
        touches: &[Touch],
        tool: Tool,
    ) -> Result<CalibrationResult, Diagnostic> {
        match (self, touches) {
            (Self::Sheet, [a, b, c]) => {
                let sheet = Sheet::touched([a.point(), b.point(), c.point()])?;
                Ok(CalibrationResult::Sheet(sheet.rounded()))
            }
            (Self::Surface, [touch]) => magician_job::Touch::of(touch.point())
                .map(|touch| CalibrationResult::Surface(touch.height))
                .ok_or_else(|| Diagnostic::of_file("the touched point is not finite")),
            (Self::Tool, [a, b]) => {
                let tip = Tip::touched([a.turn(), b.turn()], tool.bias())?;
                Ok(CalibrationResult::Tip(tip))
            }
            _ => Err(Diagnostic::of_file("wrong number of points")),
        }
    }
}

impl CalibrationResult {
    /// Saves the result in the settings.
    pub(super) fn keep(&self, config: &mut Config) -> Result<(), Failure> {
        let number = |name, value: f64| {
            let text = Key::named(name).map(|key| key.write(&value.to_string()));
            (name, text)
        };
        let (name, text) = match self {
            Self::Sheet(sheet) => return config.set_table("sheet", sheet),
            Self::Surface(height) => number("surface", *height),
            Self::Tip(tip) => ("tool", Key::named("tool").map(|key| key.write(&bias(tip)))),
        };
        match text {
            Some(Ok(text)) => config.set(name, &text),
            Some(Err(why)) => Err(Failure::invalid(format!("{name}: {why}"))),
            None => Err(Failure::new(crate::failure::Kind::Bug, name)),
        }
    }
}

/// Returns the bias of a tip in the notation that users type.
pub(super) fn bias(tip: &Tip) -> String {
    let [x, y, z] = tip.rounded_bias();
    format!("{x},{y},{z}")
}
