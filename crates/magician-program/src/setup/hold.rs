//! Keeps a pen above its surface: motion below the surface is raised onto it.
//!
//! Two positions are tracked along the plan: the programmed one, and the one held above the
//! surface. Relative steps count from the programmed position, so a later step that rises above the
//! surface again ends at its programmed target.

use magician_host::message;
use magician_host::{Setting, SettingValue};
use magician_motion::Geometry;
use magician_protocol::{CpMode, Set};

use super::POWER_UP_TOOL;
use crate::{Action, Diagnostic, DiagnosticCode, Origin, Plan, Step, Surface, Tool, Travel};

/// Depth that still counts as on the surface, mm: coordinates are rounded to 32 bits.
const DEPTH_TOLERANCE: f64 = 1e-4;
/// Smallest depth reported in a note, mm; less is rounding in the file.
const MIN_REPORTED_DEPTH: f64 = 0.05;

type Point = [f64; 3];

/// Largest depth below the surface that was avoided, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RaisedDepth {
    depth: f64,
}

impl RaisedDepth {
    pub(super) const fn new(depth: f64) -> Self {
        Self { depth }
    }

    /// Note that states the depth.
    pub(super) fn note(self) -> Diagnostic {
        let what = message!(
            "it goes up to {most:.1} mm below the surface: the pen draws that on the surface",
            most = self.depth
        );
        Diagnostic::of_file(what)
            .coded(DiagnosticCode::Assumed)
            .remedy(
                (Setting::Surface, SettingValue::Any("Z")),
                "sets another height of the surface",
            )
            .remedy(
                (Setting::Depths, SettingValue::Word("keep")),
                "takes the pen below the surface",
            )
    }
}

/// True if a plan handles things with a suction cup or gripper.
pub(super) fn handles_objects(plan: &Plan) -> bool {
    let holds = |step: &Step| matches!(step.action, Action::Suction(_) | Action::Gripper(_));
    plan.steps.iter().any(holds)
}

/// Raises the motion of a plan that leads below the surface onto it. Returns the largest depth
/// avoided, or `None` if it is less than [`MIN_REPORTED_DEPTH`].
///
/// # Errors
/// [`Diagnostic`] for the first step whose joint angles lead below the surface.
pub(crate) fn hold_above(
    plan: &mut Plan,
    surface: Surface,
) -> Result<Option<RaisedDepth>, Diagnostic> {
    let mut holder = Holder {
        surface,
        geometry: Geometry::magician(plan.tool.map_or(POWER_UP_TOOL, Tool::bias)),
        at: None,
        max_depth: 0.0,
    };
    let steps = std::mem::take(&mut plan.steps);
    plan.steps.reserve_exact(steps.len());
    for (nth, mut step) in steps.into_iter().enumerate() {
        match holder.hold(&mut step.action) {
            Ok(None) => {}
            Ok(Some(before)) => plan.steps.push(Step::new(before, step.origin)),
            Err(deep) => return Err(joint_angles_error(nth, step.origin, deep)),
        }
        plan.steps.push(step);
    }
    Ok((holder.max_depth >= MIN_REPORTED_DEPTH).then_some(RaisedDepth::new(holder.max_depth)))
}

fn joint_angles_error(nth: usize, origin: Origin, deep: f64) -> Diagnostic {
    let message = message!(
        "step {nth} leads {deep:.1} mm below the surface by joint angles",
        nth = nth + 1,
        deep
    );
    Diagnostic::new(origin, message).remedy(
        (Setting::Depths, SettingValue::Word("keep")),
        "takes the pen below the surface",
    )
}

/// Position of a tool held above the surface, and its programmed position.
#[derive(Clone, Copy)]
struct TrackedPosition {
    held: Point,
    programmed: Point,
}

struct Holder {
    surface: Surface,
    geometry: Geometry,
    at: Option<TrackedPosition>,
    max_depth: f64,
}

