//! The size in which a plan would be within reach where it lies.

use magician::Geometry;
use magician::words::Preflight;

use super::{check, reaches};
use crate::artwork::WouldFit;
use crate::reach::bisect;
use crate::{Plan, Tool};

/// So often the room for a larger size is halved.
const HALVINGS: usize = 12;
/// What does not pass the check is made smaller by this share at a time, so often.
const SHRINK: f64 = 0.98;
const SHRINKING: usize = 8;

/// The largest size in which the check passes a plan that it refuses, scaled about its middle. The plan has this scale and turn
/// by now.
#[must_use]
pub fn would_fit(plan: &Plan, start: &Preflight, scale: f64, rotate: f64) -> Option<WouldFit> {
    let geometry = match plan.tool {
        Some(tool) => Geometry::magician(Tool::bias(tool)),
        None => start.geometry(),
    };
    let [x, y, _] = crate::setup::middle(plan);
    let targets = || plan.steps.iter().filter_map(|step| step.action.target());
    let all_within = |share: f64| {
        targets().all(|[tx, ty, tz]| {
            let [tx, ty, tz] = [tx, ty, tz].map(f64::from);
            reaches(&geometry, [x + share * (tx - x), y + share * (ty - y), tz])
        })
    };
    let fits = bisect(0.0, 1.0, HALVINGS, all_within);
    let mut passing = (0..SHRINKING)
        .map(|nth| WouldFit::new(scale * fits * SHRINK.powi(nth as i32), rotate))
        .filter(WouldFit::is_any);
    passing.find(|would| {
        let smaller = plan.scaled_xy(would.scale / scale, [x, y]);
        smaller.is_ok_and(|smaller| check(&smaller, start).is_good())
    })
}
