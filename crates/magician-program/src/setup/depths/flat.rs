//! Writer of a flattened program: all lines lie at one height, and all travel is above it.

use magician_protocol::Set;

use super::covered::CutRecord;
use super::walk::{Event, coincides};
use super::{DepthTally, HEIGHT_TOLERANCE};
use crate::setup::work_lines::TOUCH_HEIGHT;
use crate::{Action, Origin, Plan, Step, Travel};
use magician_formats::simplify::kept_points;

/// Writer of the flattened program, in the coordinates of the file.
pub(super) struct Flattener {
    plan: Plan,
    touch: f64,
    lift: f64,
    /// Scale at which the program is drawn.
    scale: f64,
    tally: DepthTally,
    covered: CutRecord,
    /// Position of the tool in the flattened program.
    at: Option<[f64; 2]>,
    /// True if the tool touches the surface at that position.
    down: bool,
    /// Current line from its start; points on a straight line are left out when it is written.
    run: Vec<([f64; 2], Origin)>,
    /// Steps since the last line: travel, and steps without motion.
    pending: Vec<Step>,
    /// True if feed moves were dropped since the last line: the tool is then not at the program's
    /// position.
    dropped: bool,
    /// Repeated piece, buffered while it may turn out to be a short part of a continuing line.
    held: RepeatedPiece,
}

/// Piece of a line that is cut again at a greater depth.
#[derive(Default)]
struct RepeatedPiece {
    points: Vec<([f64; 2], Origin)>,
    length: f64,
}

impl Flattener {
    pub(super) fn new(plan: &Plan, touch: f64, lift: f64, threshold: f64, scale: f64) -> Self {
        let mut empty = Plan::new(plan.title.clone());
        (empty.tool, empty.surface) = (plan.tool, plan.surface);
        empty.names.clone_from(&plan.names);
        Self {
            plan: empty,
            touch,
            lift,
            scale,
            tally: DepthTally {
                threshold,
                ..DepthTally::default()
            },
            covered: CutRecord::new(scale),
            at: None,
            down: false,
            run: Vec::new(),
            pending: Vec::new(),
            dropped: false,
            held: RepeatedPiece::default(),
        }
    }

    pub(super) fn handle_event(&mut self, event: Event<'_>) {
        match event {
            Event::Other(step) => self.add_still_step(step),
            Event::Travel { step, to } => self.travel(step, to),
            Event::Air(length) => {
                self.tally.air += length;
                // A feed move in the air is dropped, and so is the travel to it.
                self.drop_moves();
            }
            Event::Line {
                from,
                to,
                low,
                high,
                origin,
            } => self.line([from, to], [low, high], origin),
            Event::Arc {
                from,
                via,
                to,
                low,
                length,
                step,
            } => {
                if self.covered.arc([from, via, to], low) {
                    self.tally.repeated += length;
                    self.drop_moves();
                    return;
                }
                self.count(low, length);
                self.drop_repeated();
                self.go_to(from, step.origin);
                self.flush_settings();
                self.end_run();
                let pose = |[x, y]: [f64; 2]| [x, y, self.touch, 0.0].map(|value| value as f32);
                let (via, end) = (pose(via), pose(to));
                self.plan.push(Action::Arc { via, to: end }, step.origin);
                self.run = vec![(to, step.origin)];
                self.at = Some(to);
            }
            Event::Dot { at, origin, .. } => {
                if self.covered.dot(at) {
                    self.drop_moves();
                    return;
                }
                self.tally.dots += 1;
                self.drop_repeated();
                self.go_to(at, origin);
            }
        }
    }

    fn count(&mut self, low: f64, length: f64) {
        let hundredths = (low * 100.0).round() as i64;
        *self.tally.lengths.entry(hundredths).or_default() += length;
    }

    fn line(&mut self, [from, to]: [[f64; 2]; 2], [low, high]: [f64; 2], origin: Origin) {
        let length = crate::artwork::distance(from, to);
        if self.covered.line(from, to, high) {
            self.tally.repeated += length;
            let goes_on = self
                .held
                .points
                .last()
                .map_or(self.at, |(last, _)| Some(*last));
            let pen_is_here = self.down && !self.dropped && !self.has_moved();
            if pen_is_here && goes_on.is_some_and(|last| coincides(last, from)) {
                self.held.points.push((to, origin));
                self.held.length += length;
            } else {
                self.drop_moves();
            }
            return;
        }
        self.count(low, length);
        // Drawing a short piece again is faster than lifting the pen over it.
        let held = std::mem::take(&mut self.held);
        if let Some((last, _)) = held.points.last() {
            if held.length * self.scale <= self.lift && coincides(*last, from) {
                self.tally.repeated -= held.length;
                for (point, origin) in held.points {
                    self.draw_on(point, origin);
                }
            } else {
                self.drop_moves();
            }
        }
        self.go_to(from, origin);
        self.draw_on(to, origin);
    }

