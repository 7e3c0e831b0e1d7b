use std::fmt;
use std::str::FromStr;

use crate::Surface;

/// What draws, as far as a program leaves it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Dialect {
    /// A pen that a servo lifts, if the program moves one (M280, M300); a laser if it switches a spindle or a laser (M3, M4), a
    /// fan without extruding (M106), or gives a power S, and is not a mill's: one that cuts in depth (Z below 0 while X or Y
    /// feeds), changes tools, switches coolant, counts in a tool's length (G43), turns at the speed of a surface (G96), drills, or lifts its
    /// tool between cuts, without the header of a laser's program. A pen otherwise.
    #[default]
    Detect,
    /// A pen: M3 to M5, M106, M107 and S are left out.
    Pen,
    /// A laser.
    Laser,
    /// A pen that a servo lifts (M3 or M280 with angles, M300): the angle in force while X or Y feeds is down, any other up.
    /// Z words do not count.
    Servo,
}

impl Dialect {
    /// The names of those that can be asked for.
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

/// How arcs (G2, G3) of a pen are done. A laser's are lines always: the arm has no power on an arc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Arcs {
    /// As arcs of the arm, which comes to rest at both ends of each.
    #[default]
    Arcs,
    /// As lines within the tolerance, without a stop.
    Lines,
}

/// How G-code is read, where it leaves a choice. Lengths are mm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GcodeOptions {
    /// What draws.
    pub dialect: Dialect,
    /// True if the program is to burn: coolant (M7, M8) alone does not make it a mill's then, but is the air assist of a laser.
    pub burns: bool,
    /// Where the arm stands when the program begins. Moves of one axis and relative moves begin there; nothing is drawn from
    /// there that the program does not count from there. Without it moves wait until the program has named X and Y, then the
    /// arm comes from above, and what counts from the start is refused: relative moves and arcs.
    pub start: Option<[f64; 3]>,
    /// The program is to be placed: its coordinates are its own, the tool is taken to stand at its zero when it begins, and Z
    /// is 0 where it touches until the program says Z. `start` counts for nothing then.
    pub placed: bool,
    /// The S at which the laser has full power. Without it: `$30` of the program, before the laser is switched on; what
    /// LightBurn's comments tell; 255 where M106 is the laser; 1000 if no S is above that.
    pub s_max: Option<f64>,
    /// Speed of a laser that burns before the program has said F, mm/s.
    pub laser_speed: f64,
    /// The surface that a pen goes down to which a servo lifts; Z words then do not count.
    pub surface: Option<Surface>,
    /// How far above the surface that pen is when it is up, mm.
    pub lift: f64,
    /// Speed of moves without drawing (G0), mm/s, before the ratio that is in force on the arm.
    pub travel_speed: f64,
    /// Acceleration of moves without drawing, mm/s2, before the ratio.
    pub travel_acceleration: f64,
    /// Acceleration along lines and arcs, mm/s2.
    pub acceleration: f64,
    /// How a pen's arcs are done.
    pub arcs: Arcs,
    /// Whether G28 homes the arm; it is left out if not, because homing turns the base all the way to its switch.
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
