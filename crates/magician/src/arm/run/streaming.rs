//! Streaming runs: commands pushed by a [`Feeder`] while they run.

use super::source::RunSupply;
use super::{Feeder, Run, RunOptions, RunSummary};
use crate::arm::Arm;
use crate::preflight::Guards;
use crate::{Progress, Result};

/// Run whose commands a [`Feeder`] pushes, from [`Arm::stream`].
#[derive(Debug)]
#[must_use = "it only runs while it is waited for"]
pub struct Streaming {
    run: Run<RunSupply>,
    guards: Guards,
}

impl Arm {
    /// Starts a program that is pushed command by command while it runs, possibly without end.
    ///
    /// The arm does not pause between commands as long as the feeder does not: up to `ahead`
    /// unfinished commands may be pushed.
    ///
    /// Each command is checked ([`RunOptions::guards`]) from the end of those before it, and sent
    /// as room and horizon allow. A refused command ends the program: those before it are done, and
    /// [`Streaming::wait`] returns the error with the [step](crate::Error::step). While the feeder
    /// has nothing, the arm finishes its commands and rests. A laser that a command switched on is
    /// off then, and on again with the next command. A laser that was lit before, or is lit through
    /// its pins, would stay on: that is refused.
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
    /// Runs the pushed commands, and returns when the feeder has ended and the last command has
    /// finished. `progress` is called now and then.
    ///
    /// # Errors
    /// Same as [`Arm::run_with`] and [`Run::wait`]. The run cannot be continued.
    pub async fn wait(mut self, progress: impl FnMut(Progress)) -> Result<RunSummary> {
        let run = &mut self.run;
        run.wait_for_command().await;
        if let Some(first) = run.pending.front() {
            let (arm, first) = (run.arm.clone(), [*first.command()]);
            arm.permission().check(&first)?;
            // A laser lit before would stay on while the feeder has nothing.
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
