//! What would become of a plan, before anything moves.

mod beyond;
mod foreign;
mod pen;
mod way;
mod would_fit;

use std::collections::BTreeMap;
use std::time::Duration;

use magician_host::message;
use magician_host::preflight::Preflight;
use magician_host::{Action as Deed, Error, Geometry, Limits, PtpMove, Set};
use magician_motion::MotionError;

use crate::turns::{AtOnce, SLICE, Turns, at_once};
use crate::{Action, Diagnostic, DiagnosticCode, Origin, Part, Plan};
use beyond::beyond;
pub use foreign::foreign_coordinates;
use pen::Pen;
use way::{corners, length, point};
pub use would_fit::{would_do_at, would_fit, would_fit_turned};

/// Refused steps that are kept; the others are counted.
const MOST_REFUSED: usize = 100;
/// Parts that have figures of their own.
const MOST_PARTS: usize = 4096;

/// How much of a plan is one of its parts, in all its passes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PartFigures {
    /// The part, as it begins first.
    pub part: Part,
    /// How long the tool's way is in it that draws or burns, mm.
    pub drawn: f64,
    /// How long the arm takes for it, if that is known.
    pub time: Option<Duration>,
}

/// A step that the arm could not do, or that a guard refuses.
#[derive(Debug)]
pub struct RefusedStep {
    /// The place of the step, from 0; the steps' number for what is wrong at the end. [`Report::number`] is what people say.
    pub step: usize,
    /// Where it came from.
    pub origin: Origin,
    /// The element or point that it belongs to.
    pub name: Option<String>,
    /// Why: with value, limit and unit where it is a matter of how much.
    pub error: Error,
    /// Where the step leads, with which tool and within which limits.
    pub(crate) target: Option<(Geometry, Limits, [f64; 3])>,
}

impl RefusedStep {
    /// How far the place that the step leads to is beyond the reach at its height: the distance to the nearest place in reach,
    /// rounded up to mm. None if the place is in reach, or is not known.
    #[must_use]
    pub fn beyond(&self) -> Option<f64> {
        self.target
            .as_ref()
            .and_then(|(geometry, limits, at)| beyond(geometry, limits, *at))
    }
}

impl From<&RefusedStep> for Diagnostic {
    fn from(refused_step: &RefusedStep) -> Self {
        Self {
            origin: refused_step.origin,
            name: refused_step.name.clone(),
            code: DiagnosticCode::Problem,
            message: refused_step.error.in_words(),
            help: None,
            remedies: refused_step.error.remedies().to_vec(),
            missing: None,
        }
    }
}

/// The steps that lead beyond what every arm keeps to for certain ([`Step::doubt`](magician_host::preflight::Step)): this arm may go
/// there, and another one may stop with an alarm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DoubtfulSteps {
    /// The place of the first one, from 0.
    pub step: usize,
    /// Where it came from.
    pub origin: Origin,
    /// The bound that it leaves.
    pub cause: MotionError,
    /// How many there are.
    pub count: usize,
}

/// What a check has found.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Report {
    /// The first steps that are refused, in their order.
    pub refused_steps: Vec<RefusedStep>,
    /// How many there are in all.
    pub refused: usize,
    /// The steps that not every arm can do, if there are any; they are not refused.
    pub doubtful: Option<DoubtfulSteps>,
    /// How many steps the plan has.
    pub steps: usize,
    /// How many of each kind, by [`Action::name`]; kinds that do not occur are absent.
    pub counts: BTreeMap<&'static str, usize>,
    /// How long the arm takes for all that was not refused, on a queue that never runs short: that of the virtual arm to the
    /// microsecond. `None` if a step has no end that is known (a trigger, homing, a start that is not known).
    pub time: Option<Duration>,
    /// How long the tool's way is that draws or burns, mm: with the laser lit; in a plan without a laser, the paths, lines and arcs that
    /// begin and end on the surface, which is at the lowest point of its paths if it is not known.
    pub drawn: f64,
    /// How long its other ways are, mm. Lines, paths, arcs and circles have their true length, ways of joints and jumps that
    /// of the straight line between their ends.
    pub travelled: f64,
    /// The weakest and the strongest power that is burnt, percent; none if nothing is.
    pub power: Option<[f64; 2]>,
    /// The least and the greatest x, y, z of the ways that draw or burn; none if nothing is drawn.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// The least and the greatest x, y, z at which steps end.
    pub travel_bounds: Option<[[f64; 3]; 2]>,
    /// The step with the longest way, from 0, and how long that is, mm.
    pub longest_way: Option<(usize, f64)>,
    /// The step that takes longest, from 0, and how long; segments of continuous paths aside, and what has no end that is
    /// known.
    pub longest_time: Option<(usize, Duration)>,
    /// Its parts in the order in which they begin, if it has any.
    pub parts: Vec<PartFigures>,
    /// What is added to the place of a step to have its number in the program that it is of, from 0.
    pub(crate) offset: i64,
}

