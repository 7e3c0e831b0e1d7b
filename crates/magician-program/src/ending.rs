//! Pen and arm at the end of a program or after a stop.

use magician_host::build::move_to;
use magician_host::message;
use magician_host::{Error, Result};

use crate::{Depths, Plan, RemainingProgram, Surface};

/// Treatment of pen and arm at the end of a program. The motion itself is done by the driver:
/// `Arm::lift` and `Arm::park`.
///
/// ```
/// use magician_program::{Action, Ending, Origin, Plan, Tool};
///
/// let mut plan = Plan::new("a line");
/// plan.tool = Some(Tool::Pen);
/// plan.push(Action::Path { to: [240.0, 0.0, -50.0] }, Origin::NONE);
/// let ending = Ending { lift: 10.0, ..Ending::default() };
/// assert_eq!(ending.after_stop(&plan), Some(10.0));
/// // The remaining lift after the plan's own last steps.
/// assert_eq!(ending.after_done(&plan, [240.0, 0.0, -44.0]), Some(4.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ending {
    /// Height by which a pen is lifted, mm.
    pub lift: f64,
    /// True to leave the pen where it is.
    pub stay: bool,
    /// Parking position of the tool tip (x, y, z), mm.
    pub park: Option<[f64; 3]>,
    /// True if the program was made from a drawing, an image or G-code: its tool draws even if the
    /// program does not name one.
    pub drawing: bool,
    /// Treatment of depths below the surface: unless they are kept, a pen is not parked there
    /// either.
    pub depths: Depths,
}

impl Default for Ending {
    /// Lifts the pen as far as between two lines.
    fn default() -> Self {
        Self {
            lift: crate::artwork::Marking::pen().lift,
            stay: false,
            park: None,
            drawing: false,
            depths: Depths::default(),
        }
    }
}

impl Ending {
    /// True if a plan draws with a pen: its tool is a pen, or it has no tool, follows paths or
    /// arcs, and is a [drawing](Self::drawing) or names its surface. Plans for a laser, suction cup
    /// or gripper do not draw.
    #[must_use]
    pub fn draws(&self, plan: &Plan) -> bool {
        plan.draws(self.drawing)
    }

    /// Height by which the pen is lifted after a stop or in a pause, mm. `None` if the plan does
    /// not draw, or the pen shall stay.
    #[must_use]
    pub fn after_stop(&self, plan: &Plan) -> Option<f64> {
        Some(self.lift).filter(|_| !self.stay && self.draws(plan))
    }

    /// Height by which the tool at `at` (x, y, z) is lifted when the program is done, mm. A pen
    /// gets the part of its lift that the plan has not done yet; any other tool is lifted only
    /// before parking. `None` if no lift is needed.
    #[must_use]
    pub fn after_done(&self, plan: &Plan, at: [f64; 3]) -> Option<f64> {
        let up = if self.stay {
            None
        } else if self.draws(plan) {
            Some(plan.remaining_lift(at, self.lift))
        } else {
            self.park.map(|_| self.lift)
        };
        up.filter(|up| *up > 0.0)
    }

    /// True if the tool is a pen that must never go below its surface.
    fn is_held(&self, plan: &Plan) -> bool {
        self.depths == Depths::Flatten && self.draws(plan)
    }

    /// Checks that the arm can reach the parking position from the end of the program.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](magician_host::ErrorKind::InvalidInput) for a pen that would be
    /// parked below the surface; [`ErrorKind::Unreachable`](magician_host::ErrorKind::Unreachable)
    /// with value and limit if it is out of reach.
    pub fn check(&self, rest: &RemainingProgram) -> Result<()> {
        let Some(place) = self.park else {
            return Ok(());
        };
        let refused = |error: Error| {
            let [x, y, z] = place;
            error.reworded(format!("the tool cannot be parked at {x},{y},{z}: {error}"))
        };
        let whole = rest.whole();
        if let Some(surface) = whole.surface.filter(|_| self.is_held(whole)) {
            check_above(place, surface).map_err(refused)?;
        }
        let mut arm = rest.end();
        let Some(at) = arm.arm().map(|at| at.pose) else {
            let [x, y, z] = place.map(|value| value as f32);
            let there = arm.check(&move_to(x, y, z, 0.0));
            return there.map(drop).map_err(refused);
        };
        if let Some(up) = self.after_done(whole, [at.x, at.y, at.z]) {
            let lift = arm.lift(up).map_err(refused)?;
            for command in &lift.commands {
                arm.check(command).map_err(refused)?;
            }
        }
        arm.way_to_park(place).map(drop).map_err(refused)
    }
}

/// Checks that a pen is not parked below its surface.
fn check_above([x, y, z]: [f64; 3], surface: Surface) -> Result<()> {
    /// Depth that still counts as on the surface, mm: positions are rounded.
    const DEPTH_TOLERANCE: f64 = 0.01;
    let deep = surface.at([x, y]) - z;
    if deep <= DEPTH_TOLERANCE {
        return Ok(());
    }
    Err(Error::invalid(message!(
        "that is {deep:.1} mm below the surface",
        deep
    )))
}
