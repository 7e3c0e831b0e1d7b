//! Pens in plans: whether a plan draws, on which surface, and whether it lifts the pen at its end.

use magician_protocol::Set;

use super::{Action, Plan, Tool, Travel};
use crate::Surface;

/// Height difference that counts as none, mm. It covers the rounding of 32-bit coordinates and of
/// the reported pose.
const HEIGHT_TOLERANCE: f64 = 0.05;

impl Plan {
    /// True if the plan draws with a pen.
    ///
    /// * A plan for a pen draws if any step names a target.
    /// * A plan without a tool, or with a bias, draws if it contains continuous paths or arcs and
    ///   is known to be a drawing: it has a surface, or the caller says so (`drawing`).
    /// * A plan with laser steps, or for any other tool, does not draw.
    #[must_use]
    pub fn draws(&self, drawing: bool) -> bool {
        let any = |is: fn(&Action) -> bool| self.steps.iter().any(|step| is(&step.action));
        if any(Action::is_of_a_laser) {
            return false;
        }
        match self.tool {
            Some(Tool::Pen) => any(|action| action.target().is_some()) || any(draws_along),
            None | Some(Tool::Bias(_)) => (drawing || self.surface.is_some()) && any(draws_along),
            Some(Tool::None | Tool::Suction | Tool::Gripper | Tool::Laser) => false,
        }
    }

    /// Returns the surface that a pen draws on: that of the plan, else a level one at the lowest
    /// point of its continuous paths. `None` if it has neither.
    #[must_use]
    pub fn drawn_on(&self) -> Option<Surface> {
        let level = || {
            let steps = self.steps.iter().map(|step| &step.action);
            let paths = steps.filter(|action| matches!(action, Action::Path { .. }));
            let heights = paths.filter_map(|action| Some(f64::from(action.target()?[2])));
            let lowest = heights.filter(|z| z.is_finite()).reduce(f64::min);
            lowest.map(Surface::level)
        };
        self.surface.or_else(level)
    }

    /// Returns the height, mm, by which the pen must still be lifted at the end of the plan to be
    /// `lift` above the paper.
    ///
    /// The pen stands at the given point. The paper is at the surface, or at the plan's lowest
    /// point if that is higher or there is no surface.
    #[must_use]
    pub fn remaining_lift(&self, [x, y, z]: [f64; 3], lift: f64) -> f64 {
        let targets = self.steps.iter().filter_map(|step| step.action.target());
        let lowest = targets.map(|[_, _, z]| f64::from(z)).reduce(f64::min);
        let surface = self.surface.map(|surface| surface.at([x, y]));
        let paper = [lowest, surface].into_iter().flatten().reduce(f64::max);
        let above = paper.map_or(0.0, |paper| (z - paper).max(0.0));
        let left = lift - above;
        if left > HEIGHT_TOLERANCE { left } else { 0.0 }
    }

    /// True if the last step, apart from waits, lifts the pen straight up.
    #[must_use]
    pub fn ends_with_lift(&self) -> bool {
        let mut steps = self.steps.iter().rev().map(|step| &step.action);
        let Some(Action::Move {
            to: [x, y, z, _],
            by: Travel::Line,
        }) = steps.next()
        else {
            return false;
        };
        let before = steps.find(|action| !matches!(action, Action::Wait(_)));
        let before = before.and_then(Action::target);
        before.is_some_and(|[from_x, from_y, from_z]| {
            let aside = libm::hypot(f64::from(x - from_x), f64::from(y - from_y));
            aside < HEIGHT_TOLERANCE && f64::from(z - from_z) > HEIGHT_TOLERANCE
        })
    }
}

/// True if a step draws a line: a continuous path, an arc or a circle.
fn draws_along(action: &Action) -> bool {
    match action {
        Action::Path { .. } | Action::Arc { .. } => true,
        Action::Command(command) => matches!(
            **command,
            Set::CpCmd(_) | Set::ArcCmd(_) | Set::CircleCmd(_)
        ),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use std::slice;

    use magician_host::build;

    use super::*;
    use crate::Origin;

    fn of(tool: Option<Tool>, actions: &[Action]) -> Plan {
        let mut plan = Plan::new("p");
        plan.tool = tool;
        for action in actions {
            plan.push(action.clone(), Origin::NONE);
        }
        plan
    }

    fn go(x: f32, y: f32, z: f32) -> Action {
        Action::Move {
            to: [x, y, z, 0.0],
            by: Travel::Line,
        }
    }

    fn along(x: f32, y: f32, z: f32) -> Action {
        Action::Path { to: [x, y, z] }
    }

    #[test]
    fn drawing_is_detected_by_its_pen_actions() {
        let line = [go(200.0, 0.0, -50.0), along(240.0, 0.0, -50.0)];
        for tool in [None, Some(Tool::Pen), Some(Tool::Bias([70.0, 0.0, 1.0]))] {
            assert!(of(tool, &line).draws(true), "{tool:?}");
            let mut on_paper = of(tool, &line);
            on_paper.surface = Some(Surface::level(-50.0));
            assert!(on_paper.draws(false), "{tool:?}");
        }
        for tool in [Tool::None, Tool::Suction, Tool::Gripper, Tool::Laser] {
            assert!(!of(Some(tool), &line).draws(true), "{tool:?}");
        }
        assert!(of(Some(Tool::Pen), &line[..1]).draws(false));
        // Without a named tool a path may be for any tool.
        assert!(!of(None, &line).draws(false));
        assert!(!of(None, &line[..1]).draws(true));
        assert!(!of(Some(Tool::Pen), &[build::speed(10.0, 10.0).into()]).draws(true));
        let burnt = [line.as_slice(), &[Action::Laser(true)]].concat();
        assert!(!of(None, &burnt).draws(true) && !of(Some(Tool::Pen), &burnt).draws(true));
    }

    #[test]
    fn pen_lift_is_the_remaining_lift_of_its_plan() {
        let at = |z: f64| [240.0, 0.0, z];
        let mut plan = of(None, &[go(200.0, 0.0, -40.0), along(240.0, 0.0, -50.0)]);
        assert_eq!(plan.remaining_lift(at(-50.0), 10.0), 10.0);
        assert_eq!(plan.remaining_lift(at(-46.0), 10.0), 6.0);
        assert_eq!(plan.remaining_lift(at(-40.0), 10.0), 0.0);
        assert_eq!(plan.remaining_lift(at(20.0), 10.0), 0.0);
        // The pen is pressed into the paper.
        assert_eq!(plan.remaining_lift(at(-51.0), 10.0), 10.0);
        plan.surface = Some(Surface::level(-45.0));
        assert_eq!(plan.remaining_lift(at(-45.0), 10.0), 10.0);
        // A plan that draws above its named surface still touches something at its lowest point.
        plan.surface = Some(Surface::level(-90.0));
        assert_eq!(plan.remaining_lift(at(-50.0), 10.0), 10.0);
    }

    #[test]
    fn last_lift_is_detected() {
        let (pen, line) = (Some(Tool::Pen), along(240.0, 0.0, -50.0));
        let up = go(240.0, 0.0, -40.0);
        let plan = |last: &[Action]| of(pen, &[slice::from_ref(&line), last].concat());
        assert!(plan(slice::from_ref(&up)).ends_with_lift());
        assert!(plan(&[Action::Wait(100), up.clone()]).ends_with_lift());
        assert!(!plan(&[]).ends_with_lift());
        assert!(!plan(&[go(250.0, 0.0, -40.0)]).ends_with_lift());
        assert!(!plan(&[go(240.0, 0.0, -60.0)]).ends_with_lift());
    }
}