    fn draw_on(&mut self, to: [f64; 2], origin: Origin) {
        self.flush_settings();
        self.run.push((to, origin));
        self.at = Some(to);
    }

    fn has_moved(&self) -> bool {
        let moves = |step: &Step| step.action.target().is_some();
        self.pending.iter().any(moves)
    }

    fn add_still_step(&mut self, step: &Step) {
        let sets_speed = |step: &Step| matches!(&step.action, Action::Command(command) if matches!(**command, Set::CpParams(_)));
        if sets_speed(step) {
            // Only the last of several speeds takes effect.
            self.pending.retain(|pending| !sets_speed(pending));
        }
        self.pending.push(step.clone());
    }

    fn travel(&mut self, step: &Step, [x, y, z]: [f64; 3]) {
        self.drop_repeated();
        // A rapid move within a groove would draw on the surface.
        let z = if z <= self.touch + TOUCH_HEIGHT {
            self.touch + self.lift
        } else {
            z
        };
        let to = [x, y, z, 0.0].map(|value| value as f32);
        let by = match step.action {
            Action::Move { by, .. } => by,
            _ => Travel::Line,
        };
        let action = Action::Move { to, by };
        self.pending.push(Step::new(action, step.origin));
    }

    /// Drops feed moves, and the travel that led to them.
    fn drop_moves(&mut self) {
        self.dropped = true;
        self.held = RepeatedPiece::default();
        self.pending.retain(|step| step.action.target().is_none());
    }

    fn drop_repeated(&mut self) {
        if !self.held.points.is_empty() {
            self.drop_moves();
        }
    }

    /// Writes the current line.
    fn end_run(&mut self) {
        let run = std::mem::take(&mut self.run);
        let points: Vec<[f64; 2]> = run.iter().map(|(point, _)| *point).collect();
        let stays = kept_points(&points, HEIGHT_TOLERANCE / self.scale);
        for ((point, origin), stays) in run.into_iter().zip(stays).skip(1) {
            if stays {
                self.path(point, origin);
            }
        }
    }

    fn path(&mut self, [x, y]: [f64; 2], origin: Origin) {
        let to = [x, y, self.touch].map(|value| value as f32);
        self.plan.push(Action::Path { to }, origin);
    }

    fn lift_to(&mut self, [x, y]: [f64; 2], origin: Origin) {
        let to = [x, y, self.touch + self.lift, 0.0].map(|value| value as f32);
        let by = Travel::Line;
        self.plan.push(Action::Move { to, by }, origin);
    }

    /// Writes settings between two pieces of a continuing line.
    fn flush_settings(&mut self) {
        if self.pending.is_empty() {
            return;
        }
        let last = self.run.last().copied();
        self.end_run();
        self.plan.steps.append(&mut self.pending);
        self.run.extend(last);
    }

    /// Lowers the pen at the start of a line.
    fn go_to(&mut self, begin: [f64; 2], origin: Origin) {
        let here = self.down && self.at.is_some_and(|at| coincides(at, begin));
        if here && !self.has_moved() {
            self.dropped = false;
            return;
        }
        self.end_run();
        self.lift_off(origin);
        self.write_pending();
        if self.at.is_none_or(|at| !coincides(at, begin)) {
            self.lift_to(begin, origin);
        }
        self.path(begin, origin);
        (self.at, self.down, self.dropped) = (Some(begin), true, false);
        self.run = vec![(begin, origin)];
    }

    /// Lifts the pen straight up, unless the program does so itself.
    fn lift_off(&mut self, origin: Origin) {
        let Some(at) = self.at.filter(|_| self.down) else {
            return;
        };
        let next = { self.pending.iter() }.find_map(|step| step.action.target());
        let rises = next.is_some_and(|[x, y, _]| coincides([x, y].map(f64::from), at));
        if self.dropped || !rises {
            self.lift_to(at, origin);
        }
        self.down = false;
    }

    fn write_pending(&mut self) {
        for step in std::mem::take(&mut self.pending) {
            if let Some([x, y, _]) = step.action.target() {
                self.at = Some([x, y].map(f64::from));
            }
            self.plan.steps.push(step);
        }
    }

    /// Returns the program, and the lengths drawn by depth.
    pub(super) fn finish(mut self) -> (Plan, DepthTally) {
        self.drop_repeated();
        let origin = self.run.last().map_or(Origin::NONE, |(_, origin)| *origin);
        self.end_run();
        if self.dropped || self.has_moved() {
            self.lift_off(origin);
        }
        self.write_pending();
        (self.plan, self.tally)
    }
}
