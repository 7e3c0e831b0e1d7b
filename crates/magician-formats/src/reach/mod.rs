//! Reach of a tool on a surface, and where a drawing fits within it.

mod fit;
mod hop;
mod hull;
mod outline;
mod travel;

use magician_host::{Error, Geometry, JointAngles, Limits, ToolBias};
use magician_motion::{ArmModel, ArmState, Ceilings, Move, MoveKind, Planner, Pose, Target};

use crate::Surface;
pub(crate) use hop::Travelling;
pub use hull::of as hull;
pub use travel::{APPROACH_HEIGHT, Above};

/// Reach of a tool on a surface and, lifted, above it.
///
/// It uses the same limits as the check before a run, so a drawing placed with it passes that
/// check.
///
/// ```
/// use magician_host::ToolBias;
/// use magician_formats::{Fit, Reach, Surface};
///
/// let reach = Reach::new(ToolBias::PEN, Surface::level(-60.0), 20.0);
/// assert!(reach.contains([240.0, 0.0]).is_ok());
/// let error = reach.contains([360.0, 0.0]).unwrap_err();
/// assert!(error.value() > error.limit()); // by how much
///
/// // A sheet of 80 x 60 mm in true size, in front of the arm: a point p of it goes to scale * p + offset.
/// let corners = [[0.0, 0.0], [80.0, 0.0], [80.0, 60.0], [0.0, 60.0]];
/// let place = reach.best_place(&corners, Fit::TrueSize)?;
/// assert_eq!(place.scale, 1.0);
/// assert!(corners.iter().all(|corner| reach.contains(place.of(*corner)).is_ok()));
/// # Ok::<(), magician_formats::Diagnostic>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    geometry: Geometry,
    limits: Limits,
    surface: Surface,
    lift: f64,
    r: f64,
}

/// Allowed scaling of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Fit {
    /// True size only.
    TrueSize,
    /// True size, or smaller if necessary.
    Shrink,
    /// Largest possible size.
    Fill,
}

/// Transform from a sheet to the arm: scaled about the origin of the sheet, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetTransform {
    /// Scale.
    pub scale: f64,
    /// Position of the sheet's origin, mm.
    pub offset: [f64; 2],
}

/// Returns the largest value that `check` accepts, found by bisection between `does`, which it
/// accepts, and `does_not`, which it refuses. The result is accepted.
#[must_use]
pub fn bisect(does: f64, does_not: f64, halvings: usize, check: impl Fn(f64) -> bool) -> f64 {
    let (mut does, mut does_not) = (does, does_not);
    for _ in 0..halvings {
        let scale = f64::midpoint(does, does_not);
        if check(scale) {
            does = scale;
        } else {
            does_not = scale;
        }
    }
    does
}

impl SheetTransform {
    /// Returns the position of a point of the sheet.
    #[must_use]
    pub fn of(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [dx, dy] = self.offset;
        [self.scale * x + dx, self.scale * y + dy]
    }
}

impl Reach {
    /// Creates the reach of a tool on a surface and `lift` mm above it, within the controller's own
    /// limits, at r = 0.
    #[must_use]
    pub fn new(tool: ToolBias, surface: Surface, lift: f64) -> Self {
        Self {
            geometry: Geometry::magician(tool),
            limits: ArmModel::MAGICIAN.certain,
            surface,
            lift,
            r: 0.0,
        }
    }

    /// Sets the rotation of the tool, deg.
    #[must_use]
    pub fn rotated_to(self, r: f64) -> Self {
        Self { r, ..self }
    }

    /// Sets other limits, such as [`ArmModel::guaranteed`](magician_motion::ArmModel::guaranteed).
    #[must_use]
    pub fn limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// Checks that the tool can be at a point of the surface and at the lift above it.
    ///
    /// # Errors
    /// [`Unreachable`](magician_host::ErrorKind::Unreachable) with the obstacle, the value and the
    /// limit.
    pub fn contains(&self, point: [f64; 2]) -> Result<(), Error> {
        self.heights(point).try_for_each(|lift| {
            let reached = self.state(point, lift).map(drop);
            reached.map_err(|error| match lift {
                0.0 => error,
                lift => lifted(&error, lift),
            })
        })
    }

    /// Heights above a point at which the tool must be checked so that it can be lifted straight
    /// up.
    ///
    /// These are both ends, and the heights at which the way comes closest to a limit. At a limit
    /// of a joint the wrist is on a circle around one end of a link, and closest to it at the
    /// height of the centre.
    fn heights(&self, point: [f64; 2]) -> impl Iterator<Item = f64> + use<> {
        let Geometry {
            rear_arm, forearm, ..
        } = self.geometry;
        let (j2, j3) = (self.limits.j2, self.limits.j3);
        let elbow = [j2.min, j2.max].map(|angle| rear_arm * libm::cos(angle.to_radians()));
        let turned = [j3.min, j3.max].map(|angle| -forearm * libm::sin(angle.to_radians()));
        let wrist = self.geometry.tool.z + self.surface.at(point);
        let between = 0.0..self.lift;
        let nearest = [0.0].into_iter().chain(elbow).chain(turned);
        let nearest = nearest.map(move |height| height - wrist);
        let nearest = nearest.filter(move |lift| between.contains(lift));
        [0.0, self.lift].into_iter().chain(nearest)
    }

    /// Checks that the tool can move straight between two points, on the surface and at the lift
    /// above it.
    ///
    /// # Errors
    /// Same as [`contains`](Self::contains).
    pub fn contains_line(&self, from: [f64; 2], to: [f64; 2]) -> Result<(), Error> {
        self.line(from, to, 0.0)?;
        self.line(from, to, self.lift)
            .map_err(|error| lifted(&error, self.lift))
    }

    fn pose(&self, [x, y]: [f64; 2], lift: f64) -> Pose {
        Pose::new(x, y, self.surface.at([x, y]) + lift, self.r)
    }

    fn state(&self, point: [f64; 2], lift: f64) -> Result<ArmState, Error> {
        let pose = self.pose(point, lift);
        Ok(ArmState::at_pose(&self.geometry, &pose, &self.limits)?)
    }

    /// Same as `contains`, without an error and with less work.
    pub(crate) fn has(&self, point: [f64; 2]) -> bool {
        self.heights(point)
            .all(|lift| self.joints(point, lift).is_some())
    }

    /// Returns the joint angles for the tool `lift` mm above a point of the surface. `None` if it
    /// is out of reach.
    #[must_use]
    pub fn joints(&self, point: [f64; 2], lift: f64) -> Option<JointAngles> {
        let pose = self.pose(point, lift);
        self.geometry.inverse_within(&pose, &self.limits).ok()
    }

    fn line(&self, from: [f64; 2], to: [f64; 2], lift: f64) -> Result<(), Error> {
        let start = self.state(from, lift)?;
        let planner = Planner {
            geometry: self.geometry,
            limits: self.limits,
            ceilings: Ceilings::default(),
            law: ArmModel::MAGICIAN.law,
            speeds: ArmModel::MAGICIAN.power_up.speeds(),
        };
        let request = Move {
            target: Target::Pose(self.pose(to, lift)),
            kind: MoveKind::Line,
        };
        match planner.plan(&start, &request)?.crossing {
            Some(crossing) => Err(crossing.cause.into()),
            None => Ok(()),
        }
    }
}

/// Rewords an error for a lifted tool.
fn lifted(error: &Error, lift: f64) -> Error {
    error.reworded(format!("with the tool lifted by {lift} mm: {error}"))
}
