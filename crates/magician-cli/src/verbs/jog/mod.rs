//! `jog`: a pad for the arm on the terminal, or a single checked step.

mod console;
mod pad;
mod side_panel;
#[cfg(test)]
mod tests;
mod view;
mod wording;

use std::io::{self, IsTerminal};

use clap::Args;
use magician::report::PoseReport;
use magician::{Arm, SimSpeed, commands};
use magician_job::jog::Axis;

use super::pose::ShowPose;
use super::rail::needs_rail;
use crate::context::{Context, Sim, StopPolicy, VirtualArmUse};
use crate::failure::Failure;
use crate::options::number;
use crate::output::Output;
use crate::progress::announce_wait;
use crate::saved::SavedSettings;
use crate::terminal::{self, FullScreen};

pub(super) use console::{Console, ConsoleEvent, End, next_of, title};
pub(super) use pad::{KeyEffect, Pad, Tone};
pub(super) use side_panel::{COMPACT_ROWS, compact_panel, side_panel};
#[cfg(test)]
pub(super) use tests::examples;
use view::Model;
pub(super) use view::{MOVES, alarm_panel, foot, joint_bars, log_panel, tool_lines};

/// Move the arm with keys, or by one step: `jog x 10`
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician jog             interactive: arrows move the arm, ? lists the keys
  magician jog z 10        10 mm straight up, and wait for arrival
  magician jog j1 -5       turn the base by -5 degrees

In the interactive display a key press is a checked step; `m` switches to hold mode: the arm moves \
while a key is held. It stops when the key is released, when the terminal loses the focus or is \
closed, and when this program ends. But if the program is killed (`kill -9`), or the computer or the \
cable fails, the arm moves on to the end of its axis. Most terminals report no key releases, only \
repeats: there a tap moves the arm briefly, and a held key moves it until 0.3 s after the last \
repeat. This is not a safety function: in an emergency use the arm's power switch.")]
pub(crate) struct Jog {
    /// Axis: x, y, z, r, j1 to j4, or l for the rail
    #[arg(requires = "distance")]
    axis: Option<Axis>,
    /// Distance in mm or degrees
    #[arg(allow_negative_numbers = true, value_parser = number::<f32>)]
    distance: Option<f32>,
}

/// A pad's virtual arm runs in real time, so that the user can watch it.
pub(super) const REAL_TIME_ARM: Sim = Sim {
    speed: SimSpeed::Times(1.0),
    condition: VirtualArmUse::Named,
};

impl Jog {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        match (self.axis, self.distance) {
            (Some(axis), Some(by)) => step(axis, by, context),
            _ => run_pad(context),
        }
    }
}

/// Makes one step, checked before anything is sent.
fn step(axis: Axis, by: f32, context: &mut Context) -> Result<(), Failure> {
    let quiet = context.global.json;
    let pose = context.arm(StopPolicy::Move, async |arm, _| {
        arm.laser().check_off().await?;
        if axis == Axis::L {
            needs_rail(arm).await?;
        }
        let command = [axis.step(by)];
        announce_wait(quiet, "moving", arm.run(&command)).await?;
        Ok(arm.get::<commands::Pose>().await?)
    })?;
    let answer = PoseReport::from(pose);
    context.show(&answer, |out| {
        out.line(format_args!("there: {}", answer.line()))
    })
}

fn run_pad(context: &mut Context) -> Result<(), Failure> {
    check_interactive("jog", "`magician jog x 10` makes one step")?;
    let saved = context.saved.clone();
    let json = context.global.json;
    let pose = context.arm_or(REAL_TIME_ARM, StopPolicy::Pad, async |arm, out| {
        session(arm, &saved, out, json).await
    })?;
    let answer = PoseReport::from(pose);
    context.show(&answer, |out| {
        out.line(format_args!("left at: {}", answer.line()))
    })
}

/// Fails unless a user at a terminal can hold keys.
pub(super) fn check_interactive(what: &str, without: &str) -> Result<(), Failure> {
    if !io::stdin().is_terminal() {
        let message = format!("{what} needs a keyboard, and stdin is not a terminal");
        return Err(Failure::usage(message).hint(without));
    }
    terminal::check(what, without)
}

async fn session(
    arm: &Arm,
    saved: &SavedSettings,
    out: &mut Output,
    json: bool,
) -> Result<commands::Pose, Failure> {
    let mut console = Console::open(arm, saved).await?;
    let mut stage = FullScreen::open(view::draw)?;
    let end = loop {
        stage.show(Model {
            observed: console.observed.clone(),
            pad: console.pad.clone(),
        });
        let event = console.next(&mut stage).await?;
        let end = match event {
            ConsoleEvent::Key(key) => {
                let reply = console.pad.key(key, console.now());
                console.carry_out(reply)
            }
            other => console.handle_background(&other),
        };
        if let Some(end) = end {
            break end;
        }
    };
    stage.close()?;
    console.leave(end, out, json).await?;
    Ok(arm.get::<commands::Pose>().await?)
}
