//! `record`: records the arm while it is moved by hand or by another program.

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::time::{Duration, SystemTime};

use clap::{Args, ValueHint};
use magician::Arm;
use magician_job::recording::{Format, Options, Recorder, RecordingProgress, Summary};
use magician_record::law::LawReport;
use serde::Serialize;
use tokio::time::{MissedTickBehavior, interval, sleep};

use super::jog::REAL_TIME_ARM;
use super::law;
use super::pose::rate;
use super::replay;
use crate::context::{Context, SignalPolicy};
use crate::failure::Failure;
use crate::options::{number, seconds};
use crate::paint::{is_terminal_with_escapes, print_stderr, width_of_stderr};

/// Interval of updates of the progress line.
const UPDATE_INTERVAL: Duration = Duration::from_millis(100);

/// Record the motion of the arm, as readings or as a program
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician record day.mcap                  until Ctrl-C; opens in Foxglove
  magician record day.csv --rate 50 --for 60
  magician record lead.plan.json            guide the arm by hand (its unlock button), then Ctrl-C
  magician run lead.plan.json               repeat the motion
  magician record day.csv --rate 23 --law   with the deviation from the law of motion
  magician replay day.csv --law             the same for an existing recording

The extension selects the format. .mcap, .csv and .jsonl contain readings: time, seconds, pose and \
joints in mm and deg, queue index and free space, alarms; .mcap and .jsonl also contain events of \
alarms and of the line. .plan.json is a program that repeats the motion at its own speed and \
with its pauses. .playback is the same for DobotStudio, with a stop at each point.

Recording only reads: move the arm by hand, with its own keys, or from another program through \
`magician proxy`. A recording that is killed lacks at most its last second. With --yes an existing \
file is replaced; until the end the new recording is in FILE.partial.")]
pub(crate) struct Record {
    /// File to write
    #[arg(value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// Readings per second, 0.01 to 1000; a line at 115200 baud allows about 50
    #[arg(long, value_name = "HZ", default_value_t = 20.0, value_parser = rate)]
    rate: f64,
    /// Write the units into the second line of a .csv file
    #[arg(long)]
    units: bool,
    /// Duration in seconds [default: until Ctrl-C]
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    lasting: Option<Duration>,
    /// Largest deviation of a program from the recorded motion in mm, 0.01 to 100
    #[arg(long, value_name = "MM", default_value_t = 0.5, value_parser = tolerance)]
    tolerance: f64,
    /// Print the deviation of the readings from the law of motion (see `magician replay --help`)
    #[arg(long)]
    law: bool,
}

/// Summary as JSON.
#[derive(Serialize)]
struct RecordReport<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    #[serde(skip_serializing_if = "Option::is_none")]
    law: Option<LawReport>,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value = number::<f64>(text)?;
    let good = (0.01..=100.0).contains(&value);
    good.then_some(value)
        .ok_or_else(|| "expected 0.01 to 100 mm".to_owned())
}

impl Record {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        check(&self.file, self.law, context)?;
        let json = context.global.json;
        let summary = context.until_signal(
            REAL_TIME_ARM,
            SignalPolicy::Record,
            async |arm, _, ended| self.record(arm, json, ended).await,
        )?;
        show(&summary, self.law, context)
    }

    async fn record(
        &self,
        arm: &Arm,
        json: bool,
        ended: Pin<&mut dyn Future<Output = ()>>,
    ) -> Result<Summary, Failure> {
        let options = Options {
            tolerance: self.tolerance,
            units: self.units,
            ..Options::new(SystemTime::now(), self.rate)
        };
        let mut recorder = Recorder::begin(arm, &self.file, options).await?;
        let mut progress_line = ProgressLine::begin(json, &self.file, self.lasting.is_some());
        let time = async {
            match self.lasting {
                Some(duration) => sleep(duration).await,
                None => std::future::pending().await,
            }
        };
        let end = async {
            tokio::select! {
                () = ended => {}
                () = time => {}
            }
        };
        let mut end = std::pin::pin!(end);
        let mut frames = interval(UPDATE_INTERVAL);
        frames.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                biased;
                () = &mut end => break,
                error = recorder.failed() => return Err(error.into()),
                _ = frames.tick() => progress_line.show(&recorder.progress()),
            }
        }
        drop(progress_line);
        Ok(recorder.finish().await?)
    }
}

/// Fails, before an arm is connected, if no recording can be written to this file.
pub(super) fn check(file: &Path, law: bool, context: &Context) -> Result<(), Failure> {
    let format = Format::of(file)?;
    if law && format.is_program() {
        return Err(Failure::usage(
            "--law needs readings: a .csv, .jsonl or .mcap file",
        ));
    }
    // A motion by hand cannot be repeated by a computer, so an existing file is never overwritten
    // silently.
    if file.exists() && !context.global.yes {
        let message = format!("{} already exists", file.display());
        return Err(Failure::usage(message).hint("--yes replaces it"));
    }
    Ok(())
}

/// Shows the summary of a recording and, if `law` is set, the deviation of its readings from the
/// law of motion.
pub(super) fn show(summary: &Summary, law: bool, context: &mut Context) -> Result<(), Failure> {
    // Computed from the file, so that a later `replay` of it gives the same numbers.
    let law = if law {
        Some(replay::law_of_readings(&summary.file)?)
    } else {
        None
    };
    let report = RecordReport { summary, law };
    context.show(&report, |out| {
        out.line(in_words(summary))?;
        if let Some(report) = &report.law {
            law::show(report, out)?;
        }
        if summary.format.is_program() {
            let file = summary.file.display();
            out.line(format_args!("`magician run {file}` repeats it"))?;
        }
        Ok(())
    })
}

fn in_words(summary: &Summary) -> String {
    let Summary {
        seconds,
        readings,
        length,
        ..
    } = summary;
    let steps = match summary.steps {
        Some(1) => ", 1 step".to_owned(),
        Some(steps) => format!(", {steps} steps"),
        None => String::new(),
    };
    format!(
        "{}: {seconds:.1} s, {readings} readings, {length:.1} mm travelled{steps}",
        summary.file.display()
    )
}

/// Progress on a line of stderr that is rewritten in place.
struct ProgressLine {
    is_visible: bool,
    width: usize,
}

impl ProgressLine {
    fn begin(json: bool, file: &std::path::Path, timed: bool) -> Self {
        let stderr = io::stderr();
        let is_visible = !json && stderr.is_terminal() && is_terminal_with_escapes(&stderr);
        if !json {
            let end = if timed { "" } else { "; Ctrl-C ends it" };
            print_stderr(format_args!("recording {}{end}", file.display()));
        }
        Self {
            is_visible,
            width: width_of_stderr() - 1,
        }
    }

    fn show(&mut self, progress: &RecordingProgress) {
        if !self.is_visible {
            return;
        }
        let line: String = line(progress).chars().take(self.width).collect();
        let _ = write!(io::stderr(), "\r{line}\x1b[K");
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if self.is_visible {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}

/// Formats the progress in less than 80 columns.
fn line(progress: &RecordingProgress) -> String {
    let [x, y, z, r] = progress.pose;
    let time = match progress.seconds {
        long if long >= 600.0 => format!(
            "{:.0}:{:02.0} min",
            (long / 60.0).floor(),
            (long % 60.0).floor()
        ),
        short => format!("{short:.1} s"),
    };
    format!(
        "{time}  {} readings  x{x:8.2} y{y:8.2} z{z:8.2} r{r:7.1} {:6.1} mm/s",
        progress.readings, progress.speed
    )
}
