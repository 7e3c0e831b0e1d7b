//! `demo`: an arm picks and places six cubes over the regular driver and queue, and a picture shows
//! the path it really took.

mod display;
mod picture;
mod place;
mod program;
mod recorder;
mod scene;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use magician::commands::{DeviceTime, DeviceVersion, EndEffectorParams, Pose};
use magician::sim::Controller;
use magician::{Arm, SimSpeed, Target, VirtualArm, build};
use magician_job::{Job, JobSpec, NoJournal};
use serde::Serialize;

use crate::columns::wrap;
use crate::context::{Context, Sim, StopPolicy, Taken};
use crate::failure::Failure;
use crate::output::Output;
use crate::saved::SavedSettings;
use display::Display;
use place::PictureFile;
use recorder::{ARM_PAUSE, PAUSE, Recorder};
use scene::CUBES;

/// Default speed of the virtual arm's clock, as a factor of real time.
const SPEED: f64 = 5.0;
/// Pick and place six cubes, and write a picture of the motion
#[derive(Args, Debug)]
#[command(after_help = "\
Without --port it uses a virtual arm inside this process. A real arm moves only with --yes: mount a \
suction cup, and leave nothing within its reach except six cubes of 25 mm in a row, or nothing at \
all.")]
pub(crate) struct Demo {
    /// Speed of the virtual arm as a multiple of real time, or `max` [default: 5]
    #[arg(long, value_name = "X|max", value_parser = speed)]
    speed: Option<SimSpeed>,
    /// Picture to write
    #[arg(long, alias = "out", value_name = "FILE", default_value = "demo.svg")]
    picture: PathBuf,
}

fn speed(text: &str) -> Result<SimSpeed, String> {
    match format!("sim:{text}").parse() {
        Ok(Target::Sim(speed)) => Ok(speed),
        Ok(_) => Err("expected a number above 0, or `max`".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// Result of a run.
#[derive(Serialize)]
struct Summary {
    port: String,
    cubes: usize,
    commands: u64,
    first_index: u64,
    last_index: u64,
    poses: usize,
    arm_seconds: f64,
    seconds: f64,
    picture: String,
}

impl Demo {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let sim = Sim {
            speed: self.speed.unwrap_or(SimSpeed::Times(SPEED)),
            taken: Taken::Unasked,
        };
        let target = context.target(Some(sim))?;
        let is_virtual = matches!(target, Target::Sim(_));
        if !is_virtual && self.speed.is_some() {
            return Err(Failure::usage("--speed is for a virtual arm only"));
        }
        if !is_virtual && !context.global.yes {
            let message = format!("the arm at {target} would move; nothing was sent");
            return Err(Failure::usage(message).hint("clear its reach and give --yes"));
        }
        if let Target::Sim(SimSpeed::Max) = target {
            // At full speed the motion would be over between two readings. In virtual time the arm
            // waits for the readings, which then show its path.
            let arm = VirtualArm::new(Controller::default(), SimSpeed::Times(1.0));
            context.put_up_in_arm_time(arm);
        }
        let place = PictureFile::open(&self.picture)?;
        let quiet = context.global.json;
        let saved = context.saved.clone();
        let (summary, drawing) = context.arm_or(sim, StopPolicy::Move, async |arm, out| {
            self.perform(arm, &target, out, quiet, &saved).await
        })?;
        place.fill(&drawing)?;
        context.show(&summary, |out| summary.write(out))
    }

    async fn perform(
        &self,
        arm: &Arm,
        target: &Target,
        out: &mut Output,
        quiet: bool,
        saved: &SavedSettings,
    ) -> Result<(Summary, String), Failure> {
        let begun = (arm.get::<DeviceTime>().await?.g_systick, Instant::now());
        let (_, places) = arm.stats().await?;
        let mut display = Display::new(quiet, out, places);
        display.title(&title(arm, target).await?)?;
        display.begin("homing")?;
        arm.home().await?;
        display.end(&arm.get::<Pose>().await?)?;
        let commands = program::commands();
        let pause = match target {
            Target::Sim(SimSpeed::Max) => ARM_PAUSE,
            _ => PAUSE,
        };
        let mut recorder = Recorder::new(&commands, pause);
        // The program sets the tool by a command, which a job does not undo; saved here, it is
        // restored.
        saved.save(arm, arm.get::<EndEffectorParams>().await?).await;
        let spec = JobSpec::new(program::program(&commands)).saved(saved.clone());
        let job = Job::start(arm, spec, NoJournal);
        let ran = recorder.watch(arm, &job, &mut display).await?.ran;
        arm.set_any(&build::pump_off()).await?;
        display.finish();
        let summary = Summary {
            port: arm.name().to_owned(),
            cubes: CUBES.len(),
            commands: ran.commands,
            first_index: ran.first.map_or(0, |index| index.0),
            last_index: ran.last.map_or(0, |index| index.0),
            poses: recorder.count(),
            arm_seconds: arm_seconds(begun.0, arm.get::<DeviceTime>().await?.g_systick),
            seconds: begun.1.elapsed().as_secs_f64(),
            picture: self.picture.display().to_string(),
        };
        program::confirm(arm, &ran, commands.len()).await?;
        let drawing = picture::draw(
            recorder.samples(summary.first_index),
            summary.subtitle(target),
        );
        Ok((summary, drawing))
    }
}

async fn title(arm: &Arm, target: &Target) -> Result<String, Failure> {
    let version = arm.get::<DeviceVersion>().await?;
    let (_, places) = arm.stats().await?;
    let kind = match target {
        Target::Sim(_) => "virtual arm ready",
        _ => "arm ready",
    };
    let numbers = [
        version.major_version,
        version.minor_version,
        version.revision,
    ];
    let [major, minor, revision] = numbers;
    Ok(format!(
        "{kind}: Magician, firmware {major}.{minor}.{revision}, queue {places}"
    ))
}

/// Seconds between two readings of the arm's clock, a 32-bit count of milliseconds that wraps.
fn arm_seconds(from_ms: u32, to_ms: u32) -> f64 {
    f64::from(to_ms.wrapping_sub(from_ms)) / 1000.0
}

impl Summary {
    fn times(&self, target: &Target) -> String {
        let (arm, wall) = (self.arm_seconds, self.seconds);
        match target {
            Target::Sim(SimSpeed::Times(times)) => {
                format!("{arm:.1} s of arm time in {wall:.1} s ({times}x)")
            }
            Target::Sim(SimSpeed::Max) => format!("{arm:.1} s of arm time in {wall:.1} s"),
            _ => format!("{wall:.1} s"),
        }
    }

    fn subtitle(&self, target: &Target) -> String {
        let kind = match target {
            Target::Sim(_) => "A virtual Dobot Magician",
            _ => "A Dobot Magician",
        };
        let (commands, poses) = (self.commands, self.poses);
        let times = self.times(target);
        format!(
            "{kind}: {commands} commands, {times}. Drawn from {poses} readings of GetPose during the run."
        )
    }

    fn write(&self, out: &mut Output) -> Result<(), Failure> {
        let (arm, wall) = (self.arm_seconds, self.seconds);
        let faster = arm / wall.max(1e-3);
        let done = format!(
            "done: {} commands, {arm:.1} s of arm time in {wall:.1} s ({faster:.1}x), every index confirmed, no alarms",
            self.commands
        );
        for line in wrap(&done, out.width().saturating_sub(2)) {
            out.line(format_args!("  {line}"))?;
        }
        out.line(format_args!(
            "  picture: {} (path from above and from the side)",
            self.picture
        ))
    }
}
