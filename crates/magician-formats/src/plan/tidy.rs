//! Optional clean-up of a plan's lines: duplicates are drawn once, ends that nearly meet are
//! joined, and redundant points are removed. Everything else keeps its order.
//!
//! The clean-up errs towards keeping a line. A superfluous line costs time, whereas a missing one,
//! or a travel move through the work, ruins the work. So a line is removed only if the moves to and
//! from it are fully understood, and no line is reversed or moved.

use std::collections::HashSet;
use std::ops::Range;

use magician_protocol::Set;

use super::{Action, Plan, Step, Travel};
use crate::artwork::{Tidied, Tidy, from_the_least};
use crate::simplify::{kept_points, length};

/// Distance below which positions count as equal, mm. It absorbs the rounding of 32-bit
/// coordinates.
const POSITION_TOLERANCE: f64 = 1e-3;
/// Height above a line at which a pen no longer touches, mm. A choice.
const CLEAR_HEIGHT: f64 = 0.5;

type Point = [f64; 3];

impl Plan {
    /// Cleans up the lines and reports what changed.
    ///
    /// Everything marked afterwards is within `merge + simplify` of something marked before, and
    /// vice versa.
    ///
    /// Two lines are duplicates if they pass through the same points at the same heights, in either
    /// direction; burnt lines also need the same power and speed. Only travel and speed settings
    /// may lie between them: after a pause or in another part the same line is a different one. A
    /// plan that switches its laser on and off separately stays as it is.
    pub fn tidy(&mut self, tidy: &Tidy) -> Tidied {
        let mut tidied = Tidied::default();
        let finite = |step: &Step| {
            let to = step.action.target();
            to.is_none_or(|to| to.iter().all(|value| value.is_finite()))
        };
        if self.steps.iter().any(|step| lights(&step.action)) || !self.steps.iter().all(finite) {
            return tidied;
        }
        if tidy.dedupe {
            tidied.repeated = self.without_repeated();
        }
        if tidy.merge > 0.0 {
            tidied.joined = self.without_gaps(tidy.merge);
        }
        if tidy.simplify > 0.0 {
            self.thinned(tidy.simplify);
        }
        tidied
    }

    /// Removes lines that occurred before, and returns their number.
    fn without_repeated(&mut self) -> usize {
        let traced = Traced::of(self);
        let mut known = HashSet::new();
        let mut removed = RemovedSteps::new(self.steps.len());
        let mut repeated = 0;
        for line in &traced.lines {
            if known.insert((line.scope, line.shape(&traced, self))) {
                continue;
            }
            let Some((down, up)) = traced.travel_around(line, self) else {
                continue;
            };
            repeated += 1;
            let marks = line.steps.clone();
            removed.mark_motion(self, marks.chain(down).chain(up));
        }
        removed.remove_from(self);
        repeated
    }

    /// Joins a line to the next one if that begins within `merge` of its end. Returns the number of
    /// joins.
    fn without_gaps(&mut self, merge: f64) -> usize {
        let traced = Traced::of(self);
        let mut removed = RemovedSteps::new(self.steps.len());
        let mut joined = 0;
        for pair in traced.lines.windows(2) {
            let [line, next] = pair else { continue };
            let between = line.steps.end..next.steps.start;
            let gap = distance(line.end, next.start);
            // An arc passes through three points; another start would change its circle.
            let bends = matches!(self.steps[next.steps.start].action, Action::Arc { .. });
            let alike = line.scope == next.scope
                && line.last_burn(self, &traced) == next.first_burn(self, &traced)
                && gap
                    <= if bends {
                        merge.min(POSITION_TOLERANCE)
                    } else {
                        merge
                    };
            let near = |step: &Step| match step.action.target().map(wide) {
                // A zero-length burn is not a line, yet it marks the work.
                Some(_) if step.action.burns() => false,
                // A step at the gap itself, or high enough above both lines, touches nothing.
                Some(to) => {
                    line.is_lit
                        || horizontal_distance(line.end, to) <= POSITION_TOLERANCE
                        || horizontal_distance(next.start, to) <= POSITION_TOLERANCE
                        || to[2] >= line.end[2].max(next.start[2]) + CLEAR_HEIGHT
                }
                None => sets_speed(&step.action),
            };
            if alike && self.steps[between.clone()].iter().all(near) {
                joined += 1;
                removed.mark_motion(self, between.clone());
                removed.mark_repeated_settings(self, &traced, between);
            }
        }
        removed.remove_from(self);
        joined
    }

