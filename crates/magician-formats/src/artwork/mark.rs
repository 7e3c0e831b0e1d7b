//! How a drawing becomes what the arm does: with a pen that is put down and lifted, or a laser that is lit and darkened.

use magician_host::build;
use magician_motion::Fence;

use super::{DrawingPart, PartPen, PlacedArtwork, Stroke, distance};
use crate::reach::{APPROACH, Above, Travelling};
use crate::{Action, Origin, Part, Pause, PauseCause, Plan, Reach, Step, Surface, Tool, Travel};

/// How long a pen rests where it leaves a dot, ms.
const DOT_REST: u32 = 100;
/// Half the line that a laser burns for a dot, mm: it must move to burn.
const DOT_REACH: f64 = 0.05;
/// A pen that travels is lifted by this share of its way.
const LIFTED: f64 = 0.5;

/// With what lines are drawn, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marking {
    /// The tool.
    pub tool: Tool,
    /// Power of the laser along the lines, percent; none for a pen, which is put down and lifted instead.
    pub power: Option<f32>,
    /// How far above the surface a pen travels between lines, and where both begin and end, mm.
    pub lift: f64,
    /// How far above the surface a pen travels at least, mm. On short ways it is lifted by half of them, if that is between this
    /// and `lift`, and takes all joints together where that is quicker and as good as the straight line; a laser travels so too.
    /// Without it all ways are straight, and a pen is always lifted by `lift`.
    pub hop: Option<f64>,
    /// Speed along the lines, mm/s.
    pub speed: f32,
    /// Acceleration along the lines, mm/s2.
    pub acceleration: f32,
    /// Speed between the lines, mm/s; the arm takes its speed ratio of it, half at power-up.
    pub travel: f32,
    /// The rotation that moves end with, degrees. Without it J4 stays at zero and the tool turns with the arm, which costs no
    /// time.
    pub r: Option<f32>,
    /// What ways of all joints keep to, as straight ones are checked to do.
    pub fence: Option<Fence>,
}

impl Marking {
    /// A pen, 10 mm above the paper between lines, 3 mm where they are near each other, at 50 mm/s on it.
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

    /// The laser at so many percent, at 20 mm/s.
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
    /// Where this marking can be done on a surface.
    #[must_use]
    pub fn reach(&self, surface: Surface) -> Reach {
        let reach = Reach::new(self.tool.bias(), surface, self.lift);
        self.r.map_or(reach, |r| reach.rotated_to(r.into()))
    }
}

impl PlacedArtwork {
    /// What the arm does to draw it: one path for each line, in their order.
    ///
    /// It begins from anywhere. All joints together lead to a point well above the first line, for which the arm must not be
    /// known to stand anywhere, and which rises from the paper if the pen is a little above it; a straight way could lead through
    /// the base, and a jump rises out of reach from where the arm is high already. From there on everything is straight or close
    /// to it, but where the base is in the way. It ends above the last line.
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
            usual: *marking,
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
        writer.leave();
        let (mut plan, travel) = (writer.plan, [marking.travel; 4]);
        if writer.by_joints {
            let told = build::joint_speed(travel, travel);
            plan.steps.insert(0, Step::new(told, Origin::NONE));
        }
        plan
    }

    /// The highest of the surfaces that its pens draw on.
    fn highest(&self) -> Surface {
        let drawn = self.artwork.by_part().filter_map(|(part, _)| {
            let part = self.artwork.parts.get(part.checked_sub(1)?)?;
            Some(part.pen.surface_offset)
        });
        self.surface.raised(drawn.reduce(f64::max).unwrap_or(0.0))
    }
}

/// What puts down the steps of one drawing.
struct StepWriter<'a> {
    plan: Plan,
    /// How lines are drawn, and those of the part under way.
    usual: Marking,
    marking: Marking,
    placed: &'a PlacedArtwork,
    /// Where the pen of the part under way draws.
    surface: Surface,
    reach: Reach,
    /// Where the tool is by then, and the last line.
    at: Option<(Above, Origin)>,
    /// Whether it has gone from one line to another with all joints.
    by_joints: bool,
}

