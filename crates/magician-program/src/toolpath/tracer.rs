//! Follows a plan step by step and collects the path of its tool.

use magician_host::preflight::Preflight;
use magician_host::{ArmState, JointAngles, Set};
use magician_motion::Pose;
use magician_protocol::{CpMode, PtpMode};

use super::outline::Outlines;
use super::{
    DrawnLine, Layer, MAX_MARKED_REFUSALS, Marker, MarkerKind, PlanPurpose, StrokeKind, Toolpath,
    Track,
};
use crate::yielding::{NeverYield, STEPS_PER_SLICE, Yield, run_to_end};
use crate::{Action, Color, Grip, Plan, Report, Travel};

/// Tolerance for merging corners, mm: half of the smallest visible deviation of a pen line.
const MERGE_TOLERANCE: f64 = 0.02;
/// Length below which a pen has drawn a dot, mm.
const MAX_DOT_LENGTH: f64 = 0.05;
/// Largest number of distinguished colours; lines in further colours are drawn in the default
/// colour.
const MAX_COLORS: usize = 48;
/// Largest number of markers.
const MAX_MARKERS: usize = 400;
/// Smallest and largest number of corners of a curve.
const CURVE_CORNERS: [f64; 2] = [24.0, 240.0];
/// Spacing of the corners of a curve, mm, relative to the distance between its ends.
const CORNER_SPACING: f64 = 1.0;
/// Length of the pieces in which motion out of reach is examined, mm.
const UNREACHABLE_PIECE: f64 = 1.0;
/// Largest number of such pieces.
const MAX_PIECES: f64 = 1000.0;
/// Distance beyond which a position is ignored, mm.
const MAX_COORDINATE: f64 = 10_000.0;

/// Rotation of the tool, as far as known.
#[derive(Clone, Copy)]
enum Turn {
    /// Rotation seen from above.
    R(f64),
    /// Angle of the servo.
    J4(f64),
}

/// Follows a plan and collects its [`Toolpath`].
pub(super) struct PathTracer {
    toolpath: Toolpath,
    course: Preflight,
    at: Option<[f64; 3]>,
    turn: Turn,
    holds: bool,
    lit: bool,
    /// Number of the current part.
    part: Option<u64>,
    /// Colour of the current part.
    part_color: Option<Color>,
    /// Colour of the current step.
    ink: Option<Color>,
    /// Refused steps, the next one last.
    refused_ahead: Vec<usize>,
    /// Point where the pen came down but has not drawn a line yet, and its colour.
    touched: Option<([f64; 3], Option<Color>)>,
    /// Length drawn since the pen came down, mm. Not zero at once, because the end of a descent
    /// draws a short line.
    inked: f64,
    /// True once the plan's first position is reached: motion before it leaves no mark.
    begun: bool,
    /// Current step.
    nth: usize,
    /// Drawn lines by step, if requested.
    strokes: Option<Vec<DrawnLine>>,
    /// Drawn lines, if requested.
    outlines: Option<Outlines>,
}

impl PathTracer {
    /// Creates a tracer in this state of the arm.
    pub(super) fn from(
        plan: &Plan,
        report: &Report,
        start: &Preflight,
        side: Option<bool>,
    ) -> Self {
        let purpose = PlanPurpose::of(plan);
        let first = report
            .refused_steps
            .iter()
            .map(|refused_step| refused_step.step);
        let mut refused_ahead: Vec<usize> = first.take(MAX_MARKED_REFUSALS).collect();
        refused_ahead.reverse();
        let mut tracer = Self {
            toolpath: Toolpath {
                layers: Vec::new(),
                markers: Vec::new(),
                ends: None,
                refused_steps: Vec::new(),
                drawn: 0.0,
                other: 0.0,
                bounds: None,
                has_side: side.unwrap_or(purpose.is_deep()),
                purpose,
            },
            course: start.clone(),
            at: None,
            turn: Turn::J4(0.0),
            holds: false,
            lit: false,
            part: None,
            part_color: None,
            ink: None,
            refused_ahead,
            touched: None,
            inked: 0.0,
            begun: false,
            nth: 0,
            strokes: None,
            outlines: None,
        };
        if let Some(arm) = start.arm() {
            tracer.stand(arm);
        }
        tracer
    }

    /// Drawn lines, each with its step.
    pub(super) fn strokes(mut self, plan: &Plan) -> Vec<DrawnLine> {
        self.strokes = Some(Vec::new());
        self.trace(plan);
        self.strokes.unwrap_or_default()
    }

    /// Drawn lines, and travel.
    pub(super) async fn outlines(mut self, plan: &Plan, yields: &impl Yield) -> Outlines {
        self.outlines = Some(Outlines::default());
        self.trace_yielding(plan, yields).await;
        let mut outlines = self.outlines.unwrap_or_default();
        outlines.settle();
        outlines
    }

