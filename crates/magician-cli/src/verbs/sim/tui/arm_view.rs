//! Consistent view of an arm: everything that a frame shows, read at one instant.

use std::time::Duration;

use magician_motion::{Geometry, JointAngles, Pose, ToolBias};
use magician_sim::scenario::{Color, ToolKind};
use magician_sim::world::{Drawing, ObjectPose, Support};
use magician_sim::{ArmInstant, Controller, ControllerState, PinState};

/// State of the arm and its world at an instant.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ArmView {
    /// State of the controller. The clock is truncated to whole seconds, so that the view of a
    /// resting arm changes, and is redrawn, only once a second.
    pub(super) state: ControllerState,
    /// Mounted tool if the scenario has one; otherwise the tool set on the controller.
    pub(super) tool: ToolBias,
    /// Pins of the connectors, address 1 first.
    pub(super) pins: [PinState; 20],
    /// Objects of the world.
    pub(super) items: Vec<Item>,
    /// Distance that the belt has run, mm.
    pub(super) belt_travel: f64,
    /// Lines drawn since the last view.
    pub(super) ink: Ink,
}

/// Object of the world.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Item {
    pub(super) name: String,
    /// Length, width and height, mm.
    pub(super) size: [f64; 3],
    pub(super) color: Color,
    pub(super) place: ObjectPose,
    pub(super) rest: Support,
}

/// New corners of the drawing, by stroke, and the place at which the next view continues.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ink {
    pub(super) strokes: Vec<Vec<[f64; 2]>>,
    pub(super) until: Cursor,
}

/// Place in a drawing: a stroke and a corner of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cursor {
    stroke: usize,
    corner: usize,
}

/// Largest number of corners per view. The arm's task is blocked while the view is taken, so the
/// rest follows with the next view.
const MAX_CORNERS_PER_VIEW: usize = 2_000;

impl ArmView {
    pub(super) fn at(controller: &Controller, ink: Cursor) -> Self {
        let mut state = controller.state();
        state.now =
            ArmInstant::ZERO + Duration::from_secs((state.now - ArmInstant::ZERO).as_secs());
        let look = controller.look();
        let items = look.objects().map(|object| Item {
            name: object.name().to_owned(),
            size: object.size(),
            color: object.color(),
            place: object.place(),
            rest: object.rest(),
        });
        let world = controller.world();
        let tool = (world.scenario()).and_then(|scenario| scenario.chosen_tool());
        let tool = tool.filter(|tool| tool.kind != ToolKind::None);
        let drawing = world.drawing();
        Self {
            tool: tool.map_or(state.tool, |tool| tool.bias()),
            state,
            pins: controller.pins(),
            items: items.collect(),
            belt_travel: look.belt_travel(),
            ink: drawing.map_or_else(Ink::default, |drawing| Ink::since(ink, drawing)),
        }
    }

    /// Returns the links at the arm's true position.
    pub(super) fn figure(&self) -> Figure {
        Figure::of(&self.state.true_joints, self.tool, self.rail())
    }

    /// Returns the links at the commanded position.
    pub(super) fn commanded(&self) -> Figure {
        Figure::of(&self.state.joints, self.tool, self.rail())
    }

    /// Returns the position of the carriage along Y, mm; 0 without a rail.
    pub(super) fn rail(&self) -> f64 {
        self.state.rail.unwrap_or(0.0)
    }

    /// Returns the deviation of each joint from its commanded angle, deg.
    pub(super) fn slips(&self) -> [f64; 4] {
        let (true_joints, believed) = (self.state.true_joints, self.state.joints);
        [
            true_joints.j1 - believed.j1,
            true_joints.j2 - believed.j2,
            true_joints.j3 - believed.j3,
            true_joints.j4 - believed.j4,
        ]
    }
}

impl Ink {
    fn since(from: Cursor, drawing: &Drawing) -> Self {
        let mut ink = Self {
            strokes: Vec::new(),
            until: from,
        };
        let mut left = MAX_CORNERS_PER_VIEW;
        for (nth, stroke) in drawing.strokes().iter().enumerate().skip(from.stroke) {
            let seen = if nth == from.stroke { from.corner } else { 0 };
            // Includes the last known corner, from which the line continues.
            let new = stroke.points.get(seen.saturating_sub(1)..);
            let new: Vec<_> = new.unwrap_or_default().iter().take(left).copied().collect();
            left -= new.len();
            let corner = seen.saturating_sub(1) + new.len();
            if corner > seen {
                ink.strokes.push(new);
                ink.until = Cursor {
                    stroke: nth,
                    corner,
                };
            }
            if left == 0 {
                break;
            }
        }
        ink
    }
}

