//! Check of a plan before anything moves: what is refused, how long it takes, and how far the tool
//! travels.
//!
//! The check follows the plan with a [`Preflight`], which plans each command as the arm would. A
//! refused step is skipped and leaves the state unchanged, so one run finds all mistakes. Times are
//! those of the virtual arm, to the microsecond.

mod beyond;
mod foreign;
mod motion;
mod pen;
mod would_fit;

use std::collections::BTreeMap;
use std::time::Duration;

use magician_host::message;
use magician_host::preflight::Preflight;
use magician_host::{Action as Deed, Error, Geometry, Limits, PtpMove, Set};
use magician_motion::MotionError;

use crate::yielding::{NeverYield, STEPS_PER_SLICE, Yield, run_to_end};
use crate::{Action, Diagnostic, DiagnosticCode, Origin, Part, Plan};
use beyond::beyond;
pub use foreign::foreign_coordinates;
use motion::{corners, length, point};
use pen::Pen;
pub use would_fit::{would_fit, would_fit_at, would_fit_turned};

/// Largest number of refused steps listed in a report; further ones are only counted. Bounds the
/// memory of a report.
const MAX_REFUSED_STEPS: usize = 100;
/// Largest number of parts with separate figures; further parts count only in the totals. Bounds
/// the size of a report.
const MAX_PARTS: usize = 4096;

/// Figures of one part of a plan, over all its passes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PartFigures {
    /// The part, as it first begins.
    pub part: Part,
    /// Length drawn or burnt in it, mm.
    pub drawn: f64,
    /// Duration of the part, if known.
    pub time: Option<Duration>,
}

/// Step that the arm cannot do, or that a guard refuses.
#[derive(Debug)]
pub struct RefusedStep {
    /// Index of the step, from 0; the number of steps for a fault at the end. Users see
    /// [`Report::number`].
    pub step: usize,
    /// Origin of the step in the file.
    pub origin: Origin,
    /// Element or point that it belongs to.
    pub name: Option<String>,
    /// Reason, with value, limit and unit where there is a limit.
    pub error: Error,
    /// Target of the step, with the arm's geometry (tool included) and limits.
    pub(crate) target: Option<(Geometry, Limits, [f64; 3])>,
}

impl RefusedStep {
    /// Distance from the target to the nearest place in reach at the same height, rounded up to mm.
    /// `None` if the target is in reach or unknown.
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

/// Steps whose target lies outside the bounds that every arm reaches for certain
/// ([`Step::doubt`](magician_host::preflight::Step)): one arm may go there, another may stop with
/// an alarm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DoubtfulSteps {
    /// Index of the first one, from 0.
    pub step: usize,
    /// Origin of the first one in the file.
    pub origin: Origin,
    /// Bound that it exceeds.
    pub cause: MotionError,
    /// Number of such steps.
    pub count: usize,
}

/// Result of a check.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Report {
    /// First refused steps, in order.
    pub refused_steps: Vec<RefusedStep>,
    /// Number of all refused steps.
    pub refused: usize,
    /// Steps that not every arm can do, if any; they are not refused.
    pub doubtful: Option<DoubtfulSteps>,
    /// Number of steps in the plan.
    pub steps: usize,
    /// Number of steps of each kind, by [`Action::name`]; kinds that do not occur are absent.
    pub counts: BTreeMap<&'static str, usize>,
    /// Duration of all steps except refused ones, on a queue that never runs empty: equal to the
    /// virtual arm's to the microsecond. `None` if the end of a step is unknown (a trigger, homing,
    /// an unknown start).
    pub time: Option<Duration>,
    /// Length that draws or burns, mm. With a laser: motion with the laser on. Without: paths,
    /// lines and arcs that begin and end on the surface, which is assumed at the lowest point of
    /// the paths if it is unknown.
    pub drawn: f64,
    /// Length of all other motion, mm. Lines, paths, arcs and circles count with their true length,
    /// joint moves and jumps as the straight line between their ends.
    pub travelled: f64,
    /// Smallest and largest laser power, percent; `None` if nothing is burnt.
    pub power: Option<[f64; 2]>,
    /// Bounds (least and greatest x, y, z) of the motion that draws or burns; `None` if nothing is
    /// drawn.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// Bounds of all end points of steps.
    pub travel_bounds: Option<[[f64; 3]; 2]>,
    /// Step with the longest motion, from 0, and its length, mm.
    pub longest_motion: Option<(usize, f64)>,
    /// Step with the longest duration, from 0, and that duration. Segments of continuous paths and
    /// steps without a known end do not count.
    pub longest_time: Option<(usize, Duration)>,
    /// Parts in the order in which they begin.
    pub parts: Vec<PartFigures>,
    /// Offset from an index in this report to the step's number in the whole program, from 0.
    pub(crate) offset: i64,
}

