//! Dimensions of the arm: two links, and the tool at the end of them.

use core::fmt;
use core::str::FromStr;

/// Length of the rear arm, shoulder axis to elbow axis, mm (model section 1).
pub(crate) const REAR_ARM: f64 = 135.0;
/// Length of the forearm, elbow axis to wrist axis, mm (model section 1).
pub(crate) const FOREARM: f64 = 147.0;

/// Offset of the tool from the wrist axis, mm: the protocol's end-effector bias.
///
/// `x` points away from the base along the arm, `y` to its left, and a positive `z` means that the
/// tool hangs down by that much (model section 2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolBias {
    /// Forward of the wrist axis, mm.
    pub x: f64,
    /// Left of the wrist axis, mm.
    pub y: f64,
    /// Below the wrist axis, mm.
    pub z: f64,
}

impl ToolBias {
    /// No tool: poses are those of the wrist axis. The bias of a new arm.
    pub const NONE: Self = Self::forward_by(0.0);
    /// The suction cup, 59.7 mm forward (model section 1, measured).
    pub const SUCTION: Self = Self::forward_by(59.7);
    /// The gripper, 59.7 mm forward (model section 1, measured).
    pub const GRIPPER: Self = Self::forward_by(59.7);
    /// The pen holder, 61 mm forward (model section 1).
    pub const PEN: Self = Self::forward_by(61.0);
    /// The laser, 70 mm forward (model section 1).
    pub const LASER: Self = Self::forward_by(70.0);

    /// The named tools, in the order of lists and messages.
    pub const NAMED: [(&'static str, Self); 5] = [
        ("none", Self::NONE),
        ("suction", Self::SUCTION),
        ("gripper", Self::GRIPPER),
        ("pen", Self::PEN),
        ("laser", Self::LASER),
    ];

    /// Creates a bias from x, y, z; mm.
    #[must_use]
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    const fn forward_by(x: f64) -> Self {
        Self::new(x, 0.0, 0.0)
    }

    /// Returns the bias of a named tool (`none`, `suction`, `gripper`, `pen`, `laser`; case does
    /// not matter). `None` if the name is unknown.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED
            .iter()
            .find(|(known, _)| known.eq_ignore_ascii_case(name))
            .map(|(_, bias)| *bias)
    }
}

/// Error: a text is neither the name of a tool nor a bias.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParseToolError;

impl fmt::Display for ParseToolError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("expected X,Y,Z in mm, or one of ")?;
        for (at, (name, _)) in ToolBias::NAMED.iter().enumerate() {
            let comma = if at == 0 { "" } else { ", " };
            write!(f, "{comma}{name}")?;
        }
        Ok(())
    }
}

impl core::error::Error for ParseToolError {}

/// Parses the name of a tool, or `X,Y,Z` in mm.
///
/// ```
/// use magician_motion::ToolBias;
///
/// assert_eq!("pen".parse(), Ok(ToolBias::PEN));
/// assert_eq!("61,0,5.5".parse(), Ok(ToolBias::new(61.0, 0.0, 5.5)));
/// assert!("61,0".parse::<ToolBias>().is_err());
/// ```
impl FromStr for ToolBias {
    type Err = ParseToolError;

    fn from_str(text: &str) -> Result<Self, ParseToolError> {
        if let Some(bias) = Self::named(text.trim()) {
            return Ok(bias);
        }
        let mut parts = text.split(',');
        let mut next = || -> Result<f64, ParseToolError> {
            let part = parts.next().ok_or(ParseToolError)?;
            let number: f64 = part.trim().parse().map_err(|_| ParseToolError)?;
            if number.is_finite() {
                Ok(number)
            } else {
                Err(ParseToolError)
            }
        };
        let bias = Self::new(next()?, next()?, next()?);
        match parts.next() {
            None => Ok(bias),
            Some(_) => Err(ParseToolError),
        }
    }
}

/// Dimensions of one arm: its links, and the tool bias in force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Length of the rear arm, mm.
    pub rear_arm: f64,
    /// Length of the forearm, mm.
    pub forearm: f64,
    /// The tool bias in force.
    pub tool: ToolBias,
}

impl Geometry {
    /// Returns the geometry of a Dobot Magician with this tool bias.
    #[must_use]
    pub const fn magician(tool: ToolBias) -> Self {
        Self {
            rear_arm: REAR_ARM,
            forearm: FOREARM,
            tool,
        }
    }
}

impl Default for Geometry {
    /// A Dobot Magician without a tool.
    fn default() -> Self {
        Self::magician(ToolBias::NONE)
    }
}
