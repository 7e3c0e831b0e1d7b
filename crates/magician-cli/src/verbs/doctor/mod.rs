//! `doctor`: finds the arm, checks it and its connection, and explains how to fix what is wrong.

mod report;
mod station;

use std::pin::pin;
use std::time::Duration;

use clap::Args;
use magician::{RawLine, Target};
use magician_measure::{Diagnosis, try_queue};
use tokio::time::timeout;

use crate::context::{Context, StopPolicy};
use crate::failure::{Failure, Kind};
use crate::progress::announce_wait;
use report::{FindingPrinter, write_json};

/// Longest time for the test of the queue to end after an interruption. A choice.
const TRIAL_END_TIMEOUT: Duration = Duration::from_secs(3);

/// Find the arm, check it, and explain how to fix problems
#[derive(Args, Debug)]
#[command(after_help = "\
Checks the port, its permissions and the program that holds it, distinguishes an arm from other \
devices, sends back-to-back reads, times replies, and checks alarms and queue. All of this only \
reads.

With --yes it also tests the queue: it stops the queue, adds 15 waits of 0 ms, checks the counters \
and drops the waits. Nothing moves. A queue with waiting commands is left alone; an empty one stays \
stopped until a program starts it.

With --station it checks a station instead: reachability, certificate and version, permissions of \
the token, response time, and the line, lease and alarms of each arm. This also only reads.

Nothing is saved: pass the window that it finds as --window or MAGICIAN_WINDOW, or in a program with Options::window.

Exit status 10 if a check fails, 4 to 6 if there is no arm or no station.")]
pub(crate) struct Doctor {
    /// Number of replies to time for each of two reads, 1 to 100000
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    count: u64,
}

impl Doctor {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let mut found = Diagnosis::default();
        let outcome = match context.global.station.clone() {
            Some(url) => examine_station(&url, context, &mut found),
            None => self.examine(context, &mut found),
        };
        if context.global.json {
            write_json(&found, outcome.is_ok(), &mut context.out)?;
        }
        match outcome {
            // People have read the reason among the findings already.
            Err(failure) if found.ended && !context.global.json => {
                Err(Failure::already_reported(failure.kind))
            }
            Err(failure) => Err(failure),
            Ok(()) => verdict(found.wrong()),
        }
    }

    fn examine(&self, context: &mut Context, found: &mut Diagnosis) -> Result<(), Failure> {
        let quiet = context.global.json;
        let given = context.port()?;
        let out = &mut context.out;
        let target = found.find(given.as_deref(), &mut FindingPrinter { out, quiet })?;
        let patience = context.global.timeout;
        let options = context.line_options()?;
        let mut line = context.run_with_own_line(async |out| {
            let to = &mut FindingPrinter { out, quiet };
            let mut line = found.open(&target, options, to).await?;
            found.hear(&mut line, &target, patience, to).await?;
            found.window(&mut line, &target, to).await?;
            Ok(line)
        })?;
        if context.global.yes {
            interruptible_trial(&mut line, &target, context, found)?;
        } else {
            let out = &mut context.out;
            found.leave_queue(&mut FindingPrinter { out, quiet })?;
        }
        drop(line);
        // Findings name the target in one way, however the port was given.
        context.global.port = Some(target.to_string());
        let serial = matches!(
            target,
            Target::Serial(_) | Target::Usb { .. } | Target::Arm(_)
        );
        context.arm(StopPolicy::Look, async |arm, out| {
            let to = &mut FindingPrinter { out, quiet };
            found.examine(arm, self.count, serial, to).await
        })
    }
}

/// Examines a station like an arm above.
fn examine_station(url: &str, context: &mut Context, found: &mut Diagnosis) -> Result<(), Failure> {
    let quiet = context.global.json;
    let access = station::StationAccess {
        url,
        token: context.global.token(),
        trust: context.global.trust(),
    };
    context.run_with_own_line(async |out| {
        station::examine(found, &access, &mut FindingPrinter { out, quiet }).await
    })
}

/// Runs the test of the queue. After Ctrl-C the test is completed first, because its commands would
/// remain in the queue.
fn interruptible_trial(
    line: &mut RawLine,
    target: &Target,
    context: &mut Context,
    found: &mut Diagnosis,
) -> Result<(), Failure> {
    let quiet = context.global.json;
    let mut trial = pin!(try_queue(line));
    let trying = context.run_with_own_line(async |_| {
        let trial = announce_wait(quiet, "testing the queue", &mut trial);
        Ok(trial.await)
    });
    match trying {
        Ok(trial) => {
            let out = &mut context.out;
            found.queue(trial, target, &mut FindingPrinter { out, quiet })
        }
        Err(failure) => {
            let rest = async { timeout(TRIAL_END_TIMEOUT, trial).await.is_ok() };
            if context.run_without_arm(async |_, _| Ok(rest.await))? {
                Err(failure)
            } else {
                Err(failure
                    .hint("waits of 0 ms may be left in the queue: `magician stop` drops them"))
            }
        }
    }
}

fn verdict(wrong: usize) -> Result<(), Failure> {
    let message = match wrong {
        0 => return Ok(()),
        1 => "1 check failed".to_owned(),
        wrong => format!("{wrong} checks failed"),
    };
    Err(Failure::new(Kind::CheckFailed, message))
}
