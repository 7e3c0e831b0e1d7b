//! Whether a program is a mill's, whose S is the speed of a spindle.

use super::Line;
use super::block::Block;
use super::power::setting;
use crate::Origin;

/// What a program does that a laser's does not, and whether its header is a laser's.
#[derive(Clone, Debug, Default)]
pub(super) struct Mill {
    /// The first sign of a mill, and where.
    sign: Option<(String, Origin)>,
    laser: bool,
    /// Something has moved: the header is over.
    moved: bool,
    /// The height by then, in the program's own unit and coordinates.
    z: f64,
    tool: Option<f64>,
}

impl Mill {
    /// Reads the comments and settings of a line: `$32=1` is the laser mode of a controller.
    pub(super) fn read(&mut self, text: &str) {
        if self.moved || self.laser {
            return;
        }
        let comment = text.find([';', '(']).and_then(|at| text.get(at..));
        let comment = comment.unwrap_or_default().to_ascii_lowercase();
        self.laser = ["laser", "lightburn"]
            .iter()
            .any(|name| comment.contains(name))
            || setting(text, "$32").is_some_and(|mode| mode == 1.0);
    }

    /// Looks at the words of a line; `relative` and `places` are what its Z is, `marks` whether X or Y is fed on it.
    pub(super) fn look(
        &mut self,
        block: &Block,
        line: &Line<'_>,
        (relative, places): (bool, bool),
        marks: bool,
    ) {
        self.moved |= block.has_any(b"XYZ");
        let called = block.has(b'G', 92);
        if let Some(z) = block.number(b'Z').filter(|_| called || !places) {
            let from = if relative && !called { self.z } else { 0.0 };
            self.z = from + z;
        }
        let tool = block.number(b'T');
        let changes = tool.is_some() && self.tool.is_some() && tool != self.tool;
        self.tool = tool.or(self.tool);
        let sign = if marks && self.z < 0.0 {
            format!("it cuts in depth, at Z{}", self.z)
        } else if block.has(b'M', 6) || changes {
            "it changes tools".to_owned()
        } else if block.has(b'M', 7) || block.has(b'M', 8) {
            "it switches coolant".to_owned()
        } else {
            return;
        };
        if self.sign.is_none() {
            self.sign = Some((sign, line.origin(&block.range)));
        }
    }

    /// Whether its header is a laser's.
    pub(super) fn has_laser(&self) -> bool {
        self.laser
    }

    /// By what it is known as a mill's, and where.
    pub(super) fn sign(&self) -> Option<(&str, Origin)> {
        let (sign, origin) = self.sign.as_ref().filter(|_| !self.laser)?;
        Some((sign, *origin))
    }
}
