//! Axes and directions of jogs: coordinates, joints, the rail.

use std::fmt;
use std::str::FromStr;

use magician_protocol::commands::JogCmd;
use magician_protocol::{Flag, JogCommand, Set};

use super::{line_by, move_joints_by, rail_by};
use crate::{Action, Error, ErrorCode, Message, message};

/// An axis that can be jogged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Forward, mm.
    X,
    /// To the left as seen from behind the arm, mm.
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

/// Axis and direction of a jog (document 1.9.4, errata E25); as text `x+`, `j3-`.
///
/// A separate type, so that functions for jogs cannot be given a move, or the command that ends a
/// jog. The command on the line is a [`JogCmd`].
///
/// ```
/// use magician_host::build::{Axis, JogDirection};
///
/// # fn main() -> Result<(), magician_host::build::UnknownAxis> {
/// let up: JogDirection = "z+".parse()?;
/// assert_eq!(up, Axis::Z.plus());
/// assert_eq!(Axis::J1.minus().to_string(), "j1-");
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct JogDirection {
    /// Axis that moves.
    pub axis: Axis,
    /// True for larger coordinates or angles.
    pub forward: bool,
}

impl Axis {
    /// All axes.
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

    /// Name in lower case: `x`, `j3`, `l`.
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

    /// Unit of distances: `mm` or `deg`.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::X | Self::Y | Self::Z | Self::L => "mm",
            _ => "deg",
        }
    }

    /// Direction of larger coordinates or angles.
    #[must_use]
    pub const fn plus(self) -> JogDirection {
        let forward = true;
        JogDirection {
            axis: self,
            forward,
        }
    }

    /// Direction of smaller coordinates or angles.
    #[must_use]
    pub const fn minus(self) -> JogDirection {
        let forward = false;
        JogDirection {
            axis: self,
            forward,
        }
    }

    /// Move by this distance, mm or degrees; straight for a coordinate.
    #[must_use]
    pub fn step(self, by: f32) -> Set {
        match self {
            Self::X => line_by(by, 0.0, 0.0, 0.0),
            Self::Y => line_by(0.0, by, 0.0, 0.0),
            Self::Z => line_by(0.0, 0.0, by, 0.0),
            Self::R => line_by(0.0, 0.0, 0.0, by),
            Self::J1 => move_joints_by(by, 0.0, 0.0, 0.0),
            Self::J2 => move_joints_by(0.0, by, 0.0, 0.0),
            Self::J3 => move_joints_by(0.0, 0.0, by, 0.0),
            Self::J4 => move_joints_by(0.0, 0.0, 0.0, by),
            Self::L => rail_by(by),
        }
    }
}

/// Parses the [`name`](Axis::name), ignoring case.
impl FromStr for Axis {
    type Err = UnknownAxis;

    fn from_str(text: &str) -> Result<Self, UnknownAxis> {
        let mut known = Self::ALL.into_iter();
        known
            .find(|axis| axis.name().eq_ignore_ascii_case(text))
            .ok_or(UnknownAxis)
    }
}

/// Error of a text that names no axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownAxis;

impl fmt::Display for UnknownAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("expected x, y, z, r, j1, j2, j3, j4, or l for the rail")
    }
}

impl std::error::Error for UnknownAxis {}

impl JogDirection {
    /// Signed distance of a step of this length.
    #[must_use]
    pub fn signed(self, length: f32) -> f32 {
        if self.forward { length } else { -length }
    }
}

/// Parses the name of an [`Axis`] followed by `+` or `-`.
impl FromStr for JogDirection {
    type Err = UnknownAxis;

    fn from_str(text: &str) -> Result<Self, UnknownAxis> {
        let (axis, forward) = match text.strip_suffix('+') {
            Some(axis) => (axis, true),
            None => (text.strip_suffix('-').ok_or(UnknownAxis)?, false),
        };
        let axis = axis.parse()?;
        Ok(Self { axis, forward })
    }
}

