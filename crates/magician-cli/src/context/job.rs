//! Runs a job on the arm. The job itself receives the signals and ends its motion in its own way.

use magician::Arm;

use super::Context;
use super::policy::{End, JobPolicy, Rules};
use crate::failure::Failure;
use crate::interrupt::Signals;
use crate::output::Output;

/// End of a job before its completion.
pub(crate) enum JobFailure {
    Failed(Failure),
    /// The job was stopped by a signal, a key or a typed line.
    Interrupted {
        failure: Failure,
        /// True if the arm is known to stand still.
        stands: bool,
    },
}

impl<T: Into<Failure>> From<T> for JobFailure {
    fn from(failure: T) -> Self {
        Self::Failed(failure.into())
    }
}

impl Context {
    /// Connects and takes the lease if the arm is at a station.
    async fn connect_leased(&mut self, rules: &Rules) -> Result<Arm, Failure> {
        let arm = self.connect(None, rules).await?;
        self.take_lease().await?;
        Ok(arm)
    }

    /// Runs work that moves the arm, receives signals itself, and restores settings that ended
    /// programs have left changed itself.
    pub(crate) fn job<T>(
        &mut self,
        policy: JobPolicy,
        work: impl AsyncFnOnce(&Arm, &mut Output, &mut Signals) -> Result<T, JobFailure>,
    ) -> Result<T, Failure> {
        self.apply_config()?;
        let runtime = self.runtime()?;
        let rules = policy.rules();
        runtime.block_on(async {
            let mut signals = Signals::listen()?;
            let _time = self.arm_time();
            let connected = tokio::select! {
                connected = self.connect_leased(&rules) => connected,
                _ = signals.next() => Err(self.stop_for_signal(&mut signals).await),
            };
            let arm = match connected {
                Ok(arm) if self.laser_allowed => arm.allowing_laser(),
                Ok(arm) => arm,
                Err(failure) => {
                    self.terminated |= signals.terminates();
                    return Err(failure);
                }
            };
            let ended = work(&arm, &mut self.out, &mut signals).await;
            // The context owns the connection; a clone left alive would keep it open.
            drop(arm);
            self.terminated |= signals.terminates();
            match ended {
                Ok(done) => {
                    self.note_success(rules.end);
                    Ok(done)
                }
                Err(JobFailure::Failed(failure)) => Err(match &self.connected {
                    Some(connected) => connected.explain_failure(failure),
                    None => failure,
                }),
                Err(JobFailure::Interrupted { failure, stands }) => {
                    self.note_success(End::Standing);
                    self.disconnect_after_stop(stands).await;
                    Err(failure)
                }
            }
        })
    }
}
