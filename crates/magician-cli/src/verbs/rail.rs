//! `rail`: moves the arm along its sliding rail.

use clap::{Args, Subcommand};
use magician::commands::{DeviceWithL, Pose, PoseL, PtpLParams};
use magician::{Arm, RunOptions, Set, build};
use magician_protocol::RailVersion;
use serde::Serialize;

use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::options::number;
use crate::progress::announce_wait;
use crate::saved::SavedSettings;

/// Enable the sliding rail, show its position, or move along it
#[derive(Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
Examples:
  magician rail on               enable the rail on the arm
  magician rail to 350           along the rail to 350 mm; the joints do not move
  magician rail by -50 --speed 80"
)]
pub(crate) struct Rail {
    #[command(subcommand)]
    action: Option<Action>,
}

#[derive(Clone, Copy, Debug, Subcommand)]
enum Action {
    /// Enable the rail on the arm
    On {
        /// Generation of the rail, 1 or 2
        #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=2))]
        version: u8,
    },
    /// Disable the rail on the arm
    Off,
    /// Move to a position on the rail and wait for arrival
    To {
        /// Position in mm, 0 to 1000
        #[arg(allow_negative_numbers = true, value_parser = number::<f32>)]
        place: f32,
        #[command(flatten)]
        how: How,
    },
    /// Move along the rail by a distance and wait for arrival
    By {
        /// Distance in mm
        #[arg(allow_negative_numbers = true, value_parser = number::<f32>)]
        distance: f32,
        #[command(flatten)]
        how: How,
    },
}

#[derive(Args, Clone, Copy, Debug)]
struct How {
    /// Rail speed in mm/s for this move [default: the arm's setting]
    #[arg(long, value_name = "MM/S", value_parser = number::<f32>)]
    speed: Option<f32>,
}

#[derive(Serialize)]
struct RailReport {
    rail: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    l: Option<f32>,
}

impl Rail {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let (quiet, saved) = (context.global.json, context.saved.clone());
        let answer = match self.action {
            None => context.arm(StopPolicy::Look, async |arm, _| read_rail(arm).await)?,
            Some(Action::On { version }) => set_enabled(context, true, version)?,
            Some(Action::Off) => set_enabled(context, false, 2)?,
            Some(Action::To { place, how }) => context.arm(StopPolicy::Move, async |arm, _| {
                let pose = arm.get::<Pose>().await?;
                move_along(arm, build::rail_to(place, &pose), how, quiet, &saved).await
            })?,
            Some(Action::By { distance, how }) => context
                .arm(StopPolicy::Move, async |arm, _| {
                    move_along(arm, build::rail_by(distance), how, quiet, &saved).await
                })?,
        };
        context.show(&answer, |out| match answer.l {
            Some(l) => out.line(format_args!("rail: at {l:.2} mm")),
            None => out.line("rail: not in use; `magician rail on` enables it"),
        })
    }
}

fn set_enabled(context: &mut Context, on: bool, version: u8) -> Result<RailReport, Failure> {
    let command = build::rail(on, RailVersion::from(version.saturating_sub(1)));
    context.arm(StopPolicy::Order, async |arm, _| {
        arm.set_any(&command).await?;
        read_rail(arm).await
    })
}

async fn read_rail(arm: &Arm) -> Result<RailReport, Failure> {
    let rail = arm.get::<DeviceWithL>().await?.with_l.is_on();
    let l = if rail {
        Some(arm.get::<PoseL>().await?.pose_l)
    } else {
        None
    };
    Ok(RailReport { rail, l })
}

/// Fails if the rail is not enabled on the arm: only the joints would move then.
pub(super) async fn needs_rail(arm: &Arm) -> Result<(), Failure> {
    if read_rail(arm).await?.rail {
        return Ok(());
    }
    let message = "the rail is not enabled, so only the joints would move; nothing was sent";
    Err(Failure::invalid(message).hint("`magician rail on` enables it"))
}

/// Moves along the rail, checked before anything is sent.
async fn move_along(
    arm: &Arm,
    travel: Set,
    how: How,
    quiet: bool,
    saved: &SavedSettings,
) -> Result<RailReport, Failure> {
    arm.laser().check_off().await?;
    needs_rail(arm).await?;
    let mut commands = vec![travel];
    if let Some(speed) = how.speed {
        let before = arm.get::<PtpLParams>().await?;
        commands.insert(0, build::rail_speed(speed, before.acceleration));
        commands.push(before.into());
        saved.save(arm, before).await;
    }
    let check = arm.preflight_for(&commands).await?;
    let program = check.program(&commands)?;
    let mut run = arm.start_checked(program, RunOptions::default());
    announce_wait(quiet, "moving along the rail", run.wait(|_| {})).await?;
    saved.forget();
    read_rail(arm).await
}
