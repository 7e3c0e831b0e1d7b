//! Options for reading G-code.

use std::fmt;
use std::str::FromStr;

use crate::Surface;

/// Tool that a G-code program drives. The words of G-code do not say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Dialect {
    /// Detect it from the program.
    ///
    /// * A servo-lifted pen if the program moves a servo (M280, M300).
    /// * A laser if it switches a spindle or a laser (M3, M4), a fan without extruding (M106), or
    ///   gives a power S, and nothing marks it as a mill's. Marks of a mill are: Z below 0 while X
    ///   or Y feeds, tool changes, coolant, tool length (G43), constant surface speed (G96),
    ///   drilling, and lifting between cuts without the header of a laser program.
    /// * A pen otherwise.
    #[default]
    Detect,
    /// A pen: M3 to M5, M106, M107 and S are left out.
    Pen,
    /// A laser.
    Laser,
    /// A pen that a servo lifts (M3 or M280 with angles, M300). The angle in force while X or Y
    /// feeds means down, any other means up. Z words are ignored.
    Servo,
}

impl Dialect {
    /// Names of the dialects that a user can choose.
    pub const NAMES: &'static [&'static str] = &["pen", "laser", "servo"];
}

impl FromStr for Dialect {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "pen" => Ok(Self::Pen),
            "laser" => Ok(Self::Laser),
            "servo" => Ok(Self::Servo),
            _ => Err("expected pen, laser or servo".to_owned()),
        }
    }
}

impl fmt::Display for Dialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Detect => "detect",
            Self::Pen => "pen",
            Self::Laser => "laser",
            Self::Servo => "servo",
        })
    }
}

/// Execution of a pen's arcs (G2, G3). A laser's arcs are always lines, because the arm has no
/// laser power on an arc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Arcs {
    /// Arcs of the arm, which stops at both ends of each.
    #[default]
    Arcs,
    /// Lines within the tolerance, without stops.
    Lines,
}

/// Options for reading G-code. Lengths are in mm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GcodeOptions {
    /// Tool that the program drives.
    pub dialect: Dialect,
    /// True if the program is to burn. Coolant (M7, M8) alone then counts as the air assist of a
    /// laser and not as the mark of a mill.
    pub burns: bool,
    /// Position of the arm when the program begins.
    ///
    /// Moves of a single axis and relative moves start from it. Only these draw from that position.
    /// If it is `None`, moves wait until the program has given X and Y, and the arm then comes from
    /// above; relative moves and arcs before that are refused.
    pub start: Option<[f64; 3]>,
    /// True if the program is placed on the sheet. Its coordinates are then its own: the tool is
    /// assumed at their origin at the start, with Z 0 at the surface until the program gives a Z.
    /// `start` is ignored.
    pub placed: bool,
    /// S word of full laser power.
    ///
    /// If `None`, the first of these: `$30` of the program before the laser is switched on; the
    /// value in LightBurn's comments; 255 where M106 is the laser; 1000 if no S exceeds it.
    pub s_max: Option<f64>,
    /// Speed of a laser that burns before the program gives an F, mm/s.
    pub laser_speed: f64,
    /// Surface that a servo-lifted pen is lowered to. If set, Z words are ignored.
    pub surface: Option<Surface>,
    /// Height of a lifted pen above that surface, mm.
    pub lift: f64,
    /// Speed of rapid moves (G0), mm/s, before the ratio in force on the arm.
    pub travel_speed: f64,
    /// Acceleration of rapid moves, mm/s2, before the ratio in force on the arm.
    pub travel_acceleration: f64,
    /// Acceleration along lines and arcs, mm/s2.
    pub acceleration: f64,
    /// Execution of a pen's arcs.
    pub arcs: Arcs,
    /// True if G28 homes the arm. Otherwise it is left out, because homing turns the base all the
    /// way to its switch.
    pub home: bool,
}

impl Default for GcodeOptions {
    fn default() -> Self {
        Self {
            dialect: Dialect::Detect,
            burns: false,
            start: None,
            placed: false,
            s_max: None,
            laser_speed: 20.0,
            surface: None,
            lift: 10.0,
            travel_speed: 200.0,
            travel_acceleration: 200.0,
            acceleration: 100.0,
            arcs: Arcs::Arcs,
            home: false,
        }
    }
}
