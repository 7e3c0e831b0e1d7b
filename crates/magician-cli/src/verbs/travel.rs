//! `move`: makes one motion, checked before anything is sent.

use std::cell::Cell;

use clap::Args;
use magician::preflight::CheckedProgram;
use magician::report::PoseReport;
use magician::{Arm, QueueIndex, RunOptions, Set, ToolBias, build, commands};
use magician_program::Travel;
use serde::Serialize;
use tokio::sync::Notify;

use super::pose::ShowPose;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::options::number;
use crate::progress::announce_wait;
use crate::saved::SavedSettings;

/// Largest deviation from the target of an arm that counts as there, mm and deg.
const TARGET_TOLERANCE: f64 = 0.1;

/// Move to a pose and wait for arrival
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician move 220 40 30              all joints together, rotation unchanged
  magician move 220 40 30 0 --linear   in a straight line
  magician move --relative 0 0 -10     down by 10 mm
  magician move --joints 0 45 45 0     joint angles J1 J2 J3 J4

A target out of reach is refused before anything is sent.")]
pub(crate) struct Move {
    /// x in mm, or J1 in degrees
    #[arg(allow_negative_numbers = true, value_parser = number::<f32>)]
    x: f32,
    /// y in mm, or J2
    #[arg(allow_negative_numbers = true, value_parser = number::<f32>)]
    y: f32,
    /// z in mm, or J3
    #[arg(allow_negative_numbers = true, value_parser = number::<f32>)]
    z: f32,
    /// Rotation in degrees, or J4; unchanged if omitted
    #[arg(allow_negative_numbers = true, value_parser = number::<f32>)]
    r: Option<f32>,
    /// Move in a straight line
    #[arg(long)]
    linear: bool,
    /// Jump: up, across and down
    #[arg(long, conflicts_with_all = ["linear", "relative"])]
    jump: bool,
    /// Interpret the numbers as joint angles
    #[arg(long)]
    joints: bool,
    /// Interpret the numbers as offsets from the current position
    #[arg(long)]
    relative: bool,
    /// Speed ratio of this move in percent, 1 to 100 [default: the arm's setting]
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    speed_ratio: Option<f32>,
    /// Tool that the pose refers to: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm;
    /// it stays set on the arm
    #[arg(long, value_name = "NAME|X,Y,Z", allow_hyphen_values = true)]
    tool: Option<ToolBias>,
    /// Return as soon as the arm has queued the command
    #[arg(long)]
    no_wait: bool,
    /// First run the commands that an earlier program left in the queue
    #[arg(long)]
    keep: bool,
}

fn percent(text: &str) -> Result<f32, String> {
    let value = text.trim_end_matches('%').parse::<f32>().ok();
    value
        .filter(|value| (1.0..=100.0).contains(value))
        .ok_or_else(|| "expected 1 to 100 percent".to_owned())
}

#[derive(Serialize)]
struct QueuedMove {
    index: u64,
}

impl Move {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        if self.joints && self.relative && self.linear {
            let message = "the arm has no linear move by relative joint angles";
            return Err(Failure::usage(message));
        }
        if self.keep {
            context.permit_queue()?;
        }
        let quiet = context.global.json;
        let saved = context.saved.clone();
        if self.no_wait {
            let index = context
                .arm(StopPolicy::HandOver, async |arm, _| {
                    self.start_without_wait(arm, &saved).await
                })?
                .0;
            return context.show(&QueuedMove { index }, |out| {
                out.line(format_args!("index {index}"))
            });
        }
        let pose = context.arm(StopPolicy::Move, async |arm, _| {
            self.run_move(arm, quiet, &saved).await
        })?;
        let answer = PoseReport::from(pose);
        context.show(&answer, |out| {
            out.line(format_args!("there: {}", answer.line()))
        })
    }

    /// Moves, and verifies that the arm is at its target.
    async fn run_move(
        &self,
        arm: &Arm,
        quiet: bool,
        saved: &SavedSettings,
    ) -> Result<commands::Pose, Failure> {
        let program = self.plan(arm, saved).await?;
        let end = { program.end() }.map(|end| [end.pose.x, end.pose.y, end.pose.z]);
        let mut run = arm.start_checked(program, RunOptions::default().keep(self.keep));
        announce_wait(quiet, "moving", run.wait(|_| {})).await?;
        saved.forget();
        let pose = arm.get::<commands::Pose>().await?;
        let found = [pose.x, pose.y, pose.z].map(f64::from);
        match end {
            Some(end) if (0..3).any(|at| (found[at] - end[at]).abs() > TARGET_TOLERANCE) => {
                let [x, y, z] = found;
                Err(Failure::unexpected(format!(
                    "the arm stands at x {x:.2} y {y:.2} z {z:.2}, not at its target: another \
                        program or the arm stopped the move early"
                )))
            }
            _ => Ok(pose),
        }
    }

    /// Starts the move and reports its queue index.
    async fn start_without_wait(
        &self,
        arm: &Arm,
        saved: &SavedSettings,
    ) -> Result<QueueIndex, Failure> {
        let program = self.plan(arm, saved).await?;
        let (taken, last) = (Notify::new(), Cell::new(QueueIndex(0)));
        let mut run = arm.start_checked(program, RunOptions::default().keep(self.keep));
        let run = run.wait(|progress| {
            last.set(progress.last);
            if Some(progress.sent) == progress.total {
                taken.notify_one();
            }
        });
        tokio::select! {
            biased;
            () = taken.notified() => (),
            ran = run => drop(ran?),
        }
        saved.forget();
        Ok(last.get())
    }

    /// Returns the checked commands of the move.
    async fn plan(&self, arm: &Arm, saved: &SavedSettings) -> Result<CheckedProgram, Failure> {
        arm.laser().check_off().await?;
        let pose = arm.front_end().known_pose().await?;
        let mut commands = Vec::new();
        if let Some(bias) = self.tool {
            commands.push(build::tool(bias));
        }
        let travel = self.travel(&pose);
        let before = match self.speed_ratio {
            Some(_) => Some(arm.get::<commands::PtpCommonParams>().await?),
            None => None,
        };
        match (self.speed_ratio, before) {
            (Some(ratio), Some(before)) => {
                commands.extend([build::speed(ratio, ratio), travel, before.into()]);
            }
            _ => commands.push(travel),
        }
        let mut program = CheckedProgram::begin(arm.preflight_for(&commands).await?);
        for command in &commands {
            program.add(command)?;
        }
        if let Some(before) = before {
            saved.save(arm, before).await;
        }
        Ok(program)
    }

    fn travel(&self, now: &commands::Pose) -> Set {
        let [.., j4] = now.joint_angle;
        let kept = match (self.relative, self.joints) {
            (true, _) => 0.0,
            (false, true) => j4,
            (false, false) => now.r,
        };
        let to = [self.x, self.y, self.z, self.r.unwrap_or(kept)];
        let by = match (self.linear, self.jump) {
            (true, _) => Travel::Line,
            (false, true) => Travel::Jump,
            (false, false) => Travel::Joints,
        };
        match (self.joints, self.relative) {
            (false, false) => by.to_pose(to),
            (true, false) => by.to_joints(to),
            (false, true) => {
                let [x, y, z, r] = to;
                if self.linear {
                    build::line_by(x, y, z, r)
                } else {
                    build::move_by(x, y, z, r)
                }
            }
            (true, true) => {
                let [j1, j2, j3, j4] = to;
                build::move_joints_by(j1, j2, j3, j4)
            }
        }
    }
}
