//! Streams a path of many segments, prints the progress, pauses on the way and resumes.
//!
//! `cargo run -p magician-job --example path -- PORT`: `sim`, `/dev/ttyUSB0`, `COM3`,
//! `udp:192.168.1.5`. The arm moves: keep clear of it. The tip stays at z = 20 mm and above.

use magician::{Arm, build};
use magician_job::{Job, JobEvent, JobSpec, JobState, NoJournal, PauseReason};
use magician_program::{Action, Origin, Plan, Program, Travel};

/// A spiral of `segments` segments.
fn spiral(segments: u32) -> Plan {
    let mut plan = Plan::new("a spiral");
    plan.push(build::path_speed(100.0, 100.0), Origin::NONE);
    plan.push(
        Action::Move {
            to: [240.0, 0.0, 20.0, 0.0],
            by: Travel::Line,
        },
        Origin::NONE,
    );
    for segment in 1..=segments {
        let angle = segment as f32 * 0.05;
        let radius = 0.1 * angle;
        plan.push(
            Action::Path {
                to: [240.0 + radius * angle.cos(), radius * angle.sin(), 20.0],
            },
            Origin::NONE,
        );
    }
    plan
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn std::error::Error>> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let arm = Arm::connect(port).await?;
    arm.home().await?;

    let job = Job::start(
        &arm,
        JobSpec::new(Program::new(spiral(6000), Some(1))),
        NoJournal,
    );
    let mut events = job.events();
    let (mut shown, mut was_paused) = (0, false);
    while let Some(event) = events.next().await {
        match event {
            JobEvent::Progress(progress) => {
                let steps = progress.steps.expect("it is done once");
                let percent = 100 * progress.step / steps;
                if percent >= shown + 10 {
                    shown = percent;
                    println!(
                        "{percent} %, {:.0?} left",
                        progress.remaining.unwrap_or_default()
                    );
                }
                if percent >= 50 && !was_paused {
                    was_paused = true;
                    // The call makes the request; an event reports when the job is paused.
                    drop(job.pause(PauseReason::Person));
                }
            }
            JobEvent::State(JobState::Paused { .. }) => {
                // The arm may be moved meanwhile: the job returns to its place.
                let pose = arm.pose().await?;
                println!("paused at x {:.1} y {:.1}; going on", pose.x, pose.y);
                job.resume().await?;
            }
            JobEvent::State(state) => println!("{}", state.name()),
            _ => {}
        }
    }
    let done = job.outcome().await?;
    println!("{} steps in {:.1} s", done.steps, done.seconds);
    Ok(())
}
