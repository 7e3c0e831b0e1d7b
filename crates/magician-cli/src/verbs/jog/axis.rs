//! What can be jogged: a coordinate, a joint, the rail.

use std::str::FromStr;

use magician::protocol::JogCommand;
use magician::{Set, words};

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    X,
    Y,
    Z,
    R,
    J1,
    J2,
    J3,
    J4,
    /// The rail.
    L,
}

/// An axis and a direction on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heading {
    pub(crate) axis: Axis,
    pub(crate) forward: bool,
}

impl Axis {
    pub(crate) const ALL: [Self; 9] = [
        Self::X,
        Self::Y,
        Self::Z,
        Self::R,
        Self::J1,
        Self::J2,
        Self::J3,
        Self::J4,
        Self::L,
    ];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::R => "r",
            Self::J1 => "j1",
            Self::J2 => "j2",
            Self::J3 => "j3",
            Self::J4 => "j4",
            Self::L => "l",
        }
    }

    pub(crate) const fn unit(self) -> &'static str {
        match self {
            Self::X | Self::Y | Self::Z | Self::L => "mm",
            _ => "deg",
        }
    }

    /// The move by so many mm or degrees: straight for a coordinate.
    pub(crate) fn step(self, by: f32) -> Set {
        match self {
            Self::X => words::line_by(by, 0.0, 0.0, 0.0),
            Self::Y => words::line_by(0.0, by, 0.0, 0.0),
            Self::Z => words::line_by(0.0, 0.0, by, 0.0),
            Self::R => words::line_by(0.0, 0.0, 0.0, by),
            Self::J1 => words::move_joints_by(by, 0.0, 0.0, 0.0),
            Self::J2 => words::move_joints_by(0.0, by, 0.0, 0.0),
            Self::J3 => words::move_joints_by(0.0, 0.0, by, 0.0),
            Self::J4 => words::move_joints_by(0.0, 0.0, 0.0, by),
            Self::L => words::rail_by(by),
        }
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut known = Self::ALL.into_iter();
        known
            .find(|axis| axis.name().eq_ignore_ascii_case(text))
            .ok_or_else(|| "expected x, y, z, r, j1, j2, j3, j4, or l for the rail".to_owned())
    }
}

impl Heading {
    /// What begins to jog that way.
    pub(crate) fn jog(self) -> Set {
        use JogCommand::{
            Axis1Minus, Axis1Plus, Axis2Minus, Axis2Plus, Axis3Minus, Axis3Plus, Axis4Minus,
            Axis4Plus,
        };
        let way = |plus, minus| if self.forward { plus } else { minus };
        match self.axis {
            Axis::X => words::jog_axis(way(Axis1Plus, Axis1Minus)),
            Axis::Y => words::jog_axis(way(Axis2Plus, Axis2Minus)),
            Axis::Z => words::jog_axis(way(Axis3Plus, Axis3Minus)),
            Axis::R => words::jog_axis(way(Axis4Plus, Axis4Minus)),
            Axis::J1 => words::jog_joint(way(Axis1Plus, Axis1Minus)),
            Axis::J2 => words::jog_joint(way(Axis2Plus, Axis2Minus)),
            Axis::J3 => words::jog_joint(way(Axis3Plus, Axis3Minus)),
            Axis::J4 => words::jog_joint(way(Axis4Plus, Axis4Minus)),
            Axis::L => words::jog_rail(self.forward),
        }
    }

    /// The signed distance of a step of that length.
    pub(crate) fn signed(self, length: f32) -> f32 {
        if self.forward { length } else { -length }
    }
}

/// `x+`, `j3-`.
impl std::fmt::Display for Heading {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = if self.forward { '+' } else { '-' };
        write!(f, "{}{sign}", self.axis.name())
    }
}
