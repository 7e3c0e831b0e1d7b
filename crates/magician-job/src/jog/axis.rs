//! What can be jogged: a coordinate, a joint, the rail.

use std::fmt;
use std::str::FromStr;

use magician::protocol::JogCommand;
use magician::{Set, words};

/// An axis that can be jogged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Forward, mm.
    X,
    /// To the left for who stands behind the arm, mm.
    Y,
    /// Up, mm.
    Z,
    /// Rotation of the tool, deg.
    R,
    /// The base, deg.
    J1,
    /// The rear arm, deg.
    J2,
    /// The forearm, deg.
    J3,
    /// The end effector's servo, deg.
    J4,
    /// The carriage on the rail, mm.
    L,
}

/// An axis and a direction on it; as text `x+`, `j3-`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JogDirection {
    /// What moves.
    pub axis: Axis,
    /// Towards larger coordinates or angles.
    pub forward: bool,
}

impl Axis {
    /// All of them.
    pub const ALL: [Self; 9] = [
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

    /// Its name in lower case: `x`, `j3`, `l`.
    #[must_use]
    pub const fn name(self) -> &'static str {
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

    /// Unit of its distances: `mm` or `deg`.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::X | Self::Y | Self::Z | Self::L => "mm",
            _ => "deg",
        }
    }

    /// The move by so many mm or degrees: straight for a coordinate.
    #[must_use]
    pub fn step(self, by: f32) -> Set {
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

/// By its [`name`](Axis::name), in upper or lower case.
impl FromStr for Axis {
    type Err = UnknownAxis;

    fn from_str(text: &str) -> Result<Self, UnknownAxis> {
        let mut known = Self::ALL.into_iter();
        known
            .find(|axis| axis.name().eq_ignore_ascii_case(text))
            .ok_or(UnknownAxis)
    }
}

/// The text is the name of no axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownAxis;

impl fmt::Display for UnknownAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("expected x, y, z, r, j1, j2, j3, j4, or l for the rail")
    }
}

impl std::error::Error for UnknownAxis {}

impl JogDirection {
    /// What begins to jog that way.
    #[must_use]
    pub fn jog(self) -> Set {
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
    #[must_use]
    pub fn signed(self, length: f32) -> f32 {
        if self.forward { length } else { -length }
    }
}

/// `x+`, `j3-`.
impl fmt::Display for JogDirection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.forward { '+' } else { '-' };
        write!(f, "{}{sign}", self.axis.name())
    }
}