impl Holder {
    /// Changes an action so that it stays above the surface; returns an action to insert before it.
    ///
    /// # Errors
    /// Depth below the surface, mm, of a target given in joint angles.
    fn hold(&mut self, action: &mut Action) -> Result<Option<Action>, f64> {
        match action {
            Action::Move { to, .. } => self.pose(to),
            Action::Joints { to, .. } => self.joints(*to)?,
            Action::Shift { by, .. } => self.shift(by),
            Action::Path { to } => return Ok(self.path(to)),
            Action::Burn { to, .. } => self.point(to),
            Action::Arc { via, to } => return Ok(self.arc(via, to)),
            // The home point is a setting of the arm, so the position after homing is unknown.
            Action::Home => self.at = None,
            Action::Command(command) => return self.command(command),
            // Waits, tools and markers do not move the arm.
            _ => {}
        }
        Ok(None)
    }

    fn command(&mut self, command: &mut Set) -> Result<Option<Action>, f64> {
        let (mode, [x, y, z, r]) = match command {
            Set::PtpCmd(ptp) => (
                ptp.ptp_mode,
                [&mut ptp.x, &mut ptp.y, &mut ptp.z, &mut ptp.r],
            ),
            Set::PtpPoCmd(ptp) => (
                ptp.ptp_mode,
                [&mut ptp.x, &mut ptp.y, &mut ptp.z, &mut ptp.r],
            ),
            Set::PtpWithLCmd(ptp) => (
                ptp.ptp_mode,
                [&mut ptp.x, &mut ptp.y, &mut ptp.z, &mut ptp.r],
            ),
            Set::PtpPoWithLCmd(ptp) => (
                ptp.ptp_mode,
                [&mut ptp.x, &mut ptp.y, &mut ptp.z, &mut ptp.r],
            ),
            Set::CpCmd(cp) => {
                let mut to = [cp.x, cp.y, cp.z];
                let before = match cp.cp_mode {
                    CpMode::Absolute => self.path(&mut to),
                    _ => {
                        let [x, y, z] = to;
                        let mut by = [x, y, z, 0.0];
                        self.shift(&mut by);
                        to = [x, y, by[2]];
                        None
                    }
                };
                cp.z = to[2];
                return Ok(before);
            }
            Set::ArcCmd(arc) => return Ok(self.arc(&mut arc.cir_point, &mut arc.to_point)),
            Set::CircleCmd(circle) => {
                let at = self.at;
                let before = self.arc(&mut circle.cir_point, &mut circle.to_point);
                // A circle ends where it began.
                self.at = before.as_ref().and_then(target).or(at);
                return Ok(before);
            }
            other => {
                if other.row().effect.moves_arm() {
                    // An untracked motion: relative steps after it have no known start.
                    self.at = None;
                }
                return Ok(None);
            }
        };
        let mut to = [*x, *y, *z, *r];
        match mode {
            mode if mode.is_absolute_pose() => self.pose(&mut to),
            mode if mode.is_pose() => self.shift(&mut to),
            mode if mode.is_absolute() => self.joints(to)?,
            // Joint offsets from an unknown start, or an unknown mode.
            _ => self.at = None,
        }
        *z = to[2];
        Ok(None)
    }

    fn height_above(&self, [x, y, z]: Point) -> f64 {
        z - self.surface.at([x, y])
    }

    /// Position raised vertically onto the surface if it lies below.
    fn raised(&mut self, programmed: Point) -> Point {
        let above = self.height_above(programmed);
        if above >= -DEPTH_TOLERANCE || !above.is_finite() {
            return programmed;
        }
        self.max_depth = self.max_depth.max(-above);
        let [x, y, _] = programmed;
        [x, y, self.surface.at([x, y])]
    }

    fn move_to(&mut self, programmed: Point) -> Point {
        let held = self.raised(programmed);
        self.at = Some(TrackedPosition { held, programmed });
        held
    }

    fn point(&mut self, to: &mut [f32; 3]) {
        let programmed = to.map(f64::from);
        let held = self.move_to(programmed);
        // Unchanged targets keep their exact bits.
        if held != programmed {
            to[2] = held[2] as f32;
        }
    }

