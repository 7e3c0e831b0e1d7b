//! Requests of a handle: deadline, submission to the driver task, and the wait for the answer.
//!
//! Each request carries its deadline to the task, which ends it with an error when the deadline
//! passes. The handle watches the deadline too, so a call returns even if the task is starved. Time
//! in which the process was suspended does not count against it.

use std::sync::MutexGuard;
use std::time::Duration;

use magician_host::ArmPicture;
use magician_protocol::FrameBuf;
use tokio::sync::oneshot;
use tokio::time::{Instant, timeout, timeout_at};

use super::Arm;
use super::driver::{Message, command_name};
use super::homing::homes;
use crate::connection::{Request, must_not_repeat};
use crate::message;
use crate::{Error, ErrorCode, Result};

/// Upper bound of a timeout: longer than any caller waits, and small enough to be added to any
/// instant without overflow.
const MAX_TIMEOUT: Duration = Duration::from_secs(30 * 365 * 24 * 3600);

/// Additional time after the deadline before the handle gives up on the task. Choice: the task
/// normally reports the timeout itself, with a more precise error.
const DEADLINE_GRACE: Duration = Duration::from_millis(5);
/// Additional wait for the task to be scheduled when the handle runs first. Choice: a few scheduler
/// turns.
const SCHEDULING_GRACE: Duration = Duration::from_millis(3);

/// Sending requests.
impl Arm {
    pub(super) fn deadline(&self) -> Instant {
        self.call_deadline()
            .max(Instant::now() + self.patience.min(MAX_TIMEOUT))
    }

    /// Returns the deadline of calls outside a run.
    pub(super) fn call_deadline(&self) -> Instant {
        let timeout = self.timeout().max(self.inner.shared.min_datagram_timeout());
        Instant::now() + timeout.min(MAX_TIMEOUT)
    }

    /// Returns the last queue fault as an error, if it ended a call that began at stop count
    /// `since` or if it has not been reported yet.
    pub(super) fn queue_fault(&self, since: Option<u64>) -> Result<()> {
        match self.inner.shared.queue_fault(since) {
            None => Ok(()),
            Some(queue_fault) => queue_fault.into_result(),
        }
    }

    pub(super) async fn ask(&self, request: Request) -> Result<FrameBuf> {
        self.ask_until(request, self.deadline()).await
    }

    pub(super) async fn ask_until(&self, request: Request, deadline: Instant) -> Result<FrameBuf> {
        if self.waits_for_jog(&request) {
            return self.ask_behind_jog(request, deadline).await;
        }
        let stops = self.stops();
        // Boxed, as are the fence checks below: their futures are large and rarely needed, and
        // every call would carry them.
        if homes(&request.frame().frame()) {
            Box::pin(self.homing().expect()).await;
        }
        if self.fence().is_none() {
            return self.send_and_wait(request, deadline, stops).await;
        }
        let frame = *request.frame();
        let turn = Box::pin(self.fence_check().hold_frame(&frame.frame(), deadline)).await?;
        let answer = self.send_and_wait(request, deadline, stops).await;
        if let Some(turn) = turn {
            turn.ends(&answer);
        }
        answer
    }

    /// Sends a read, which no fence needs to check.
    pub(super) async fn request_read(&self, request: Request) -> Result<FrameBuf> {
        let (deadline, stops) = (self.deadline(), self.stops());
        if self.waits_for_jog(&request) {
            return self.ask_behind_jog(request, deadline).await;
        }
        self.send_and_wait(request, deadline, stops).await
    }

    async fn send_and_wait(
        &self,
        request: Request,
        deadline: Instant,
        stops: u64,
    ) -> Result<FrameBuf> {
        let frame = *request.frame();
        let answer = self.submit(request, deadline, stops).await?;
        self.answer(answer, &frame, deadline).await
    }

    /// Returns the number of stops requested over this connection so far, by any handle; see
    /// [`RunOptions::unless_stopped_since`](super::RunOptions::unless_stopped_since).
    #[must_use]
    pub fn stops(&self) -> u64 {
        self.inner.shared.stops()
    }

    /// Submits a request to the task, and returns the receiver of its answer. A queued command from
    /// before the last stop is not sent.
    pub(super) async fn submit(
        &self,
        request: Request,
        deadline: Instant,
        stops: u64,
    ) -> Result<oneshot::Receiver<Result<FrameBuf>>> {
        self.permission()
            .check_frame(&request.frame().frame())
            .and_then(|()| self.permission().check_jog(&request.frame().frame()))
            .map_err(|error| error.with_command(command_name(&request.frame().frame())))?;
        let (reply, answer) = oneshot::channel();
        let message = Message::Submit {
            request,
            deadline,
            stops,
            reply,
        };
        match timeout_at(deadline, self.inner.messages.send(message)).await {
            Ok(Ok(())) => Ok(answer),
            Ok(Err(_)) => Err(Error::closed()),
            // The inbox stayed full until the deadline, so the task is starved.
            Err(_) => Err(Error::stuck()),
        }
    }