    /// Removes points from which the line deviates by no more than the tolerance.
    fn thinned(&mut self, tolerance: f64) {
        let traced = Traced::of(self);
        let mut removed = RemovedSteps::new(self.steps.len());
        for line in &traced.lines {
            let mut from = line.steps.start;
            while from < line.steps.end {
                let alike = self.steps[from..line.steps.end].iter();
                let count = alike
                    .take_while(|step| goes_on(&self.steps[from], step))
                    .count();
                let to = from + count.max(1);
                if count > 1 {
                    let points: Vec<Point> = [traced.before[from]]
                        .into_iter()
                        .chain((from..to).map(|at| self.steps[at].action.target().map(wide)))
                        .flatten()
                        .collect();
                    let stays = kept_points(&points, tolerance);
                    // The first point is the start of the line, which belongs to the step before.
                    for (at, stays) in (from..to).zip(stays.into_iter().skip(1)) {
                        removed.steps[at] |= !stays;
                    }
                }
                from = to;
            }
        }
        removed.remove_from(self);
    }
}

/// True if a step continues a straight path in the same way: same kind, same power, same feed.
fn goes_on(one: &Step, next: &Step) -> bool {
    let alike = match (&one.action, &next.action) {
        (Action::Path { .. }, Action::Path { .. }) => true,
        (Action::Burn { power, .. }, Action::Burn { power: other, .. }) => power == other,
        _ => false,
    };
    alike && (one.feed, one.follows_speed) == (next.feed, next.follows_speed)
}

/// True if a step lights the laser other than along a segment.
fn lights(action: &Action) -> bool {
    action.burns() && !matches!(action, Action::Burn { .. })
}

/// True if a step only sets the speed of later ones.
fn sets_speed(action: &Action) -> bool {
    let Action::Command(command) = action else {
        return false;
    };
    matches!(
        **command,
        Set::CpParams(_) | Set::PtpCoordinateParams(_) | Set::PtpCommonParams(_)
    )
}

fn wide(point: [f32; 3]) -> Point {
    point.map(f64::from)
}

fn distance(a: Point, b: Point) -> f64 {
    length([0, 1, 2].map(|axis: usize| a[axis] - b[axis]))
}

fn horizontal_distance(a: Point, b: Point) -> f64 {
    length([a[0] - b[0], a[1] - b[1]])
}

/// Steps to be removed.
struct RemovedSteps {
    steps: Vec<bool>,
}

impl RemovedSteps {
    fn new(steps: usize) -> Self {
        Self {
            steps: vec![false; steps],
        }
    }

    /// Marks the steps that have a target.
    fn mark_motion(&mut self, plan: &Plan, steps: impl IntoIterator<Item = usize>) {
        for at in steps {
            self.steps[at] |= plan.steps[at].action.target().is_some();
        }
    }

    /// Marks settings of the path speed whose effect is overridden, or that restore the speed in
    /// force before.
    fn mark_repeated_settings(&mut self, plan: &Plan, traced: &Traced, between: Range<usize>) {
        let sets = |at: &usize| matches!(&plan.steps[*at].action, Action::Command(command) if matches!(**command, Set::CpParams(_)));
        let settings: Vec<usize> = between.clone().filter(sets).collect();
        let Some((last, others)) = settings.split_last() else {
            return;
        };
        { others.iter() }.for_each(|at| self.steps[*at] = true);
        if traced.speeds[between.start] == traced.speeds[between.end] {
            self.steps[*last] = true;
        }
    }

    fn remove_from(self, plan: &mut Plan) {
        let mut removed = self.steps.into_iter();
        plan.steps.retain(|_| !removed.next().unwrap_or(false));
    }
}

/// A line marked without a break.
struct Line {
    /// Steps from the first mark to the last, with the speed settings in between.
    steps: Range<usize>,
    start: Point,
    end: Point,
    is_lit: bool,
    /// Lines of different scopes are never duplicates.
    scope: u64,
}

