//! Coordinates of another machine, taken as the arm's.

use magician_host::{Action, Given, Setting};

use super::Report;
use crate::setup::{extent, extent_of_marks};
use crate::{Diagnostic, Plan};

/// Nothing is drawn so near to the axis of the arm's base, mm.
const BASE: f64 = 110.0;

/// Why a program in the arm's coordinates is refused whose coordinates look like those of another machine: nothing that it draws
/// is within reach, or it leads into the arm's own base, as a program does that is drawn from a machine's zero.
#[must_use]
pub fn foreign_coordinates(plan: &Plan, report: &Report) -> Option<Diagnostic> {
    let refused = || report.refused_steps.iter();
    let beyond = refused().find(|step| step.beyond().is_some())?;
    let is_in_base = |at: [f64; 3]| libm::hypot(at[0], at[1]) < BASE;
    let mut targets = refused().filter_map(|step| step.target.map(|(_, at)| at));
    if report.bounds.is_some() && !targets.any(is_in_base) {
        return None;
    }
    let [least, most] = extent_of_marks(plan).or_else(|| extent(plan))?;
    let [x, y] = [0, 1].map(|axis| format!("{:.0} to {:.0}", least[axis], most[axis]));
    let message = format!(
        "its coordinates look like those of another machine: it draws at x {x}, y {y} mm, and x 0, y 0 is \
            the axis of this arm's base"
    );
    let problem = Diagnostic::new(beyond.origin, message)
        .remedy((Setting::Place, Given::On), "lays it in front of the arm")
        .remedy((Setting::Fit, Given::On), "chooses its size as well");
    let burns = plan.steps.iter().any(|step| step.action.is_of_a_laser());
    Some(match burns {
        true => problem.remedy(Action::Engrave, "lays it in front of the arm, too"),
        false => problem,
    })
}