/// Joints of the arm, seen from the side as `[r, z]` in the arm's plane, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Figure {
    pub(super) elbow: [f64; 2],
    pub(super) wrist: [f64; 2],
    pub(super) tip: [f64; 2],
    /// Distance of the tip to the left of the arm's plane, mm.
    left: f64,
    /// Angle of the base, deg.
    base: f64,
    rail: f64,
}

impl Figure {
    pub(super) fn of(joints: &JointAngles, tool: ToolBias, rail: f64) -> Self {
        let Geometry {
            rear_arm, forearm, ..
        } = Geometry::magician(tool);
        let (sin2, cos2) = joints.j2.to_radians().sin_cos();
        let (sin3, cos3) = joints.j3.to_radians().sin_cos();
        let elbow = [rear_arm * sin2, rear_arm * cos2];
        let wrist = [elbow[0] + forearm * cos3, elbow[1] - forearm * sin3];
        Self {
            elbow,
            wrist,
            tip: [wrist[0] + tool.x, wrist[1] - tool.z],
            left: tool.y,
            base: joints.j1,
            rail,
        }
    }

    /// Returns the point x, y at distance `r` in the arm's plane and `left` to its left.
    fn above(&self, r: f64, left: f64) -> [f64; 2] {
        let (sin, cos) = self.base.to_radians().sin_cos();
        [r * cos - left * sin, r * sin + left * cos + self.rail]
    }

    pub(super) fn elbow_above(&self) -> [f64; 2] {
        self.above(self.elbow[0], 0.0)
    }

    pub(super) fn wrist_above(&self) -> [f64; 2] {
        self.above(self.wrist[0], 0.0)
    }

    pub(super) fn tip_above(&self) -> [f64; 2] {
        self.above(self.tip[0], self.left)
    }

    /// Returns the point x, y at distance `r` in the arm's plane.
    pub(super) fn out(&self, r: f64) -> [f64; 2] {
        self.above(r, 0.0)
    }

    /// Converts a point x, y into distance along the arm's plane and to its left.
    pub(super) fn seen(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.base.to_radians().sin_cos();
        let y = y - self.rail;
        [x * cos + y * sin, y * cos - x * sin]
    }
}

/// Returns the joint angles after a push by hand, or the reason why the arm does not yield.
pub(super) fn pushed(
    state: &ControllerState,
    limits: &magician_motion::Limits,
    by: Push,
) -> Result<JointAngles, String> {
    let joints = state.true_joints;
    let pushed = match by {
        Push::Joint(joint, degrees) => {
            let mut joints = joints;
            match joint {
                1 => joints.j1 += degrees,
                2 => joints.j2 += degrees,
                3 => joints.j3 += degrees,
                _ => joints.j4 += degrees,
            }
            joints
        }
        Push::Tool([x, y, z]) => {
            let geometry = Geometry::magician(state.tool);
            let there = geometry
                .forward(&joints)
                .offset_by(&Pose::new(x, y, z, 0.0));
            let reached = geometry
                .inverse(&there)
                .map_err(|error| error.to_string())?;
            // Pushing the tool does not rotate it.
            JointAngles {
                j4: joints.j4,
                ..reached
            }
        }
    };
    limits.check(&pushed).map_err(|error| error.to_string())?;
    Ok(pushed)
}

/// Push by hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Push {
    /// Turns a joint, 1 to 4, by degrees.
    Joint(u8, f64),
    /// Moves the tool along x, y and z, mm.
    Tool([f64; 3]),
}

#[cfg(test)]
mod tests {
    use magician_motion::ArmModel;
    use magician_protocol::commands::{PtpCmd, QueuedCmdStartExec};
    use magician_protocol::{Ctrl, FrameBuf, PtpMode, Set};
    use magician_sim::{LinkId, Profile, Scenario, World};

    use super::*;

    fn view() -> ArmView {
        ArmView::at(&Controller::default(), Cursor::default())
    }