impl Report {
    /// True if the arm can do the whole plan.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.refused == 0
    }

    /// Number of a step as shown to users, from 1. A check of a [remaining
    /// program](crate::RemainingProgram::check) counts from the start of the whole program.
    #[must_use]
    pub fn number(&self, place: usize) -> u64 {
        let place = i64::try_from(place).unwrap_or(i64::MAX);
        let step = u64::try_from(place.saturating_add(self.offset));
        step.unwrap_or(0).saturating_add(1)
    }

    fn refuse(&mut self, plan: &Plan, step: usize, error: Error, arm: &Preflight) {
        self.refused += 1;
        if self.refused_steps.len() < MAX_REFUSED_STEPS {
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

    fn add_motion(&mut self, step: usize, way: f64, draws: bool) {
        if draws {
            self.drawn += way;
        } else {
            self.travelled += way;
        }
        if self.longest_motion.is_none_or(|(_, longest)| way > longest) {
            self.longest_motion = Some((step, way));
        }
    }

    fn add_time(&mut self, step: usize, time: Duration) {
        if time < Duration::MAX && self.longest_time.is_none_or(|(_, longest)| time > longest) {
            self.longest_time = Some((step, time));
        }
    }
}

/// Checks a plan that begins with the pose and settings of `start`.
///
/// A refused step is skipped: the check continues from the state before it.
#[must_use]
pub fn check(plan: &Plan, start: &Preflight) -> Report {
    run_to_end(check_yielding(plan, start, &NeverYield))
}

/// Like [`check`](fn@check), yielding to other tasks between slices.
pub(crate) async fn check_yielding(plan: &Plan, start: &Preflight, yields: &impl Yield) -> Report {
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
    for (nth, slice) in plan.steps.chunks(STEPS_PER_SLICE).enumerate() {
        for (at, step) in (nth * STEPS_PER_SLICE..).zip(slice) {
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
        // A long plan takes seconds: yield so that the arm is served meanwhile.
        yields.yield_now().await;
    }
    // The last path can be planned only now that nothing follows it.
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

/// Widens bounds to include a point.
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
    /// Current part, with the drawn length and the time at its beginning.
    part: Option<(usize, f64, Option<Duration>)>,
    report: Report,
}

impl CheckRun {
    /// Time so far, if the current path ended here.
    fn elapsed(&self) -> Option<Duration> {
        self.time?.checked_add(self.arm.clone().rest())
    }

    fn begin(&mut self, part: &Part) {
        self.end_part();
        let parts = &mut self.report.parts;
        let known = parts.iter().position(|known| known.part.n == part.n);
        let nth = known.unwrap_or(parts.len());
        // Beyond the limit a part counts in the totals only.
        if nth == MAX_PARTS {
            return;
        }
        if known.is_none() {
            parts.push(PartFigures {
                part: part.clone(),
                drawn: 0.0,
                time: Some(Duration::ZERO),
            });
        }
        self.part = Some((nth, self.report.drawn, self.elapsed()));
    }

    fn end_part(&mut self) {
        let Some((nth, drawn, began)) = self.part.take() else {
            return;
        };
        let ends = self.elapsed();
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

    /// Refuses a rail position if no rail is in use: the arm would ignore the position and take the
    /// right pose at the wrong place.
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
        // `Duration::MAX` marks an end that is unknown: the total is unknown from here on.
        self.time = self.time.filter(|_| done.time < Duration::MAX);
        self.time = self.time.map(|time| time.saturating_add(done.time));
        let is_path = matches!(command, Set::CpCmd(_) | Set::CpLeCmd(_));
        // Segments of a path are planned together, so a single segment has no duration to report.
        if !is_path {
            self.report
                .add_time(step, done.time.saturating_sub(done.path));
        }
        self.pen.note(command);
        match command {
            // A segment without length does not burn.
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
                self.report.add_motion(step, way, draws);
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