    fn pose(&mut self, to: &mut [f32; 4]) {
        let mut point = [to[0], to[1], to[2]];
        self.point(&mut point);
        to[2] = point[2];
    }

    fn shift(&mut self, by: &mut [f32; 4]) {
        // Without a known start the height of a relative step is unknown. The check of the plan
        // tests whether it is within reach.
        let Some(TrackedPosition { held, programmed }) = self.at else {
            return;
        };
        let offset = [by[0], by[1], by[2]].map(f64::from);
        let to = [0, 1, 2].map(|axis: usize| programmed[axis] + offset[axis]);
        let from = held[2];
        let held = self.move_to(to);
        // Unchanged offsets keep their exact bits.
        if held[2] - from != offset[2] {
            by[2] = (held[2] - from) as f32;
        }
    }

    fn joints(&mut self, to: [f32; 4]) -> Result<(), f64> {
        let joints = to.map(f64::from);
        let pose = self.geometry.forward(&joints.into());
        let programmed = [pose.x, pose.y, pose.z];
        let above = self.height_above(programmed);
        // Joint angles cannot be corrected in Z alone, so such a step is refused.
        if above < -MIN_REPORTED_DEPTH {
            return Err(-above);
        }
        self.at = Some(TrackedPosition {
            held: programmed,
            programmed,
        });
        Ok(())
    }

    /// Splits a line where it crosses the surface; the part below is moved onto the surface.
    fn path(&mut self, to: &mut [f32; 3]) -> Option<Action> {
        let before = self.at;
        self.point(to);
        let from = before?.programmed;
        let programmed = self.at?.programmed;
        let (here, there) = (self.height_above(from), self.height_above(programmed));
        let crosses = here.min(there) < -DEPTH_TOLERANCE && here.max(there) > DEPTH_TOLERANCE;
        crosses.then(|| {
            let share = here / (here - there);
            let [x, y] =
                [0, 1].map(|axis: usize| from[axis] + share * (programmed[axis] - from[axis]));
            let to = [x, y, self.surface.at([x, y])].map(|value| value as f32);
            Action::Path { to }
        })
    }

    /// Moves an arc that leads below the surface onto it as a whole.
    fn arc(&mut self, via: &mut [f32; 4], to: &mut [f32; 4]) -> Option<Action> {
        let from = self.at;
        // Only the three points of an arc are tested, because an arc cannot be split like a line.
        let points = [*via, *to].map(|[x, y, z, _]| [x, y, z].map(f64::from));
        let ends = points.into_iter().chain(from.map(|from| from.programmed));
        let is_below = ends
            .map(|end| self.height_above(end))
            .any(|above| above < -DEPTH_TOLERANCE);
        if !is_below {
            self.move_to(points[1]);
            return None;
        }
        for (pose, [x, y, z]) in [via, to].into_iter().zip(points) {
            self.move_to([x, y, z]);
            pose[2] = self.surface.at([x, y]) as f32;
        }
        let [x, y, _] = points[1];
        self.at = Some(TrackedPosition {
            held: [x, y, self.surface.at([x, y])],
            programmed: points[1],
        });
        let [x, y, z] = from?.held;
        let on = self.surface.at([x, y]);
        (z - on > DEPTH_TOLERANCE).then(|| Action::Move {
            to: [x, y, on, 0.0].map(|value| value as f32),
            by: Travel::Line,
        })
    }
}

fn target(action: &Action) -> Option<TrackedPosition> {
    let held = action.target()?.map(f64::from);
    Some(TrackedPosition {
        held,
        programmed: held,
    })
}

#[cfg(test)]
mod tests {
    use magician_host::build;
    use proptest::prelude::*;

    use super::*;

    const SURFACE: Surface = Surface {
        height: -50.0,
        slope: [0.02, -0.01],
    };

    fn plan(actions: impl IntoIterator<Item = Action>) -> Plan {
        let mut plan = Plan::new("p");
        plan.tool = Some(Tool::Pen);
        { actions.into_iter() }.for_each(|action| plan.push(action, Origin::NONE));
        plan
    }

