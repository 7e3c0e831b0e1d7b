//! Steps of a placed program: work steps stay unchanged, travel moves are replaced by moves within
//! reach.

use magician_motion::ToolBias;

use super::ProgramTransform;
use crate::artwork::Marking;
use crate::setup::work_lines::TOUCH_HEIGHT;
use crate::{Action, Origin, Plan, Reach, Step, Surface, Tool, Travel};
use magician_formats::reach::{APPROACH_HEIGHT, Above};

/// Number of points tried along a travel move that leaves the reach.
const EXIT_SAMPLES: u32 = 64;

/// Builds the motion through a placed program.
pub(super) struct Guide<'a> {
    plan: Plan,
    steps: Vec<Step>,
    course: &'a ProgramTransform,
    surface: Surface,
    reach: Reach,
    lift: f64,
    at: Option<Above>,
}

impl<'a> Guide<'a> {
    pub(super) fn new(
        plan: Plan,
        course: &'a ProgramTransform,
        surface: Surface,
        marking: &Marking,
    ) -> Self {
        Self {
            plan,
            steps: Vec::new(),
            course,
            surface,
            reach: Reach::new(marking.tool.bias(), surface, marking.lift),
            lift: marking.lift,
            at: None,
        }
    }

    /// Builds the whole plan. It starts from any pose, above the first work position; earlier
    /// travel is left out.
    pub(super) fn build(mut self) -> Plan {
        let steps = std::mem::take(&mut self.plan.steps);
        let mut first = ([0.0; 3], Origin::NONE);
        for step in steps {
            let target = step.action.target().map(|to| to.map(f64::from));
            // Travel before the first mark is replaced by the entry from above.
            if let (None, Some(to), false) = (self.at, target, step.action.marks()) {
                first = (to, step.origin);
                continue;
            }
            if step.action.marks() && self.at.is_none() {
                let (to, origin) = first;
                self.enter(self.above(to), origin);
            }
            self.follow(step, target);
        }
        self.plan.steps = self.steps;
        self.plan
    }

    fn above(&self, to: [f64; 3]) -> Above {
        self.course.of(to)
    }

    fn point(&self, (at, above): Above) -> [f32; 3] {
        let z = self.surface.at(at) + above;
        [at[0], at[1], z].map(|value| value as f32)
    }

    fn pose(&self, place: Above) -> [f32; 4] {
        let [x, y, z] = self.point(place);
        [x, y, z, 0.0]
    }

    fn push(&mut self, action: Action, origin: Origin) {
        self.steps.push(Step::new(action, origin));
    }

    fn push_move(&mut self, to: Above, by: Travel, origin: Origin) {
        let pose = self.pose(to);
        self.push(Action::Move { to: pose, by }, origin);
        self.at = Some(to);
    }

    /// Enters from any pose: above the target by a joint move, then straight down.
    fn enter(&mut self, to: Above, origin: Origin) {
        let to = (to.0, to.1.max(0.0));
        let over = self.reach.over(to, to.1 + self.lift + APPROACH_HEIGHT);
        self.push_move(over, Travel::Joints, origin);
        if over != to {
            self.push_move(to, Travel::Line, origin);
        }
    }

    fn follow(&mut self, step: Step, target: Option<[f64; 3]>) {
        let origin = step.origin;
        let Some(to) = target.map(|to| self.above(to)) else {
            self.steps.push(step);
            return;
        };
        // A hole becomes a dot on the surface, at any depth of the drill.
        let to = match (&step.action, self.at) {
            (Action::Path { .. }, Some(from)) if from.0 == to.0 => {
                (to.0, to.1.max(self.course.deepest))
            }
            _ => to,
        };
        let action = match step.action {
            Action::Path { .. } if self.is_straight_reachable(to) || to.1 <= TOUCH_HEIGHT => {
                Action::Path { to: self.point(to) }
            }
            Action::Burn { power, .. } => Action::Burn {
                to: self.point(to),
                power,
            },
            Action::Arc {
                via: [x, y, z, _], ..
            } => {
                let via = self.above([x, y, z].map(f64::from));
                Action::Arc {
                    via: self.pose(via),
                    to: self.pose(to),
                }
            }
            _ => return self.travel((to.0, to.1.max(0.0)), origin),
        };
        let feed = step.feed;
        self.steps.push(Step {
            feed,
            ..Step::new(action, origin)
        });
        self.at = Some(to);
    }

    fn is_straight_reachable(&self, to: Above) -> bool {
        self.at
            .is_some_and(|from| self.reach.is_straight_move_possible(from, to))
    }

    /// Travels to a position: straight if possible, else lower, else around the base. If none
    /// works, it stops at the last reachable point of the straight line.
    fn travel(&mut self, to: Above, origin: Origin) {
        let Some(from) = self.at else {
            return self.enter(to, origin);
        };
        if from == to {
            return;
        }
        let lowest = self.lift.min(to.1);
        let heights = (0..=10).map(|nth| to.1 + (lowest - to.1) * f64::from(nth) / 10.0);
        let places: Vec<Above> = heights.map(|height| (to.0, height)).collect();
        if let Some(place) = places
            .iter()
            .find(|place| self.reach.is_straight_move_possible(from, **place))
        {
            return self.push_move(*place, Travel::Line, origin);
        }
        let is_reached = |place: &&Above| self.reach.joints(place.0, place.1).is_some();
        if let Some(place) = places.iter().find(is_reached) {
            let high = self.reach.over(from, self.lift + APPROACH_HEIGHT);
            self.push_move(high, Travel::Line, origin);
            return self.enter(*place, origin);
        }
        let share = |nth: u32| {
            let share = f64::from(nth) / f64::from(EXIT_SAMPLES);
            let between = |from: f64, to: f64| from + share * (to - from);
            let at = [0, 1].map(|axis| between(from.0[axis], to.0[axis]));
            (at, between(from.1, to.1))
        };
        let mut nearer = (1..EXIT_SAMPLES).rev().map(share);
        if let Some(near) = nearer.find(|near| self.reach.is_straight_move_possible(from, *near)) {
            self.push_move(near, Travel::Line, origin);
        }
    }
}

/// Adds a safe approach from above to the first point of a plan in arm coordinates.
pub(super) fn add_entry_from_above(plan: &mut Plan, lift: f64) {
    let first = (plan.steps.iter()).position(|step| step.action.target().is_some());
    let Some((at, step)) = first.and_then(|at| Some((at, plan.steps.get(at)?.clone()))) else {
        return;
    };
    let Action::Move {
        to: [x, y, z, r],
        by: Travel::Joints,
    } = step.action
    else {
        return;
    };
    let tool = plan.tool.map_or(ToolBias::PEN, Tool::bias);
    let ground = f64::from(z).min(0.0);
    let reach = Reach::new(tool, Surface::level(ground), lift);
    let above = f64::from(z) - ground;
    let place = [x, y].map(f64::from);
    let over = reach.over((place, above), above + lift + APPROACH_HEIGHT);
    if over == (place, above) {
        return;
    }
    let ([over_x, over_y], over_z) = over;
    let over = [over_x, over_y, over_z + ground].map(|value| value as f32);
    let to = [over[0], over[1], over[2], r];
    let by = Travel::Joints;
    let origin = step.origin;
    let action = Action::Move { to, by };
    plan.steps.insert(at, Step::new(action, origin));
    if let Some(Step {
        action: Action::Move { by, .. },
        ..
    }) = plan.steps.get_mut(at + 1)
    {
        *by = Travel::Line;
    }
}
