//! Drawn lines of a plan, with a limited number of points.
//!
//! A station sends these lines to pages, so their number of points is bounded: the tolerance is
//! doubled until they fit. If the largest tolerance does not suffice, lines are left out evenly.

use magician_host::preflight::Preflight;

use super::tracer::PathTracer;
use super::track::Track;
use crate::yielding::{NeverYield, Yield, run_to_end};
use crate::{Plan, Report};

/// Initial tolerance, mm.
const INITIAL_TOLERANCE: f64 = 0.02;
/// Largest tolerance, mm; beyond it lines are left out instead.
const MAX_TOLERANCE: f64 = 5.0;

/// Line drawn by a pen or laser without lifting or switching off, from above.
///
/// ```
/// use magician_host::{JointAngles, ToolBias, preflight::Preflight};
/// use magician_program::toolpath::Outline;
/// use magician_program::{Action, Origin, Plan, Surface, Tool, Travel};
///
/// let mut plan = Plan::new("two lines");
/// plan.tool = Some(Tool::Pen);
/// plan.surface = Some(Surface::level(-60.0));
/// plan.push(Action::Move { to: [200.0, 0.0, -60.0, 0.0], by: Travel::Joints }, Origin::NONE);
/// plan.push(Action::Path { to: [240.0, 0.0, -60.0] }, Origin::NONE);
/// plan.push(Action::Path { to: [240.0, 30.0, -60.0] }, Origin::NONE);
///
/// let lines = Outline::of(&plan, &Preflight::at(JointAngles::HOME, ToolBias::PEN), 1000);
/// assert_eq!(lines.len(), 1);
/// assert_eq!(lines[0].points, [[200.0, 0.0], [240.0, 0.0], [240.0, 30.0]]);
/// assert_eq!((lines[0].height, lines[0].reachable), (-60.0, true));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Outline {
    /// Points in the arm's x and y, mm; at least two.
    pub points: Vec<[f64; 2]>,
    /// Height of its start, mm.
    pub height: f64,
    /// True if it is within reach.
    pub reachable: bool,
    /// Darkness in percent, in steps of 10: the power of a laser, 100 for ink.
    pub power: u8,
    /// Number of its part, in a plan with parts.
    pub part: Option<u64>,
}

impl Outline {
    /// Lines that a plan draws from this state of the arm, in order, with at most `most` points.
    #[must_use]
    pub fn of(plan: &Plan, start: &Preflight, most: usize) -> Vec<Self> {
        run_to_end(Self::with_travels(plan, start, most, &NeverYield)).0
    }

    /// Like [`of`](Self::of), with the travel motion of the tip in space, also with at most `most`
    /// points. Yields to other tasks between slices.
    pub async fn with_travels(
        plan: &Plan,
        start: &Preflight,
        most: usize,
        yields: &impl Yield,
    ) -> (Vec<Self>, Vec<Vec<[f64; 3]>>) {
        let tracer = PathTracer::from(plan, &Report::default(), start, Some(false));
        let Outlines {
            mut lines, travels, ..
        } = tracer.outlines(plan, yields).await;
        let mut tolerance = INITIAL_TOLERANCE;
        while lines.iter().map(|line| line.track.len()).sum::<usize>() > most
            && tolerance < MAX_TOLERANCE
        {
            tolerance *= 2.0;
            for line in &mut lines {
                line.track = line.track.thinned(tolerance);
            }
        }
        let outlines = lines.iter().flat_map(|of| {
            let lines = of.track.lines().filter(|line| line.len() > 1);
            lines.map(|line| Self {
                points: line.to_vec(),
                height: of.height,
                reachable: of.reachable,
                power: of.power,
                part: of.part,
            })
        });
        let outlines = evenly(outlines.collect(), most, |line: &Self| line.points.len());
        (outlines, evenly(travels, most, Vec::len))
    }
}

/// Keeps an evenly spread selection if there are too many points.
fn evenly<T>(outlines: Vec<T>, most: usize, points_of: impl Fn(&T) -> usize) -> Vec<T> {
    let points: usize = outlines.iter().map(&points_of).sum();
    let each = points.div_ceil(most.max(1)).max(1);
    if each == 1 {
        return outlines;
    }
    let mut left = most;
    let mut kept: Vec<_> = outlines.into_iter().step_by(each).collect();
    kept.retain(|line| {
        let fits = points_of(line) <= left;
        left -= if fits { points_of(line) } else { 0 };
        fits
    });
    kept
}

/// Line being collected.
#[derive(Clone, Debug)]
struct Line {
    reachable: bool,
    power: u8,
    part: Option<u64>,
    height: f64,
    track: Track,
}

/// Collects drawn lines, and travel between them.
#[derive(Clone, Debug, Default)]
pub(super) struct Outlines {
    lines: Vec<Line>,
    /// End of the last line.
    end: Option<[f64; 2]>,
    travels: Vec<Vec<[f64; 3]>>,
    /// True if the last travel ended at a line.
    ends_at_line: bool,
}

