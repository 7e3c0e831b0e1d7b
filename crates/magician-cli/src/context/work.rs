//! Runs a verb's work on the arm under a policy, and handles signals meanwhile.
//!
//! The work is a future that races a signal. When the signal wins, the work is dropped and the arm
//! is stopped if the policy or the driver says that something moves. The same happens when a
//! station announces its end; the verb then fails with a port error. Afterwards a shell keeps the
//! connection, and a single command closes it; `policy` has the rules.

use std::future::Future;
use std::pin::{Pin, pin};

use magician::Arm;
use tokio::time::timeout;

use super::connect::{Connected, Sim};
use super::policy::{BurnEnd, End, Rules, SignalPolicy, StopPolicy};
use super::stop::{INTERRUPTED, STATION_ENDED, kind_of_stop, stop, stop_again};
use super::{Context, DISCONNECT_TIMEOUT, STOP_CONFIRM_TIMEOUT};
use crate::failure::{Failure, Kind, incomplete};
use crate::interrupt::{Signal, Signals};
use crate::output::Output;
use crate::paint::print_stderr;
use crate::progress::announce_wait;
use crate::saved::{Access, RecoveredSettings, SavedSettings};

impl Context {
    /// Runs work with the arm, connecting first if necessary.
    pub(crate) fn arm<T>(
        &mut self,
        policy: StopPolicy,
        work: impl AsyncFnOnce(&Arm, &mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.work(None, policy.rules(), policy.access(), work)
    }

    /// Runs work like [`arm`](Self::arm), with a rule for a virtual arm in this process.
    pub(crate) fn arm_or<T>(
        &mut self,
        sim: Sim,
        policy: StopPolicy,
        work: impl AsyncFnOnce(&Arm, &mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.work(Some(sim), policy.rules(), policy.access(), work)
    }

    /// Runs work that lasts until a signal, or until the station announces its end. Then the future
    /// passed to `work` completes, and `work` is expected to return normally.
    pub(crate) fn until_signal<T>(
        &mut self,
        sim: Sim,
        policy: SignalPolicy,
        work: impl AsyncFnOnce(
            &Arm,
            &mut Output,
            Pin<&mut dyn Future<Output = ()>>,
        ) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let rules = policy.rules();
        let begin = rules.ending(End::Continues);
        let clone = async |arm: &Arm, _: &mut Output| Ok(arm.clone());
        let arm = self.work(Some(sim), begin, Access::Reads, clone)?;
        let done = self.run_without_arm(async |out, signals| {
            let ends = arm.front_end().end_notice();
            let signal = async {
                tokio::select! {
                    _ = signals.next() => {}
                    () = ends.given() => {}
                }
            };
            work(&arm, out, pin!(signal)).await
        })?;
        self.note_success(rules.end);
        Ok(done)
    }

    /// Runs work that opens its lines itself. A signal drops it, and its connections stop what they
    /// started.
    pub(crate) fn run_with_own_line<T>(
        &mut self,
        work: impl AsyncFnOnce(&mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.close_connection()?;
        self.run_without_arm(async |out, signals| {
            tokio::select! {
                outcome = work(out) => return outcome,
                _ = signals.next() => {}
            }
            // Dropping the work has closed its connections. Wait while their driver tasks send the
            // last frames.
            tokio::time::sleep(DISCONNECT_TIMEOUT).await;
            Err(Failure::interrupted())
        })
    }

    /// Runs work that does not use the context's arm and handles signals itself: servers, verbs
    /// that step a clock of their own, viewers of files.
    pub(crate) fn run_without_arm<T>(
        &mut self,
        work: impl AsyncFnOnce(&mut Output, &mut Signals) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let runtime = self.runtime()?;
        runtime.block_on(async {
            let mut signals = Signals::listen()?;
            let outcome = work(&mut self.out, &mut signals).await;
            self.terminated |= signals.terminates();
            outcome
        })
    }

    /// Handles a signal between two lines of a shell: stops what earlier lines started.
    pub(crate) fn interrupt(&mut self, signal: Signal) -> Result<Failure, Failure> {
        let runtime = self.runtime()?;
        runtime.block_on(async {
            let mut signals = Signals::listen_after(signal)?;
            Ok(self.stop_for_signal(&mut signals).await)
        })
    }

    /// Closes the connection, for a verb that opens the line in its own way.
    pub(crate) fn close_connection(&mut self) -> Result<(), Failure> {
        let runtime = self.runtime()?;
        runtime.block_on(self.disconnect());
        Ok(())
    }

    /// Closes the connection, if there is one. Motions continue if `outcome` is a success and are
    /// stopped otherwise.
    pub(crate) fn finish(&mut self, outcome: Result<(), Failure>) -> Result<(), Failure> {
        self.disconnect_after(outcome.is_ok());
        let trace_error = self.end_trace();
        outcome.and_then(|()| match trace_error {
            Some(why) => Err(incomplete("trace", &why)),
            None => Ok(()),
        })
    }

    fn disconnect_after(&mut self, succeeded: bool) {
        let (Some(connected), Some(runtime)) = (self.connected.take(), &self.runtime) else {
            return;
        };
        let (arm, laser) = (connected.arm.clone(), connected.untracked.laser);
        if succeeded {
            note_running_motors(&arm, self.global.station.is_some());
        }
        runtime.block_on(async {
            let laser_off = match laser {
                _ if !succeeded => None,
                Some(BurnEnd::UntilSwitchedOff) => Some(Ok(())),
                Some(BurnEnd::WhileConnected) => Some(arm.laser().switch_off().await),
                None => Some(arm.laser().switch_off_after().await),
            };
            // If the arm did not confirm that the laser is off, do not detach the connection:
            // closing it then switches the laser off once more.
            if let Some(Ok(())) = laser_off {
                arm.detach();
            }
            drop(arm);
            connected.close().await;
        });
    }

    /// Takes the lease of the connected arm: see [`Connected::take_lease`].
    pub(super) async fn take_lease(&self) -> Result<(), Failure> {
        match &self.connected {
            Some(connected) => connected.take_lease(self.global.json).await,
            None => Ok(()),
        }
    }

    /// Notes that the work has succeeded.
    pub(super) fn note_success(&mut self, end: End) {
        if let Some(connected) = &mut self.connected {
            connected.untracked.note_success(end);
        }
    }

    fn work<T>(
        &mut self,
        sim: Option<Sim>,
        rules: Rules,
        access: Access,
        work: impl AsyncFnOnce(&Arm, &mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.apply_config()?;
        let runtime = self.runtime()?;
        runtime.block_on(async {
            let mut signals = Signals::listen()?;
            let _time = self.arm_time();
            let work = async {
                let arm = &self.connect(sim, &rules).await?;
                if access == Access::Sets && !rules.reconnects {
                    self.take_lease().await?;
                }
                let ends = arm.front_end().end_notice();
                let work = async {
                    let settled = SavedSettings::recover(arm, access).await;
                    self.out.note_settled(&settled, self.global.json);
                    let done = if self.laser_allowed {
                        work(&arm.allowing_laser(), &mut self.out).await
                    } else {
                        work(arm, &mut self.out).await
                    }?;
                    // Before the work the arm's queue was busy; now it may be empty.
                    if let RecoveredSettings::Deferred(_) = settled {
                        let settled = SavedSettings::recover(arm, Access::Sets).await;
                        self.out.note_settled(&settled, self.global.json);
                    }
                    Ok(done)
                };
                tokio::select! {
                    // Work that completes together with the notice counts as done.
                    biased;
                    done = work => done.map(Some),
                    () = ends.given() => Ok(None),
                }
            };
            let outcome = tokio::select! {
                outcome = work => match outcome {
                    Ok(Some(done)) => {
                        self.note_success(rules.end);
                        Ok(done)
                    }
                    Ok(None) => Err(self.stop_for_station(&mut signals).await),
                    Err(failure) => Err(self.restore_after_failure(failure, &mut signals).await),
                },
                _ = signals.next() => Err(self.stop_for_signal(&mut signals).await),
            };
            self.terminated |= signals.terminates();
            outcome
        })
    }

    /// Restores settings after a failure. A signal limits the time for that but does not cancel it.
    async fn restore_after_failure(&mut self, failure: Failure, signals: &mut Signals) -> Failure {
        let Some(connected) = &self.connected else {
            return failure;
        };
        let failure = connected.explain_failure(failure);
        let restored = {
            let mut restoring = pin!(self.saved.restore_after_failure(&connected.arm));
            tokio::select! {
                () = &mut restoring => return failure,
                _ = signals.next() => timeout(STOP_CONFIRM_TIMEOUT, restoring).await.is_ok(),
            }
        };
        self.saved.leave();
        self.disconnect_after_stop(restored).await;
        Failure::interrupted()
    }

    /// Stops what was started, and waits until the arm stands. A second signal during that repeats
    /// the stop and restores settings, neither of which moves the arm.
    pub(super) async fn stop_for_signal(&mut self, signals: &mut Signals) -> Failure {
        let open = self.connected.as_ref();
        let needs_stop = open.is_some_and(Connected::needs_stop);
        let (message, _) = self.stop_arm(needs_stop, INTERRUPTED, signals).await;
        Failure::new(Kind::Interrupted, message)
    }

    /// Stops the arm like [`stop_for_signal`](Self::stop_for_signal), because the arm's station is
    /// about to end.
    async fn stop_for_station(&mut self, signals: &mut Signals) -> Failure {
        let open = self.connected.as_ref();
        let needs_stop = open.is_some_and(Connected::needs_end) || !self.saved.is_empty();
        let (message, signalled) = self.stop_arm(needs_stop, STATION_ENDED, signals).await;
        Failure::new(kind_of_stop(true, signalled), message)
    }

    /// Stops the arm if `needs_stop`, and ends the connection. Returns the message for the user and
    /// true if a signal arrived during the stop. The message begins with `cause`, except after such
    /// a signal.
    async fn stop_arm(
        &mut self,
        needs_stop: bool,
        cause: &str,
        signals: &mut Signals,
    ) -> (String, bool) {
        let mut signalled = false;
        let outcome = match &self.connected {
            Some(open) if needs_stop => {
                let arm = &open.arm;
                let ended =
                    announce_wait(self.global.json, "stopping", stop(arm, &self.saved, cause));
                let ended = tokio::select! {
                    biased;
                    // A signal takes precedence over a stop that is confirmed at the same time.
                    _ = signals.next() => None,
                    ended = ended => Some(ended),
                };
                let ended = match ended {
                    Some(ended) => ended,
                    None => {
                        signalled = true;
                        stop_again(arm, &self.saved).await
                    }
                };
                self.note_success(End::Stopped);
                ended
            }
            _ => Ok(cause.to_owned()),
        };
        self.saved.leave();
        self.disconnect_after_stop(outcome.is_ok()).await;
        (outcome.unwrap_or_else(|message| message), signalled)
    }

    /// Closes the connection after an interruption. A shell keeps it if the arm stands.
    pub(super) async fn disconnect_after_stop(&mut self, stands: bool) {
        if !stands {
            // Dropping the connection sends its last frames without waiting for answers, since the
            // arm may not answer.
            self.connected = None;
        } else if !self.in_shell {
            self.disconnect().await;
        }
    }
}

/// Prints which motors keep running after this program, and what stops them.
fn note_running_motors(arm: &Arm, at_station: bool) {
    for motor in arm.motors().running() {
        let output = u8::from(motor) + 1;
        if at_station {
            print_stderr(format_args!(
                "note: motor {output} stops: at a station a motor runs only while its program holds the lease"
            ));
            continue;
        }
        let stops = match output {
            1 => "`magician conveyor stop`".to_owned(),
            output => format!("`magician conveyor stop --motor {output}`"),
        };
        print_stderr(format_args!(
            "note: motor {output} keeps running; {stops} or `magician stop` stops it"
        ));
    }
}
