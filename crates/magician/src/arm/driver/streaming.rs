//! Running a program: the task feeds the [`Stream`] from the handle that runs it, and reports its
//! progress.

use std::sync::Arc;
use std::task::{Context, Poll};

use magician_protocol::{Frame, FrameBuf};
use tokio::sync::{mpsc, oneshot, watch};

use super::explain::{failed, holds};
use super::{Driver, ReplyTarget};
use crate::arm::run::Supply;
use crate::connection::{Failure, IndexLaw, Ticket};
use crate::message;
use crate::stream::{Item, Leftover, Stream, StreamEvent, StreamFailure};
use crate::{Error, ErrorCode, Result};

/// Program to run, submitted by a handle.
#[derive(Debug)]
pub(in crate::arm) struct Program {
    pub(in crate::arm) stream: Stream,
    /// Commands in order; closed after the last.
    pub(in crate::arm) feed: mpsc::Receiver<Item>,
    /// Feeder of the commands, if they come from one.
    pub(in crate::arm) supply: Option<Arc<Supply>>,
    /// Stops before the run began.
    pub(in crate::arm) stops: u64,
    pub(in crate::arm) reached: watch::Sender<RunProgress>,
    pub(in crate::arm) end: oneshot::Sender<RunEnd>,
    /// Number of commands given to the stream.
    pub(in crate::arm) offered: u64,
}

/// Progress of a program.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::arm) struct RunProgress {
    /// Commands that the arm has accepted.
    pub(in crate::arm) accepted: u64,
    /// Indices of the first and last accepted command.
    pub(in crate::arm) indices: Option<(u64, u64)>,
    /// Index of the command that finished last, at the last reading.
    pub(in crate::arm) current: u64,
}

/// Outcome of a program.
#[derive(Debug)]
pub(in crate::arm) struct RunEnd {
    pub(in crate::arm) outcome: Result<()>,
    pub(in crate::arm) reached: RunProgress,
    /// Unfinished commands, and the feed with those not taken yet.
    pub(in crate::arm) rest: Option<(Leftover, mpsc::Receiver<Item>)>,
}

impl Program {
    /// Passes arrived commands to the stream, as far as it has room.
    fn fed(&mut self, cx: &mut Context<'_>) -> Result<()> {
        self.take(cx)?;
        if let Some(supply) = &self.supply {
            self.stream.expect(supply.next_offer(self.offered));
        }
        Ok(())
    }

    fn take(&mut self, cx: &mut Context<'_>) -> Result<()> {
        while self.stream.room() > 0 {
            match self.feed.poll_recv(cx) {
                Poll::Pending => break,
                Poll::Ready(None) => {
                    self.stream.finish();
                    break;
                }
                Poll::Ready(Some(item)) => {
                    self.offered += 1;
                    self.stream.offer(item).map_err(|refused| {
                        let error = Error::invalid(refused.sentence());
                        error.with_command(item.command.row().set_name)
                    })?;
                }
            }
        }
        Ok(())
    }
}

impl Driver {
    /// Starts a program.
    pub(super) fn take_program(&mut self, program: Box<Program>) {
        let runs = self.runs_program();
        let refusal = if program.stops != self.shared.stops() {
            Some(failed(Failure::Stopped))
        } else if !self.link_is_up() {
            Some(self.gone())
        } else if runs {
            Some(Error::new(
                ErrorCode::Busy,
                message!("another program runs"),
            ))
        } else if self.jog_runs() {
            Some(Error::new(ErrorCode::Busy, message!("a jog is under way")))
        } else {
            self.refuse_window(&program.stream)
        };
        match refusal {
            Some(error) => end(*program, Err(error)),
            None => {
                self.shared.picture().program_runs(true);
                self.program = Some(*program);
                self.lead();
            }
        }
    }

    /// Refuses a window that this arm or line does not support.
    fn refuse_window(&self, stream: &Stream) -> Option<Error> {
        let IndexLaw::Broken(breach) = self.connection.law() else {
            return None;
        };
        (stream.settings().window > 1).then(|| {
            let message = message!(
                "a window above 1 cannot be used here: {breach}",
                breach = breach.to_string()
            );
            Error::new(ErrorCode::Unsupported, message)
        })
    }

    /// Ends the program for a stop of another caller, before it sees what became of its commands.
    pub(super) fn heed_stop(&mut self) {
        let stops = self.shared.stops();
        if let Some(program) = self.program.as_mut().filter(|one| one.stops != stops) {
            // Interrupted, not dropped: answers in flight still show what the arm has taken.
            program.stream.interrupt(Failure::Stopped);
        }
    }

    /// Feeds the stream and lets it submit what is due; true if the program has ended.
    pub(super) fn drive_program(&mut self, cx: &mut Context<'_>) -> bool {
        let (now, jog_ends) = (self.now(), self.jog_ends());
        let Self {
            program: Some(program),
            connection,
            ..
        } = self
        else {
            return false;
        };
        if program.end.poll_closed(cx).is_ready() {
            self.give_up_program();
            return true;
        }
        // While a jog ends, a motion of the program would prevent the arm from coming to rest.
        if !jog_ends {
            if let Err(error) = program.fed(cx) {
                self.end_program(Err(error));
                return true;
            }
            program.stream.advance(now, connection);
        }
        self.tell_program()
    }