/// The lines of a plan, and the state before each of its steps.
struct Traced {
    lines: Vec<Line>,
    /// Position of the tool before each step; `None` if unknown.
    before: Vec<Option<Point>>,
    /// Parameters of continuous paths in force before each step, and after the last.
    speeds: Vec<Option<[u32; 3]>>,
}

impl Traced {
    fn of(plan: &Plan) -> Self {
        let burns = plan.steps.iter().any(|step| step.action.is_of_a_laser());
        let mut traced = Self {
            lines: Vec::new(),
            before: Vec::with_capacity(plan.steps.len()),
            speeds: Vec::with_capacity(plan.steps.len() + 1),
        };
        let (mut at, mut speed, mut scope) = (None, None, 0);
        // True while the last line may continue.
        let mut open = false;
        for (nth, step) in plan.steps.iter().enumerate() {
            traced.before.push(at);
            traced.speeds.push(speed);
            let action = &step.action;
            let to = action.target().map(wide);
            let marks = match action {
                Action::Burn { power, .. } => *power > 0.0,
                action => !burns && action.marks(),
            };
            match (at, to) {
                (Some(from), Some(to)) if marks && goes_across(action, from, to) => {
                    match traced.lines.last_mut().filter(|_| open) {
                        Some(line) => {
                            line.steps.end = nth + 1;
                            line.end = to;
                        }
                        None => traced.lines.push(Line {
                            steps: nth..nth + 1,
                            start: from,
                            end: to,
                            is_lit: burns,
                            scope,
                        }),
                    }
                    open = true;
                }
                _ if sets_speed(action) => {
                    if let Action::Command(command) = action
                        && let Set::CpParams(params) = **command
                    {
                        speed = Some(
                            [params.plan_acc, params.junction_vel, params.acc_or_period]
                                .map(f32::to_bits),
                        );
                    }
                }
                (_, to) => {
                    open = false;
                    // Any other action may be a pause, a change of pen, or anything else, so a new
                    // scope begins. Silent steps keep the position of the tool.
                    let known = matches!(action, Action::Laser(false) | Action::Wait(_));
                    if to.is_none() && !known {
                        scope += 1;
                        at = at.filter(|_| action.is_silent());
                    }
                }
            }
            at = to.or(at);
        }
        traced.speeds.push(speed);
        traced
    }

    /// Returns the steps that lead down to a line and up from it. `None` if anything else happens
    /// there. Once these steps and the line are removed, the tool passes above the line.
    fn travel_around(&self, line: &Line, plan: &Plan) -> Option<(Range<usize>, Range<usize>)> {
        let Range { start, end } = line.steps;
        let nothing = (start..start, end..end);
        let next = plan.steps.get(end..)?.iter();
        let mut next = next.skip_while(|step| sets_speed(&step.action));
        if line.is_lit {
            // Moves to and from a burnt line are dark, so they may stay wherever they lead.
            let goes_on = next.next().is_none_or(|step| match step.action {
                Action::Burn { power, .. } => power == 0.0,
                Action::Move { by, .. } => by == Travel::Line,
                Action::Laser(on) => !on,
                _ => false,
            });
            return goes_on.then_some(nothing);
        }
        let high = line.height(plan) + CLEAR_HEIGHT;
        // Down: the steps straight above the start of the line, back to where the tool is clear of
        // it.
        let mut down = start;
        loop {
            let step = plan.steps.get(down.checked_sub(1)?)?;
            match (step.action.target().map(wide), sets_speed(&step.action)) {
                (Some(to), _) if horizontal_distance(to, line.start) > POSITION_TOLERANCE => {
                    return None;
                }
                (Some(to), _) if to[2] >= high => break,
                (Some(_), _) | (None, true) => down -= 1,
                (None, false) => return None,
            }
        }
        // Up: the steps straight above its end until the tool is clear. The clear step itself stays
        // and leads on from above the start of the removed line.
        let mut up = end;
        loop {
            let step = plan.steps.get(up)?;
            match (&step.action, step.action.target().map(wide)) {
                // A curve could dip down between its ends.
                (Action::Move { by, .. }, _) if *by != Travel::Line => return None,
                (_, Some(to)) if horizontal_distance(to, line.end) > POSITION_TOLERANCE => {
                    return None;
                }
                (_, Some(to)) if to[2] >= high => break,
                (action, None) if !sets_speed(action) => return None,
                _ => up += 1,
            }
        }
        Some((down..start, end..up))
    }
}

