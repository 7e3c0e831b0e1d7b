//! In which size, or where, a plan would be within reach that is not.

use magician_host::Geometry;
use magician_host::preflight::Preflight;

use super::check;
use crate::artwork::{WouldFit, rounded};
use crate::{Plan, Tool};
use magician_formats::reach::bisect;

/// So often the room for a larger size is halved.
const HALVINGS: usize = 12;
/// What does not pass the check is made smaller by this share at a time, so often.
const SHRINK: f64 = 0.98;
const SHRINKING: usize = 8;
/// The other way to lay a sheet, deg.
const QUARTER: f64 = 90.0;
/// Turned is better if it is larger by this share.
const LARGER: f64 = 1.001;

/// The same turned by another 90 degrees, if it may be larger so than as it lies, where `straight` is its largest size.
#[must_use]
pub fn would_fit_turned(
    plan: &Plan,
    start: &Preflight,
    (scale, rotate): (f64, f64),
    straight: Option<WouldFit>,
) -> Option<WouldFit> {
    let [x, y, _] = crate::setup::middle(plan);
    let turned = plan.rotated(QUARTER, [x, y]).ok()?;
    let rotate = rotate + QUARTER;
    let would_fit = if check(&turned, start).is_good() {
        Some(WouldFit::new(scale, rotate))
    } else {
        would_fit(&turned, start, scale, rotate)
    };
    let least = straight.map_or(0.0, |straight| LARGER * straight.scale);
    would_fit.filter(|would_fit| would_fit.scale > least)
}

/// The middle of what it draws, where the check passes a plan in its size and turn that it refuses where it lies.
#[must_use]
pub fn would_do_at(plan: &Plan, start: &Preflight) -> Option<[f64; 2]> {
    let [x, y, _] = crate::setup::middle(plan);
    let [dx, dy] = crate::setup::offset_within_reach(plan)?;
    let at = [x + dx, y + dy].map(rounded);
    let moved = plan.moved([at[0] - x, at[1] - y, 0.0]).ok()?;
    check(&moved, start).is_good().then_some(at)
}

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
            let at = [x + share * (tx - x), y + share * (ty - y), tz];
            geometry.reaches(at, &start.arm_model().limits)
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
