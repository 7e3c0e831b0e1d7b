//! `conform`: runs the conformance cases against an arm.

mod human;
mod list;
mod record;

use std::io::{self, BufRead, IsTerminal, Write};
use std::time::{Duration, Instant};

use clap::Args;
use magician::{ErrorKind, RawLine, SimSpeed, Target};
use magician_conform::{Case, LineTarget, Outcome, Runner, SimTarget, Suite};

use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::output::Output;
use crate::progress::announce_wait;

/// Default timeout of an answer: the Wi-Fi module takes up to 2 s.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(3);
/// Longest time for restoring the arm's parameters after an interruption. A choice: every parameter
/// takes a request, each with its timeout.
const RESTORE_TIMEOUT: Duration = Duration::from_secs(20);

/// Run the conformance suite against an arm
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician conform --port sim                     all cases on a virtual arm
  magician conform --list --only queue            list the cases with source and confidence
  magician conform --port /dev/ttyUSB0 --skip moves

A PATTERN is a chapter (ptp, queue, framing), a name with * as a wildcard, a tag (moves, exact, \
hurts, sim-only, power-up), or a confidence: M measured on real arms, V the vendor's document or \
code for this arm, VL the vendor's code for the sibling arm, T third parties, G our assumption.

A real arm moves only after confirmation at the terminal, or with --yes: remove its tool and clear \
its reach. Cases that could damage or uncalibrate it are skipped. Its parameters are saved first and \
restored at the end; its queue and its alarms are cleared.

Exit status 10 if a case fails.")]
pub(crate) struct Conform {
    /// Run only cases that match PATTERN (repeatable)
    #[arg(long, value_name = "PATTERN")]
    only: Vec<String>,
    /// Skip cases that match PATTERN (repeatable)
    #[arg(long, value_name = "PATTERN")]
    skip: Vec<String>,
    /// List the cases as a Markdown table instead of running them; -v adds their steps
    #[arg(long)]
    list: bool,
}

/// Number of cases by result.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    passed: usize,
    failed: usize,
    skipped: usize,
}

impl Tally {
    fn count(&mut self, outcome: &Outcome) {
        match outcome {
            Outcome::Passed => self.passed += 1,
            Outcome::Failed(_) => self.failed += 1,
            Outcome::Skipped(_) => self.skipped += 1,
        }
    }
}

/// Output of the results, for people or as JSON.
trait Printer {
    fn case(&mut self, case: &Case, outcome: &Outcome) -> Result<(), Failure>;
    fn end(&mut self, tally: Tally, took: Duration) -> Result<(), Failure>;
}

impl Conform {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let suite =
            Suite::built_in().map_err(|error| Failure::new(Kind::Bug, error.to_string()))?;
        let cases = suite.select(&self.only, &self.skip);
        if let Some(pattern) = suite.unmatched(self.only.iter().chain(&self.skip)) {
            let message = format!("no case matches `{pattern}`");
            return Err(Failure::invalid(message).hint("`magician conform --list` shows them"));
        }
        if self.list {
            return list::show(&cases, context);
        }
        let Some(target) = target(context)? else {
            return run_on(SimTarget::default(), &cases, context);
        };
        permit(&target, &cases, context)?;
        let options = context.line_options()?;
        let open = async |_: &mut Output| Ok(RawLine::open_with(&target, options).await?);
        let line = context.run_with_own_line(open)?;
        run_on(LineTarget::new(line), &cases, context)
    }
}

/// Returns the target; `None` for a virtual arm in this process.
fn target(context: &mut Context) -> Result<Option<Target>, Failure> {
    match context.target(None)? {
        Target::Sim(SimSpeed::Max) => Ok(None),
        Target::Sim(SimSpeed::Times(_)) => {
            let message = "`conform` steps the clock of a virtual arm itself: a speed has no \
                effect";
            Err(Failure::usage(message).hint("use --port sim"))
        }
        target => Ok(Some(target)),
    }
}