impl Outlines {
    pub(super) fn draw(
        &mut self,
        (reachable, power, part): (bool, u8, Option<u64>),
        from: [f64; 3],
        to: [f64; 3],
    ) {
        let [[x, y, from_z], [to_x, to_y, to_z]] = [from, to];
        let (from, to) = ([x, y], [to_x, to_y]);
        // A descending pen starts to draw slightly above the surface, which is not the height of
        // its line.
        let comes_down = from_z - to_z > libm::hypot(to_x - x, to_y - y);
        let height = if comes_down { to_z } else { from_z };
        self.ends_at_line = true;
        let Self { lines, end, .. } = self;
        match lines.last_mut() {
            Some(line)
                if (line.reachable, line.power, line.part) == (reachable, power, part)
                    && *end == Some(from) =>
            {
                if comes_down {
                    line.height = line.height.min(height);
                }
                line.track.line_to(to);
            }
            last => {
                if let Some(line) = last {
                    line.track.settle();
                }
                let mut track = Track::new(INITIAL_TOLERANCE);
                track.begin(from);
                track.line_to(to);
                lines.push(Line {
                    reachable,
                    power,
                    part,
                    height,
                    track,
                });
            }
        }
        *end = Some(to);
    }

    /// Adds motion without a mark.
    pub(super) fn travel(&mut self, from: [f64; 3], to: [f64; 3]) {
        if from == to {
            return;
        }
        let begins = std::mem::take(&mut self.ends_at_line);
        let last = { self.travels.last_mut() }.filter(|way| !begins && way.last() == Some(&from));
        let Some(way) = last else {
            self.travels.push(vec![from, to]);
            return;
        };
        // The motion continues straight: drop the point between.
        if let [.., before, last] = way.as_mut_slice()
            && is_straight(*before, *last, to)
        {
            *last = to;
        } else {
            way.push(to);
        }
    }

    pub(super) fn settle(&mut self) {
        if let Some(line) = self.lines.last_mut() {
            line.track.settle();
        }
    }
}

/// True if a corner is too flat to be seen.
fn is_straight(from: [f64; 3], corner: [f64; 3], to: [f64; 3]) -> bool {
    let [one, two] = [[from, corner], [corner, to]]
        .map(|[from, to]| [0, 1, 2].map(|axis| to[axis] - from[axis]));
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|axis| a[axis] * b[axis]).sum::<f64>();
    let along = dot(one, two);
    along > 0.0 && along * along > 0.999_99 * dot(one, one) * dot(two, two)
}

#[cfg(test)]
mod tests {
    use magician_host::{JointAngles, ToolBias};

    use super::*;
    use crate::{Action, Origin, Surface, Tool, Travel};

    fn start() -> Preflight {
        Preflight::at(JointAngles::HOME, ToolBias::PEN)
    }

    #[test]
    fn outline_points_are_bounded_for_any_number_of_lines() {
        let mut plan = Plan::new("hatch");
        plan.tool = Some(Tool::Pen);
        plan.surface = Some(Surface::level(-60.0));
        for nth in 0..500 {
            let x = 200.0 + nth as f32 * 0.1;
            for (y, z) in [(-20.0, -50.0), (-20.0, -60.0)] {
                let by = Travel::Line;
                plan.push(
                    Action::Move {
                        to: [x, y, z, 0.0],
                        by,
                    },
                    Origin::NONE,
                );
            }
            for corner in 0..20 {
                let y = -19.0 + corner as f32;
                let x = x + (corner % 2) as f32;
                plan.push(Action::Path { to: [x, y, -60.0] }, Origin::NONE);
            }
        }
        for most in [20_000, 5_000, 700, 3] {
            let outlines = Outline::of(&plan, &start(), most);
            let points: usize = outlines.iter().map(|line| line.points.len()).sum();
            assert!(points <= most && points > most / 10, "{points} of {most}");
            assert!(outlines.iter().all(|line| line.points.len() > 1));
        }
        let all = Outline::of(&plan, &start(), 20_000);
        assert_eq!(all.len(), 500);
    }

    #[test]
    fn burn_with_two_powers_gives_two_adjoining_lines() {
        let mut plan = Plan::new("greys");
        plan.tool = Some(Tool::Laser);
        for (x, power) in [(200.0, 0.0), (210.0, 25.0), (220.0, 30.0), (230.0, 80.0)] {
            let to = [x, 0.0, -60.0];
            plan.push(Action::Burn { to, power }, Origin::NONE);
        }
        let lines = Outline::of(&plan, &start(), 100);
        let found: Vec<_> = { lines.iter() }
            .map(|line| (line.power, line.points.as_slice()))
            .collect();
        let expected: [(u8, &[[f64; 2]]); 2] = [
            (30, &[[200.0, 0.0], [220.0, 0.0]]),
            (80, &[[220.0, 0.0], [230.0, 0.0]]),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn unreachable_stretch_is_a_separate_line() {
        let mut plan = Plan::new("too far");
        plan.tool = Some(Tool::Pen);
        plan.surface = Some(Surface::level(-60.0));
        let by = Travel::Line;
        let to = [250.0, 0.0, -60.0, 0.0];
        plan.push(Action::Move { to, by }, Origin::NONE);
        for x in [500.0, 250.0] {
            plan.push(
                Action::Path {
                    to: [x, 0.0, -60.0],
                },
                Origin::NONE,
            );
        }
        let lines = Outline::of(&plan, &start(), 100);
        let reachable: Vec<_> = lines.iter().map(|line| line.reachable).collect();
        assert_eq!(reachable, [true, false, true], "{lines:?}");
        assert_eq!(lines[0].points.last(), lines[1].points.first());
    }
}
