//! `conveyor`: drives a belt on one of the arm's motor outputs.

use clap::{Args, Subcommand};
use magician::build::{CONVEYOR_FARTHEST, conveyor_speed};
use magician::{Set, build};
use magician_protocol::Stepper;
use serde::Serialize;

use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::options::number;
use crate::progress::announce_wait;

/// Run the conveyor belt on a motor output
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician conveyor run 50          50 mm/s until stopped; -50 runs backwards
  magician conveyor by 120          120 mm forward, and wait until the belt has stopped
  magician conveyor stop")]
pub(crate) struct Conveyor {
    #[command(subcommand)]
    action: Action,
    /// Motor output of the conveyor, 1 or 2
    #[arg(long, global = true, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    motor: u8,
}

#[derive(Clone, Copy, Debug, Subcommand)]
enum Action {
    /// Run the belt until it is stopped
    Run {
        /// Speed in mm/s, -120 to 120; the sign is the direction
        #[arg(allow_negative_numbers = true, value_parser = number::<f32>)]
        speed: f32,
    },
    /// Move the belt by a distance and wait until it has stopped
    By {
        /// Distance in mm; the sign is the direction
        #[arg(allow_negative_numbers = true, value_parser = number::<f32>)]
        distance: f32,
        /// Speed in mm/s, up to 120
        #[arg(long, value_name = "MM/S", default_value_t = 50.0, value_parser = number::<f32>)]
        speed: f32,
    },
    /// Stop the belt
    Stop,
}

#[derive(Serialize)]
struct BeltReport {
    motor: u8,
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    distance: Option<f32>,
}

impl Conveyor {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let motor = self.motor;
        let output = Stepper::from(motor.saturating_sub(1));
        let answer = match self.action {
            Action::Run { speed } => {
                let speed = conveyor_speed(speed)?;
                if speed != 0.0 && context.lease_ends_at_once() {
                    let message = "at a station a belt stops when the lease ends, and the lease of \
                        this command ends at once; nothing was sent";
                    return Err(Failure::usage(message).hint(
                        "`magician shell` keeps the lease; `magician conveyor by` ends by itself",
                    ));
                }
                turn(context, motor, output, speed)?
            }
            Action::Stop => turn(context, motor, output, 0.0)?,
            Action::By { distance, speed } => {
                if conveyor_speed(speed)? <= 0.0 {
                    let message = format!("the speed is {speed} mm/s, but must be above 0");
                    return Err(Failure::invalid(message));
                }
                let command = build::conveyor_by(output, checked_distance(distance)?, speed);
                let quiet = context.global.json;
                context.arm(StopPolicy::Move, async |arm, _| {
                    advance(arm, command, quiet).await
                })?;
                BeltReport {
                    motor,
                    speed: None,
                    distance: Some(distance),
                }
            }
        };
        context.show(&answer, |out| match (answer.speed, answer.distance) {
            (Some(speed), _) if speed != 0.0 => {
                out.line(format_args!("conveyor {motor}: running at {speed} mm/s"))
            }
            (_, Some(distance)) => {
                out.line(format_args!("conveyor {motor}: moved by {distance} mm"))
            }
            _ => out.line(format_args!("conveyor {motor}: stopped")),
        })
    }
}

/// Returns the distance if a belt command can express it.
fn checked_distance(distance: f32) -> Result<f32, Failure> {
    if f64::from(distance).abs() <= CONVEYOR_FARTHEST {
        Ok(distance)
    } else {
        Err(Failure::invalid(format!(
            "{distance} mm: limit {CONVEYOR_FARTHEST:.0} mm in either direction"
        )))
    }
}

fn turn(
    context: &mut Context,
    motor: u8,
    output: Stepper,
    speed: f32,
) -> Result<BeltReport, Failure> {
    let command = build::conveyor(output, speed);
    context.arm(StopPolicy::Order, async |arm, _| {
        Ok(arm.set_any(&command).await?)
    })?;
    Ok(BeltReport {
        motor,
        speed: Some(speed),
        distance: None,
    })
}

async fn advance(arm: &magician::Arm, command: Set, quiet: bool) -> Result<(), Failure> {
    let mut run = arm.start([command]);
    announce_wait(quiet, "moving the belt", run.wait(|_| {})).await?;
    Ok(())
}
