//! `calibrate`: finds the position of the paper, the height of the surface or the bias of the tool
//! from points that its tip touches.

mod answer;
mod paper;
mod saved;
mod session;
mod sketch;
mod subject;
mod view;

use std::io::{self, IsTerminal, Write};

use clap::{Args, Subcommand};
use magician::commands::EndEffectorParams;
use magician::{Arm, build};
use magician_program::{Diagnostic, Tool};
use serde::Serialize;

use self::answer::CalibrationReport;
use self::saved::Part;
use self::session::Outcome;
use self::subject::{CalibrationResult, Subject, Touch};
use super::jog::{REAL_TIME_ARM, check_interactive};
use crate::config::Config;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::mounted::mounted_tool;
use crate::numbers::numbers;
use crate::options::number;
use crate::permission::homed;
use crate::voice::Command;

#[cfg(test)]
pub(super) use view::tests::examples;

/// Measure the work surface, the sheet and the tool by touching points
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician calibrate sheet             touch three corners of the paper; drawings are placed on it
  magician calibrate surface           touch the table once: measures only its height
  magician calibrate tool              touch one point twice, turning the tool in between: its bias
  magician calibrate show              show the calibration; `forget` deletes it
  magician calibrate sheet --points 180,-60,-61 300,-60,-61 180,60,-61 --yes

Move the arm to the points by hand with its unlock button, or with the keys of `magician jog`. The \
result is saved in the settings file, which `draw`, `engrave` and `run` read.")]
pub(crate) struct Calibrate {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Measure the sheet: touch its lower left, lower right and upper left corners, seen with the
    /// arm's X axis pointing right
    Sheet {
        /// Use these three corners (x, y, z of the tool in mm) instead of touching
        #[arg(long, num_args = 3, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
        points: Option<Vec<[f64; 3]>>,
        #[command(flatten)]
        mounted: TouchingTool,
    },
    /// Measure the height of a level surface: touch it once
    Surface {
        /// Use this height (z of the tool in mm) instead of touching
        #[arg(long, value_name = "Z", allow_hyphen_values = true, value_parser = number::<f64>)]
        height: Option<f64>,
        #[command(flatten)]
        mounted: TouchingTool,
    },
    /// Measure the bias of the tool: touch one point twice, turning the tool in between
    Tool {
        /// Use these two poses (x, y in mm and r in degrees) instead of touching
        #[arg(long, num_args = 2, value_name = "X,Y,R", allow_hyphen_values = true, value_parser = numbers::<3>)]
        poses: Option<Vec<[f64; 3]>>,
        /// Also set the new bias on the arm
        #[arg(long)]
        tell: bool,
        #[command(flatten)]
        mounted: TouchingTool,
    },
    /// Show the calibration
    Show,
    /// Delete the calibration, or one part of it
    Forget {
        /// Part to delete [default: all]
        #[arg(value_enum)]
        part: Option<Part>,
    },
}

/// The tool that touches.
#[derive(Args, Clone, Copy, Debug)]
struct TouchingTool {
    /// Mounted tool, for touching and drawing: none, suction, gripper, pen, laser, or its bias
    /// X,Y,Z in mm; it stays set on the arm
    #[arg(long, value_name = "NAME|X,Y,Z", allow_hyphen_values = true)]
    tool: Option<Tool>,
    /// Measure even if the arm is not known to be homed; the result may be wrong
    #[arg(long)]
    unhomed: bool,
}

impl Calibrate {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        match self.action {
            Action::Sheet { points, mounted } => {
                let points =
                    points.map(|points| points.into_iter().map(Touch::from_point).collect());
                find(Subject::Sheet, points, mounted, false, context)
            }
            Action::Surface { height, mounted } => {
                let points = height.map(|z| vec![Touch::from_point([0.0, 0.0, z])]);
                find(Subject::Surface, points, mounted, false, context)
            }
            Action::Tool {
                poses,
                tell,
                mounted,
            } => {
                let poses =
                    poses.map(|poses| poses.into_iter().map(Touch::from_rotation).collect());
                find(Subject::Tool, poses, mounted, tell, context)
            }
            Action::Show => saved::show(context),
            Action::Forget { part } => saved::forget(part, context),
        }
    }
}