    /// Follows all steps.
    pub(super) fn trace(&mut self, plan: &Plan) {
        run_to_end(self.trace_yielding(plan, &NeverYield));
    }

    async fn trace_yielding(&mut self, plan: &Plan, yields: &impl Yield) {
        if let Some(command) = plan.preamble() {
            self.set(&command);
        }
        for (slice, steps) in plan.steps.chunks(STEPS_PER_SLICE).enumerate() {
            for (nth, step) in (slice * STEPS_PER_SLICE..).zip(steps) {
                // White would be invisible, and black is the default colour.
                let color = step.color.or(self.part_color);
                self.ink = color.filter(|color| !color.is_pale() && *color != Color::default());
                self.step(nth, &step.action, plan.name_of(&step.origin));
            }
            yields.yield_now().await;
        }
        self.dot();
    }

    fn stand(&mut self, arm: &ArmState) {
        self.turn = Turn::J4(arm.joints.j4);
        self.arrive([arm.pose.x, arm.pose.y, arm.pose.z]);
    }

    fn arrive(&mut self, at: [f64; 3]) {
        self.at = Some(at);
        let [_, end] = self.toolpath.ends.get_or_insert([at, at]);
        *end = at;
    }

    /// Follows one step.
    fn step(&mut self, nth: usize, action: &Action, name: Option<&str>) {
        self.nth = nth;
        match *action {
            Action::Path { to } => self.path(to.map(f64::from), None),
            Action::Burn { to, power } => self.path(to.map(f64::from), Some(power.into())),
            Action::Move {
                to: [x, y, z, r],
                by: Travel::Line,
            } => {
                self.straight([x, y, z].map(f64::from), None);
                self.turn = Turn::R(r.into());
            }
            Action::Shift {
                by: [x, y, z, r],
                line: true,
            } => self.shift([x, y, z].map(f64::from), r.into()),
            Action::Move { .. }
            | Action::Joints { .. }
            | Action::Shift { .. }
            | Action::Arc { .. } => {
                if let Some(command) = action.command() {
                    self.curve(&command, action.target());
                }
            }
            Action::Suction(on) => self.hold(on, name),
            Action::Gripper(grip) => self.hold(grip == Grip::Close, name),
            Action::Laser(on) => self.lit = on,
            // A pen that waits on the paper leaves a dot instead of a marker.
            Action::Wait(_) if self.touched.is_some() => {}
            Action::Wait(_) => self.mark(MarkerKind::Wait, name),
            Action::Home => self.at = None,
            Action::Command(ref command) => self.command(command),
            Action::Part(ref part) => {
                self.part = Some(part.n);
                self.part_color = part.color;
            }
            Action::Pause(_) => {}
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
        while self.refused_ahead.pop_if(|step| *step == nth).is_some() {
            let there = action.target().map(|to| to.map(f64::from));
            self.toolpath.refused_steps.push((nth, there.or(self.at)));
        }
    }

    fn command(&mut self, command: &Set) {
        match command {
            Set::CpCmd(cp) if cp.cp_mode == CpMode::Relative => {
                self.relative([cp.x, cp.y, cp.z].map(f64::from), None, Self::path);
            }
            Set::CpLeCmd(cp) if cp.cp_mode == CpMode::Relative => {
                let power = cp.velocity_or_power.into();
                self.relative([cp.x, cp.y, cp.z].map(f64::from), Some(power), Self::path);
            }
            Set::PtpCmd(ptp) => {
                let places = matches!(ptp.ptp_mode, PtpMode::JumpMovlXyz);
                self.curve(command, places.then_some([ptp.x, ptp.y, ptp.z]));
            }
            Set::PtpPoCmd(ptp) => {
                let places = ptp.ptp_mode.is_absolute_pose();
                self.curve(command, places.then_some([ptp.x, ptp.y, ptp.z]));
            }
            Set::PtpWithLCmd(_) | Set::PtpPoWithLCmd(_) | Set::CircleCmd(_) => {
                self.curve(command, None);
            }
            Set::HomeCmd(_) | Set::JogCmd(_) | Set::ResetPose(_) => self.at = None,
            _ => self.set(command),
        }
    }

    /// Applies a setting that later motion depends on.
    fn set(&mut self, command: &Set) {
        let moves_the_tip = matches!(command, Set::EndEffectorParams(_));
        let before = self.state().filter(|_| moves_the_tip);
        // Mistakes are in the report already.
        let _ = self.course.check(command);
        if let Some(before) = before {
            self.stand(&ArmState::at_joints(
                &self.course.geometry(),
                &before.joints,
            ));
        }
    }

    fn shift(&mut self, by: [f64; 3], turn: f64) {
        self.relative(by, None, Self::straight);
        match &mut self.turn {
            Turn::R(r) | Turn::J4(r) => *r += turn,
        }
    }

    fn relative(
        &mut self,
        by: [f64; 3],
        power: Option<f64>,
        go: fn(&mut Self, [f64; 3], Option<f64>),
    ) {
        if let Some(at) = self.at {
            go(self, [0, 1, 2].map(|axis| at[axis] + by[axis]), power);
        }
    }

    /// Goes straight to a position.
    fn straight(&mut self, to: [f64; 3], power: Option<f64>) {
        if !is_plausible(to) {
            return;
        }
        if let Some(from) = self.at {
            let power = power.or(self.lit.then_some(100.0));
            self.go(from, to, power);
        }
        self.begun = true;
        self.arrive(to);
    }

    /// Goes straight to a position with the servo at rest.
    fn path(&mut self, to: [f64; 3], power: Option<f64>) {
        if let Turn::R(_) = self.turn {
            self.turn = Turn::J4(self.state().map_or(0.0, |arm| arm.joints.j4));
        }
        self.straight(to, power);
    }

    /// Follows the true motion of a command, as far as it is known.
    fn curve(&mut self, command: &Set, target: Option<[f32; 3]>) {
        let from = self.state();
        let way = from.and_then(|from| self.course.motion_of(&from, command));
        let Some(way) = way else {
            if let Some(to) = target {
                self.straight(to.map(f64::from), None);
            }
            return;
        };
        let (start, end) = (way.start().pose, way.end().pose);
        let apart = libm::hypot(end.x - start.x, end.y - start.y) + (end.z - start.z).abs();
        let round = matches!(command, Set::CircleCmd(_));
        let [least, most] = CURVE_CORNERS;
        let corners = if round {
            most
        } else {
            (apart / CORNER_SPACING).clamp(least, most)
        };
        let power = self.lit.then_some(100.0);
        let mut last = [start.x, start.y, start.z];
        for nth in 1..=corners as u64 {
            let Pose { x, y, z, .. } = way.curve(way.duration_us() * nth / corners as u64).pose;
            self.go(last, [x, y, z], power);
            last = [x, y, z];
        }
        self.begun = true;
        self.stand(way.end());
    }

    /// State of the arm, even beyond its limits: the report covers those.
    fn state(&self) -> Option<ArmState> {
        let [x, y, z] = self.at?;
        let geometry = self.course.geometry();
        let pose = |r| Pose::new(x, y, z, r);
        let joints = match self.turn {
            Turn::R(r) => geometry.inverse(&pose(r)).ok()?,
            Turn::J4(j4) => JointAngles {
                j4,
                ..geometry.inverse(&pose(0.0)).ok()?
            },
        };
        let pose = pose(joints.j1 + joints.j4);
        Some(ArmState { joints, pose })
    }

    fn go(&mut self, from: [f64; 3], to: [f64; 3], power: Option<f64>) {
        let mark = match self.toolpath.purpose.mark([from, to], power, self.holds) {
            StrokeKind::Ink(_) if !self.begun => StrokeKind::Nothing,
            mark => mark,
        };
        self.touch(mark, from, to);
        let (geometry, limits) = (self.course.geometry(), self.course.arm_model().limits);
        if [from, to].iter().all(|end| geometry.reaches(*end, &limits)) {
            return self.draw(mark, mark, from, to);
        }
        let apart = (0..3)
            .map(|axis| (to[axis] - from[axis]).powi(2))
            .sum::<f64>()
            .sqrt();
        let pieces = (apart / UNREACHABLE_PIECE).ceil().clamp(1.0, MAX_PIECES);
        let at =
            |nth: f64| [0, 1, 2].map(|axis| from[axis] + (to[axis] - from[axis]) * nth / pieces);
        let within = |nth: u32| geometry.reaches(at(f64::from(nth) + 0.5), &limits);
        let mut begun = 0;
        for nth in 1..=pieces as u32 {
            if nth == pieces as u32 || within(nth) != within(begun) {
                let shown = if within(begun) {
                    mark
                } else {
                    StrokeKind::Unreachable
                };
                self.draw(shown, mark, at(f64::from(begun)), at(f64::from(nth)));
                begun = nth;
            }
        }
    }

    /// Leaves a dot where a pen comes down and up again without a line.
    fn touch(&mut self, mark: StrokeKind, from: [f64; 3], to: [f64; 3]) {
        let is_down = |at: [f64; 3]| {
            let mark = self.toolpath.purpose.mark([at; 2], None, false);
            matches!(mark, StrokeKind::Ink(_))
        };
        // A pen that starts on the sheet, after a touch-off for example, has drawn nothing.
        if !self.begun && is_down(from) {
            return;
        }
        if let StrokeKind::Ink(_) = mark {
            self.inked += libm::hypot(to[0] - from[0], to[1] - from[1]);
            self.touched = (self.inked < MAX_DOT_LENGTH).then_some((to, self.ink));
        } else if is_down(to) {
            self.touched = (self.inked < MAX_DOT_LENGTH).then_some((to, self.ink));
        } else {
            self.dot();
            self.inked = 0.0;
        }
    }

    fn dot(&mut self) {
        if let Some((at, color)) = self.touched.take()
            && self.inked == 0.0
        {
            let ink = StrokeKind::Ink(None);
            let limits = &self.course.arm_model().limits;
            let shown = if self.course.geometry().reaches(at, limits) {
                ink
            } else {
                StrokeKind::Unreachable
            };
            // The pen may already be moving to a line of another colour.
            let next = std::mem::replace(&mut self.ink, color);
            self.draw(shown, ink, at, at);
            self.ink = next;
        }
    }

    /// Adds a part of the motion to the picture and to the lengths.
    fn draw(&mut self, shown: StrokeKind, mark: StrokeKind, from: [f64; 3], to: [f64; 3]) {
        let shown = match shown {
            StrokeKind::Ink(_) => StrokeKind::Ink(self.ink),
            other => other,
        };
        let toolpath = &mut self.toolpath;
        let layer_of = |layers: &[Layer], mark| {
            let mut layers = layers.iter();
            layers.position(|layer| layer.mark == mark)
        };
        let mut known = layer_of(&toolpath.layers, shown);
        let mut shown = shown;
        if let (StrokeKind::Ink(Some(_)), None) = (shown, known)
            && toolpath.layers.len() >= MAX_COLORS
        {
            shown = StrokeKind::Ink(None);
            known = layer_of(&toolpath.layers, shown);
        }
        let nth = known.unwrap_or_else(|| {
            let (above, side) = (Track::new(MERGE_TOLERANCE), Track::new(MERGE_TOLERANCE));
            toolpath.layers.push(Layer {
                mark: shown,
                above,
                side,
            });
            toolpath.layers.len() - 1
        });
        let Some(layer) = toolpath.layers.get_mut(nth) else {
            return;
        };
        let flat = |[x, y, _]: [f64; 3]| [x, y];
        let side_view = |[x, y, z]: [f64; 3]| [libm::hypot(x, y), z];
        layer.above.begin(flat(from));
        layer.above.line_to(flat(to));
        if toolpath.has_side {
            layer.side.begin(side_view(from));
            layer.side.line_to(side_view(to));
        }
        let squares: f64 = (0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum();
        match mark {
            StrokeKind::Ink(_) | StrokeKind::Burn(_) => {
                if let Some(strokes) = &mut self.strokes {
                    DrawnLine::add(strokes, self.nth, flat(from), flat(to));
                }
                if let Some(outlines) = &mut self.outlines {
                    let reachable = shown != StrokeKind::Unreachable;
                    outlines.draw((reachable, mark.power(), self.part), from, to);
                }
                toolpath.drawn += squares.sqrt();
                for [x, y] in [flat(from), flat(to)] {
                    let [low, high] = toolpath.bounds.get_or_insert([[x, y]; 2]);
                    *low = [low[0].min(x), low[1].min(y)];
                    *high = [high[0].max(x), high[1].max(y)];
                }
            }
            StrokeKind::Nothing | StrokeKind::Carried | StrokeKind::Unreachable => {
                toolpath.other += squares.sqrt();
                if let Some(outlines) = &mut self.outlines {
                    outlines.travel(from, to);
                }
            }
        }
    }

    fn hold(&mut self, holds: bool, name: Option<&str>) {
        let kind = match (self.holds, holds) {
            (false, true) => MarkerKind::Pick,
            (true, false) => MarkerKind::Place,
            // The command does not change the tool's state.
            _ => return,
        };
        self.holds = holds;
        self.mark(kind, name);
    }

    fn mark(&mut self, kind: MarkerKind, name: Option<&str>) {
        if let Some(at) = self
            .at
            .filter(|_| self.toolpath.markers.len() < MAX_MARKERS)
        {
            Marker::add(&mut self.toolpath.markers, at, kind, name);
        }
    }

    /// Returns the toolpath; `steps` is the number of steps.
    pub(super) fn finish(mut self, steps: usize) -> Toolpath {
        let at = self.at;
        let rest = self.refused_ahead.drain(..).rev();
        self.toolpath
            .refused_steps
            .extend(rest.map(|step| (step.min(steps), at)));
        for layer in &mut self.toolpath.layers {
            layer.above.settle();
            layer.side.settle();
        }
        self.toolpath.thin(MERGE_TOLERANCE);
        self.toolpath
    }
}

fn is_plausible(place: [f64; 3]) -> bool {
    // False for NaN.
    place.iter().all(|value| value.abs() < MAX_COORDINATE)
}
