use crate::Surface;

/// What the help of a [`Problem`](crate::Problem) ends with that a known start would solve: [`GcodeOptions::start`].
pub(crate) const NEEDS_START: &str = "say where the arm stands when the program begins";

/// What draws, as far as a program leaves it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Dialect {
    /// A laser if the program switches a spindle or a laser (M3, M4), a fan without extruding (M106), or gives a power S;
    /// a pen otherwise.
    #[default]
    Detect,
    /// A pen: M3 to M5, M106, M107 and S are left out.
    Pen,
    /// A laser.
    Laser,
}

/// How arcs (G2, G3) of a pen are done. A laser's are lines always: the arm has no power on an arc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
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
    /// Where the arm stands when the program begins. Without it moves wait until the program has named X and Y, a Z that is
    /// needed earlier is the first one of the program (0 if it has none), and what depends on the start is refused: relative
    /// moves, a laser that burns at once.
    pub start: Option<[f64; 3]>,
    /// The S at which the laser has full power. Without it 255, or 1000 for a program with greater ones.
    pub laser_range: Option<f64>,
    /// The surface that the pen of `M300 S30` goes down to; Z words then do not count.
    pub surface: Option<Surface>,
    /// How far above the surface the pen of `M300 S50` is, mm.
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
            start: None,
            laser_range: None,
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