/// Calibrates `subject`, shows the result, and saves it if the user agrees.
fn find(
    subject: Subject,
    given: Option<Vec<Touch>>,
    mounted: TouchingTool,
    set_on_arm: bool,
    context: &mut Context,
) -> Result<(), Failure> {
    let configured_tool = mounted_tool(&*context.config()?)?;
    let (found, tool, saves) = match given {
        Some(touches) => {
            let tool = tool_of_points(subject, mounted, configured_tool, context)?;
            let found = subject.evaluate(&touches, tool).map_err(touch_failure)?;
            let saves = context.global.yes;
            (
                found,
                tool,
                if saves {
                    SaveDecision::Yes
                } else {
                    SaveDecision::Ask
                },
            )
        }
        None => {
            let hint = subject.without_terminal_hint();
            check_interactive(&format!("calibrate {}", subject.name()), hint)?;
            let (outcome, tool) = touch_at_pad(subject, mounted, configured_tool, context)?;
            let Some(Outcome { found, saves }) = outcome else {
                let nothing = NoResult { saved: false };
                return context.show(&nothing, |out| out.line("nothing was saved"));
            };
            (
                found,
                tool,
                if saves {
                    SaveDecision::Yes
                } else {
                    SaveDecision::No
                },
            )
        }
    };
    let mut report = CalibrationReport::new(&found, tool);
    // The result is shown before the question whether to save it.
    if !context.global.json {
        report.write(&mut context.out)?;
        context.out.flush()?;
    }
    let saves = match saves {
        SaveDecision::Ask => ask_to_save(context.global.json)?,
        other => other == SaveDecision::Yes,
    };
    if saves {
        let mut config = Config::load()?;
        found.keep(&mut config)?;
        report.saved = true;
        // Sheet and surface were touched with the old tool.
        if subject == Subject::Tool {
            report.stale = ["sheet", "surface"]
                .into_iter()
                .filter(|name| config.file_value(name).is_some())
                .collect();
        }
        report.sheet_counts = subject == Subject::Surface && config.file_value("sheet").is_some();
        report.file = config.path().map(|path| path.display().to_string());
    }
    if let (CalibrationResult::Tip(tip), true) = (&found, set_on_arm) {
        let command = build::tool(tip.bias);
        context.arm(StopPolicy::Order, async |arm, _| {
            Ok(arm.set_any(&command).await?)
        })?;
        report.told = Some(true);
    }
    if context.global.json {
        context.out.json(&report)
    } else {
        report.write_end(subject, &mut context.out)
    }
}

/// Answer of a session that was left without a result.
#[derive(Serialize)]
struct NoResult {
    saved: bool,
}

/// Converts a problem with touched points into a failure with its advice.
fn touch_failure(problem: Diagnostic) -> Failure {
    let advice = problem.advice(&Command);
    let failure = Failure::invalid(problem.message);
    match advice {
        Some(advice) => failure.hint(advice),
        None => failure,
    }
}

/// States whether a result is saved to the settings file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SaveDecision {
    Yes,
    No,
    /// The user at the terminal decides.
    Ask,
}

/// Asks on the terminal whether to save the result; false with `--json` or without a terminal.
fn ask_to_save(json: bool) -> Result<bool, Failure> {
    if json || !io::stdin().is_terminal() || !io::stderr().is_terminal() {
        return Ok(false);
    }
    let mut stderr = io::stderr();
    write!(stderr, "save it? y/n ")?;
    stderr.flush()?;
    let mut line = String::new();
    io::stdin().read_line(&mut line)?;
    Ok(matches!(line.trim(), "y" | "Y" | "yes"))
}

/// Returns the tool with which points given on the command line were touched. Only the calibration
/// of a tool depends on it.
fn tool_of_points(
    subject: Subject,
    mounted: TouchingTool,
    configured_tool: Option<Tool>,
    context: &mut Context,
) -> Result<Tool, Failure> {
    match (mounted.tool, subject) {
        (Some(tool), _) => Ok(tool),
        (None, Subject::Tool) => context.arm(StopPolicy::Look, async |arm, _| {
            Ok(Tool::from(&arm.get::<EndEffectorParams>().await?))
        }),
        (None, _) => Ok(configured_tool.unwrap_or(Tool::Pen)),
    }
}

/// Lets the user touch the points with the jog pad.
fn touch_at_pad(
    subject: Subject,
    mounted: TouchingTool,
    configured_tool: Option<Tool>,
    context: &mut Context,
) -> Result<(Option<Outcome>, Tool), Failure> {
    let saved = context.saved.clone();
    let asks = !context.global.yes;
    let json = context.global.json;
    context.arm_or(REAL_TIME_ARM, StopPolicy::Pad, async |arm, out| {
        let arm = &homed(arm, mounted.unhomed).await?;
        let tool = tool_in_force(arm, subject, mounted, configured_tool).await?;
        let outcome = session::run(arm, &saved, subject, tool, asks, (out, json)).await?;
        Ok((outcome, tool))
    })
}

/// Returns the tool whose bias is in force on the arm, after setting it if asked. A sheet touched
/// with another tool than the drawing tool would be displaced by the difference of their biases.
async fn tool_in_force(
    arm: &Arm,
    subject: Subject,
    mounted: TouchingTool,
    configured_tool: Option<Tool>,
) -> Result<Tool, Failure> {
    if let Some(tool) = mounted.tool {
        arm.set_any(&build::tool(tool.bias())).await?;
    }
    let tool = Tool::from(&arm.get::<EndEffectorParams>().await?);
    let drawing_tool = configured_tool.unwrap_or(Tool::Pen);
    let is_other = tool.bias() != drawing_tool.bias();
    if is_other && mounted.tool.is_none() && subject != Subject::Tool {
        let message = format!(
            "the arm's poses are for the tool {tool}, but drawings use the tool {drawing_tool}: the \
                measured position would be wrong"
        );
        return Err(Failure::invalid(message).hint(format!(
            "--tool {drawing_tool} sets it on the arm; `magician config set tool NAME` sets the tool \
                that draws"
        )));
    }
    Ok(tool)
}