fn goes_across(action: &Action, from: Point, to: Point) -> bool {
    matches!(action, Action::Arc { .. }) || horizontal_distance(from, to) > POSITION_TOLERANCE
}

impl Line {
    /// Largest height at which the line marks.
    fn height(&self, plan: &Plan) -> f64 {
        let steps = plan.steps.get(self.steps.clone()).unwrap_or_default();
        let places = steps.iter().flat_map(|step| {
            let via = match step.action {
                Action::Arc {
                    via: [x, y, z, _], ..
                } => Some([x, y, z]),
                _ => None,
            };
            [step.action.target(), via].into_iter().flatten()
        });
        places
            .map(|place| f64::from(place[2]))
            .fold(self.start[2], f64::max)
    }

    /// Burn settings at its end; [`first_burn`](Self::first_burn) at its start.
    fn last_burn(&self, plan: &Plan, traced: &Traced) -> Option<Burnt> {
        burnt(plan, traced, self.steps.end.checked_sub(1)?)
    }

    fn first_burn(&self, plan: &Plan, traced: &Traced) -> Option<Burnt> {
        burnt(plan, traced, self.steps.start)
    }

    /// Returns a key that is equal for duplicates: independent of direction, and for closed lines
    /// of the start point.
    fn shape(&self, traced: &Traced, plan: &Plan) -> Vec<Piece> {
        let near = |point: Point| point.map(|value| (value / POSITION_TOLERANCE).round() as i64);
        let mut forth = vec![Piece::At(near(self.start))];
        for at in self.steps.clone() {
            let action = &plan.steps[at].action;
            let Some(to) = action.target() else { continue };
            let via = match action {
                Action::Arc {
                    via: [x, y, z, _], ..
                } => Some(near(wide([*x, *y, *z]))),
                _ => None,
            };
            forth.push(Piece::By(via, burnt(plan, traced, at)));
            forth.push(Piece::At(near(wide(to))));
        }
        if let Some(closed) = canonical_rotation(&forth) {
            return closed;
        }
        let back = forth.iter().rev().copied().collect();
        forth.min(back)
    }
}

/// Element of a shape key: a point, or the segment between two points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Piece {
    At([i64; 3]),
    By(Option<[i64; 3]>, Option<Burnt>),
}

/// Normalises a closed line to a canonical start and direction. `None` if it is open, or its
/// segments differ.
fn canonical_rotation(line: &[Piece]) -> Option<Vec<Piece>> {
    let (first, rest) = line.split_first()?;
    let (by, _) = rest.split_first()?;
    let ways = line.iter().skip(1).step_by(2);
    let alike = matches!(by, Piece::By(None, _)) && ways.clone().all(|way| way == by);
    if !alike || line.last() != Some(first) {
        return None;
    }
    let mut places: Vec<Piece> = rest.iter().skip(1).step_by(2).copied().collect();
    let forth = from_the_least(places.clone());
    places.reverse();
    let mut least = forth.min(from_the_least(places));
    // Without the extra elements, a closed line would equal the open line along its corners.
    least.extend([*by, *by]);
    Some(least)
}

/// Burn settings of a step: power, path parameters, feed, and whether the power follows the speed.
type Burnt = (u32, Option<[u32; 3]>, Option<u32>, bool);

fn burnt(plan: &Plan, traced: &Traced, at: usize) -> Option<Burnt> {
    let step = plan.steps.get(at)?;
    let Action::Burn { power, .. } = step.action else {
        return None;
    };
    let feed = step.feed.map(f32::to_bits);
    Some((
        power.to_bits(),
        traced.speeds.get(at).copied().flatten(),
        feed,
        step.follows_speed,
    ))
}

#[cfg(test)]
mod tests;
