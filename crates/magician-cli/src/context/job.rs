//! Running a job on the arm: the job hears signals itself and ends by itself.

use magician::Arm;

use super::Context;
use super::policy::{End, JobPolicy, Rules};
use crate::failure::Failure;
use crate::interrupt::Signals;
use crate::output::Output;

/// How a job ended that has not come to its good end.
pub(crate) enum Ended {
    Failed(Failure),
    /// A signal, a key or a line of the user's has stopped it.
    Interrupted {
        failure: Failure,
        /// Whether the arm is known to stand.
        stands: bool,
    },
}

impl<T: Into<Failure>> From<T> for Ended {
    fn from(failure: T) -> Self {
        Self::Failed(failure.into())
    }
}

impl Context {
    /// The arm that is meant, with its lease at a station.
    async fn connect_leased(&mut self, rules: &Rules) -> Result<Arm, Failure> {
        let arm = self.connect(None, rules).await?;
        self.take_lease().await?;
        Ok(arm)
    }

    /// Works with the arm on something that moves it, hears signals itself, and settles itself what others have left.
    pub(crate) fn job<T>(
        &mut self,
        policy: JobPolicy,
        work: impl AsyncFnOnce(&Arm, &mut Output, &mut Signals) -> Result<T, Ended>,
    ) -> Result<T, Failure> {
        self.settle()?;
        let runtime = self.runtime()?;
        let rules = policy.rules();
        runtime.block_on(async {
            let mut signals = Signals::listen()?;
            let _time = self.arm_time();
            let connected = tokio::select! {
                connected = self.connect_leased(&rules) => connected,
                _ = signals.next() => Err(self.halt(&mut signals).await),
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
            // The connection is the context's: a clone would keep it.
            drop(arm);
            self.terminated |= signals.terminates();
            match ended {
                Ok(done) => {
                    self.ends(rules.end);
                    Ok(done)
                }
                Err(Ended::Failed(failure)) => Err(match &self.connected {
                    Some(connected) => connected.meant(failure),
                    None => failure,
                }),
                Err(Ended::Interrupted { failure, stands }) => {
                    self.ends(End::Stands);
                    self.interrupted(stands).await;
                    Err(failure)
                }
            }
        })
    }
}
