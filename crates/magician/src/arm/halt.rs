//! Stopping the arm and waiting until it is at rest.
//!
//! A stop is several frames: ForceStop, laser off, clear, and the pins and motors that this
//! connection may have set. All are sent at stop priority, ahead of pending requests. The arm
//! answers at once and may still brake, so rest is found by reading equal poses. [`Stopper`]
//! requests the same from threads without a runtime: it sets a flag and wakes the task.

use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use magician_protocol::commands::{JogCmd, Pose, QueuedCmdStopExec};
use magician_protocol::{JogCommand, NoArgs};
use tokio::sync::mpsc::WeakSender;
use tokio::sync::mpsc::error::TrySendError;
use tokio::time::{Instant, sleep};

use super::driver::Message;
use super::gate::motors_off;
use super::shared::lock;
use super::{Arm, Shared};
use crate::connection::{Priority, Request};
use crate::message;
use crate::{Error, ErrorCode, ErrorKind, REST_READ_INTERVAL, RestDetector, Result};

/// Longest time to come to rest: braking from full speed, or a motion that a Clear lets finish.
/// Choice, with margin.
const MAX_BRAKING_TIME: Duration = Duration::from_secs(5);
/// Time between two reads that check for rest.
pub(super) const REST_POLL_INTERVAL: Duration = Duration::from_micros(REST_READ_INTERVAL);

/// Longest wait of a blocking stop for its confirmation. Choice: a thread that handles Ctrl-C or a
/// button should not hang longer.
const STOP_CONFIRM_TIMEOUT: Duration = Duration::from_secs(1);

/// Stops requested from outside of any task.
#[derive(Debug, Default)]
pub(super) struct Halts {
    asked: bool,
    waiters: Vec<Waiter>,
}

/// Thread that waits for the end of a stop.
#[derive(Debug)]
pub(super) struct Waiter(SyncSender<Result<()>>);

impl Waiter {
    pub(super) fn tell(self, outcome: Result<()>) {
        // A waiter that has timed out has dropped its receiver.
        let _ = self.0.try_send(outcome);
    }
}

impl Shared {
    /// True if a stop was requested since the last [`take_halt`](Self::take_halt).
    pub(super) fn is_halt_asked(&self) -> bool {
        lock(&self.halts).asked
    }

    /// Takes the waiters of a stop requested since the last call; `None` if there was no request.
    pub(super) fn take_halt(&self) -> Option<Vec<Waiter>> {
        let mut halts = lock(&self.halts);
        let waiters = std::mem::take(&mut halts.waiters);
        std::mem::take(&mut halts.asked).then_some(waiters)
    }
}

/// Stops the arm from any thread, such as a handler of Ctrl-C, a button of a window or a watchdog.
///
/// It needs no runtime, and it does not keep the connection open: once that has ended, the arm has
/// been stopped or was deliberately detached.
///
/// ```
/// use magician::blocking::Arm;
///
/// # fn main() -> magician::Result<()> {
/// let arm = Arm::connect("sim")?;
/// let stopper = arm.stopper();
/// std::thread::spawn(move || stopper.stop_blocking()).join().expect("no panic")?;
/// assert!(!arm.moving());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Stopper {
    messages: WeakSender<Message>,
    shared: Arc<Shared>,
}

impl Stopper {
    /// Passes the stop to the connection's task and returns immediately.
    ///
    /// The task sends the frames of [`Arm::stop`] ahead of everything else, and retransmits them
    /// for up to three seconds until they are answered. While the line is lost, they are the first
    /// frames after a reconnect.
    ///
    /// # Errors
    /// [`ErrorKind::Closed`] if the connection has ended.
    pub fn request_stop(&self) -> Result<()> {
        self.ask(None)
    }