impl Report {
    /// Whether the arm can do all of it.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.refused == 0
    }

    /// The number of the step at a place, as people count them: from 1, and where the check was of what is
    /// [left](crate::RemainingProgram::check) of a program, over all of that.
    #[must_use]
    pub fn number(&self, place: usize) -> u64 {
        let place = i64::try_from(place).unwrap_or(i64::MAX);
        let step = u64::try_from(place.saturating_add(self.offset));
        step.unwrap_or(0).saturating_add(1)
    }

    fn refuse(&mut self, plan: &Plan, step: usize, error: Error, arm: &Preflight) {
        self.refused += 1;
        if self.refused_steps.len() < MOST_REFUSED {
            let refused = plan.steps.get(step);
            let origin = refused.map_or(Origin::NONE, |step| step.origin);
            let target = refused.and_then(|step| step.action.target());
            self.refused_steps.push(RefusedStep {
                step,
                origin,
                name: plan.name_of(&origin).map(str::to_owned),
                error,
                target: target.map(|at| {
                    let limits = arm.arm_model().limits;
                    (arm.geometry(), limits, at.map(f64::from))
                }),
            });
        }
    }

    fn doubt(&mut self, step: usize, origin: Origin, cause: Option<MotionError>) {
        let Some(cause) = cause else {
            return;
        };
        let first = DoubtfulSteps {
            step,
            origin,
            cause,
            count: 0,
        };
        self.doubtful.get_or_insert(first).count += 1;
    }

    pub(crate) fn burn(&mut self, percent: f64) {
        if percent > 0.0 {
            let [least, most] = self.power.unwrap_or([percent; 2]);
            self.power = Some([least.min(percent), most.max(percent)]);
        }
    }

    fn travel(&mut self, step: usize, way: f64, draws: bool) {
        if draws {
            self.drawn += way;
        } else {
            self.travelled += way;
        }
        if self.longest_way.is_none_or(|(_, longest)| way > longest) {
            self.longest_way = Some((step, way));
        }
    }

    fn take(&mut self, step: usize, time: Duration) {
        if time < Duration::MAX && self.longest_time.is_none_or(|(_, longest)| time > longest) {
            self.longest_time = Some((step, time));
        }
    }
}

/// Follows a plan from where `start` has the arm, with the settings that it has in force, and tells what came of it. A step that
/// is refused is left out: the next one is followed from where it would have begun.
#[must_use]
pub fn check(plan: &Plan, start: &Preflight) -> Report {
    at_once(check_in_turns(plan, start, &AtOnce))
}

/// The same, with turns for others.
pub(crate) async fn check_in_turns(plan: &Plan, start: &Preflight, turns: &impl Turns) -> Report {
    let mut course = CheckRun {
        arm: start.clone().summing(),
        pen: Pen::of(plan),
        time: Some(Duration::ZERO),
        part: None,
        report: Report {
            steps: plan.steps.len(),
            ..Report::default()
        },
    };
    if let Some(tool) = plan.preamble()
        && let Err(error) = course.arm.check(&tool)
    {
        course.refuse(plan, 0, error);
    }
    let mut counts = [0; Action::NAMES.len()];
    for (nth, slice) in plan.steps.chunks(SLICE).enumerate() {
        for (at, step) in (nth * SLICE..).zip(slice) {
            if let Some(count) = counts.get_mut(step.action.kind()) {
                *count += 1;
            }
            let Some(command) = step.action.command() else {
                if let Action::Part(part) = &step.action {
                    course.begin(part);
                }
                continue;
            };
            match course.follow(at, &command) {
                Ok(doubt) => course.report.doubt(at, step.origin, doubt),
                Err(error) => course.refuse(plan, at, error),
            }
        }
        turns.give().await;
    }
    if let Err(error) = course.arm.finish() {
        course.refuse(plan, plan.steps.len(), error);
    }
    course.end_part();
    let rest = course.arm.rest();
    let mut report = course.report;
    report.time = course.time.map(|time| time.saturating_add(rest));
    let counted = Action::NAMES.into_iter().zip(counts);
    report.counts = counted.filter(|(_, count)| *count > 0).collect();
    report
}

