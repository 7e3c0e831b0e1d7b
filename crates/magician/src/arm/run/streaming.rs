//! Programs that are told while they run.

use super::source::Fed;
use super::{Feeder, Ran, Run, RunOptions};
use crate::arm::Arm;
use crate::preflight::Guards;
use crate::{Progress, Result};

/// Commands that a [`Feeder`] tells while they run, from [`Arm::stream`].
#[derive(Debug)]
#[must_use = "it only runs while it is waited for"]
pub struct Streaming {
    run: Run<Fed>,
    guards: Guards,
}

impl Arm {
    /// A program that is told command by command while it runs, and may have no end. The arm does not wait between commands as
    /// long as the feeder does not: it is told up to `ahead` commands that the arm has not finished.
    ///
    /// Each command is checked ([`RunOptions::guards`]) as those before it leave the arm, and sent as room and horizon allow. One
    /// that is refused ends the program: those before it are done, and [`Streaming::wait`] returns why, with the
    /// [step](crate::Error::step). While the feeder has nothing, the arm finishes what it has and stands; a laser that a
    /// command switched on goes dark then, and comes on again with the next command. One that burns before, or is lit through
    /// its pins, would burn on: that is refused.
    ///
    /// ```
    /// use magician::{Arm, RunOptions, build};
    ///
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> magician::Result<()> {
    /// # let arm = Arm::connect("sim").await?;
    /// let (feeder, run) = arm.stream(8, RunOptions::default());
    /// let tell = async {
    ///     for nth in 0..20 {
    ///         if !feeder.has_room().await {
    ///             break;
    ///         }
    ///         feeder.push(build::path_to(220.0, nth as f32, 20.0));
    ///     }
    ///     feeder.end();
    /// };
    /// let (ran, ()) = tokio::join!(run.wait(|_| {}), tell);
    /// assert_eq!(ran?.commands, 20);
    /// # Ok(())
    /// # }
    /// ```
    pub fn stream(&self, ahead: usize, options: RunOptions) -> (Feeder, Streaming) {
        let (feeder, fed) = Feeder::new(self, ahead);
        let supply = fed.supply();
        let stops = options.stops.unwrap_or_else(|| self.stops());
        let mut run = Run::new(self, fed, options.unless_stopped_since(stops));
        run.supply = Some(supply);
        let guards = options.guards;
        (feeder, Streaming { run, guards })
    }
}

impl Streaming {
    /// Runs what it is told, and returns when the feeder has ended and the last command has finished; `progress` is called now
    /// and then.
    ///
    /// # Errors
    /// As [`Arm::run_with`] and [`Run::wait`]. It cannot be gone on with.
    pub async fn wait(mut self, progress: impl FnMut(Progress)) -> Result<Ran> {
        let run = &mut self.run;
        run.come().await;
        if let Some(first) = run.pending.front() {
            let (arm, first) = (run.arm.clone(), [*first.command()]);
            arm.permission().check(&first)?;
            // One that burns already would burn on while the feeder has nothing.
            arm.laser().check_off().await?;
            if self.guards.alarms || self.guards.require_homed {
                arm.front_end().check_alarms(&first, self.guards).await?;
            }
            let check = arm.preflight().await?;
            run.checks = Some(check.clone().guards(self.guards));
            self.run = self.run.along(check);
        }
        self.run.wait(progress).await
    }
}
