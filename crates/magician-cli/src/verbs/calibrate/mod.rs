//! `calibrate`: finds the position of the paper, the height of the surface or the bias of the tool
//! from points that its tip touches.

mod answer;
mod known;
mod paper;
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
use self::known::Part;
use self::session::Outcome;
use self::subject::{Found, Subject, Touch};
use super::jog::{AT_SIGHT, for_a_person};
use crate::config::Config;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::mounted::usual_tool;
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
    deed: Deed,
}

#[derive(Debug, Subcommand)]
enum Deed {
    /// Measure the sheet: touch its lower left, lower right and upper left corners, seen with the
    /// arm's X axis pointing right
    Sheet {
        /// Use these three corners (x, y, z of the tool in mm) instead of touching
        #[arg(long, num_args = 3, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
        points: Option<Vec<[f64; 3]>>,
        #[command(flatten)]
        mounted: Mounted,
    },
    /// Measure the height of a level surface: touch it once
    Surface {
        /// Use this height (z of the tool in mm) instead of touching
        #[arg(long, value_name = "Z", allow_hyphen_values = true, value_parser = number::<f64>)]
        height: Option<f64>,
        #[command(flatten)]
        mounted: Mounted,
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
        mounted: Mounted,
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
struct Mounted {
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
        match self.deed {
            Deed::Sheet { points, mounted } => {
                let points = points.map(|points| points.into_iter().map(Touch::of_point).collect());
                find(Subject::Sheet, points, mounted, false, context)
            }
            Deed::Surface { height, mounted } => {
                let points = height.map(|z| vec![Touch::of_point([0.0, 0.0, z])]);
                find(Subject::Surface, points, mounted, false, context)
            }
            Deed::Tool {
                poses,
                tell,
                mounted,
            } => {
                let poses = poses.map(|poses| poses.into_iter().map(Touch::of_turn).collect());
                find(Subject::Tool, poses, mounted, tell, context)
            }
            Deed::Show => known::show(context),
            Deed::Forget { part } => known::forget(part, context),
        }
    }
}

/// Finds the subject's position, shows it, and saves it if wanted.
fn find(
    subject: Subject,
    given: Option<Vec<Touch>>,
    mounted: Mounted,
    tell: bool,
    context: &mut Context,
) -> Result<(), Failure> {
    let usual = usual_tool(&*context.config()?)?;
    let (found, tool, saves) = match given {
        Some(touches) => {
            let tool = tool_of_points(subject, mounted, usual, context)?;
            let found = subject.found(&touches, tool).map_err(wrong)?;
            let saves = context.global.yes;
            (found, tool, if saves { Saves::Yes } else { Saves::Asks })
        }
        None => {
            let way = subject.without_a_terminal();
            for_a_person(&format!("calibrate {}", subject.name()), way)?;
            let (outcome, tool) = at_the_pad(subject, mounted, usual, context)?;
            let Some(Outcome { found, saves }) = outcome else {
                let nothing = Nothing { saved: false };
                return context.show(&nothing, |out| out.line("nothing was saved"));
            };
            (found, tool, if saves { Saves::Yes } else { Saves::No })
        }
    };
    let mut answer = CalibrationReport::new(&found, tool);
    // The result is shown before the question whether to save it.
    if !context.global.json {
        answer.write(&mut context.out)?;
        context.out.flush()?;
    }
    let saves = match saves {
        Saves::Asks => asks(context.global.json)?,
        other => other == Saves::Yes,
    };
    if saves {
        let mut config = Config::load()?;
        found.keep(&mut config)?;
        answer.saved = true;
        // Sheet and surface were touched with the old tool.
        if subject == Subject::Tool {
            answer.stale = ["sheet", "surface"]
                .into_iter()
                .filter(|name| config.says(name).is_some())
                .collect();
        }
        answer.sheet_counts = subject == Subject::Surface && config.says("sheet").is_some();
        answer.file = config.path().map(|path| path.display().to_string());
    }
    if let (Found::Tip(tip), true) = (&found, tell) {
        let command = build::tool(tip.bias);
        context.arm(StopPolicy::Order, async |arm, _| {
            Ok(arm.set_any(&command).await?)
        })?;
        answer.told = Some(true);
    }
    if context.global.json {
        context.out.json(&answer)
    } else {
        answer.write_end(subject, &mut context.out)
    }
}

/// Answer of a session that was left without a result.
#[derive(Serialize)]
struct Nothing {
    saved: bool,
}

/// Converts a problem with touched points into a failure with its advice.
fn wrong(problem: Diagnostic) -> Failure {
    let advice = problem.advice(&Command);
    let failure = Failure::invalid(problem.message);
    match advice {
        Some(advice) => failure.hint(advice),
        None => failure,
    }
}

/// Decision about saving.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Saves {
    Yes,
    No,
    /// The user at the terminal decides.
    Asks,
}

/// Asks on the terminal; false without one.
fn asks(json: bool) -> Result<bool, Failure> {
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

/// Returns the tool of points given as numbers. It matters only for the calibration of a tool.
fn tool_of_points(
    subject: Subject,
    mounted: Mounted,
    usual: Option<Tool>,
    context: &mut Context,
) -> Result<Tool, Failure> {
    match (mounted.tool, subject) {
        (Some(tool), _) => Ok(tool),
        (None, Subject::Tool) => context.arm(StopPolicy::Look, async |arm, _| {
            Ok(Tool::from(&arm.get::<EndEffectorParams>().await?))
        }),
        (None, _) => Ok(usual.unwrap_or(Tool::Pen)),
    }
}

/// Lets the user touch the points with the jog pad.
fn at_the_pad(
    subject: Subject,
    mounted: Mounted,
    usual: Option<Tool>,
    context: &mut Context,
) -> Result<(Option<Outcome>, Tool), Failure> {
    let saved = context.saved.clone();
    let asks = !context.global.yes;
    let json = context.global.json;
    context.arm_or(AT_SIGHT, StopPolicy::Pad, async |arm, out| {
        let arm = &homed(arm, mounted.unhomed).await?;
        let tool = tool_in_force(arm, subject, mounted, usual).await?;
        let outcome = session::run(arm, &saved, subject, tool, asks, (out, json)).await?;
        Ok((outcome, tool))
    })
}

/// Returns the tool whose bias is in force on the arm, after setting it if asked. A sheet touched
/// with another tool than the drawing tool would be displaced by the difference of their biases.
async fn tool_in_force(
    arm: &Arm,
    subject: Subject,
    mounted: Mounted,
    usual: Option<Tool>,
) -> Result<Tool, Failure> {
    if let Some(tool) = mounted.tool {
        arm.set_any(&build::tool(tool.bias())).await?;
    }
    let tool = Tool::from(&arm.get::<EndEffectorParams>().await?);
    let draws = usual.unwrap_or(Tool::Pen);
    let is_other = tool.bias() != draws.bias();
    if is_other && mounted.tool.is_none() && subject != Subject::Tool {
        let message = format!(
            "the arm's poses are for the tool {tool}, but drawings use the tool {draws}: the \
                measured position would be wrong"
        );
        return Err(Failure::invalid(message).hint(format!(
            "--tool {draws} sets it on the arm; `magician config set tool NAME` sets the tool \
                that draws"
        )));
    }
    Ok(tool)
}
