//! Conversion of placed artwork into a plan: with a pen that is lowered and lifted, or a laser that
//! is switched on and off.
//!
//! [`StepWriter`] follows the tool from stroke to stroke. Travel between strokes is straight,
//! except:
//!
//! * on short ways a pen is lifted only by half the distance ([`Marking::hop`]);
//! * a joint move replaces a straight one where it is quicker and stays close to it;
//! * where the straight way would lead through the base, the tool goes round it.
//!
//! The first stroke is approached with a joint move from above, because nothing is known about
//! where the arm stands when the plan begins.

use magician_host::build;
use magician_motion::Fence;

use super::{DrawingPart, PartPen, PlacedArtwork, Stroke, distance};
use crate::reach::{APPROACH_HEIGHT, Above, Travelling};
use crate::{Action, Origin, Part, Pause, PauseCause, Plan, Reach, Step, Surface, Tool, Travel};

/// Time that a pen rests to leave a dot, ms.
const DOT_REST_MS: u32 = 100;
/// Half the length of the line that a laser burns for a dot, mm. The laser burns only along a
/// segment.
const DOT_HALF_LENGTH: f64 = 0.05;
/// Height of a pen during travel, as a share of the distance.
const HOP_HEIGHT_SHARE: f64 = 0.5;

/// Tool and parameters with which strokes are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marking {
    /// The tool.
    pub tool: Tool,
    /// Laser power along strokes, percent; `None` for a pen, which is lowered and lifted instead.
    pub power: Option<f32>,
    /// Height of a travelling pen above the surface, and of the tool at the start and end of each
    /// plan, mm.
    pub lift: f64,
    /// Smallest height of a travelling pen above the surface, mm.
    ///
    /// If set, a pen is lifted on short ways by half the distance, within `hop` to `lift`, and
    /// travel of a pen or laser uses joint moves where these are quicker and as safe as straight
    /// ones. If `None`, all travel is straight, and a pen is always lifted by `lift`.
    pub hop: Option<f64>,
    /// Speed along strokes, mm/s.
    pub speed: f32,
    /// Acceleration along strokes, mm/s2.
    pub acceleration: f32,
    /// Speed of travel, mm/s. The arm applies its speed ratio to it, which is 50 % after power-up.
    pub travel: f32,
    /// Rotation r of the moves, degrees. If `None`, J4 stays at zero and the tool turns with the
    /// arm, which costs no time.
    pub r: Option<f32>,
    /// Fence that joint moves must respect. Straight moves are checked against it later.
    pub fence: Option<Fence>,
}

impl Marking {
    /// Returns the defaults of a pen: 50 mm/s on the paper, lifted by 3 to 10 mm between strokes.
    #[must_use]
    pub const fn pen() -> Self {
        Self {
            tool: Tool::Pen,
            power: None,
            lift: 10.0,
            hop: Some(3.0),
            speed: 50.0,
            acceleration: 100.0,
            travel: 200.0,
            r: None,
            fence: None,
        }
    }

    /// Returns the defaults of a laser with this power, percent: 20 mm/s.
    #[must_use]
    pub const fn laser(power: f32) -> Self {
        Self {
            tool: Tool::Laser,
            power: Some(power),
            speed: 20.0,
            ..Self::pen()
        }
    }
}

impl Marking {
    /// Returns where this marking can be done on a surface.
    #[must_use]
    pub fn reach(&self, surface: Surface) -> Reach {
        let reach = Reach::new(self.tool.bias(), surface, self.lift);
        self.r.map_or(reach, |r| reach.rotated_to(r.into()))
    }
}

