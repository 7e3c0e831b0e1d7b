//! `pose`: shows the pose of the arm, once or repeatedly.

use std::io::Write;
use std::time::Duration;

use clap::Args;
use magician::report::PoseReport;
use magician::{Arm, commands};
use tokio::time::MissedTickBehavior;

use crate::columns::Columns;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::output::Output;
use crate::paint::is_terminal_with_escapes;

/// Show the pose: tool position and joint angles
#[derive(Args, Debug)]
pub(crate) struct Pose {
    /// Show the pose continuously until Ctrl-C
    #[arg(long)]
    watch: bool,
    /// With --watch: readings per second, 0.01 to 1000
    #[arg(long, value_name = "HZ", default_value_t = 10.0, requires = "watch", value_parser = rate)]
    rate: f64,
}

pub(super) fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse::<f64>().ok();
    rate.filter(|rate| (0.01..=1000.0).contains(rate))
        .ok_or_else(|| "expected 0.01 to 1000 per second".to_owned())
}

impl Pose {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let json = context.global.json;
        context.arm(StopPolicy::Look, async |arm, out| {
            if self.watch {
                return self.print_repeatedly(arm, json, out).await;
            }
            let answer = PoseReport::from(arm.get::<commands::Pose>().await?);
            if json {
                out.json(&answer)
            } else {
                answer.write(out)
            }
        })
    }

    async fn print_repeatedly(
        &self,
        arm: &Arm,
        json: bool,
        out: &mut Output,
    ) -> Result<(), Failure> {
        let mut ticks = tokio::time::interval(Duration::from_secs_f64(1.0 / self.rate));
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut next = async || {
            ticks.tick().await;
            let pose = arm.get::<commands::Pose>().await?;
            Ok::<_, Failure>(PoseReport::from(pose))
        };
        if !json && is_terminal_with_escapes(&std::io::stdout()) {
            let mut live = LiveLine(out);
            loop {
                live.show(&next().await?.line())?;
            }
        }
        loop {
            let answer = next().await?;
            if json {
                out.json(&answer)?;
            } else {
                out.line(answer.line())?;
            }
            out.flush()?;
        }
    }
}

/// Formats of a pose for people.
pub(crate) trait ShowPose {
    /// Writes aligned lines.
    fn write(&self, out: &mut Output) -> Result<(), Failure>;
    /// Returns one line of less than 80 columns.
    fn line(&self) -> String;
}

impl ShowPose for PoseReport {
    fn write(&self, out: &mut Output) -> Result<(), Failure> {
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

    fn line(&self) -> String {
        let (x, y, z, r) = (self.x, self.y, self.z, self.r);
        let (j1, j2, j3, j4) = (self.j1, self.j2, self.j3, self.j4);
        format!("x{x:8.2} y{y:8.2} z{z:8.2} r{r:8.2}  j{j1:7.1}{j2:7.1}{j3:7.1}{j4:7.1}")
    }
}

/// Line that is rewritten in place; dropping it ends the line.
struct LiveLine<'o>(&'o mut Output);

impl LiveLine<'_> {
    fn show(&mut self, line: &str) -> Result<(), Failure> {
        write!(self.0, "\r{line}\x1b[K")?;
        self.0.flush()
    }
}

impl Drop for LiveLine<'_> {
    fn drop(&mut self) {
        // The reader is gone, and `drop` cannot report it.
        let _ = self.0.line("").and_then(|()| self.0.flush());
    }
}
