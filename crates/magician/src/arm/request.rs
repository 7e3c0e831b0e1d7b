use std::sync::MutexGuard;
use std::time::Duration;

use magician_host::ArmPicture;
use magician_protocol::FrameBuf;
use tokio::sync::oneshot;
use tokio::time::{Instant, timeout, timeout_at};

use super::Arm;
use super::driver::{Message, command_name};
use super::homing::homes;
use crate::connection::{Request, is_once};
use crate::message;
use crate::{Error, ErrorCode, Result};

/// Longer than anybody waits, and short enough to be added to any instant.
const FOREVER: Duration = Duration::from_secs(30 * 365 * 24 * 3600);

/// So long after its deadline a call ends even if the task is kept from its work.
const GRACE: Duration = Duration::from_millis(5);
/// How long the task may take for a turn.
const TURN: Duration = Duration::from_millis(3);

/// Requests.
impl Arm {
    pub(super) fn deadline(&self) -> Instant {
        self.call_deadline()
            .max(Instant::now() + self.patience.min(FOREVER))
    }

    /// As it is for calls that are no part of a run.
    pub(super) fn call_deadline(&self) -> Instant {
        let timeout = self.timeout().max(self.inner.shared.attempts());
        Instant::now() + timeout.min(FOREVER)
    }

    /// Returns a fault of the queue, to a call that began after `since` and asks first.
    pub(super) fn queue_fault(&self, since: Option<u64>) -> Result<()> {
        match self.inner.shared.queue_fault(since) {
            None => Ok(()),
            Some(queue_fault) => queue_fault.told(),
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
        if homes(&request.frame().frame()) {
            Box::pin(self.homing().expect()).await;
        }
        if self.fence().is_none() {
            return self.asked(request, deadline, stops).await;
        }
        let frame = *request.frame();
        let turn = Box::pin(self.fence_check().hold_frame(&frame.frame(), deadline)).await?;
        let answer = self.asked(request, deadline, stops).await;
        if let Some(turn) = turn {
            turn.ends(&answer);
        }
        answer
    }

    /// A read: no fence is asked for it.
    pub(super) async fn ask_for(&self, request: Request) -> Result<FrameBuf> {
        let (deadline, stops) = (self.deadline(), self.stops());
        if self.waits_for_jog(&request) {
            return self.ask_behind_jog(request, deadline).await;
        }
        self.asked(request, deadline, stops).await
    }

    async fn asked(&self, request: Request, deadline: Instant, stops: u64) -> Result<FrameBuf> {
        let frame = *request.frame();
        let answer = self.submit(request, deadline, stops).await?;
        self.answer(answer, &frame, deadline).await
    }

    /// How many stops were asked for over this connection so far, by whomever:
    /// [`RunOptions::unless_stopped_since`](super::RunOptions::unless_stopped_since).
    #[must_use]
    pub fn stops(&self) -> u64 {
        self.inner.shared.stops()
    }

    /// Hands a request to the task; its answer comes through what this returns. A queued command
    /// that belongs to a time before the last stop is not sent.
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
            Err(_) => Err(Error::stuck()),
        }
    }

    /// The answer, or an error even if the task should be kept from its work.
    pub(super) async fn answer(
        &self,
        answer: oneshot::Receiver<Result<FrameBuf>>,
        request: &FrameBuf,
        deadline: Instant,
    ) -> Result<FrameBuf> {
        let silent = if is_once(&request.frame()) {
            Error::uncertain(None, None)
        } else {
            Error::new(ErrorCode::NoAnswer, message!("no answer"))
        };
        self.answer_or(silent, answer, request, deadline).await
    }

    /// As [`answer`](Self::answer), with the error of a task that is kept from its work.
    pub(super) async fn answer_or<T>(
        &self,
        silent: Error,
        mut answer: oneshot::Receiver<Result<T>>,
        request: &FrameBuf,
        deadline: Instant,
    ) -> Result<T> {
        let before = self.inner.shared.slept();
        let mut late = deadline + GRACE;
        loop {
            let heard = timeout_at(late, self.heard(&mut answer)).await;
            // A caller that was held up wakes with all others, perhaps before the task.
            let heard = match heard {
                Err(_) => timeout(TURN, self.heard(&mut answer)).await,
                heard => heard,
            };
            let extended = deadline + GRACE + (self.inner.shared.slept() - before);
            break match heard {
                Ok(Some(result)) => result,
                Ok(None) => Err(Error::closed()),
                Err(_) if extended > late => {
                    late = extended;
                    continue;
                }
                Err(_) => Err(silent),
            };
        }
        .map_err(|error| match error.command() {
            Some(_) => error,
            None => error.with_command(command_name(&request.frame())),
        })
    }

    /// What the task says, or nothing once it has ended: a message that is sent while it ends may stay where it is, with
    /// all that would tell of that.
    pub(super) async fn heard<T>(&self, answer: &mut oneshot::Receiver<T>) -> Option<T> {
        tokio::select! {
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
    async fn what_the_task_is_kept_from_answering_may_have_been_done() {
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
            arm.heard(&mut answer).await,
            Some(()),
            "what was said counts"
        );
    }
}
