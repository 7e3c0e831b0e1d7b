//! Running a job on the arm: the job hears signals itself and ends by itself.

use magician::Arm;

use super::{ArmTime, Context, Sim};
use crate::failure::Failure;
use crate::interrupt::{Signal, Signals};
use crate::output::Output;

/// How a job ended that has not come to its good end.
pub(crate) enum Ended {
    Failed(Failure),
    /// A signal, a key or a line of the user's has stopped it.
    Interrupted {
        failure: Failure,
        /// Whether the arm is known to stand.
        stands: bool,
        /// Whether the system wants this program to end.
        terminates: bool,
    },
}

impl<T: Into<Failure>> From<T> for Ended {
    fn from(failure: T) -> Self {
        Self::Failed(failure.into())
    }
}

impl Context {
    /// Works with the arm on something that moves it, hears signals itself, and settles itself what others have left.
    pub(crate) fn job<T>(
        &mut self,
        sim: Option<Sim>,
        work: impl AsyncFnOnce(&Arm, &mut Output, &mut Signals) -> Result<T, Ended>,
    ) -> Result<T, Failure> {
        self.sets_going(true);
        self.settle()?;
        let runtime = self.runtime()?;
        let in_arm_time = std::mem::take(&mut self.in_arm_time);
        let ended = runtime.block_on(async {
            let mut signals = Signals::listen()?;
            let _time = in_arm_time.then(ArmTime::begin);
            let connected = tokio::select! {
                connected = self.connected_anew(sim) => connected,
                signal = signals.next() => {
                    self.terminated |= signal == Signal::Terminate;
                    return Err(Ended::Failed(self.halt(&mut signals).await));
                }
            };
            let arm = connected?;
            let arm = if self.burns {
                arm.allowing_laser()
            } else {
                arm
            };
            let ended = work(&arm, &mut self.out, &mut signals).await;
            // The connection is the context's: a clone would keep it.
            drop(arm);
            if let Err(Ended::Interrupted { stands, .. }) = &ended {
                self.interrupted(*stands).await;
            }
            ended
        });
        match ended {
            Ok(done) => {
                self.going = false;
                Ok(done)
            }
            Err(Ended::Failed(failure)) => Err(failure),
            Err(Ended::Interrupted {
                failure,
                terminates,
                ..
            }) => {
                self.terminated |= terminates;
                self.going = false;
                Err(failure)
            }
        }
    }

    /// The arm that is meant now, connected to if need be.
    pub(super) async fn connected_anew(&mut self, sim: Option<Sim>) -> Result<Arm, Failure> {
        if (self.arm.as_ref()).is_some_and(|open| open.port != self.global.port) {
            self.disconnect().await;
        }
        let connected = match self.arm.take() {
            Some(connected) => connected,
            None => self.connect(sim).await?,
        };
        let arm = self.arm.insert(connected).arm.clone();
        let timeout = self.global.timeout;
        arm.set_timeout(timeout.unwrap_or(magician::Options::default().timeout));
        Ok(arm)
    }

    /// What becomes of the connection after an interrupt.
    pub(super) async fn interrupted(&mut self, stands: bool) {
        if !stands {
            // Dropped, the connection says once more what it can and waits for nothing.
            self.arm = None;
        } else if !self.in_shell {
            self.disconnect().await;
        }
    }
}
