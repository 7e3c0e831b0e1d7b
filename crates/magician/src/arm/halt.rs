//! Bringing the arm to a stand.

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
use super::shared::held;
use super::{Arm, Shared};
use crate::connection::{Priority, Request};
use crate::message;
use crate::{Error, ErrorCode, ErrorKind, REST_READ_INTERVAL, RestDetector, Result};

/// How long the arm may take to come to a stand: from full speed at twice the acceleration, and the
/// end of a motion that a Clear lets finish.
const BRAKING: Duration = Duration::from_secs(5);
/// Time between two reads that are to tell whether the arm is at rest.
pub(super) const APART: Duration = Duration::from_micros(REST_READ_INTERVAL);

/// How long a stop from outside of any task waits until it is confirmed.
const HALT: Duration = Duration::from_secs(1);

/// Stops that were asked for from outside of any task.
#[derive(Debug, Default)]
pub(super) struct Halts {
    asked: bool,
    waiters: Vec<Waiter>,
}

/// A waiter for the end of a stop, on a thread of its own.
#[derive(Debug)]
pub(super) struct Waiter(SyncSender<Result<()>>);

impl Waiter {
    pub(super) fn tell(self, outcome: Result<()>) {
        let _ = self.0.try_send(outcome);
    }
}

impl Shared {
    /// Whether a stop was asked for since the last look.
    pub(super) fn is_halt_asked(&self) -> bool {
        held(&self.halts).asked
    }

    /// The waiters for a stop that was requested since the last check, if any.
    pub(super) fn take_halt(&self) -> Option<Vec<Waiter>> {
        let mut halts = held(&self.halts);
        let waiters = std::mem::take(&mut halts.waiters);
        std::mem::take(&mut halts.asked).then_some(waiters)
    }
}

/// Stops the arm from anywhere: a thread that waits for Ctrl-C, a window's button, a watchdog. It needs no runtime, and
/// it does not keep the connection: when that has ended, the arm has been stopped or was let go on purpose.
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
    /// Hands the stop to the connection's task and returns at once. The task sends what [`Arm::stop`] sends, ahead of
    /// everything else, for up to three seconds until it is answered; while the line is lost, it is the first thing that is
    /// said when it is back.
    ///
    /// # Errors
    /// [`ErrorKind::Closed`] when the connection has ended.
    pub fn request_stop(&self) -> Result<()> {
        self.ask(None)
    }

    /// As [`request_stop`](Self::request_stop), and waits until the arm has answered that it stops, a second at most.
    /// It may still brake when this returns; a motion that is asked for then waits until it stands.
    ///
    /// On a thread that is needed to serve the connection itself (inside a single-threaded runtime) nothing can be
    /// answered meanwhile: use [`Arm::stop`] there.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`] when the arm does not answer, [`ErrorKind::Port`] while the line is lost (the stop will be
    /// said), [`ErrorKind::Closed`] when the connection has ended.
    pub fn stop_blocking(&self) -> Result<()> {
        let (tell, told) = sync_channel(1);
        self.ask(Some(Waiter(tell)))?;
        match told.recv_timeout(HALT) {
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
        self.shared.picture().stop_asked();
        self.shared.stop();
        {
            let mut halts = held(&self.shared.halts);
            halts.asked = true;
            halts.waiters.extend(waiter);
        }
        match messages.try_send(Message::Wake) {
            // With so many messages before it the task is awake, and looks.
            Ok(()) | Err(TrySendError::Full(_)) => Ok(()),
            Err(TrySendError::Closed(_)) => Err(Error::closed()),
        }
    }
}

impl Arm {
    /// What stops the arm from any thread, without a runtime: see [`Stopper`].
    #[must_use]
    pub fn stopper(&self) -> Stopper {
        Stopper {
            messages: self.inner.messages.downgrade(),
            shared: Arc::clone(&self.inner.shared),
        }
    }