/// Fails unless the user has allowed a real arm to move, if any of the cases moves it.
fn permit(target: &Target, cases: &[&Case], context: &Context) -> Result<(), Failure> {
    let count = cases.iter().filter(|case| case.moves_an_arm()).count();
    if count == 0 || context.global.yes {
        return Ok(());
    }
    let message = format!("the arm at {target} would move in {count} cases; nothing was sent");
    let refused = Err(Failure::usage(message)
        .hint("clear its reach and give --yes, or leave them out with --skip moves"));
    if context.global.json || !io::stdin().is_terminal() || !io::stderr().is_terminal() {
        return refused;
    }
    let mut stderr = io::stderr();
    write!(
        stderr,
        "The arm at {target} will move through most of its range in {count} cases. Is its tool \
            off and its reach clear? [y/N] "
    )?;
    stderr.flush()?;
    let mut answer = String::new();
    io::stdin().lock().read_line(&mut answer)?;
    // Only an explicit yes lets a real arm move.
    match answer.trim().to_ascii_lowercase().as_str() {
        "y" | "yes" => Ok(()),
        _ => refused,
    }
}

/// Runs the cases and prints their results.
fn run_on<T: magician_conform::Target>(
    arm: T,
    cases: &[&Case],
    context: &mut Context,
) -> Result<(), Failure> {
    let quiet = context.global.json;
    let patience = context.global.timeout.unwrap_or(ANSWER_TIMEOUT);
    let details = context.global.verbose > 0;
    let mut runner =
        Runner::new(arm, patience).map_err(|error| Failure::new(Kind::Bug, error.to_string()))?;
    let tally = context.run_without_arm(async |out, signals| {
        let work = async {
            if quiet {
                run_all(&mut runner, cases, quiet, record::Records { out }).await
            } else {
                run_all(&mut runner, cases, quiet, human::Lines::new(out, details)).await
            }
        };
        let outcome = tokio::select! {
            outcome = work => Ok(outcome),
            _ = signals.next() => Err(()),
        };
        // The arm's parameters are restored however the run ended.
        let ended = tokio::time::timeout(RESTORE_TIMEOUT, runner.end()).await;
        match outcome {
            Ok(outcome) => {
                let tally = outcome?;
                ended.map_err(|_| restore_failure())??;
                Ok(Some(tally))
            }
            Err(()) => Ok(None),
        }
    })?;
    match tally {
        None => Err(Failure::interrupted()),
        Some(Tally { failed: 0, .. }) => Ok(()),
        Some(Tally { failed, passed, .. }) => {
            let cases = if failed == 1 { "case" } else { "cases" };
            let message = format!("{failed} {cases} failed, {passed} passed");
            Err(Failure::new(Kind::CheckFailed, message))
        }
    }
}

/// Failure of an arm that did not answer while its parameters were restored.
fn restore_failure() -> Failure {
    let message = "the arm's parameters were not restored in time";
    Failure::new(Kind::Driver(ErrorKind::Timeout), message)
}

async fn run_all<T: magician_conform::Target>(
    runner: &mut Runner<T>,
    cases: &[&Case],
    quiet: bool,
    mut printer: impl Printer,
) -> Result<Tally, Failure> {
    let begun = Instant::now();
    let mut tally = Tally::default();
    announce_wait(quiet, "saving the arm's parameters", runner.begin()).await?;
    for (at, case) in cases.iter().enumerate() {
        let what = format!("{} of {}: {}", at + 1, cases.len(), case.id);
        let outcome = announce_wait(quiet, &what, runner.run(case)).await?;
        tally.count(&outcome);
        printer.case(case, &outcome)?;
    }
    printer.end(tally, begun.elapsed())?;
    Ok(tally)
}

/// Returns a count with its noun; `None` for a count of 0.
fn some(count: usize, what: &str) -> Option<String> {
    (count > 0).then(|| format!("{count} {what}"))
}

/// Formats the parts of a tally.
fn in_words(tally: Tally) -> String {
    let Tally {
        passed,
        failed,
        skipped,
    } = tally;
    let parts = [
        some(failed, "failed"),
        some(passed, "passed"),
        some(skipped, "skipped"),
    ];
    let parts: Vec<_> = parts.into_iter().flatten().collect();
    match parts.as_slice() {
        [] => "nothing to do".to_owned(),
        parts => parts.join(", "),
    }
}

/// Wraps a text to the output's width less the indentation.
fn fitted(text: &str, indent: usize, out: &Output) -> Vec<String> {
    crate::columns::wrap(text, out.width().saturating_sub(indent))
}
