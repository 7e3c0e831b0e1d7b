//! Path of the tool over an image, line by line in burning order.
//!
//! Each line is cut into runs of equal level and stretches between wide gaps. A stretch begins and
//! ends with an overscan, so that the tool burns only at full speed. Between stretches the tool
//! travels or continues on the path, whichever is faster.

use std::ops::Range;

use magician_host::build;

use super::tone::Powers;
use super::{Engrave, Grid};
use crate::artwork::distance;
use crate::{Action, Origin, Plan, Reach, Surface, Tool, Travel};
use magician_formats::reach::APPROACH_HEIGHT;

/// Speed ratio that an arm applies to travel moves by default (model section 6).
const DEFAULT_SPEED_RATIO: f64 = 0.5;

/// Speeds and lengths from which the durations of motions are estimated, to choose the faster one.
pub(super) struct ScanSpeeds {
    speed: f64,
    acceleration: f64,
    run_up: f64,
    travel: f64,
}

impl ScanSpeeds {
    pub(super) fn new(engrave: &Engrave) -> Self {
        Self {
            speed: engrave.speed,
            acceleration: engrave.acceleration,
            run_up: engrave.run_up(),
            travel: engrave.travel * DEFAULT_SPEED_RATIO,
        }
    }

    /// Duration from rest to rest at engraving speed, s.
    fn engrave_time(&self, length: f64) -> f64 {
        rest_to_rest(length, self.speed, self.acceleration)
    }

    /// Duration from rest to rest at travel speed, s.
    fn travel_time(&self, length: f64) -> f64 {
        rest_to_rest(length, self.travel, self.travel)
    }

    /// True if braking before a gap, travelling and accelerating after the gap is faster than
    /// crossing the gap at engraving speed.
    fn is_travel_faster(&self, gap: f64) -> bool {
        let between = gap - 2.0 * self.run_up;
        let runs = 2.0 * self.engrave_time(2.0 * self.run_up);
        between > 0.0 && self.travel_time(between) + runs < gap / self.speed
    }
}

/// Duration of a motion from rest to rest (model section 7), s.
fn rest_to_rest(length: f64, speed: f64, acceleration: f64) -> f64 {
    if length * acceleration > speed * speed {
        length / speed + speed / acceleration
    } else {
        2.0 * (length / acceleration).sqrt()
    }
}

/// Plan built line by line.
pub(super) struct Scan<'e> {
    plan: Plan,
    grid: Grid,
    surface: Surface,
    engrave: &'e Engrave,
    speeds: ScanSpeeds,
    /// Number of lines with a burn so far.
    burnt_lines: usize,
    /// Position of the tool.
    at: Option<[f64; 2]>,
    /// True if the last segment had power.
    is_lit: bool,
    /// Segments of one stretch: end as share of the width, and level.
    segments: Vec<(f64, u8)>,
}

impl<'e> Scan<'e> {
    pub(super) fn new(
        mut plan: Plan,
        grid: Grid,
        surface: Surface,
        engrave: &'e Engrave,
        speeds: ScanSpeeds,
    ) -> Self {
        let travel = engrave.travel as f32;
        plan.push(build::line_speed(travel, travel), Origin::NONE);
        let path = build::path_speed(engrave.speed as f32, engrave.acceleration as f32);
        plan.push(path, Origin::NONE);
        Self {
            plan,
            grid,
            surface,
            engrave,
            speeds,
            burnt_lines: 0,
            at: None,
            is_lit: false,
            segments: Vec::new(),
        }
    }

    /// Adds one line of levels at `down` (share of the height). `row` is its row of pixels in the
    /// image, counted from 0.
    pub(super) fn add_line(&mut self, levels: &[u8], down: f64, row: usize, powers: &Powers) {
        let cells = levels.len() as f64;
        let runs = runs(levels);
        let mut stretches = self.stretches(&runs, self.grid.size()[0] / cells);
        if stretches.is_empty() {
            return;
        }
        // Count only burnt lines, so that the direction alternates across skipped lines too.
        let backwards = self.engrave.both_directions && self.burnt_lines % 2 == 1;
        if backwards {
            stretches.reverse();
        }
        self.burnt_lines += 1;
        let origin = Origin {
            line: u32::try_from(row.saturating_add(1)).unwrap_or(u32::MAX),
            ..Origin::NONE
        };
        for stretch in stretches {
            let runs = runs.get(stretch).unwrap_or_default();
            self.set_segments(runs, cells, backwards);
            // Taken and put back to reuse its memory on every line.
            let segments = std::mem::take(&mut self.segments);
            for (nth, (right, level)) in segments.iter().enumerate() {
                let to = self.grid.at([*right, down]);
                match nth {
                    // The first segment leads to the start of the overscan, which may be far away.
                    0 => self.approach(to, origin),
                    _ => self.add_segment(to, powers.of(*level), origin),
                }
            }
            self.segments = segments;
        }
    }

    /// Ends the plan with the laser off and the tool lifted.
    pub(super) fn end(mut self) -> Plan {
        // Sent explicitly: the last segment may have had power.
        self.plan.push(Action::Laser(false), Origin::NONE);
        if let Some(at) = self.at {
            self.travel(
                self.above_surface(at, self.engrave.lift),
                Travel::Line,
                Origin::NONE,
            );
        }
        self.plan
    }

