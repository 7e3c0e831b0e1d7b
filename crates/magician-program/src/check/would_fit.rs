//! Size or position at which a plan that is out of reach would fit.

use magician_host::Geometry;
use magician_host::preflight::Preflight;

use super::check;
use crate::artwork::{WouldFit, rounded};
use crate::{Plan, Tool};
use magician_formats::reach::bisect;

/// Bisection steps for the scale.
const BISECTION_STEPS: usize = 12;
/// Factor by which a plan that fails the full check is reduced each time. The bisection looks at
/// targets alone; the motion between them may leave the reach.
const SHRINK_FACTOR: f64 = 0.98;
/// Number of such reductions.
const MAX_SHRINKS: usize = 8;
/// Turn to the other orientation of a sheet, deg.
const QUARTER_TURN: f64 = 90.0;
/// Smallest gain in size for which a turn is proposed. A choice, above rounding.
const MIN_GAIN: f64 = 1.001;

/// Largest size after a turn by another 90 degrees, if that is larger than `straight`, the largest
/// size without a turn.
#[must_use]
pub fn would_fit_turned(
    plan: &Plan,
    start: &Preflight,
    (scale, rotate): (f64, f64),
    straight: Option<WouldFit>,
) -> Option<WouldFit> {
    let [x, y, _] = crate::setup::middle(plan);
    let turned = plan.rotated(QUARTER_TURN, [x, y]).ok()?;
    let rotate = rotate + QUARTER_TURN;
    let would_fit = if check(&turned, start).is_good() {
        Some(WouldFit::new(scale, rotate))
    } else {
        would_fit(&turned, start, scale, rotate)
    };
    let least = straight.map_or(0.0, |straight| MIN_GAIN * straight.scale);
    would_fit.filter(|would_fit| would_fit.scale > least)
}

/// Position for the middle of the drawing at which a refused plan passes the check at its size and
/// rotation; `None` if no position does.
#[must_use]
pub fn would_fit_at(plan: &Plan, start: &Preflight) -> Option<[f64; 2]> {
    let [x, y, _] = crate::setup::middle(plan);
    let [dx, dy] = crate::setup::offset_within_reach(plan)?;
    let at = [x + dx, y + dy].map(rounded);
    let moved = plan.moved([at[0] - x, at[1] - y, 0.0]).ok()?;
    check(&moved, start).is_good().then_some(at)
}

/// Largest size at which a refused plan passes the check, scaled about its middle. `scale` and
/// `rotate` have been applied to the plan already.
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
    let fits = bisect(0.0, 1.0, BISECTION_STEPS, all_within);
    let mut passing = (0..MAX_SHRINKS)
        .map(|nth| WouldFit::new(scale * fits * SHRINK_FACTOR.powi(nth as i32), rotate))
        .filter(WouldFit::is_any);
    passing.find(|would| {
        let smaller = plan.scaled_xy(would.scale / scale, [x, y]);
        smaller.is_ok_and(|smaller| check(&smaller, start).is_good())
    })
}
