//! Breaches of a fence, and errors in its definition.

use core::fmt;

/// A part of a [`Fence`](super::Fence).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FencePart {
    /// Lowest z of the tip.
    Floor,
    /// A side of the box that the tip stays in.
    Box {
        /// 0 for x, 1 for y, 2 for z.
        axis: usize,
        /// True for the side with the higher coordinate.
        upper: bool,
    },
    /// A box that the tip stays out of; index from 0.
    KeepOut(usize),
    /// Highest speed of the tip.
    TopSpeed,
    /// Highest power of the laser.
    Laser,
}

impl FencePart {
    pub(super) const BOX: Self = Self::Box {
        axis: 0,
        upper: false,
    };
    pub(super) const SIDES: [Self; 6] = [
        Self::side(0, false),
        Self::side(0, true),
        Self::side(1, false),
        Self::side(1, true),
        Self::side(2, false),
        Self::side(2, true),
    ];

    const fn side(axis: usize, upper: bool) -> Self {
        Self::Box { axis, upper }
    }

    /// Name in configuration and JSON: `floor`, `box`, `keep_out`, `top_speed`, `strongest_laser`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Floor => "floor",
            Self::Box { .. } => "box",
            Self::KeepOut(_) => "keep_out",
            Self::TopSpeed => "top_speed",
            Self::Laser => "strongest_laser",
        }
    }

    /// Unit of the values of this part.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Floor | Self::Box { .. } | Self::KeepOut(_) => "mm",
            Self::TopSpeed => "mm/s",
            Self::Laser => "%",
        }
    }
}

/// Breach of one part of a fence by a motion or a command.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Breach {
    /// Part that is broken.
    pub part: FencePart,
    /// Coordinate, speed or power that would result; for a keep-out the depth of the tip inside it,
    /// mm.
    pub value: f64,
    /// Value of the bound; 0 for a keep-out.
    pub limit: f64,
    /// Position of the tip, mm; `None` for speed and laser.
    pub at: Option<[f64; 3]>,
}

fn axis_name(axis: usize) -> &'static str {
    ["x", "y", "z"].get(axis).copied().unwrap_or("z")
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            part,
            value,
            limit,
            at,
        } = self;
        match part {
            FencePart::Floor => write!(
                f,
                "the tool tip would be at z {value:.1} mm, the fence's floor is {limit:.1} mm"
            ),
            FencePart::Box { axis, upper } => {
                let verb = if *upper { "ends" } else { "begins" };
                let axis = axis_name(*axis);
                write!(
                    f,
                    "the tool tip would be at {axis} {value:.1} mm, the fence's box {verb} at {limit:.1} mm"
                )
            }
            FencePart::KeepOut(nth) => {
                let [x, y, z] = at.unwrap_or_default();
                let nth = nth + 1;
                write!(
                    f,
                    "the tool tip would be at x {x:.1}, y {y:.1}, z {z:.1} mm, {value:.1} mm inside keep-out {nth} of \
                     the fence"
                )
            }
            FencePart::TopSpeed => write!(
                f,
                "the tool tip would go at {value:.1} mm/s, the fence's top speed is {limit:.1} mm/s"
            ),
            FencePart::Laser => write!(
                f,
                "the laser would burn at {value:.1} %, the fence allows {limit:.1} %"
            ),
        }
    }
}

impl core::error::Error for Breach {}

/// Error in the definition of a fence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FenceError {
    /// A number is NaN or infinite.
    NotFinite(FencePart),
    /// The first corner of a box is not below the second one on this axis.
    Inverted {
        /// The box in question.
        part: FencePart,
        /// 0 for x, 1 for y, 2 for z.
        axis: usize,
    },
    /// A number is out of its range.
    OutOfRange(FencePart, f64),
    /// More keep-outs than a fence can hold.
    TooMany,
}

impl fmt::Display for FenceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(part) => write!(f, "{}: expected finite numbers", part.name()),
            Self::Inverted { part, axis } => write!(
                f,
                "{}: the first corner must be below the second, and is not on {}",
                part.name(),
                axis_name(*axis)
            ),
            Self::OutOfRange(FencePart::Laser, value) => {
                write!(f, "strongest_laser: {value} is not 0 to 100 %")
            }
            Self::OutOfRange(part, value) => {
                write!(f, "{}: {value} must be above 0", part.name())
            }
            Self::TooMany => write!(
                f,
                "keep_out: more than {} boxes",
                super::Fence::MOST_KEEP_OUTS
            ),
        }
    }
}

impl core::error::Error for FenceError {}
