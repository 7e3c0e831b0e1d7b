//! Detection of programs for a mill, whose S is the speed of a spindle and not the power of a
//! laser.

use magician_host::{Message, message};

use super::SourceLine;
use super::block::Block;
use super::modes::Modes;
use super::power::setting;
use crate::Origin;

/// Sign of a mill that also occurs in laser programs, as air assist.
fn coolant_sign() -> Message {
    message!("it switches coolant")
}

/// Tracks whether a tool is lifted, moved across and fed down again, which a laser never is.
#[derive(Clone, Debug, Default)]
struct Lifts {
    /// Z of the last cut.
    cut: Option<f64>,
    /// Height above it at which the tool moved across, and whether it was fed down since.
    across: Option<f64>,
    fed_down: bool,
}

impl Lifts {
    /// Follows a change of Z. Returns true if a second cut begins.
    fn follow(&mut self, from: f64, to: f64, (travels, feeds, marks): (bool, bool, bool)) -> bool {
        if travels && self.cut.is_some_and(|cut| to > cut) {
            self.across = Some(to);
        }
        self.fed_down |= feeds && to < from && self.across.is_some();
        if !marks {
            return false;
        }
        let again = self.fed_down && self.across.is_some_and(|across| to < across);
        *self = Self {
            cut: Some(to),
            ..Self::default()
        };
        again
    }
}

/// Signs of a mill in a program, and of a laser in its header.
#[derive(Clone, Debug, Default)]
pub(super) struct Mill {
    /// First sign of a mill, with its place.
    sign: Option<(Message, Origin)>,
    laser: bool,
    /// True if coolant is the air assist of a laser.
    has_air_assist: bool,
    /// True once something has moved, which ends the header.
    moved: bool,
    /// Current height, in the program's own unit and coordinates.
    z: f64,
    tool: Option<f64>,
    lifts: Lifts,
}

impl Mill {
    pub(super) fn new(has_air_assist: bool) -> Self {
        Self {
            has_air_assist,
            ..Self::default()
        }
    }

    /// Examines comments and settings of a line. `$32=1` is the laser mode of a controller.
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

    /// Examines the words of a line. `places` is true if its coordinates are not positions in
    /// program coordinates; `marks` is true if it feeds X or Y.
    pub(super) fn examine(
        &mut self,
        block: &Block,
        line: &SourceLine<'_>,
        modes: &Modes,
        (places, marks): (bool, bool),
    ) {
        self.moved |= block.has_any(b"XYZ");
        let before = self.z;
        let called = block.has(b'G', 92);
        if let Some(z) = block.number(b'Z').filter(|_| called || !places) {
            let from = if modes.relative && !called {
                self.z
            } else {
                0.0
            };
            self.z = from + z;
        }
        let tool = block.number(b'T');
        let changes = tool.is_some() && self.tool.is_some() && tool != self.tool;
        self.tool = tool.or(self.tool);
        let travels = !modes.feeds() && !places && block.has_any(b"XY");
        let lifts = self
            .lifts
            .follow(before, self.z, (travels, modes.feeds(), marks));
        if self.sign.is_some() {
            return;
        }
        let sign = if marks && self.z < 0.0 {
            message!("it cuts at Z{z}", z = self.z)
        } else if block.has(b'M', 6) || changes {
            message!("it changes tools")
        } else if !self.has_air_assist && (block.has(b'M', 7) || block.has(b'M', 8)) {
            coolant_sign()
        } else if modes.drills() {
            message!("it drills, G81 to G89")
        } else if block.has(b'G', 43) {
            message!("it applies a tool length, G43")
        } else if block.has(b'G', 96) {
            message!("it uses constant surface speed, G96")
        } else if lifts {
            message!("it lifts its tool between cuts")
        } else {
            return;
        };
        self.sign = Some((sign, line.origin(&block.range)));
    }

    /// True if coolant is the first sign of a mill.
    pub(super) fn is_cooled_alone(&self) -> bool {
        { self.sign.as_ref() }.is_some_and(|(sign, _)| *sign == coolant_sign())
    }

    /// True if the header is a laser's.
    pub(super) fn has_laser(&self) -> bool {
        self.laser
    }

    /// Returns the sign of a mill, with its place; `None` if the header is a laser's.
    pub(super) fn sign(&self) -> Option<(&Message, Origin)> {
        let (sign, origin) = self.sign.as_ref().filter(|_| !self.laser)?;
        Some((sign, *origin))
    }
}