impl From<JogDirection> for JogCmd {
    fn from(direction: JogDirection) -> Self {
        use JogCommand::{
            Axis1Minus, Axis1Plus, Axis2Minus, Axis2Plus, Axis3Minus, Axis3Plus, Axis4Minus,
            Axis4Plus, RailMinus, RailPlus,
        };
        let (is_joint, plus, minus) = match direction.axis {
            Axis::X => (Flag::OFF, Axis1Plus, Axis1Minus),
            Axis::Y => (Flag::OFF, Axis2Plus, Axis2Minus),
            Axis::Z => (Flag::OFF, Axis3Plus, Axis3Minus),
            Axis::R => (Flag::OFF, Axis4Plus, Axis4Minus),
            Axis::J1 => (Flag::ON, Axis1Plus, Axis1Minus),
            Axis::J2 => (Flag::ON, Axis2Plus, Axis2Minus),
            Axis::J3 => (Flag::ON, Axis3Plus, Axis3Minus),
            Axis::J4 => (Flag::ON, Axis4Plus, Axis4Minus),
            // The coordinate frame does not matter to the rail; the joint flag is a choice.
            Axis::L => (Flag::ON, RailPlus, RailMinus),
        };
        let cmd = if direction.forward { plus } else { minus };
        Self { is_joint, cmd }
    }
}

impl From<JogDirection> for Set {
    fn from(direction: JogDirection) -> Self {
        JogCmd::from(direction).into()
    }
}

/// Returns the direction of a jog command.
///
/// # Errors
/// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for a command that does not start a
/// jog.
impl TryFrom<&Set> for JogDirection {
    type Error = Error;

    fn try_from(command: &Set) -> Result<Self, Error> {
        let wrong = |message: Message| {
            Error::new(ErrorCode::WrongCommand, message).with_command(command.row().set_name)
        };
        let Set::JogCmd(jog) = command else {
            return Err(wrong(message!("it is not a jog command")));
        };
        let axes = if jog.is_joint.is_on() {
            [Axis::J1, Axis::J2, Axis::J3, Axis::J4]
        } else {
            [Axis::X, Axis::Y, Axis::Z, Axis::R]
        };
        // The rail has its own values in both coordinate frames.
        let (axis, forward) = match jog.cmd {
            JogCommand::RailPlus => (Axis::L, true),
            JogCommand::RailMinus => (Axis::L, false),
            JogCommand::Stop => {
                let stop = wrong(message!("a stop does not begin a jog"));
                return Err(stop.remedy(Action::StopJog, "ends one"));
            }
            other => match other.axis() {
                Some((number, forward)) => (axes[number], forward),
                // A value beyond the protocol's: the arm's behaviour is unknown.
                None => return Err(wrong(message!("unknown axis"))),
            },
        };
        Ok(Self { axis, forward })
    }
}

/// Formats the direction as `x+` or `j3-`.
impl fmt::Display for JogDirection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.forward { '+' } else { '-' };
        write!(f, "{}{sign}", self.axis.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn direction_round_trips_through_text_and_command() {
        for axis in Axis::ALL {
            for direction in [axis.plus(), axis.minus()] {
                assert_eq!(direction.to_string().parse(), Ok(direction));
                assert_eq!(
                    JogDirection::try_from(&Set::from(direction)).unwrap(),
                    direction
                );
            }
        }
        for text in ["", "+", "x", "x*", "j5+", "x++"] {
            assert_eq!(text.parse::<JogDirection>(), Err(UnknownAxis), "{text}");
        }
    }

    #[test]
    fn frames_that_start_no_jog_are_not_recognised_as_one() {
        let jog = |cmd| {
            Set::from(JogCmd {
                is_joint: Flag::ON,
                cmd,
            })
        };
        for command in [
            crate::build::home(),
            jog(JogCommand::Stop),
            jog(JogCommand::from(11)),
        ] {
            let error = JogDirection::try_from(&command).unwrap_err();
            assert_eq!(error.code(), ErrorCode::WrongCommand, "{error}");
        }
    }
}