    /// Stops as [`request_stop`](Self::request_stop) does, and waits up to a second until the arm
    /// has confirmed the stop.
    ///
    /// The arm may still brake when this returns; a later motion waits until it is at rest. Do not
    /// call this on a thread that has to serve the connection (inside a single-threaded runtime),
    /// where nothing can be answered meanwhile: use [`Arm::stop`] there.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`] if the arm does not answer, [`ErrorKind::Port`] while the line is
    /// lost (the stop is sent on reconnect), [`ErrorKind::Closed`] if the connection has ended.
    pub fn stop_blocking(&self) -> Result<()> {
        let (tell, told) = sync_channel(1);
        self.ask(Some(Waiter(tell)))?;
        match told.recv_timeout(STOP_CONFIRM_TIMEOUT) {
            Ok(outcome) => outcome,
            Err(RecvTimeoutError::Timeout) => {
                let message =
                    message!("the arm did not confirm within a second that it has stopped");
                Err(Error::new(ErrorCode::StopUnconfirmed, message))
            }
            Err(RecvTimeoutError::Disconnected) => Err(Error::closed()),
        }
    }

    fn ask(&self, waiter: Option<Waiter>) -> Result<()> {
        let messages = self.messages.upgrade().ok_or_else(Error::closed)?;
        // Counted here and not by the task: calls that begin from now on belong to the time after
        // the stop.
        self.shared.picture().stop_asked();
        self.shared.stop();
        {
            let mut halts = lock(&self.shared.halts);
            halts.asked = true;
            halts.waiters.extend(waiter);
        }
        match messages.try_send(Message::Wake) {
            // With a full inbox the task is awake anyway, and sees the flag.
            Ok(()) | Err(TrySendError::Full(_)) => Ok(()),
            Err(TrySendError::Closed(_)) => Err(Error::closed()),
        }
    }
}

impl Arm {
    /// Returns a [`Stopper`], which stops the arm from any thread without a runtime.
    #[must_use]
    pub fn stopper(&self) -> Stopper {
        Stopper {
            messages: self.inner.messages.downgrade(),
            shared: Arc::clone(&self.inner.shared),
        }
    }

    /// True if motion that this connection started may still be in progress: a motion, or a running
    /// queue.
    ///
    /// This errs towards true: finished motion counts until the current index was read (outside of
    /// the queue: poses of an arm at rest). Motion started by others does not count.
    #[must_use]
    pub fn moving(&self) -> bool {
        self.picture().motion().is_moving()
    }
}

impl Arm {
    /// Sends the frames of a stop, and returns when they are answered; the arm may still brake.
    pub(super) async fn halted(&self, deadline: Instant, stops: u64) -> Result<()> {
        let shared = &self.inner.shared;
        let held = shared.held_motors(true);
        let behind = shared.lowered_pins().into_iter();
        let own = Request::halt()?.into_iter().chain(behind);
        let burns = shared.picture().may_be_lit();
        let motors = motors_off().map(|(output, request)| (request, held.contains(&output)));
        let mut answers = Vec::new();
        for (request, counts) in own.map(|request| (request, true)).chain(motors) {
            let frame = *request.frame();
            let answer = self.submit(request, deadline, stops).await?;
            // The answer of a motor output that this connection did not start does not decide if
            // the arm has stopped.
            if counts {
                answers.push((answer, frame));
            }
        }
        // The pose shows where to resume a burn (`lights_out`). Without an answer the stop is still
        // complete.
        let pose = if burns {
            Some(
                self.submit(Request::get::<Pose>(&NoArgs)?, deadline, stops)
                    .await?,
            )
        } else {
            None
        };
        let mut outcome = Ok(());
        for (answer, frame) in answers {
            let answer = self.answer(answer, &frame, deadline).await;
            outcome = outcome.and(answer.map(drop));
        }
        // Dropping the receiver earlier would cancel the read before it is sent.
        drop(pose);
        outcome
    }

    /// Lets the command in progress finish, then pauses the queue (document 1.19.2).
    ///
    /// Waiting commands stay; [`Queue::start`](super::Queue::start) continues with them. A run in
    /// progress ends, so that it does not start the queue again.
    ///
    /// # Errors
    /// Same as [`get`](Self::get).
    pub async fn stop_gentle(&self) -> Result<()> {
        let request = Request::set(&QueuedCmdStopExec {})?;
        self.ask(request.priority(Priority::Stop)).await.map(drop)
    }

