//! What of a fence is broken, and what is wrong with one.

use core::fmt;

/// A part of a [`Fence`](super::Fence).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FencePart {
    /// The lowest z.
    Floor,
    /// A side of the box that the tip stays in.
    Box {
        /// 0 for x, 1 for y, 2 for z.
        axis: usize,
        /// The side at its higher end.
        upper: bool,
    },
    /// A box that the tip stays out of, counted from 0.
    KeepOut(usize),
    /// The highest speed of the tip.
    TopSpeed,
    /// The strongest that the laser may burn.
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

    /// Its name in configuration and JSON: `floor`, `box`, `keep_out`, `top_speed`, `strongest_laser`.
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

    /// The unit of its values.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Floor | Self::Box { .. } | Self::KeepOut(_) => "mm",
            Self::TopSpeed => "mm/s",
            Self::Laser => "%",
        }
    }
}

/// A part of a fence that a motion or a command would break.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Breach {
    /// Which part.
    pub part: FencePart,
    /// The coordinate, the speed or the power that it would be; for a keep-out how deep the tip would be in it, mm.
    pub value: f64,
    /// What is allowed; 0 for a keep-out.
    pub limit: f64,
    /// Where the tip would be, mm.
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

/// Why there is no such fence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FenceError {
    /// NaN or infinity.
    NotFinite(FencePart),
    /// The first corner of a box is not below the second one on this axis.
    Inverted {
        /// Which box.
        part: FencePart,
        /// 0 for x, 1 for y, 2 for z.
        axis: usize,
    },
    /// A number out of its range.
    OutOfRange(FencePart, f64),
    /// More keep-outs than one may have.
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
