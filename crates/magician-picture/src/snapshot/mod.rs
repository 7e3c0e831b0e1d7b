//! Snapshots: an arm in its pose from above and from the side, and the world around a virtual one.

mod above;
#[cfg(feature = "png")]
mod pixels;
mod run;
mod side;

use magician_host::{AlarmSet, Geometry, JointAngles, ToolBias};
use magician_motion::Pose;
use magician_sim::Controller;
use magician_sim::scenario::{Color, ToolKind};
use magician_sim::world::{Drawing, Support};
#[cfg(feature = "png")]
pub use pixels::{View, pixels};
pub use run::{MovedObject, RunReading, RunView};

use crate::ground;
use crate::panel::{MARGIN, TICK_SPACE};
use crate::svg::palette::{CARRIED, FAINT, INK, WRONG};
use crate::svg::{Anchor, Number, Svg, TextStyle, signed};

/// Scale of both views, 1 : 4.
const SCALE: f64 = 0.25;
/// Part of the ground shown from above, mm.
const ABOVE_PART: [[f64; 2]; 2] = [[-100.0, -340.0], [360.0, 340.0]];
/// Part of the plane through the arm shown from the side, mm.
const SIDE_PART: [[f64; 2]; 2] = [[-90.0, -180.0], [360.0, 260.0]];
/// Space for title and figures, mm.
const HEAD_HEIGHT: f64 = 18.0;
/// Half the width of the base, and its depth below the shoulder (model section 1), mm.
const BASE_BODY: [f64; 2] = [ground::BASE_HALF_SIDE, 138.0];
/// Thickness of the links from above and from the side, mm.
const LINK_THICKNESS: [f64; 2] = [26.0, 20.0];
/// Thickness of table and belt from the side, mm.
const PLATE_THICKNESS: f64 = 8.0;
/// Colour of the links.
const LINK_COLOR: &str = "#52606d";
/// Colour of a belt.
const BELT_COLOR: &str = "#7d8894";
/// Colour of a table from the side.
const TABLE_COLOR: &str = "#e6dcc6";

/// State of an arm to draw.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ArmView {
    /// Title.
    pub title: String,
    /// Joint angles, deg.
    pub joints: JointAngles,
    /// Tool bias from the wrist.
    pub tool: ToolBias,
    /// Active alarms.
    pub alarms: AlarmSet,
    /// Further facts, a few words each.
    pub facts: Vec<String>,
}

/// Picture of an arm in its pose.
///
/// ```
/// use magician_host::JointAngles;
/// use magician_picture::{Snapshot, ArmView};
///
/// let mut arm = ArmView::default();
/// arm.joints = JointAngles::HOME;
/// assert!(Snapshot::of_arm(&arm).to_svg().starts_with("<svg"));
/// ```
#[derive(Clone, Debug)]
pub struct Snapshot {
    svg: String,
}

/// A box in the world.
struct Body {
    name: String,
    size: [f64; 3],
    /// X, y, z of the middle of its underside, and its rotation.
    place: [f64; 4],
    color: Color,
    state: BodyState,
}

/// State of a box.
#[derive(Clone, Copy, PartialEq, Eq)]
enum BodyState {
    Stands,
    Held,
    /// Moved to its place by a run.
    Moved,
}

/// Surroundings of the arm.
#[derive(Default)]
struct Surroundings {
    /// Height of the table, and its range in x and in y.
    table: Option<(f64, [[f64; 2]; 2])>,
    belt: Option<Belt>,
    bodies: Vec<Body>,
    /// Position and end of the beam of each sensor.
    beams: Vec<[[f64; 3]; 2]>,
    drawing: Drawing,
}

struct Belt {
    start: [f64; 2],
    /// Direction, degrees.
    direction: f64,
    length: f64,
    width: f64,
    height: f64,
}

impl Body {
    fn is_held(&self) -> bool {
        self.state == BodyState::Held
    }

    /// Colour and width of its edge.
    fn edge(&self) -> [&'static str; 2] {
        match self.state {
            BodyState::Stands => [FAINT, "0.3"],
            BodyState::Held => [INK, "0.6"],
            BodyState::Moved => [CARRIED, "0.4"],
        }
    }

    /// Corners of its outline from above.
    fn corners(&self) -> [[f64; 2]; 4] {
        let [x, y, _, yaw] = self.place;
        let [length, width, _] = self.size.map(|side| side / 2.0);
        let corners = [
            [-length, -width],
            [length, -width],
            [length, width],
            [-length, width],
        ];
        corners.map(|corner| {
            let [dx, dy] = turned(corner, yaw);
            [x + dx, y + dy]
        })
    }