    #[test]
    fn tip_of_the_figure_matches_the_pose() {
        let mut look = view();
        look.state.true_joints = JointAngles::new(30.0, 40.0, 20.0, 0.0);
        look.tool = ToolBias::new(60.0, 10.0, 5.0);
        let pose = Geometry::magician(look.tool).forward(&look.state.true_joints);
        let figure = look.figure();
        let [x, y] = figure.tip_above();
        assert!((x - pose.x).abs() < 1e-9 && (y - pose.y).abs() < 1e-9);
        assert!((figure.tip[1] - pose.z).abs() < 1e-9);
        let [r, left] = figure.seen([x, y]);
        assert!((r - figure.tip[0]).abs() < 1e-9 && (left - 10.0).abs() < 1e-9);
    }

    #[test]
    fn push_moves_tool_or_joint_up_to_its_limits() {
        let state = view().state;
        let limits = Profile::default().arm_model().limits;
        let joints = pushed(&state, &limits, Push::Tool([0.0, 10.0, 0.0])).unwrap();
        let geometry = Geometry::magician(state.tool);
        let (before, after) = (
            geometry.forward(&state.true_joints),
            geometry.forward(&joints),
        );
        assert!((after.y - before.y - 10.0).abs() < 1e-9 && (after.x - before.x).abs() < 1e-9);
        assert_eq!(joints.j4, state.true_joints.j4);

        let joints = pushed(&state, &limits, Push::Joint(3, 2.0)).unwrap();
        assert_eq!(joints.j3, state.true_joints.j3 + 2.0);
        let refused = pushed(&state, &limits, Push::Joint(2, 100.0)).unwrap_err();
        assert!(refused.contains("joint 2"), "{refused}");
        let refused = pushed(
            &state,
            &ArmModel::MAGICIAN.certain,
            Push::Tool([500.0, 0.0, 0.0]),
        );
        assert!(refused.is_err());
    }

    #[test]
    fn objects_are_projected_to_their_position() {
        let text = "[table]\nheight = -70\n[[object]]\nname = \"cube\"\nsize = [20, 20, 20]\nat = [220, 50]\ncolor = \"red\"";
        let world = World::from_scenario(&Scenario::from_toml(text).unwrap());
        let controller = Controller::in_world(Profile::default(), world);
        let look = ArmView::at(&controller, Cursor::default());
        let [cube] = &look.items[..] else {
            panic!("{:?}", look.items)
        };
        assert_eq!((&cube.name[..], cube.rest), ("cube", Support::Table));
        assert_eq!(
            (cube.place.x, cube.place.y, cube.place.z),
            (220.0, 50.0, -70.0)
        );
    }

    /// Consecutive views show the whole drawing, although every motion is viewed several times.
    #[test]
    fn consecutive_views_show_the_whole_drawing() {
        let text = "[arm]\nhomed = true\n[tool]\nkind = \"pen\"\n[table]\nheight = -40";
        let world = World::from_scenario(&Scenario::from_toml(text).unwrap());
        let mut arm = Controller::in_world(Profile::default(), world);
        let send = |arm: &mut Controller, set: Set, ctrl| {
            let frame = FrameBuf::set(&set, ctrl).unwrap();
            arm.receive(LinkId(0), frame.bytes());
        };
        send(&mut arm, QueuedCmdStartExec {}.into(), Ctrl::SET);
        let corners = [(241.0, 0.0), (261.0, 40.0), (281.0, -20.0), (241.0, 0.0)];
        for z in [-20.0, -40.0, -40.5, -20.0, -40.0] {
            for (x, y) in corners {
                let ptp_mode = PtpMode::MovlXyz;
                let (x, r) = (x + z, 0.0);
                let line = PtpCmd {
                    ptp_mode,
                    x,
                    y,
                    z,
                    r,
                };
                send(&mut arm, line.into(), Ctrl::QUEUED);
            }
        }
        let mut cursor = Cursor::default();
        let mut seen: Vec<[f64; 2]> = Vec::new();
        let mut looks = 0;
        for step in 0..600 {
            arm.advance(ArmInstant::from_micros(step * 100_000));
            let ink = ArmView::at(&arm, cursor).ink;
            looks += usize::from(!ink.strokes.is_empty());
            for stroke in ink.strokes {
                // The continuation of a stroke begins with its last known corner.
                let known = seen.last() == stroke.first();
                seen.extend(stroke.into_iter().skip(usize::from(known)));
            }
            cursor = ink.until;
        }
        let drawing = arm.world().drawing().unwrap();
        let drawn = drawing.strokes().iter().flat_map(|stroke| &stroke.points);
        assert!(drawing.strokes().len() >= 2 && looks > 3);
        assert_eq!(seen, drawn.copied().collect::<Vec<_>>());
        assert!(ArmView::at(&arm, cursor).ink.strokes.is_empty());
    }
}