impl PlacedArtwork {
    /// Returns the plan that draws the artwork: one path per stroke, in the order of the strokes.
    ///
    /// The plan may start from any position of the arm. It begins with a joint move to a point well
    /// above the first stroke: a straight move could lead through the base, and a jump from a high
    /// position would leave the reach. From a pen just above the paper this move rises. After that
    /// all travel is straight or close to it, except around the base. The plan ends above the last
    /// stroke.
    #[must_use]
    pub fn plan(&self, marking: &Marking) -> Plan {
        let mut plan = Plan::new(self.artwork.title.clone());
        plan.tool = Some(marking.tool);
        plan.surface = Some(self.highest());
        plan.names.clone_from(&self.artwork.names);
        plan.push(
            build::line_speed(marking.travel, marking.travel),
            Origin::NONE,
        );
        plan.push(
            build::path_speed(marking.speed, marking.acceleration),
            Origin::NONE,
        );
        let mut writer = StepWriter {
            plan,
            default_marking: *marking,
            marking: *marking,
            placed: self,
            surface: self.surface,
            reach: marking.reach(self.surface),
            at: None,
            by_joints: false,
        };
        let mut begun = false;
        for (part, strokes) in self.artwork.by_part() {
            let part = part
                .checked_sub(1)
                .and_then(|at| self.artwork.parts.get(at));
            match part {
                Some(part) if part.unasked => continue,
                Some(part) => writer.part(part, strokes, begun),
                None => strokes.iter().for_each(|stroke| writer.draw(stroke)),
            }
            begun = true;
        }
        writer.rise_from_last_stroke();
        let (mut plan, travel) = (writer.plan, [marking.travel; 4]);
        if writer.by_joints {
            let told = build::joint_speed(travel, travel);
            plan.steps.insert(0, Step::new(told, Origin::NONE));
        }
        plan
    }

    /// Returns the highest of the surfaces that the pens draw on.
    fn highest(&self) -> Surface {
        let drawn = self.artwork.by_part().filter_map(|(part, _)| {
            let part = self.artwork.parts.get(part.checked_sub(1)?)?;
            Some(part.pen.surface_offset)
        });
        self.surface.raised(drawn.reduce(f64::max).unwrap_or(0.0))
    }
}

/// State while writing the steps of a drawing.
struct StepWriter<'a> {
    plan: Plan,
    /// Defaults for the drawing; `marking` has those of the current part.
    default_marking: Marking,
    marking: Marking,
    placed: &'a PlacedArtwork,
    /// Surface of the current part.
    surface: Surface,
    reach: Reach,
    /// Position of the tool, and the origin of the last stroke; `None` before the first move.
    at: Option<(Above, Origin)>,
    /// True once a joint move was used between strokes, so that the plan must set joint speeds.
    by_joints: bool,
}