    /// True if a program runs whose caller still waits.
    pub(super) fn runs_program(&mut self) -> bool {
        if (self.program.as_ref()).is_some_and(|program| program.end.is_closed()) {
            self.give_up_program();
        }
        self.program.is_some()
    }

    /// Ends a program whose caller has gone: its unsent requests are withdrawn.
    fn give_up_program(&mut self) {
        if let Some(program) = &self.program {
            program.stream.withdraw(&mut self.connection);
            self.end_program(Err(failed(Failure::Stopped)));
        }
    }

    /// Interrupts the program if a caller stops or clears the queue, which the program's own
    /// requests must not undo.
    pub(super) fn steer_program(&mut self, request: &Frame<'_>) {
        if let (true, Some(program)) = (holds(request), &mut self.program) {
            program.stream.interrupt(Failure::Stopped);
        }
    }

    /// Handles the events of the stream; true if the program has ended.
    fn tell_program(&mut self) -> bool {
        while let Some(program) = &mut self.program
            && let Some(event) = program.stream.poll_event()
        {
            let name = &self.shared.name;
            match event {
                StreamEvent::Sent {
                    accepted,
                    first,
                    last,
                    current,
                } => {
                    if let Some(supply) = &program.supply {
                        supply.finished(program.stream.finished());
                    }
                    program.reached.send_replace(RunProgress {
                        accepted,
                        indices: Some((first, last)),
                        current,
                    });
                }
                StreamEvent::Starved { times } => {
                    tracing::debug!(times, "{name}: the arm's queue ran dry");
                }
                StreamEvent::Places { counted, read } => {
                    tracing::warn!(counted, read, "{name}: the queue has another size");
                }
                StreamEvent::Recovered { again, window } => tracing::warn!(
                    again,
                    window,
                    "{name}: commands were lost on the line; the path goes on from its last certain point"
                ),
                StreamEvent::Resumed { found, waiting } => {
                    tracing::info!(found, waiting, "{name}: the program goes on");
                }
                StreamEvent::Finished { .. } => self.end_program(Ok(())),
                StreamEvent::Failed(failure) => {
                    let error = self.explain_stream(failure);
                    self.end_program(Err(error));
                }
                // Unreachable in a published build too: the crates depend on each other by exact
                // version.
                #[cfg(not(magician_workspace))]
                _ => unreachable!(),
            }
        }
        self.program.is_none()
    }

    pub(super) fn end_program(&mut self, outcome: Result<()>) {
        let Some(program) = self.program.take() else {
            return;
        };
        // Their outcome still counts for the motion that this connection started.
        for (ticket, request) in program.stream.under_way() {
            self.await_answer(ticket, request, ReplyTarget::Discard);
        }
        self.shared.picture().program_runs(false);
        end(program, outcome);
    }

    /// Passes the end of a request to the program; true if it belongs to it.
    pub(super) fn program_answered(
        &mut self,
        ticket: Ticket,
        result: &Result<FrameBuf, Failure>,
    ) -> bool {
        let now = self.now();
        let connection = &mut self.connection;
        let program = self.program.as_mut();
        program.is_some_and(|program| program.stream.answered(now, ticket, result, connection))
    }

    /// Passes a reply to another caller to the stream, which may use it too.
    pub(super) fn overhear(&mut self, reply: &FrameBuf) {
        let now = self.now();
        if let Some(program) = &mut self.program {
            program.stream.note_foreign_reply(now, reply);
        }
    }

    /// Returns the error for the end of a program.
    fn explain_stream(&self, failure: StreamFailure) -> Error {
        let code = match failure {
            StreamFailure::Request(Failure::Lost) => return self.gone(),
            StreamFailure::Request(failure) => return failed(failure),
            StreamFailure::Dropped { .. } | StreamFailure::Reset { .. } => ErrorCode::Dropped,
            StreamFailure::NotDrained { .. } => ErrorCode::NotFinished,
            StreamFailure::Index { .. } | StreamFailure::Unclear { .. } => ErrorCode::Uncertain,
            // The remaining failures are answers that contradict each other.
            _ => ErrorCode::BadAnswer,
        };
        let error = Error::new(code, failure.sentence());
        match failure {
            StreamFailure::Unclear { confirmed, found } => {
                error.between(confirmed.map(|last| last.saturating_add(1)), Some(found))
            }
            _ => error,
        }
    }
}

fn end(program: Program, outcome: Result<()>) {
    let Program {
        stream,
        mut feed,
        reached,
        end,
        ..
    } = program;
    // The handle then notices that its commands are no longer wanted, and gets the rest back.
    feed.close();
    let rest = outcome.is_err().then(|| (stream.leftover(), feed));
    let reached = *reached.borrow();
    // The handle may have dropped the run, and then wants nothing back.
    let _ = end.send(RunEnd {
        outcome,
        reached,
        rest,
    });
}
