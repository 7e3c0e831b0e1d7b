//! Check over all iterations of a program.

use magician_host::preflight::Preflight;

use super::RemainingProgram;
use crate::check::{check_yielding, widen};
use crate::yielding::{NeverYield, STEPS_PER_SLICE, Yield, run_to_end};
use crate::{DoubtfulSteps, PartFigures, Plan, RefusedStep, Report};

/// Largest number of iterations checked one by one, if each ends elsewhere. Bounds the work for
/// endless programs that drift.
const MAX_ITERATIONS: usize = 100;

impl RemainingProgram {
    /// Checks the rest of the program: the first part, then iterations until one leaves the arm as
    /// it found it, because later ones repeat it; at most a hundred. Indices of refused steps
    /// continue from those of the [first](Self::first) part.
    #[must_use]
    pub fn check(&self) -> Report {
        run_to_end(self.check_yielding(&NeverYield))
    }

    /// Like [`check`](Self::check), yielding to other tasks between slices.
    pub async fn check_yielding(&self, yields: &impl Yield) -> Report {
        let mut report = check_yielding(&self.first, &self.start_with_settings, yields).await;
        if self.following != Some(0) && report.is_good() {
            self.check_iterations(&mut report, yields).await;
        }
        report.time = report.time.filter(|_| self.following.is_some());
        report.offset = self.offset();
        report
    }

    /// Adds the iterations after the first part.
    async fn check_iterations(&self, report: &mut Report, yields: &impl Yield) {
        let mut course = self.start_with_settings.clone();
        follow(&mut course, &self.first, yields).await;
        let iteration = Plan {
            tool: None,
            ..Plan::clone(&self.whole)
        };
        let mut left = self.following;
        let mut steps = self.first.steps.len();
        for nth in 1..=MAX_ITERATIONS {
            let again = check_yielding(&iteration, &course, yields).await;
            let before = course.arm().copied();
            follow(&mut course, &iteration, yields).await;
            let settled = course.arm().copied() == before || nth == MAX_ITERATIONS;
            let times = left.map_or(0, |left| if settled { left } else { 1 });
            add(report, again, times, steps);
            steps = steps.saturating_add(iteration.steps.len());
            left = left.map(|left| left.saturating_sub(times));
            if settled || left == Some(0) || !report.is_good() {
                return;
            }
        }
    }
}

/// Follows a plan that has been checked from this state.
async fn follow(course: &mut Preflight, plan: &Plan, yields: &impl Yield) {
    if let Some(tool) = plan.preamble() {
        let _ = course.check(&tool);
    }
    for slice in plan.steps.chunks(STEPS_PER_SLICE) {
        for step in slice {
            if let Some(command) = step.action.command() {
                let _ = course.check(&command);
            }
        }
        yields.yield_now().await;
    }
}

/// Adds the report of an iteration that is repeated `times`, after `steps` steps.
fn add(report: &mut Report, iteration: Report, times: u64, steps: usize) {
    let count = u32::try_from(times).unwrap_or(u32::MAX);
    let time = iteration.time.and_then(|time| time.checked_mul(count));
    report.time = (report.time.zip(time)).and_then(|(all, time)| all.checked_add(time));
    report.drawn += times as f64 * iteration.drawn;
    report.travelled += times as f64 * iteration.travelled;
    report.refused += iteration.refused;
    let refused_steps = iteration
        .refused_steps
        .into_iter()
        .map(|refused_step| RefusedStep {
            step: refused_step.step.saturating_add(steps),
            ..refused_step
        });
    report.refused_steps.extend(refused_steps);
    if let Some(doubtful) = iteration.doubtful {
        let more = doubtful.count.saturating_mul(count as usize);
        let first = DoubtfulSteps {
            step: doubtful.step.saturating_add(steps),
            count: 0,
            ..doubtful
        };
        report.doubtful.get_or_insert(first).count += more;
    }
    for part in iteration.parts {
        let known = { report.parts.iter_mut() }.find(|known| known.part.n == part.part.n);
        let time = part.time.and_then(|time| time.checked_mul(count));
        match known {
            Some(known) => {
                known.drawn += times as f64 * part.drawn;
                known.time = (known.time.zip(time)).and_then(|(all, time)| all.checked_add(time));
            }
            // The part began before the rest does.
            None => report.parts.push(PartFigures {
                drawn: times as f64 * part.drawn,
                time,
                ..part
            }),
        }
    }
    for percent in iteration.power.into_iter().flatten() {
        report.burn(percent);
    }
    for at in iteration.bounds.into_iter().flatten() {
        widen(&mut report.bounds, at);
    }
    for at in iteration.travel_bounds.into_iter().flatten() {
        widen(&mut report.travel_bounds, at);
    }
}

#[cfg(test)]
mod tests {
    use magician_host::Set;
    use magician_host::commands::PtpCmd;
    use magician_protocol::PtpMode;

    use super::super::Program;
    use super::super::remaining::tests::{plan, rest, start};
    use crate::Origin;

    #[test]
    fn check_counts_every_iteration() {
        let once = rest(Some(1), 0).check();
        let thrice = rest(Some(3), 0).check();
        assert!(thrice.is_good());
        let [once_s, thrice_s] = [&once, &thrice].map(|report| report.time.unwrap().as_secs_f64());
        // The first iteration includes the move from home.
        assert!(
            thrice_s > 2.0 * once_s && thrice_s < 3.0 * once_s,
            "{once_s} {thrice_s}"
        );
        assert!(rest(None, 0).check().time.is_none());
    }

    /// Each iteration goes 30 mm further out.
    #[test]
    fn drifting_iterations_are_checked_until_one_is_refused() {
        let mut plan = plan();
        let further = PtpCmd {
            ptp_mode: PtpMode::MovlXyzInc,
            x: 30.0,
            y: 0.0,
            z: 0.0,
            r: 0.0,
        };
        plan.push(Set::from(further), Origin::NONE);
        plan.steps.drain(..2);
        let check = |iterations, from| {
            let program = Program::new(plan.clone(), iterations);
            let rest = program.remaining(from, start()).expect("within reach");
            let report = rest.check();
            let steps = report.refused_steps.iter();
            let steps: Vec<u64> = steps.map(|one| report.number(one.step)).collect();
            (report, steps)
        };
        let (twice, _) = check(Some(2), 0);
        assert!(twice.is_good());
        assert!((twice.travelled - 60.0).abs() < 1e-6);
        assert!(twice.travel_bounds.is_some_and(|[_, most]| most[0] > 250.0));
        // After 200 mm and four iterations the target is beyond the arm's reach.
        for (iterations, from) in [(Some(9), 0), (None, 0), (Some(9), 3)] {
            let (report, steps) = check(iterations, from);
            assert!(!report.is_good());
            assert!(steps.len() == 1 && steps[0] % 2 == 0, "{steps:?}");
            assert!((4..=from + 10).contains(&steps[0]), "{steps:?}");
        }
    }
}
