//! What a plan leaves, as few lines as a picture elsewhere needs.

use magician_host::words::Preflight;

use super::tracer::PathTracer;
use super::track::Track;
use crate::{Plan, Report};

/// What is finer than this is not kept, mm.
const FINE: f64 = 0.02;
/// Coarser than this lines are not made, mm: some are left out instead.
const COARSEST: f64 = 5.0;

/// A line that a pen or a laser leaves without being lifted or switched off, seen from above.
///
/// ```
/// use magician_host::{JointAngles, ToolBias, words::Preflight};
/// use magician_program::preview::Outline;
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
/// assert!(lines[0].reachable);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Outline {
    /// Its points, in the arm's x and y, mm: two or more.
    pub points: Vec<[f64; 2]>,
    /// Whether the arm comes there.
    pub reachable: bool,
}

impl Outline {
    /// The lines that a plan leaves when the arm stands there before it, in their order: of no more points than `most`.
    #[must_use]
    pub fn of(plan: &Plan, start: &Preflight, most: usize) -> Vec<Self> {
        let tracer = PathTracer::from(plan, &Report::default(), start, Some(false));
        let mut lines = tracer.outlines(plan).lines;
        let mut tolerance = FINE;
        while lines.iter().map(|(_, track)| track.len()).sum::<usize>() > most
            && tolerance < COARSEST
        {
            tolerance *= 2.0;
            for (_, track) in &mut lines {
                *track = track.thinned(tolerance);
            }
        }
        let outlines = lines.iter().flat_map(|(reachable, track)| {
            let lines = track.lines().filter(|line| line.len() > 1);
            lines.map(|line| Self {
                points: line.to_vec(),
                reachable: *reachable,
            })
        });
        evenly(outlines.collect(), most)
    }
}

/// Some of them, all over, where they have too many points together.
fn evenly(outlines: Vec<Outline>, most: usize) -> Vec<Outline> {
    let points: usize = outlines.iter().map(|line| line.points.len()).sum();
    let each = points.div_ceil(most.max(1)).max(1);
    if each == 1 {
        return outlines;
    }
    let mut left = most;
    let mut kept: Vec<_> = outlines.into_iter().step_by(each).collect();
    kept.retain(|line| {
        let fits = line.points.len() <= left;
        left -= if fits { line.points.len() } else { 0 };
        fits
    });
    kept
}

/// Collects lines as they are drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct Outlines {
    /// Each, and whether the arm comes there.
    lines: Vec<(bool, Track)>,
    /// Where the last one ends.
    end: Option<[f64; 2]>,
}

impl Outlines {
    pub(super) fn draw(&mut self, reachable: bool, from: [f64; 2], to: [f64; 2]) {
        let Self { lines, end } = self;
        match lines.last_mut() {
            Some((as_before, track)) if *as_before == reachable && *end == Some(from) => {
                track.line_to(to);
            }
            last => {
                if let Some((_, track)) = last {
                    track.settle();
                }
                let mut track = Track::new(FINE);
                track.begin(from);
                track.line_to(to);
                lines.push((reachable, track));
            }
        }
        *end = Some(to);
    }

    pub(super) fn settle(&mut self) {
        if let Some((_, track)) = self.lines.last_mut() {
            track.settle();
        }
    }
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
    fn however_many_lines_there_are_the_points_are_bounded() {
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
    fn what_is_out_of_reach_is_a_line_of_its_own() {
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