    /// Waits for the answer; returns an error after the deadline even if the task is starved.
    pub(super) async fn answer(
        &self,
        answer: oneshot::Receiver<Result<FrameBuf>>,
        request: &FrameBuf,
        deadline: Instant,
    ) -> Result<FrameBuf> {
        // A request that must not be repeated may have been executed, so the caller has to be told.
        let timeout_error = if must_not_repeat(&request.frame()) {
            Error::uncertain(None, None)
        } else {
            Error::new(ErrorCode::NoAnswer, message!("no answer"))
        };
        self.answer_or(timeout_error, answer, request, deadline)
            .await
    }

    /// Waits as [`answer`](Self::answer) does, with `timeout_error` as the error of a starved task.
    pub(super) async fn answer_or<T>(
        &self,
        timeout_error: Error,
        mut answer: oneshot::Receiver<Result<T>>,
        request: &FrameBuf,
        deadline: Instant,
    ) -> Result<T> {
        let before = self.inner.shared.suspended();
        let mut latest_return = deadline + DEADLINE_GRACE;
        loop {
            let outcome = timeout_at(latest_return, self.answer_or_end(&mut answer)).await;
            // After a suspension all tasks wake at once, perhaps this one before the driver: give
            // it a turn.
            let outcome = match outcome {
                Err(_) => timeout(SCHEDULING_GRACE, self.answer_or_end(&mut answer)).await,
                outcome => outcome,
            };
            // The driver reports the length of a suspension; the deadline moves on by it.
            let extended = deadline + DEADLINE_GRACE + (self.inner.shared.suspended() - before);
            break match outcome {
                Ok(Some(result)) => result,
                Ok(None) => Err(Error::closed()),
                Err(_) if extended > latest_return => {
                    latest_return = extended;
                    continue;
                }
                Err(_) => Err(timeout_error),
            };
        }
        .map_err(|error| match error.command() {
            Some(_) => error,
            None => error.with_command(command_name(&request.frame())),
        })
    }

    /// Returns the answer of the task; `None` once the task has ended. Answer and end are both
    /// watched, because a message sent while the task ends may stay in the inbox, together with its
    /// reply channel.
    pub(super) async fn answer_or_end<T>(&self, answer: &mut oneshot::Receiver<T>) -> Option<T> {
        tokio::select! {
            // The answer first: an answer received before the end of the connection still counts.
            biased;
            answer = &mut *answer => answer.ok(),
            () = self.ended() => answer.try_recv().ok(),
        }
    }

    pub(super) fn picture(&self) -> MutexGuard<'_, ArmPicture> {
        self.inner.shared.picture()
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::NoArgs;
    use magician_protocol::commands::{Pose, QueuedCmdStartDownload};

    use super::*;
    use crate::ErrorKind;
    use crate::Options;

    #[tokio::test(start_paused = true)]
    async fn unanswered_command_is_uncertain() {
        let arm = Arm::simulated(crate::VirtualArm::default(), Options::default()).await;
        let arm = arm.unwrap();
        let download = QueuedCmdStartDownload {
            total_loop: 1,
            line_per_loop: 1,
        };
        let kind = async |request: Request| {
            let (_kept, answer) = oneshot::channel();
            let answer = arm.answer(answer, request.frame(), Instant::now()).await;
            answer.unwrap_err().kind()
        };
        let once = kind(Request::set(&download).unwrap()).await;
        assert_eq!(once, ErrorKind::Uncertain);
        let again = kind(Request::get::<Pose>(&NoArgs).unwrap()).await;
        assert_eq!(again, ErrorKind::Timeout);
    }

    #[tokio::test(start_paused = true)]
    async fn a_message_that_comes_after_the_end_is_not_waited_for() {
        let arm = Arm::simulated(crate::VirtualArm::default(), Options::default()).await;
        let arm = arm.unwrap();
        arm.clone().close().await;
        let (_kept, answer) = oneshot::channel();
        let request: Request = Request::get::<Pose>(&NoArgs).unwrap();
        let answer = arm.answer(answer, request.frame(), arm.deadline()).await;
        assert_eq!(answer.unwrap_err().kind(), ErrorKind::Closed);
        let (kept, mut answer) = oneshot::channel();
        kept.send(()).unwrap();
        assert_eq!(
            arm.answer_or_end(&mut answer).await,
            Some(()),
            "what was said counts"
        );
    }
}
