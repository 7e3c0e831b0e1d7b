//! What would become of a plan, before anything moves.

use std::time::Duration;

use magician::words::Preflight;
use magician::{Error, Set};

use crate::{Origin, Plan, Problem};

/// As many complaints are kept; the others are counted.
const MOST_COMPLAINTS: usize = 100;

/// A step that the arm could not do, or that a guard refuses.
#[derive(Debug)]
pub struct Complaint {
    /// Which step, from 0; the steps' number for what is wrong at the end.
    pub step: usize,
    /// Where it came from.
    pub origin: Origin,
    /// The element or point that it belongs to.
    pub name: Option<String>,
    /// Why: with value, limit and unit where it is a matter of how much.
    pub error: Error,
}

impl From<&Complaint> for Problem {
    fn from(complaint: &Complaint) -> Self {
        Self {
            origin: complaint.origin,
            name: complaint.name.clone(),
            message: complaint.error.to_string(),
            help: None,
        }
    }
}

/// What a check has found.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Report {
    /// The first complaints, in the order of the steps.
    pub complaints: Vec<Complaint>,
    /// How many there are in all.
    pub refused: usize,
    /// How long the arm takes for all that was not refused, on a queue that never runs short: that of the virtual arm to the
    /// microsecond. `None` if a step has no end that is known (a trigger, homing, a start that is not known).
    pub time: Option<Duration>,
    /// How long the tool's way is that draws or burns, mm.
    pub drawn: f64,
    /// How long its other straight ways and arcs are, mm.
    pub travelled: f64,
    /// The least and the greatest x, y, z at which steps end.
    pub bounds: Option<[[f64; 3]; 2]>,
}

impl Report {
    /// Whether the arm can do all of it.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.refused == 0
    }

    fn complain(&mut self, plan: &Plan, step: usize, error: Error) {
        self.refused += 1;
        if self.complaints.len() < MOST_COMPLAINTS {
            let origin = plan
                .steps
                .get(step)
                .map_or(Origin::NONE, |step| step.origin);
            self.complaints.push(Complaint {
                step,
                origin,
                name: plan.name_of(&origin).map(str::to_owned),
                error,
            });
        }
    }

    fn reach(&mut self, at: [f64; 3]) {
        let [least, most] = self.bounds.get_or_insert([at, at]);
        for axis in 0..3 {
            least[axis] = least[axis].min(at[axis]);
            most[axis] = most[axis].max(at[axis]);
        }
    }
}

/// Follows a plan from where `start` has the arm, with the settings that it has in force, and tells what came of it. A step that
/// is refused is left out: the next one is followed from where it would have begun.
#[must_use]
pub fn check(plan: &Plan, start: &Preflight) -> Report {
    let mut report = Report::default();
    let mut course = start.clone();
    let mut time = Some(Duration::ZERO);
    let first = plan.preamble().into_iter().count();
    for (nth, command) in plan.commands().enumerate() {
        let step = nth.saturating_sub(first);
        let before = course.arm().map(|arm| arm.pose);
        match course.check(&command) {
            Ok(done) => {
                time = time.filter(|_| done.time < Duration::MAX);
                time = time.map(|time| time.saturating_add(done.time));
                let after = done.end.map(|end| end.pose);
                if let (Some(from), Some(to)) = (before, after) {
                    let way = from.distance_to(&to);
                    match &command {
                        Set::CpCmd(_) | Set::CpLeCmd(_) => report.drawn += way,
                        _ => report.travelled += way,
                    }
                    report.reach([to.x, to.y, to.z]);
                }
            }
            Err(error) => report.complain(plan, step, error),
        }
    }
    if let Err(error) = course.finish() {
        report.complain(plan, plan.steps.len(), error);
    }
    report.time = time;
    report
}