impl StepWriter<'_> {
    /// Writes a part, as many passes as it has. Pauses before it so that the pen can be changed.
    fn part(&mut self, drawn: &DrawingPart, strokes: &[Stroke], begun: bool) {
        let origin = strokes.first().map_or(Origin::NONE, |stroke| stroke.origin);
        self.lift_pen();
        if drawn.waits || begun && self.marking.power.is_none() {
            let text = match self.marking.power {
                None => format!("mount the pen for part {}", drawn.part),
                Some(_) => format!("part {} is next", drawn.part),
            };
            let cause = PauseCause::Part;
            self.plan
                .push(Action::Pause(Box::new(Pause { text, cause })), origin);
        }
        self.select_pen(&drawn.pen, origin);
        for pass in 1..=drawn.passes {
            let part = Part {
                pass: (drawn.passes > 1).then_some(u64::from(pass)),
                ..drawn.part.clone()
            };
            self.lift_pen();
            self.plan.push(Action::Part(Box::new(part)), origin);
            strokes.iter().for_each(|stroke| self.draw(stroke));
        }
    }

    /// Switches to the pen of another part.
    fn select_pen(&mut self, pen: &PartPen, origin: Origin) {
        let speed = self.marking.speed;
        let usual = self.default_marking;
        self.marking = Marking {
            lift: pen.lift.unwrap_or(usual.lift),
            speed: pen.speed.map_or(usual.speed, |speed| speed as f32),
            power: usual
                .power
                .map(|power| pen.power.map_or(power, |power| power as f32)),
            ..usual
        };
        let before = self.surface;
        self.surface = self.placed.surface.raised(pen.surface_offset);
        self.reach = self.marking.reach(self.surface);
        // The tool stays where it is, so its height above the new surface differs.
        if let Some(((_, above), _)) = &mut self.at {
            *above += before.height - self.surface.height;
        }
        if self.marking.speed != speed {
            let told = build::path_speed(self.marking.speed, self.marking.acceleration);
            self.plan.push(told, origin);
        }
    }

    fn draw(&mut self, stroke: &Stroke) {
        let Some(first) = stroke.points.first() else {
            return;
        };
        let dot = stroke.points.iter().all(|point| point == first);
        let begins = self.plan.steps.len();
        match (self.marking.power, dot) {
            (None, _) => self.write(stroke, dot),
            (Some(power), false) => self.burn(&stroke.points, power, stroke.origin),
            (Some(power), true) => self.burn(&self.dot_line(*first), power, stroke.origin),
        }
        let colors = &self.placed.artwork.colors;
        let color = (stroke.style.color as usize).checked_sub(1);
        let color = color.and_then(|at| colors.get(at)).copied();
        // Steps that lift the pen off the previous stroke keep that stroke's colour.
        let (before, steps) = self.plan.steps.split_at_mut(begins);
        let color_before = before.last().and_then(|step| step.color);
        for step in steps {
            step.color = if step.origin == stroke.origin {
                color
            } else {
                color_before
            };
        }
    }

    /// Returns the line that a laser burns for a dot: centred on it, or to one side where the
    /// centred line is out of reach.
    fn dot_line(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        let by = |from: f64, to: f64| [[x + from, y], [x + to, y]];
        let about = by(-DOT_HALF_LENGTH, DOT_HALF_LENGTH);
        let ways = [
            about,
            by(0.0, -2.0 * DOT_HALF_LENGTH),
            by(0.0, 2.0 * DOT_HALF_LENGTH),
        ];
        let mut reached = ways
            .into_iter()
            .filter(|ends| ends.iter().all(|end| self.reach.has(*end)));
        reached.next().unwrap_or(about)
    }

    /// Writes a stroke with a pen: lower, draw, stay down.
    fn write(&mut self, stroke: &Stroke, dot: bool) {
        let Some((first, others)) = stroke.points.split_first() else {
            return;
        };
        let origin = stroke.origin;
        self.hop(*first, origin);
        if dot {
            self.plan.push(Action::Wait(DOT_REST_MS), origin);
        } else {
            self.along(*first, others, origin, |to| Action::Path { to });
        }
        let last = others.last().unwrap_or(first);
        self.at = Some(((*last, 0.0), origin));
    }

    /// Moves the pen from the end of the last stroke to the start of the next: up, across, down. If
    /// the strokes meet, the pen stays down.
    fn hop(&mut self, to: [f64; 2], origin: Origin) {
        let lift = self.marking.lift;
        match self.at {
            // Compared in 32 bits, in which the arm gets them: an equal point is no move.
            Some((from, _))
                if self.marking.hop.is_some() && self.point(from) == self.point((to, 0.0)) => {}
            Some(((from, above), last)) if above <= 0.0 => {
                let low = self.height_over(distance(from, to));
                let height = if self.reach.is_lifted_line_possible(from, to, low) {
                    low
                } else {
                    lift
                };
                self.travel_straight_or_by_joints((from, height), last);
                self.travel((to, height), origin);
                self.travel_straight_or_by_joints((to, 0.0), origin);
            }
            // The pen is up already, or its position is unknown.
            _ => {
                self.travel((to, lift), origin);
                self.line((to, 0.0), origin);
            }
        }
    }

    /// Returns the lift for travel over this distance.
    fn height_over(&self, way: f64) -> f64 {
        let lift = self.marking.lift;
        match self.marking.hop {
            Some(least) => lift.min(least.max(HOP_HEIGHT_SHARE * way)),
            None => lift,
        }
    }

    /// Burns a stroke: dark to its start, lit along it, then off.
    fn burn(&mut self, points: &[[f64; 2]], power: f32, origin: Origin) {
        let Some((first, others)) = points.split_first() else {
            return;
        };
        // No lift: a laser marks only along segments with power.
        self.travel((*first, 0.0), origin);
        self.along(*first, others, origin, |to| Action::Burn { to, power });
        // The firmware probably switches the laser off at the end of a path. This is unconfirmed,
        // so a command is sent.
        self.plan.push(Action::Laser(false), origin);
        let last = others.last().unwrap_or(first);
        self.at = Some(((*last, 0.0), origin));
    }

    /// Adds one segment per vertex. Vertices that coincide in 32 bits are skipped.
    fn along(
        &mut self,
        first: [f64; 2],
        others: &[[f64; 2]],
        origin: Origin,
        segment: impl Fn([f32; 3]) -> Action,
    ) {
        let mut last = self.point((first, 0.0));
        for corner in others {
            let to = self.point((*corner, 0.0));
            if to != last {
                self.plan.push(segment(to), origin);
                last = to;
            }
        }
    }

    /// Moves to the start of a stroke.
    fn travel(&mut self, to: Above, origin: Origin) {
        match self.at {
            Some((from, _)) if from.0 == to.0 => {
                if from.1 != to.1 {
                    self.travel_straight_or_by_joints(to, origin);
                }
            }
            Some((from, _)) if self.reach.is_lifted_line_possible(from.0, to.0, to.1) => {
                self.travel_straight_or_by_joints(to, origin)
            }
            Some((from, _)) => self.travel_around_base(from, to, origin),
            None => self.approach(to, origin),
        }
    }

    /// Moves around the base: a joint move high above both ends, or a chain of straight moves where
    /// the slope of the surface blocks the joint move.
    fn travel_around_base(&mut self, from: Above, to: Above, origin: Origin) {
        let [high, over] = [from, to].map(|end| self.high_above(end));
        let lift = self.marking.lift;
        let corners = if self.reach.clears(high, over, lift / 2.0) {
            None
        } else {
            self.reach.corners_around_base(from.0, to.0, lift)
        };
        let Some(corners) = corners else {
            self.line(high, origin);
            self.approach(to, origin);
            return;
        };
        self.line((from.0, lift), origin);
        for corner in corners.into_iter().chain([to.0]) {
            self.line((corner, lift), origin);
        }
        if to.1 != lift {
            self.line(to, origin);
        }
    }

    /// Moves above the target with all joints, then down to it.
    fn approach(&mut self, to: Above, origin: Origin) {
        let over = self.high_above(to);
        self.push_move(over, Travel::Joints, origin);
        if over != to {
            self.line(to, origin);
        }
    }

    /// Raises a position well above the surface, as far as it stays within reach.
    fn high_above(&self, end: Above) -> Above {
        self.reach.over(end, self.marking.lift + APPROACH_HEIGHT)
    }

    /// Lifts the pen unless it is already up. Has no effect on a laser.
    fn lift_pen(&mut self) {
        if self.marking.power.is_none() {
            self.rise_from_last_stroke();
        }
    }

    /// Moves up from the last stroke unless the tool is already up.
    fn rise_from_last_stroke(&mut self) {
        if let Some(((at, above), origin)) = self.at
            && above < self.marking.lift
        {
            self.line((at, self.marking.lift), origin);
        }
    }

    /// Moves between strokes: straight, or with all joints where that is quicker and close to
    /// straight.
    fn travel_straight_or_by_joints(&mut self, to: Above, origin: Origin) {
        let travelling = Travelling {
            speed: self.marking.travel.into(),
            turns: self.marking.r.is_none(),
            fence: self.marking.fence,
        };
        let quicker = self.marking.hop.is_some()
            && self
                .at
                .is_some_and(|(from, _)| self.reach.is_quicker_by_joints(from, to, &travelling));
        self.by_joints |= quicker;
        let by = if quicker {
            Travel::Joints
        } else {
            Travel::Line
        };
        self.push_move(to, by, origin);
    }

    fn line(&mut self, to: Above, origin: Origin) {
        self.push_move(to, Travel::Line, origin);
    }

    fn push_move(&mut self, to: Above, by: Travel, origin: Origin) {
        let [x, y, z] = self.point(to);
        let turned = || {
            self.reach
                .joints(to.0, to.1)
                .map_or(0.0, |joints| joints.j1)
        };
        let r = self.marking.r.unwrap_or_else(|| turned() as f32);
        let to_pose = [x, y, z, r];
        self.plan.push(Action::Move { to: to_pose, by }, origin);
        self.at = Some((to, origin));
    }

    fn point(&self, (at, above): Above) -> [f32; 3] {
        let z = self.surface.at(at) + above;
        [at[0], at[1], z].map(|value| value as f32)
    }
}