    /// Two opposite corners from the side: distance from the base axis, and z.
    fn side_corners(&self) -> [[f64; 2]; 2] {
        let [x, y, z, _] = self.place;
        let [length, width, height] = self.size;
        let (middle, half) = (libm::hypot(x, y), length.max(width) / 2.0);
        [[middle - half, z], [middle + half, z + height]]
    }
}

impl Belt {
    /// Corners of its outline from above.
    fn corners(&self) -> [[f64; 2]; 4] {
        let half = self.width / 2.0;
        let corners = [
            (0.0, -half),
            (self.length, -half),
            (self.length, half),
            (0.0, half),
        ];
        corners.map(|(along, offset)| self.at(along, offset))
    }

    /// Two opposite corners from the side, between its smallest and largest distance from the base
    /// axis.
    fn side_corners(&self) -> [[f64; 2]; 2] {
        let half = self.width / 2.0;
        let points = (0..=24).flat_map(|nth| {
            let along = self.length * f64::from(nth) / 24.0;
            [-half, 0.0, half].map(|offset| self.at(along, offset))
        });
        let [near, far] = points.fold([f64::MAX, 0.0_f64], |[near, far], [x, y]| {
            [near.min(libm::hypot(x, y)), far.max(libm::hypot(x, y))]
        });
        [[near, self.height], [far, self.height - PLATE_THICKNESS]]
    }

    /// Returns the point at a distance along the belt and a distance to the left of its middle
    /// line.
    fn at(&self, along: f64, offset: f64) -> [f64; 2] {
        let [x, y] = turned([along, offset], self.direction);
        [self.start[0] + x, self.start[1] + y]
    }
}

impl Snapshot {
    /// Draws an arm alone.
    #[must_use]
    pub fn of_arm(view: &ArmView) -> Self {
        Self::draw_views(view, &Surroundings::default())
    }

    /// Draws a virtual arm in its true pose, and its world, at this instant.
    #[must_use]
    pub fn of_world(arm: &Controller) -> Self {
        let (view, surroundings) = Self::view_of(arm);
        Self::draw_views(&view, &surroundings)
    }

    /// Draws an arm after a run, with the path of its tool and the objects it moved.
    #[must_use]
    pub fn of_run(view: &ArmView, run: &RunView) -> Self {
        Self {
            svg: run::draw(view, run),
        }
    }

    fn view_of(arm: &Controller) -> (ArmView, Surroundings) {
        let state = arm.state();
        let scenario = arm.world().scenario();
        let mounted = scenario.and_then(|scenario| scenario.chosen_tool());
        let mounted = mounted.filter(|tool| tool.kind != ToolKind::None);
        let mut facts = vec![format!("{} s", Number(state.now.as_micros() as f64 / 1e6))];
        let look = arm.look();
        if let Some(held) = look.held() {
            facts.push(format!("holds {}", held.name()));
        }
        if state.laser {
            facts.push(format!("laser at {} %", Number(state.laser_power)));
        }
        let title = scenario.and_then(|scenario| scenario.title());
        let view = ArmView {
            title: title.unwrap_or("Virtual arm").to_owned(),
            joints: state.true_joints,
            tool: mounted.map_or(state.tool, |tool| tool.bias()),
            alarms: state.alarms,
            facts,
        };
        let bodies = look.objects().map(|object| {
            let place = object.place();
            Body {
                name: object.name().to_owned(),
                size: object.size(),
                place: [place.x, place.y, place.z, place.yaw],
                color: object.color(),
                state: match object.rest() {
                    Support::Tool => BodyState::Held,
                    _ => BodyState::Stands,
                },
            }
        });
        let surroundings = Surroundings {
            table: scenario
                .and_then(|scenario| scenario.table())
                .map(|table| (table.height, [table.x, table.y])),
            belt: scenario
                .and_then(|scenario| scenario.conveyor())
                .map(|belt| Belt {
                    start: belt.start,
                    direction: belt.direction,
                    length: belt.length,
                    width: belt.width,
                    height: belt.height,
                }),
            bodies: bodies.collect(),
            beams: scenario
                .map(|scenario| scenario.sensors())
                .unwrap_or_default()
                .iter()
                .map(|sensor| [sensor.beam.from, sensor.beam.to])
                .collect(),
            drawing: arm.drawing(),
        };
        (view, surroundings)
    }

