//! `doctor`: finds the arm or says why not, looks it over, and says what to do about what it finds.

mod arm;
mod find;
mod line;
mod report;

use clap::Args;

use crate::context::Context;
use crate::failure::{Failure, Kind};
use report::{Finding, Report};

/// Find the arm or say why not, look it over, and say what to do
#[derive(Args, Debug)]
#[command(after_help = "\
It looks for the port, its permission and who holds it, listens for an arm or for what else is there, sends reads back to \
back, times answers, and looks at alarms and queue. All this only reads.

With --yes it also tries the queue: it stops it, puts 15 waits of no length into it, looks at its counters and drops them. \
Nothing moves. A queue in which commands wait is left alone.

Nothing is kept: the window it finds is set with --window or MAGICIAN_WINDOW, or in a program with Options::window.

Exit status 10 if something is wrong with the arm, 4 to 6 if there is none.")]
pub(crate) struct Doctor {
    /// Answers to time, of each of two kinds
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    count: u64,
}

impl Doctor {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let mut report = Report::new(context.global.json);
        let outcome = self.examine(context, &mut report);
        if context.global.json {
            report.write_json(&mut context.out)?;
        }
        match outcome {
            Err(failure) if report.explains() => Err(Failure::told(failure.kind)),
            Err(failure) => Err(failure),
            Ok(()) => verdict(report.wrong()),
        }
    }

    fn examine(&self, context: &mut Context, report: &mut Report) -> Result<(), Failure> {
        let target = find::target(context, report)?;
        let (patience, yes) = (context.global.timeout, context.global.yes);
        let options = context.line_options()?;
        context.attending(async |out| {
            let mut line = line::open(&target, options, report, out).await?;
            line::hear(&mut line, &target, patience, report, out).await?;
            line::window(&mut line, report, out).await?;
            line::queue(&mut line, yes, report, out).await
        })?;
        // What was found is said under the same name for every port.
        context.global.port = Some(target.to_string());
        let serial = matches!(target, magician::Target::Serial(_));
        context.with_arm(async |arm, out| arm::examine(arm, self.count, serial, report, out).await)
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
