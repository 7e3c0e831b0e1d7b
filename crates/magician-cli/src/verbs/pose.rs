use std::io::{IsTerminal, Write};
use std::time::Duration;

use clap::Args;
use magician::commands;
use serde::Serialize;

use crate::columns::Columns;
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Output;

/// Show where the arm is: tool position and joint angles
#[derive(Args, Debug)]
pub(crate) struct Pose {
    /// Go on showing it until Ctrl-C
    #[arg(long)]
    watch: bool,
    /// How often, with --watch
    #[arg(long, value_name = "HZ", default_value_t = 10.0, requires = "watch", value_parser = rate)]
    rate: f64,
}

/// A pose as JSON has it.
#[derive(Serialize)]
pub(crate) struct Answer {
    x: f32,
    y: f32,
    z: f32,
    r: f32,
    j1: f32,
    j2: f32,
    j3: f32,
    j4: f32,
}

impl From<commands::Pose> for Answer {
    fn from(pose: commands::Pose) -> Self {
        let [j1, j2, j3, j4] = pose.joint_angle;
        let commands::Pose { x, y, z, r, .. } = pose;
        Self {
            x,
            y,
            z,
            r,
            j1,
            j2,
            j3,
            j4,
        }
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse::<f64>().ok();
    rate.filter(|rate| (0.01..=1000.0).contains(rate))
        .ok_or_else(|| "expected 0.01 to 1000 times a second".to_owned())
}

impl Pose {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let json = context.global.json;
        context.with_arm(async |arm, out| {
            if !self.watch {
                let answer = Answer::from(arm.get::<commands::Pose>().await?);
                return if json {
                    out.json(&answer)
                } else {
                    answer.write(out)
                };
            }
            let mut ticks = tokio::time::interval(Duration::from_secs_f64(1.0 / self.rate));
            ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
            let live = !json && std::io::stdout().is_terminal();
            loop {
                ticks.tick().await;
                let answer = Answer::from(arm.get::<commands::Pose>().await?);
                match (json, live) {
                    (true, _) => out.json(&answer)?,
                    (false, true) => write!(out, "\r{}\x1b[K", answer.line())?,
                    (false, false) => out.line(answer.line())?,
                }
                out.flush()?;
            }
        })
    }
}

impl Answer {
    /// Aligned lines.
    pub(crate) fn write(&self, out: &mut Output) -> Result<(), Failure> {
        let mut columns = Columns::default();
        let place = [
            ("x", self.x, "mm"),
            ("y", self.y, "mm"),
            ("z", self.z, "mm"),
            ("r", self.r, "deg"),
        ];
        let joints = [
            ("j1", self.j1),
            ("j2", self.j2),
            ("j3", self.j3),
            ("j4", self.j4),
        ];
        for ((name, value, unit), (joint, angle)) in place.into_iter().zip(joints) {
            let (value, angle) = (format!("{value:9.3}"), format!("{angle:9.3}"));
            columns.row([name, &value, &format!("{unit:<5}"), joint, &angle, "deg"]);
        }
        columns.write(out)
    }

    /// One line.
    pub(crate) fn line(&self) -> String {
        let place = format!(
            "x {:8.2}  y {:8.2}  z {:8.2}  r {:8.2}",
            self.x, self.y, self.z, self.r
        );
        let (j1, j2, j3, j4) = (self.j1, self.j2, self.j3, self.j4);
        format!("{place}   j1 {j1:7.2}  j2 {j2:7.2}  j3 {j3:7.2}  j4 {j4:7.2}")
    }
}