    /// Returns the SVG.
    #[must_use]
    pub fn to_svg(&self) -> &str {
        &self.svg
    }

    fn draw_views(view: &ArmView, surroundings: &Surroundings) -> Self {
        let [left, top] = [MARGIN + TICK_SPACE[0], MARGIN + HEAD_HEIGHT];
        let size = |part: [[f64; 2]; 2]| [0, 1].map(|axis| (part[1][axis] - part[0][axis]) * SCALE);
        let side_view_left = left + size(ABOVE_PART)[0] + MARGIN + TICK_SPACE[0];
        let width = side_view_left + size(SIDE_PART)[0] + MARGIN;
        let height = top + size(ABOVE_PART)[1] + TICK_SPACE[1] + MARGIN;
        let mut svg = Svg::page([width, height], "mm", &view.title);
        let arm = Geometry::magician(view.tool);
        let pose = arm.forward(&view.joints);
        draw_header(&mut svg, left, view, &pose);
        above::draw(&mut svg, [left, top], &arm, &view.joints, surroundings);
        side::draw(
            &mut svg,
            [side_view_left, top],
            &arm,
            &view.joints,
            surroundings,
        );
        Self { svg: svg.finish() }
    }
}

/// Draws title, pose and further facts.
fn draw_header(svg: &mut Svg, left: f64, view: &ArmView, pose: &Pose) {
    let title = TextStyle {
        size: 5.2,
        colour: INK,
        anchor: Anchor::Start,
        rim: false,
    };
    svg.text([left, MARGIN + 4.0], &view.title, &title);
    let text = TextStyle {
        size: 3.2,
        colour: FAINT,
        ..title
    };
    let tenth = |value: f64| signed((value * 10.0).round() / 10.0);
    let labelled = |names: [&str; 4], values: [f64; 4]| {
        let pairs = names.iter().zip(values);
        let pairs: Vec<_> = pairs
            .map(|(name, value)| format!("{name} {}", tenth(value)))
            .collect();
        pairs.join("  ")
    };
    let place = labelled(["x", "y", "z", "r"], pose.to_array());
    let joints = labelled(["J1", "J2", "J3", "J4"], view.joints.to_array());
    let pose_and_joints = format!("{place}   ·   {joints}");
    svg.text([left, MARGIN + 9.6], pose_and_joints, &text);
    let alarms = view
        .alarms
        .codes()
        .map(|code| match magician_host::Alarm::with_code(code) {
            Some(alarm) => format!("alarm {code:#04x} {}", alarm.name),
            None => format!("alarm {code:#04x}"),
        });
    let alarms: Vec<String> = alarms.collect();
    let alarm_style = if view.alarms.blocking() {
        TextStyle {
            colour: WRONG,
            ..text
        }
    } else {
        text
    };
    let facts: Vec<String> = view.facts.iter().cloned().chain(alarms).collect();
    svg.text([left, MARGIN + 14.4], facts.join("   ·   "), &alarm_style);
}

/// Two opposite corners of the base from the side.
fn base_side_corners() -> [[f64; 2]; 2] {
    let [half, down] = BASE_BODY;
    [[-half, -down], [half, -down / 3.0]]
}

/// Base axis, wrist and tip of the tool, from above.
fn links_from_above(arm: &Geometry, joints: &JointAngles) -> [[f64; 2]; 3] {
    let [wrist, tip] = wrist_and_tip(arm, joints);
    [[0.0, 0.0], [wrist.x, wrist.y], [tip.x, tip.y]]
}

/// Shoulder, elbow, wrist and tip of the tool, from the side: distance from the base axis, and z.
fn links_from_side(arm: &Geometry, joints: &JointAngles) -> [[f64; 2]; 4] {
    let straight = JointAngles { j1: 0.0, ..*joints };
    let (sin, cos) = libm::sincos(joints.j2.to_radians());
    let [wrist, tip] = wrist_and_tip(arm, &straight);
    let elbow = [arm.rear_arm * sin, arm.rear_arm * cos];
    [[0.0, 0.0], elbow, [wrist.x, wrist.z], [tip.x, tip.z]]
}

fn wrist_and_tip(arm: &Geometry, joints: &JointAngles) -> [Pose; 2] {
    let tool = ToolBias::NONE;
    [Geometry { tool, ..*arm }, *arm].map(|arm| arm.forward(joints))
}

fn turned([x, y]: [f64; 2], degrees: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    [x * cos - y * sin, x * sin + y * cos]
}

fn hex(Color([red, green, blue]): Color) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests;
