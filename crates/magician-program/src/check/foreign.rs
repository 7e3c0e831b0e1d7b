//! Detection of coordinates meant for another machine.

use magician_host::message;
use magician_host::{Action, Setting, SettingValue};

use super::Report;
use crate::setup::extent_of_marks;
use crate::{Diagnostic, Plan};

/// Distance from the base axis within which no program for this arm draws, mm.
const BASE_RADIUS: f64 = 110.0;
/// Distance beyond the reach from which a program is taken to be meant for another machine, mm. A
/// choice.
const FOREIGN_DISTANCE: f64 = 100.0;

/// Explains a refused program in arm coordinates that looks like one for another machine.
///
/// Such a program draws only far beyond the reach, or leads into the arm's base, because its zero
/// is the corner of another machine. `None` for any other program.
#[must_use]
pub fn foreign_coordinates(plan: &Plan, report: &Report) -> Option<Diagnostic> {
    let refused = || report.refused_steps.iter();
    let (first, beyond) = refused().find_map(|step| Some((step, step.beyond()?)))?;
    let is_in_base = |at: [f64; 3]| libm::hypot(at[0], at[1]) < BASE_RADIUS;
    let mut targets = refused().filter_map(|step| step.target.map(|(_, _, at)| at));
    // A program that is partly in reach was probably made for this arm.
    let is_far = report.bounds.is_none() && beyond > FOREIGN_DISTANCE;
    if !is_far && !targets.any(is_in_base) {
        return None;
    }
    let [least, most] = extent_of_marks(plan).or_else(|| plan.extent())?;
    let [x, y] = [0, 1].map(|axis| format!("{:.0} to {:.0}", least[axis], most[axis]));
    let message = message!(
        "its coordinates look like those of another machine: it draws at x {x}, y {y} mm, and x 0, y 0 is \
            the axis of this arm's base",
        x,
        y
    );
    let problem = Diagnostic::new(first.origin, message)
        .remedy(
            (Setting::Place, SettingValue::On),
            "lays it in front of the arm",
        )
        .remedy((Setting::Fit, SettingValue::On), "chooses its size as well");
    let burns = plan.steps.iter().any(|step| step.action.is_of_a_laser());
    Some(if burns {
        problem.remedy(Action::Engrave, "lays it in front of the arm, too")
    } else {
        problem
    })
}
