//! `demo`: an arm picks and places six cubes, through the same driver, bytes and queue as any other
//! program's, and a picture of where it really went.

mod display;
mod picture;
mod recorder;
mod scene;

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use magician::commands::{
    DeviceTime, DeviceVersion, EndEffectorParams, Pose, PtpCommonParams, PtpJump2Params,
};
use magician::{Arm, Set, SimSpeed, Target, words};
use serde::Serialize;

use super::tools::at_once;
use crate::columns::wrap;
use crate::context::{Context, Sim};
use crate::failure::{Failure, Kind};
use crate::output::Output;
use display::Display;
use recorder::Recorder;
use scene::{CUBES, Errand, LIFT, TOOL, TOP};

/// Speed of the virtual arm's clock unless told.
const SPEED: f64 = 5.0;
/// Share of the set speeds, percent.
const SPEED_RATIO: f32 = 75.0;
/// How long the cup takes to hold a cube, or to let it go.
const GRIP: Duration = Duration::from_millis(300);
/// How far the arm may end up from where it should, mm.
const REACHED: f32 = 0.01;

/// Watch an arm pick and place six cubes, and get a picture of its way
#[derive(Args, Debug)]
#[command(after_help = "\
Without --port it works with a virtual arm inside this process. A real arm moves only with --yes: with a suction cup on \
it, and nothing within its reach but six cubes of 25 mm in a row, or nothing at all.")]
pub(crate) struct Demo {
    /// Speed of the virtual arm: arm seconds per second, 5 unless given, or `max`
    #[arg(long, value_name = "X|max", value_parser = speed)]
    speed: Option<SimSpeed>,
    /// Picture to write
    #[arg(long, value_name = "FILE", default_value = "demo.svg")]
    out: PathBuf,
}

fn speed(text: &str) -> Result<SimSpeed, String> {
    match format!("sim:{text}").parse() {
        Ok(Target::Sim(speed)) => Ok(speed),
        Ok(_) => Err("expected a number above 0, or `max`".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// What a run has come to.
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

/// Settings of the arm that the demonstration changes and puts back.
struct Settings {
    tool: EndEffectorParams,
    jump: PtpJump2Params,
    speed: PtpCommonParams,
}

impl Demo {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let sim = Sim {
            speed: self.speed.unwrap_or(SimSpeed::Times(SPEED)),
            unasked: true,
        };
        let target = context.target(Some(sim))?;
        let is_virtual = matches!(target, Target::Sim(_));
        if !is_virtual && self.speed.is_some() {
            return Err(Failure::usage(
                "--speed is for a virtual arm; a real one has its own",
            ));
        }
        if !is_virtual && !context.global.yes {
            let message = format!("the arm at {target} would move; nothing was sent");
            return Err(Failure::usage(message).hint("clear its reach and give --yes"));
        }
        let mut file = self.create()?;
        let quiet = context.global.json;
        let (summary, drawing) = context.with_arm_at(Some(sim), async |arm, out| {
            self.perform(arm, &target, out, quiet).await
        })?;
        file.write_all(drawing.as_bytes())
            .map_err(|error| self.unwritable(&error))?;
        context.show(&summary, |out| summary.write(out))
    }

    /// The file is there before the arm moves.
    fn create(&self) -> Result<File, Failure> {
        File::create(&self.out).map_err(|error| self.unwritable(&error))
    }

    fn unwritable(&self, error: &std::io::Error) -> Failure {
        Failure::invalid(format!("{} cannot be written: {error}", self.out.display()))
    }

    async fn perform(
        &self,
        arm: &Arm,
        target: &Target,
        out: &mut Output,
        quiet: bool,
    ) -> Result<(Summary, String), Failure> {
        let begun = (arm.get::<DeviceTime>().await?.g_systick, Instant::now());
        let (_, places) = arm.stats().await?;
        let mut display = Display::new(quiet, out, places);
        display.title(&title(arm, target).await?)?;
        display.begin("homing")?;
        arm.home().await?;
        display.end(&arm.get::<Pose>().await?)?;
        let settings = Settings::read(arm).await?;
        let commands = commands();
        check(arm, &commands).await?;
        let mut recorder = Recorder::new(&commands);
        let ran = recorder.run(arm, &commands, &mut display).await;
        let restored = settings.restore(arm).await;
        let ran = ran?;
        restored?;
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
            picture: self.out.display().to_string(),
        };
        confirm(arm, &summary, commands.len()).await?;
        let drawing = picture::draw(
            &recorder.samples(summary.first_index),
            &summary.subtitle(target),
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

/// The whole program, from the settings it needs to the way back home.
fn commands() -> Vec<Set> {
    let mut commands = vec![
        words::tool(TOOL),
        words::jump_height(LIFT as f32, (TOP + LIFT) as f32),
        words::speed(SPEED_RATIO, SPEED_RATIO),
        words::suction(false),
    ];
    for errand in CUBES {
        commands.extend(carry(errand));
    }
    let home = scene::home();
    commands.push(words::jump_to(
        home.x as f32,
        home.y as f32,
        home.z as f32,
        home.r as f32,
    ));
    commands
}

/// Picks a cube and places it.
fn carry(Errand { from, to }: Errand) -> [Set; 6] {
    let above = |(x, y): (f64, f64)| words::jump_to(x as f32, y as f32, TOP as f32, 0.0);
    [
        above(from),
        words::suction(true),
        words::wait(GRIP),
        above(to),
        words::suction(false),
        words::wait(GRIP),
    ]
}

/// Nothing is sent that the arm cannot do.
async fn check(arm: &Arm, commands: &[Set]) -> Result<(), Failure> {
    let mut check = arm.preflight().await?;
    for command in commands {
        check.check(command)?;
    }
    Ok(())
}

/// The arm has done all of it, in one row of indices, without an alarm, and is back.
async fn confirm(arm: &Arm, summary: &Summary, commands: usize) -> Result<(), Failure> {
    let failed = |what: String| Err(Failure::new(Kind::CheckFailed, what));
    let indices = (summary.last_index + 1).saturating_sub(summary.first_index);
    if summary.commands != commands as u64 || indices != commands as u64 {
        let took = summary.commands;
        return failed(format!(
            "the arm took {took} of {commands} commands in {indices} indices"
        ));
    }
    let alarms = arm.alarms().await?;
    if !alarms.is_empty() {
        return failed(format!("alarms stand at the end: {alarms}"));
    }
    let (pose, home) = (arm.get::<Pose>().await?, scene::JOINTS_AT_END);
    let apart = pose
        .joint_angle
        .iter()
        .zip(home)
        .map(|(found, wanted)| (found - wanted).abs());
    if apart.fold(0.0, f32::max) > REACHED {
        return failed(format!(
            "the arm ends at joints {:?}, not at home",
            pose.joint_angle
        ));
    }
    Ok(())
}

impl Settings {
    async fn read(arm: &Arm) -> Result<Self, Failure> {
        Ok(Self {
            tool: arm.get().await?,
            jump: arm.get().await?,
            speed: arm.get().await?,
        })
    }

    async fn restore(self, arm: &Arm) -> Result<(), Failure> {
        for command in [
            self.tool.into(),
            self.jump.into(),
            self.speed.into(),
            words::pump_off(),
        ] {
            at_once(arm, &command).await?;
        }
        Ok(())
    }
}

/// Both are of the arm's clock, which wraps.
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
