//! `doctor`: finds the arm or says why not, looks it over, and says what to do about what it finds.

mod arm;
mod find;
mod line;
mod report;

use std::pin::pin;
use std::time::Duration;

use clap::Args;
use magician::{RawLine, Target};
use tokio::time::timeout;

use crate::context::{Context, StopPolicy};
use crate::failure::{Failure, Kind};
use crate::progress::attended;
use report::{Finding, Report};

/// How long the trial of the queue may take to end once it is interrupted.
const LEAVING: Duration = Duration::from_secs(3);

/// Find the arm, check it, and explain how to fix what is wrong
#[derive(Args, Debug)]
#[command(after_help = "\
It checks the port, its permissions and the program that holds it, tells an arm from other \
    devices, sends reads back to back, times replies, and checks alarms and queue. All of this \
    only reads.

With --yes it also tests the queue: it stops the queue, puts 15 waits of 0 ms into it, checks the counters and drops the waits. Nothing moves. A queue with waiting commands is left alone; an empty one stays stopped until a program starts it.

Nothing is saved: set the window that it finds with --window or MAGICIAN_WINDOW, or in a program with Options::window.

Exit status 10 if a check of the arm fails, 4 to 6 if there is no arm.")]
pub(crate) struct Doctor {
    /// Replies to time, of each of two kinds
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    count: u64,
}

impl Doctor {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let mut report = Report::new(context.global.json);
        let outcome = self.examine(context, &mut report);
        if context.global.json {
            report.write_json(outcome.is_ok(), &mut context.out)?;
        }
        match outcome {
            Err(failure) if report.explains() => Err(Failure::told(failure.kind)),
            Err(failure) => Err(failure),
            Ok(()) => verdict(report.wrong()),
        }
    }

    fn examine(&self, context: &mut Context, report: &mut Report) -> Result<(), Failure> {
        let target = find::target(context, report)?;
        let patience = context.global.timeout;
        let options = context.line_options()?;
        let mut line = context.attending(async |out| {
            let mut line = line::open(&target, options, report, out).await?;
            line::hear(&mut line, &target, patience, report, out).await?;
            line::window(&mut line, &target, report, out).await?;
            Ok(line)
        })?;
        match context.global.yes {
            true => try_queue(&mut line, &target, context, report)?,
            false => line::leave_queue(report, &mut context.out)?,
        }
        drop(line);
        // What was found is said under the same name for every port.
        context.global.port = Some(target.to_string());
        let serial = matches!(
            target,
            Target::Serial(_) | Target::Usb { .. } | Target::Arm(_)
        );
        context.arm(StopPolicy::Look, async |arm, out| {
            arm::examine(arm, self.count, serial, report, out).await
        })
    }
}

/// Tries the queue. Ctrl-C lets it come to its end first, because its commands would be left in the queue.
fn try_queue(
    line: &mut RawLine,
    target: &Target,
    context: &mut Context,
    report: &mut Report,
) -> Result<(), Failure> {
    let quiet = report.quiet();
    let mut trial = pin!(line::queue_trial(line));
    let trying = context.attending(async |_| {
        let trial = attended(quiet, "testing the queue", &mut trial);
        Ok(trial.await)
    });
    match trying {
        Ok(trial) => line::queue(trial, target, report, &mut context.out),
        Err(failure) => {
            let rest = async { timeout(LEAVING, trial).await.is_ok() };
            match context.alone(async |_, _| Ok(rest.await))? {
                true => Err(failure),
                false => Err(failure
                    .hint("waits of 0 ms may be left in the queue: `magician stop` drops them")),
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