    /// Whether something that was set going over this connection may be under way: a motion, or a queue that runs. It
    /// errs towards yes: what has finished counts until the current index (or, outside of the queue, poses of an arm at rest)
    /// was read. What others set going does not count.
    #[must_use]
    pub fn moving(&self) -> bool {
        self.picture().motion().is_moving()
    }
}

impl Arm {
    /// Sends what stops the arm; it may still brake when it has answered.
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
            // That the arm has a motor which nothing here started does not decide whether it has stopped.
            if counts {
                answers.push((answer, frame));
            }
        }
        // Where a burn goes on: see `lights_out`. An arm that does not tell it has stopped all the same.
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
        // Dropped before, it would not go out any more.
        drop(pose);
        outcome
    }

    /// Lets the command under way finish and then holds the queue (document 1.19.2). What waits
    /// stays; [`Queue::start`](super::Queue::start) goes on with it. A run under way ends, so that it does not start the queue.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn stop_gentle(&self) -> Result<()> {
        let request = Request::set(&QueuedCmdStopExec {})?;
        self.ask(request.priority(Priority::Stop)).await.map(drop)
    }

    /// Ends a jog, at once and for sure: repeated until the arm stands.
    ///
    /// # Errors
    /// As [`stop`](Self::stop).
    pub async fn stop_jog(&self) -> Result<()> {
        let stop = JogCmd {
            is_joint: magician_protocol::Flag::OFF,
            cmd: JogCommand::Stop,
        };
        let until = self.deadline();
        loop {
            let request = Request::set(&stop)?.priority(Priority::Stop);
            let patience = Instant::now() + Duration::from_millis(300);
            match self.ask_until(request, patience.min(until)).await {
                Ok(_) => return self.wait_still().await,
                Err(error) if !again(&error) || Instant::now() >= until => return Err(error),
                // The answer to a read proves that none to this stop can come: the next one's is known for its own.
                Err(_) => {
                    let look = Request::get::<Pose>(&magician_protocol::NoArgs)?;
                    let patience = Instant::now() + Duration::from_millis(300);
                    let _ = self.ask_until(look, patience.min(until)).await;
                }
            }
        }
    }

    /// Waits until the arm stands if it may still brake after a forced stop over this connection.
    ///
    /// Called before anything reads where a motion begins. A braking arm is still on its way, and
    /// keeps the place of the command that was stopped, which the stop has made nobody's: it would be
    /// taken for another program's.
    pub(super) async fn come_to_rest(&self) -> Result<()> {
        let braking = self.picture().motion().is_braking();
        if braking {
            self.wait_still().await
        } else {
            Ok(())
        }
    }

    /// Waits until the arm stands: equal poses, as [`RestDetector`] has it.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`] when it still moves after five seconds, else as [`get`](Self::get).
    pub async fn wait_still(&self) -> Result<()> {
        let brakes = self.picture().motion().is_braking();
        self.still_until(Instant::now() + BRAKING, brakes).await
    }

    /// True if the arm stands: its queue has nothing of this connection under way, and a few looks find the same pose.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn stands(&self) -> Result<bool> {
        // What has finished counts as under way until the index is read.
        self.queue().current_index().await?;
        if self.picture().motion().runs_queue() {
            return Ok(false);
        }
        match self.still_until(Instant::now(), false).await {
            Err(error) if error.code() == ErrorCode::StopUnconfirmed => Ok(false),
            still => still.map(|()| true),
        }
    }

    /// Waits until the arm is at rest; of an arm that brakes, until anyone has seen it stand since its stop. Fails at the first
    /// pose from `until` on that differs from the one before.
    async fn still_until(&self, until: Instant, brakes: bool) -> Result<()> {
        let stops = self.picture().motion().stops();
        let mut rest = RestDetector::default();
        let mut before = None;
        loop {
            let pose = self.get::<Pose>().await?;
            // The end of a jog may have seen the arm stand between these looks. What moves it now began after that.
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
            sleep(APART).await;
        }
    }
}

/// Whether what failed may work the next time: not on a line that is gone.
fn again(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::Timeout | ErrorKind::Uncertain)
}
