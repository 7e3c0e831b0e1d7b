//! Delivery of connection events: each answer goes to the receiver of its request, and to the
//! picture of the arm.

use magician_host::picture::Origin;
use magician_protocol::{FrameBuf, QueuedCmdIndex};

use super::explain::explain;
use super::{Driver, ReplyTarget, Waiting};
use crate::Result;
use crate::arm::events;
use crate::arm::shared::QueueFault;
use crate::connection::{Event, Failure, Ticket};

impl Driver {
    /// Delivers the events of the connection; true if there were any.
    pub(super) fn tell(&mut self) -> bool {
        let mut told = false;
        // Before the first round trip the lifetime is a default, which no deadline should be
        // stretched by.
        if !self.shared.ordered && self.connection.round_trip().is_some() {
            self.shared.note_lifetime(self.connection.lifetime());
        }
        while let Some(event) = self.connection.poll_event() {
            told = true;
            match event {
                Event::Done { ticket, result } => self.deliver(ticket, result),
                Event::Reset => self.was_reset(),
                Event::Unaccounted { from, to } => {
                    self.note_surplus(from, to);
                    let (from, to) = (QueuedCmdIndex(from), QueuedCmdIndex(to));
                    self.happens(events::Event::Unaccounted { from, to });
                }
                // Unreachable in a published build too: the crates depend on each other by exact
                // version.
                #[cfg(not(magician_workspace))]
                _ => unreachable!(),
            }
        }
        told
    }

    /// Handles commands that the arm took although this connection did not send them. If the
    /// running program may have one of its commands duplicated, it continues.
    fn note_surplus(&mut self, from: u64, to: u64) {
        let name = &self.shared.name;
        let program = self.program.as_mut();
        if program.is_some_and(|program| program.stream.note_duplicate(from, to)) {
            tracing::info!(
                from,
                "{name}: the line duplicated a command, without effect"
            );
            return;
        }
        tracing::warn!(
            from,
            to,
            "{name}: queued commands that this program did not send, or sent only once"
        );
        self.shared.note_fault(QueueFault::Unaccounted { from, to });
    }

    fn was_reset(&mut self) {
        tracing::warn!(
            "{}: the arm was switched off and on, or reset",
            self.shared.name
        );
        if let Some(program) = &mut self.program {
            program.stream.reset();
        }
        let gone = self.shared.picture().reset();
        self.shared.note_fault(QueueFault::Reset(gone));
        self.note_reset();
        let gone = gone.map(|(first, last)| (QueuedCmdIndex(first), QueuedCmdIndex(last)));
        self.happens(events::Event::Reset { gone });
    }

    fn deliver(&mut self, ticket: Ticket, result: Result<FrameBuf, Failure>) {
        let at = self.waiting.iter().position(|one| one.ticket == ticket);
        let done = at.map(|at| self.waiting.swap_remove(at));
        // A resumed program also takes the answers to requests it had in flight when it was
        // interrupted.
        let is_program = self.program_answered(ticket, &result);
        if let Some(done) = &done {
            self.shared.picture().returned(&done.request.frame());
        }
        let done = done.filter(|_| !is_program);
        if done.is_none() && !is_program {
            // The receiver was dropped when the connection began to shut down.
            return;
        }
        self.note_end(done.as_ref(), &result);
        let Some(done) = done else {
            return;
        };
        let request = done.request.frame();
        if let Ok(reply) = &result {
            self.overhear(reply);
        }
        // While the line is lost every call fails with its cause, not with the bare loss.
        let result = result.map_err(|failure| match failure {
            Failure::Lost => self.gone(),
            failure => explain(&request, failure),
        });
        match done.to {
            ReplyTarget::Caller(reply) => drop(reply.send(result)),
            ReplyTarget::Halt(number) => self.halt_answered(number, result.map(drop)),
            ReplyTarget::Settling => self.handle_settling_answer(result.map(drop)),
            ReplyTarget::Poll => self.polled(),
            ReplyTarget::Jog(reply, jog) => self.jog_began(result.map(drop), reply, jog),
            ReplyTarget::JogStop => self.jog_stopped(result),
            ReplyTarget::JogPose => self.jog_pose(result),
            ReplyTarget::JogLook(jog, asked) => self.jog_seen(result, jog, asked),
            ReplyTarget::Discard => {}
        }
    }

    /// Passes the end of a request to the picture, and the events that follow to the listeners.
    /// `done` is `None` for a request of the program. This is the only place where answers reach
    /// the picture.
    fn note_end(&self, done: Option<&Waiting>, result: &Result<FrameBuf, Failure>) {
        let now = self.now();
        let mut picture = self.shared.picture();
        match (done, result) {
            (Some(done), Ok(reply)) => {
                let origin = match done.to {
                    ReplyTarget::Caller(_) => Origin::Caller,
                    // Including a caller that has gone: commands it left in a stopped queue must
                    // not be started by the next one.
                    _ => Origin::Run,
                };
                picture.answered(now, origin, &done.request.frame(), &reply.frame());
            }
            (Some(done), Err(failure)) => {
                picture.failed(Some(&done.request.frame()), failure);
            }
            (None, Ok(reply)) => {
                let view = reply.frame();
                if let (true, Ok(QueuedCmdIndex(index))) = (view.ctrl().queued(), view.read()) {
                    let program = self.program.as_ref();
                    let item = program.and_then(|program| program.stream.item_at(index));
                    picture.accepted(index, item.map(|item| &item.command));
                } else {
                    // A reply carries the id and Ctrl of its request, and the picture needs no more
                    // for an immediate request of a program.
                    picture.answered(now, Origin::Run, &view, &view);
                }
            }
            (None, Err(failure)) => picture.failed(None, failure),
        }
        drop(picture);
        self.tell_events();
    }
}