/// Bounds that hold a point as well.
pub(crate) fn widen(bounds: &mut Option<[[f64; 3]; 2]>, at: [f64; 3]) {
    let [least, most] = bounds.get_or_insert([at, at]);
    for ((least, most), at) in least.iter_mut().zip(most).zip(at) {
        *least = least.min(at);
        *most = most.max(at);
    }
}

struct CheckRun {
    arm: Preflight,
    pen: Pen,
    time: Option<Duration>,
    /// The part under way, and what was drawn and how much time had passed when it began.
    part: Option<(usize, f64, Option<Duration>)>,
    report: Report,
}

impl CheckRun {
    /// The time so far, where the path under way would end here.
    fn until_here(&self) -> Option<Duration> {
        self.time?.checked_add(self.arm.clone().rest())
    }

    fn begin(&mut self, part: &Part) {
        self.end_part();
        let parts = &mut self.report.parts;
        let known = parts.iter().position(|known| known.part.n == part.n);
        let nth = known.unwrap_or(parts.len());
        if nth == MOST_PARTS {
            return;
        }
        if known.is_none() {
            parts.push(PartFigures {
                part: part.clone(),
                drawn: 0.0,
                time: Some(Duration::ZERO),
            });
        }
        self.part = Some((nth, self.report.drawn, self.until_here()));
    }

    fn end_part(&mut self) {
        let Some((nth, drawn, began)) = self.part.take() else {
            return;
        };
        let ends = self.until_here();
        if let Some(figures) = self.report.parts.get_mut(nth) {
            figures.drawn += self.report.drawn - drawn;
            let took = ends
                .zip(began)
                .map(|(ends, began)| ends.saturating_sub(began));
            figures.time = (figures.time.zip(took)).and_then(|(all, took)| all.checked_add(took));
        }
    }

    fn refuse(&mut self, plan: &Plan, step: usize, error: Error) {
        self.report.refuse(plan, step, error, &self.arm);
    }

    /// Refuses a place on a rail that is not in use: the arm would ignore it, and go to the right pose at the wrong place.
    fn check_rail(&self, command: &Set) -> Result<(), Error> {
        let Some(l) = PtpMove::from_command(command).and_then(|to| to.rail) else {
            return Ok(());
        };
        if self.arm.is_on_rail() {
            return Ok(());
        }
        let message = message!(
            "needs a rail, for its place at {l} mm, and the arm is not told of one",
            l
        );
        let error = Error::invalid(message).with_command(command.row().set_name);
        Err(error.remedy(
            Deed::UseRail,
            "tells the arm that it is on a rail; home it then",
        ))
    }

    fn follow(&mut self, step: usize, command: &Set) -> Result<Option<MotionError>, Error> {
        let before = self.arm.arm().copied();
        if !command.row().queueable {
            return Err(
                Error::invalid(message!("cannot be queued")).with_command(command.row().set_name)
            );
        }
        self.check_rail(command)?;
        let done = self.arm.check(command)?;
        self.time = self.time.filter(|_| done.time < Duration::MAX);
        self.time = self.time.map(|time| time.saturating_add(done.time));
        let is_path = matches!(command, Set::CpCmd(_) | Set::CpLeCmd(_));
        if !is_path {
            self.report.take(step, done.time.saturating_sub(done.path));
        }
        self.pen.note(command);
        match command {
            // A segment without a length lights nothing.
            Set::CpLeCmd(segment) if done.end != before => {
                self.report.burn(segment.velocity_or_power.into());
            }
            Set::SetEndEffectorLaser(_) if self.pen.is_lit() => self.report.burn(100.0),
            _ => {}
        }
        if let (Some(from), Some(to)) = (before, done.end) {
            let way = length(command, &from, &to);
            if way > 0.0 {
                let draws = self.pen.draws(command, &from, &to);
                self.report.travel(step, way, draws);
                if draws {
                    for at in corners(command, &from, &to) {
                        widen(&mut self.report.bounds, at);
                    }
                }
            }
            widen(&mut self.report.travel_bounds, point(&to));
        }
        Ok(done.doubt)
    }
}