impl StepWriter<'_> {
    /// A part, as often as it is to be drawn. Between parts a pen is changed.
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
        self.take(&drawn.pen, origin);
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

    /// Another pen draws from here on.
    fn take(&mut self, pen: &PartPen, origin: Origin) {
        let speed = self.marking.speed;
        let usual = self.usual;
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
            (Some(power), true) => self.burn(&self.speck(*first), power, stroke.origin),
        }
        let colors = &self.placed.artwork.colors;
        let color = (stroke.style.color as usize).checked_sub(1);
        let color = color.and_then(|at| colors.get(at)).copied();
        // The pen goes up from the line before, in its colour.
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

    /// The line that a laser burns for a dot: about it, or on from it where that is not reached.
    fn speck(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        let by = |from: f64, to: f64| [[x + from, y], [x + to, y]];
        let about = by(-DOT_REACH, DOT_REACH);
        let ways = [about, by(0.0, -2.0 * DOT_REACH), by(0.0, 2.0 * DOT_REACH)];
        let mut reached = ways
            .into_iter()
            .filter(|ends| ends.iter().all(|end| self.reach.has(*end)));
        reached.next().unwrap_or(about)
    }

    /// Pen down, along, up.
    fn write(&mut self, stroke: &Stroke, dot: bool) {
        let Some((first, others)) = stroke.points.split_first() else {
            return;
        };
        let origin = stroke.origin;
        self.hop(*first, origin);
        if dot {
            self.plan.push(Action::Wait(DOT_REST), origin);
        } else {
            self.along(*first, others, origin, |to| Action::Path { to });
        }
        let last = others.last().unwrap_or(first);
        self.at = Some(((*last, 0.0), origin));
    }

    /// The pen from where the last line ends to where the next begins: up, across, down. Where one goes on from the other it stays
    /// down.
    fn hop(&mut self, to: [f64; 2], origin: Origin) {
        let lift = self.marking.lift;
        match self.at {
            Some((from, _))
                if self.marking.hop.is_some() && self.point(from) == self.point((to, 0.0)) => {}
            Some(((from, above), last)) if above <= 0.0 => {
                let low = self.height_over(distance(from, to));
                let height = if self.reach.leads(from, to, low) {
                    low
                } else {
                    lift
                };
                self.leg((from, height), last);
                self.travel((to, height), origin);
                self.leg((to, 0.0), origin);
            }
            _ => {
                self.travel((to, lift), origin);
                self.line((to, 0.0), origin);
            }
        }
    }

    /// How high a pen goes over a way of this length.
    fn height_over(&self, way: f64) -> f64 {
        let lift = self.marking.lift;
        match self.marking.hop {
            Some(least) => lift.min(least.max(LIFTED * way)),
            None => lift,
        }
    }

    /// To its beginning, along with the laser lit, dark.
    fn burn(&mut self, points: &[[f64; 2]], power: f32, origin: Origin) {
        let Some((first, others)) = points.split_first() else {
            return;
        };
        self.travel((*first, 0.0), origin);
        self.along(*first, others, origin, |to| Action::Burn { to, power });
        self.plan.push(Action::Laser(false), origin);
        let last = others.last().unwrap_or(first);
        self.at = Some(((*last, 0.0), origin));
    }

    /// One segment for each corner that is another point for the arm.
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

    /// To where a line begins.
    fn travel(&mut self, to: Above, origin: Origin) {
        match self.at {
            Some((from, _)) if from.0 == to.0 => {
                if from.1 != to.1 {
                    self.leg(to, origin);
                }
            }
            Some((from, _)) if self.reach.leads(from.0, to.0, to.1) => self.leg(to, origin),
            Some((from, _)) => self.go_round(from, to, origin),
            None => self.approach(to, origin),
        }
    }

    /// Around the base: with all joints from well above to well above, or step by step where that leads through a slope.
    fn go_round(&mut self, from: Above, to: Above, origin: Origin) {
        let [high, over] = [from, to].map(|end| self.raised(end));
        let lift = self.marking.lift;
        let corners = if self.reach.clears(high, over, lift / 2.0) {
            None
        } else {
            self.reach.round_base(from.0, to.0, lift)
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

    /// Over it with all joints, then down.
    fn approach(&mut self, to: Above, origin: Origin) {
        let over = self.raised(to);
        self.go(over, Travel::Joints, origin);
        if over != to {
            self.line(to, origin);
        }
    }

    /// Well above it, as far as that is reached.
    fn raised(&self, end: Above) -> Above {
        self.reach.over(end, self.marking.lift + APPROACH)
    }

    /// Up, if a pen is not up.
    fn lift_pen(&mut self) {
        if self.marking.power.is_none() {
            self.leave();
        }
    }

    /// Up from the last line, if the tool is not up.
    fn leave(&mut self) {
        if let Some(((at, above), origin)) = self.at
            && above < self.marking.lift
        {
            self.line((at, self.marking.lift), origin);
        }
    }

    /// From one line to the next, or a part of that: straight, or close to it with all joints where that is quicker.
    fn leg(&mut self, to: Above, origin: Origin) {
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
        self.go(to, by, origin);
    }

    fn line(&mut self, to: Above, origin: Origin) {
        self.go(to, Travel::Line, origin);
    }

    fn go(&mut self, to: Above, by: Travel, origin: Origin) {
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
