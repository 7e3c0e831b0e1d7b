//! Requests to a running job: stop, pause and resume, received at every await of the engine.

use std::future::{Future, pending};

use magician::EndNotice;
use tokio::sync::{mpsc, oneshot};

use crate::error::{PauseError, ResumeError};
use crate::event::PauseReason;
use crate::handle::Request;

/// Marker: a stop was requested.
#[derive(Debug)]
pub(super) struct Stopped;

type PauseReply = oneshot::Sender<Result<(), PauseError>>;
pub(super) type ResumeReply = oneshot::Sender<Result<(), ResumeError>>;

/// Receiver of the requests to a job.
pub(super) struct Inbox {
    requests: mpsc::UnboundedReceiver<Request>,
    /// Notice that the program at the other end of the line is about to end. The notice stops the
    /// job like a stop by a person.
    line_end_notice: EndNotice,
    first_stop: FirstStop,
    /// Pause requests without a reply yet.
    pauses: Vec<PauseReply>,
    /// Reason of the first pending pause request.
    reason: Option<PauseReason>,
}

/// Request to a running job.
#[derive(Debug)]
pub(super) enum RunInterruption {
    Pause,
    Stop,
}

/// Request to a paused job.
pub(super) enum PauseEnd {
    Resume(ResumeReply),
    Stop,
}

/// Source of the first stop of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FirstStop {
    None,
    Person,
    /// The end of the line. The first stop of a person after it counts as the same stop, not as a
    /// second one: Ctrl-C in a terminal reaches the station and the job at once.
    Line,
    LineAndPerson,
}

impl Inbox {
    pub(super) fn new(
        requests: mpsc::UnboundedReceiver<Request>,
        line_end_notice: EndNotice,
    ) -> Self {
        Self {
            requests,
            line_end_notice,
            first_stop: FirstStop::None,
            pauses: Vec::new(),
            reason: None,
        }
    }

    /// True if a pause was requested and the job is not paused yet.
    pub(super) fn wants_pause(&self) -> bool {
        self.reason.is_some()
    }

    /// Reason of the pending pause; [`PauseReason::Person`] if none is pending.
    pub(super) fn reason(&self) -> PauseReason {
        self.reason.unwrap_or(PauseReason::Person)
    }

    /// Replies to all pending pause requests.
    pub(super) fn answer_pauses(&mut self, answer: impl Fn() -> Result<(), PauseError>) {
        self.reason = None;
        for reply in self.pauses.drain(..) {
            // The requester may have stopped waiting.
            let _ = reply.send(answer());
        }
    }

    /// True if the end of the line stopped the job.
    pub(super) fn was_stopped_by_line(&self) -> bool {
        matches!(self.first_stop, FirstStop::Line | FirstStop::LineAndPerson)
    }

    async fn next_request(&mut self) -> Request {
        loop {
            let Self {
                requests,
                line_end_notice,
                first_stop,
                ..
            } = self;
            let request = tokio::select! {
                biased;
                Some(request) = requests.recv() => request,
                () = line_end_notice.given(), if *first_stop == FirstStop::None => {
                    *first_stop = FirstStop::Line;
                    return Request::Stop;
                }
                // All handles are dropped: there are no more requests.
                else => pending().await,
            };
            match (&request, *first_stop) {
                (Request::Stop, FirstStop::Line) => *first_stop = FirstStop::LineAndPerson,
                (Request::Stop, FirstStop::None) => {
                    *first_stop = FirstStop::Person;
                    return request;
                }
                // A second stop, or a pause or resume.
                _ => return request,
            }
        }
    }

    fn note_pause(&mut self, reason: PauseReason, reply: PauseReply) {
        self.reason.get_or_insert(reason);
        self.pauses.push(reply);
    }

    /// Runs `work` unless a stop comes first. Pause requests that arrive meanwhile stay pending.
    pub(super) async fn unless_stopped<T>(
        &mut self,
        work: impl Future<Output = T>,
    ) -> Result<T, Stopped> {
        // Boxed: the engine's futures are large, and some threads have small stacks.
        let mut work = Box::pin(work);
        loop {
            tokio::select! {
                // Requests first: work that is always ready must not starve a stop.
                biased;
                request = self.next_request() => match request {
                    Request::Stop => return Err(Stopped),
                    Request::Pause(reason, reply) => self.note_pause(reason, reply),
                    Request::Resume(reply) => drop(reply.send(Err(ResumeError::NotPaused))),
                },
                output = &mut work => return Ok(output),
            }
        }
    }

    /// Waits for the next stop or pause while the job runs.
    pub(super) async fn next_interruption(&mut self) -> RunInterruption {
        loop {
            match self.next_request().await {
                Request::Stop => return RunInterruption::Stop,
                Request::Pause(reason, reply) => {
                    self.note_pause(reason, reply);
                    return RunInterruption::Pause;
                }
                Request::Resume(reply) => drop(reply.send(Err(ResumeError::NotPaused))),
            }
        }
    }

    /// Waits for the next stop or resume while the job is paused.
    pub(super) async fn next_pause_end(&mut self) -> PauseEnd {
        loop {
            match self.next_request().await {
                Request::Stop => return PauseEnd::Stop,
                // The job is paused already.
                Request::Pause(_, reply) => drop(reply.send(Ok(()))),
                Request::Resume(reply) => return PauseEnd::Resume(reply),
            }
        }
    }
}