    /// Heights above the surface of all targets and via points of a plan of absolute and relative
    /// steps.
    fn heights(plan: &Plan) -> Vec<f64> {
        let mut at: Option<Point> = None;
        let mut all = Vec::new();
        for step in &plan.steps {
            let to = match &step.action {
                Action::Shift {
                    by: [x, y, z, _], ..
                } => at.map(|[a, b, c]| [a + f64::from(*x), b + f64::from(*y), c + f64::from(*z)]),
                action => action.target().map(|to| to.map(f64::from)),
            };
            if let Action::Arc {
                via: [x, y, z, _], ..
            } = step.action
            {
                all.push([x, y, z].map(f64::from));
            }
            all.extend(to);
            at = to.or(at);
        }
        all.iter()
            .map(|[x, y, z]| z - SURFACE.at([*x, *y]))
            .collect()
    }

    fn action() -> impl Strategy<Value = Action> {
        let x = || 150.0..300.0_f32;
        let y = || -100.0..100.0_f32;
        let z = || -80.0..-30.0_f32;
        prop_oneof![
            (x(), y(), z()).prop_map(|(x, y, z)| Action::Move {
                to: [x, y, z, 0.0],
                by: Travel::Line
            }),
            (x(), y(), z()).prop_map(|(x, y, z)| Action::Path { to: [x, y, z] }),
            (x(), y(), z(), x(), y(), z()).prop_map(|(a, b, c, x, y, z)| Action::Arc {
                via: [a, b, c, 0.0],
                to: [x, y, z, 0.0]
            }),
            (-9.0..9.0_f32, -9.0..9.0_f32, -20.0..20.0_f32).prop_map(|(x, y, z)| Action::Shift {
                by: [x, y, z, 0.0],
                line: true
            }),
        ]
    }

    proptest! {
        #[test]
        fn held_plan_leads_nowhere_below_the_surface(
            actions in proptest::collection::vec(action(), 1..20),
        ) {
            let start = Action::Move { to: [200.0, 0.0, 0.0, 0.0], by: Travel::Joints };
            let mut held = plan(std::iter::once(start).chain(actions));
            hold_above(&mut held, SURFACE).unwrap();
            for above in heights(&held) {
                prop_assert!(above > -1e-3, "{above}: {:?}", held.steps);
            }
        }
    }

    #[test]
    fn line_through_the_surface_is_on_it_from_the_crossing_on() {
        let level = Surface::level(-50.0);
        let mut held = plan([
            Action::Path {
                to: [200.0, 0.0, -49.0],
            },
            Action::Path {
                to: [210.0, 0.0, -54.0],
            },
        ]);
        let raised = hold_above(&mut held, level).unwrap().unwrap();
        assert!(raised.note().message.contains("4.0 mm below"));
        let ends: Vec<_> = held
            .steps
            .iter()
            .filter_map(|step| step.action.target())
            .collect();
        assert_eq!(
            ends,
            [
                [200.0, 0.0, -49.0],
                [202.0, 0.0, -50.0],
                [210.0, 0.0, -50.0]
            ]
        );
    }

    #[test]
    fn plan_above_the_surface_keeps_its_exact_bits() {
        let mut held = plan([
            Action::Path {
                to: [200.0, 0.0, -50.00005],
            },
            build::line_by(0.1, 0.2, 0.3, 0.0).into(),
        ]);
        let before = held.clone();
        assert_eq!(hold_above(&mut held, Surface::level(-50.0)).unwrap(), None);
        assert_eq!(held, before);
    }

    #[test]
    fn joint_angles_below_the_surface_are_refused() {
        let mut held = plan([build::move_joints(0.0, 60.0, 60.0, 0.0).into()]);
        let refused = hold_above(&mut held, Surface::level(100.0)).unwrap_err();
        assert!(refused.message.contains("by joint angles"), "{refused}");
    }
}
