//! Drawn lines of a plan by step, to show progress.

use magician_host::preflight::Preflight;

use super::tracer::PathTracer;
use crate::{Plan, Report};

/// Length below which a line is merged with the next, mm.
const MIN_LENGTH: f64 = 0.3;

/// Straight line drawn by a pen or laser, from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnLine {
    /// Step that ends the line, from 0.
    pub step: usize,
    /// Start, in the arm's x and y, mm.
    pub from: [f64; 2],
    /// End, in the arm's x and y, mm.
    pub to: [f64; 2],
}

impl DrawnLine {
    /// Lines that a plan draws from this state of the arm, in order. Curves become several lines;
    /// lines too short to be seen are merged.
    ///
    /// ```
    /// use magician_host::{JointAngles, ToolBias, preflight::Preflight};
    /// use magician_program::toolpath::DrawnLine;
    /// use magician_program::{Action, Origin, Plan, Surface, Tool, Travel};
    ///
    /// let mut plan = Plan::new("a line");
    /// plan.tool = Some(Tool::Pen);
    /// plan.surface = Some(Surface::level(-60.0));
    /// plan.push(Action::Move { to: [200.0, 0.0, -60.0, 0.0], by: Travel::Joints }, Origin::NONE);
    /// plan.push(Action::Path { to: [240.0, 0.0, -60.0] }, Origin::NONE);
    ///
    /// let strokes = DrawnLine::of(&plan, &Preflight::at(JointAngles::HOME, ToolBias::PEN));
    /// assert_eq!(strokes, [DrawnLine { step: 1, from: [200.0, 0.0], to: [240.0, 0.0] }]);
    /// ```
    #[must_use]
    pub fn of(plan: &Plan, start: &Preflight) -> Vec<Self> {
        PathTracer::from(plan, &Report::default(), start, Some(false)).strokes(plan)
    }

    pub(super) fn add(strokes: &mut Vec<Self>, step: usize, from: [f64; 2], to: [f64; 2]) {
        if let Some(last) = strokes.last_mut()
            && last.to == from
            && libm::hypot(last.to[0] - last.from[0], last.to[1] - last.from[1]) < MIN_LENGTH
        {
            (last.step, last.to) = (step, to);
            return;
        }
        strokes.push(Self { step, from, to });
    }
}