    /// Ends a jog immediately, and retransmits the stop until the arm is at rest.
    ///
    /// # Errors
    /// Same as [`stop`](Self::stop).
    pub async fn stop_jog(&self) -> Result<()> {
        let stop = JogCmd {
            is_joint: magician_protocol::Flag::OFF,
            cmd: JogCommand::Stop,
        };
        let until = self.deadline();
        loop {
            let request = Request::set(&stop)?.priority(Priority::Stop);
            // Choice: repeats a lost stop about three times a second, while the arm still moves.
            let patience = Instant::now() + Duration::from_millis(300);
            match self.ask_until(request, patience.min(until)).await {
                Ok(_) => return self.wait_still().await,
                Err(error) if !again(&error) || Instant::now() >= until => return Err(error),
                // The answer to a read proves that the reply to this stop is lost, so the next
                // reply belongs to the next stop (head of `magician-host/src/connection/mod.rs`,
                // rule 3).
                Err(_) => {
                    let look = Request::get::<Pose>(&magician_protocol::NoArgs)?;
                    let patience = Instant::now() + Duration::from_millis(300);
                    // The answer itself is of no interest, only that it arrived.
                    let _ = self.ask_until(look, patience.min(until)).await;
                }
            }
        }
    }

    /// Waits until the arm is at rest if it may still brake after a forced stop over this
    /// connection.
    ///
    /// Called before any read of a start position. A braking arm has not reached its final pose
    /// yet, and the stopped command still occupies its place in the queue, where it would be taken
    /// for a command of another program.
    pub(super) async fn come_to_rest(&self) -> Result<()> {
        let braking = self.picture().motion().is_braking();
        if braking {
            self.wait_still().await
        } else {
            Ok(())
        }
    }

    /// Waits until the arm is at rest, which [`RestDetector`] finds by equal poses.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`] if it still moves after five seconds, else as [`get`](Self::get).
    pub async fn wait_still(&self) -> Result<()> {
        let brakes = self.picture().motion().is_braking();
        self.still_until(Instant::now() + MAX_BRAKING_TIME, brakes)
            .await
    }

    /// True if the arm is at rest: nothing of this connection runs in its queue, and a few reads
    /// find the same pose.
    ///
    /// # Errors
    /// Same as [`get`](Self::get).
    pub async fn stands(&self) -> Result<bool> {
        // Finished commands count as in progress until the index is read.
        self.queue().current_index().await?;
        if self.picture().motion().runs_queue() {
            return Ok(false);
        }
        match self.still_until(Instant::now(), false).await {
            Err(error) if error.code() == ErrorCode::StopUnconfirmed => Ok(false),
            still => still.map(|()| true),
        }
    }

    /// Waits until the arm is at rest; for a braking arm, until any reader has seen it at rest
    /// since the stop. Fails at the first pose change after `until`.
    async fn still_until(&self, until: Instant, brakes: bool) -> Result<()> {
        let stops = self.picture().motion().stops();
        let mut rest = RestDetector::default();
        let mut before = None;
        loop {
            let pose = self.get::<Pose>().await?;
            // The task may have seen the arm at rest after a jog, between these reads. Motion now
            // is new motion, which this call must not wait for.
            if brakes && self.picture().motion().has_stood_after(stops) {
                return Ok(());
            }
            if rest.see(self.inner.shared.now(), pose) {
                self.inner.shared.stood_after(stops);
                return Ok(());
            }
            let moves = before.replace(pose).is_some_and(|before| before != pose);
            if moves && Instant::now() >= until {
                return Err(Error::new(
                    ErrorCode::StopUnconfirmed,
                    message!("the arm still moves"),
                ));
            }
            sleep(REST_POLL_INTERVAL).await;
        }
    }
}

/// True if a retry may succeed, which a lost line rules out.
fn again(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::Timeout | ErrorKind::Uncertain)
}