    /// Groups of runs that the tool crosses without a stop: from the first run that burns to the
    /// last, split at gaps over which travelling is faster.
    fn stretches(&self, runs: &[ScanRun], cell: f64) -> Vec<Range<usize>> {
        if !self.engrave.white_skip {
            let all = 0..runs.len();
            return vec![all];
        }
        let mut stretches: Vec<Range<usize>> = Vec::new();
        let mut burnt_to = 0;
        for (nth, run) in runs.iter().enumerate().filter(|(_, run)| run.level > 0) {
            let gap = (run.from - burnt_to) as f64 * cell;
            match stretches.last_mut() {
                Some(last) if !self.speeds.is_travel_faster(gap) => last.end = nth + 1,
                _ => stretches.push(nth..nth + 1),
            }
            burnt_to = run.to;
        }
        stretches
    }

    /// Computes the segments of some runs; the first one ends where the overscan begins.
    fn set_segments(&mut self, runs: &[ScanRun], cells: f64, backwards: bool) {
        self.segments.clear();
        let (Some(first), Some(last)) = (runs.first(), runs.last()) else {
            return;
        };
        let overscan = self.speeds.run_up / self.grid.size()[0];
        let edge = |cell: usize| cell as f64 / cells;
        let (left, right) = (edge(first.from), edge(last.to));
        if backwards {
            self.segments.push((right + overscan, 0));
            self.segments.push((right, 0));
            let reversed = runs.iter().rev();
            reversed.for_each(|run| self.extend(edge(run.from), run.level));
            self.extend(left - overscan, 0);
        } else {
            // The overscan before the line is a separate segment, so that the burn begins at full
            // speed.
            self.segments.push((left - overscan, 0));
            self.segments.push((left, 0));
            runs.iter()
                .for_each(|run| self.extend(edge(run.to), run.level));
            self.extend(right + overscan, 0);
        }
    }

    /// Extends the last segment to `to` if it has this level, else adds a segment.
    fn extend(&mut self, to: f64, level: u8) {
        match self.segments.last_mut() {
            Some((end, last_level)) if *last_level == level => *end = to,
            _ => self.segments.push((to, level)),
        }
    }

    /// Moves to the start of a stretch with the laser off, along the path or as a travel move,
    /// whichever is faster.
    fn approach(&mut self, to: [f64; 2], origin: Origin) {
        let Some(at) = self.at else {
            // The first move may start anywhere: a joint move never leaves the reach on its way.
            self.travel(self.approach_position(to), Travel::Joints, origin);
            self.travel(self.on_surface(to), Travel::Line, origin);
            self.at = Some(to);
            return;
        };
        let length = distance(at, to);
        if self.speeds.travel_time(length) < self.speeds.engrave_time(length) {
            // Without overscan the last segment has left the laser on.
            if self.is_lit {
                self.plan.push(Action::Laser(false), origin);
                self.is_lit = false;
            }
            self.travel(self.on_surface(to), Travel::Line, origin);
            self.at = Some(to);
        } else {
            self.add_segment(to, 0.0, origin);
        }
    }

    /// Adds one segment of the path, unless it has no length.
    fn add_segment(&mut self, to: [f64; 2], power: f32, origin: Origin) {
        let target = self.on_surface(to);
        if self.at.is_some_and(|at| self.on_surface(at) == target) {
            return;
        }
        let burn = Action::Burn { to: target, power };
        self.plan.push(burn, origin);
        (self.at, self.is_lit) = (Some(to), power > 0.0);
    }

    /// Adds a travel move. J4 stays at 0, as on the path, because turning it would take time.
    fn travel(&mut self, [x, y, z]: [f32; 3], by: Travel, origin: Origin) {
        let to = [x, y, z, libm::atan2f(y, x).to_degrees()];
        self.plan.push(Action::Move { to, by }, origin);
    }

    fn on_surface(&self, at: [f64; 2]) -> [f32; 3] {
        self.above_surface(at, 0.0)
    }

    fn above_surface(&self, at: [f64; 2], height: f64) -> [f32; 3] {
        [at[0], at[1], self.surface.at(at) + height].map(|value| value as f32)
    }

    /// Position well above a point, as far as the reach allows.
    fn approach_position(&self, at: [f64; 2]) -> [f32; 3] {
        let lift = self.engrave.lift;
        let reach = Reach::new(Tool::Laser.bias(), self.surface, lift);
        let (at, above) = reach.over((at, 0.0), lift + APPROACH_HEIGHT);
        self.above_surface(at, above)
    }
}

/// Adjacent cells of a line with the same level.
#[derive(Clone, Copy)]
struct ScanRun {
    from: usize,
    to: usize,
    level: u8,
}

fn runs(levels: &[u8]) -> Vec<ScanRun> {
    let mut from = 0;
    let same = levels.chunk_by(|one, other| one == other);
    let run = same.map(|cells| {
        let to = from + cells.len();
        let level = cells.first().copied().unwrap_or(0);
        let run = ScanRun { from, to, level };
        from = to;
        run
    });
    run.collect()
}
