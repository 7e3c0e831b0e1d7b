//! Events of the connection, and their receivers.

use magician_protocol::{FrameBuf, QueuedCmdIndex};

use super::explain::explain;
use super::{Driver, To};
use crate::Result;
use crate::arm::events;
use crate::arm::in_flight::InFlightMotion;
use crate::arm::shared::QueueFault;
use crate::connection::{Event, Failure, Ticket};

impl Driver {
    /// Passes the connection's events on; whether there were any.
    pub(super) fn tell(&mut self) -> bool {
        let mut told = false;
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
                #[cfg(not(magician_workspace))]
                _ => unreachable!(),
            }
        }
        told
    }

    /// The arm has taken more than was sent. A program that may have one of its commands doubled goes on.
    fn note_surplus(&mut self, from: u64, to: u64) {
        let name = &self.shared.name;
        let program = self.program.as_mut();
        if program.is_some_and(|program| program.stream.doubled(from, to)) {
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
        let gone = self.in_flight().reset();
        self.shared.gate().reset();
        self.shared.own().clear();
        self.shared.note_fault(QueueFault::Reset(gone));
        self.note_reset();
        self.see_reset();
        let gone = gone.map(|(first, last)| (QueuedCmdIndex(first), QueuedCmdIndex(last)));
        self.happens(events::Event::Reset { gone });
    }

    fn deliver(&mut self, ticket: Ticket, result: Result<FrameBuf, Failure>) {
        let at = self.waiting.iter().position(|one| one.ticket == ticket);
        let done = at.map(|at| self.waiting.swap_remove(at));
        if let Some(done) = &done {
            self.in_flight().ends(&done.request.frame());
        }
        // A program that goes on takes up what was left under way by it when it was interrupted.
        if self.program_answered(ticket, &result) {
            return;
        }
        let Some(done) = done else {
            return;
        };
        let request = done.request.frame();
        match &result {
            Ok(reply) => {
                self.in_flight().answered(&request, reply);
                self.shared.gate().answered(&request);
                let now = self.now();
                (self.shared.known()).answered(now, &request, &reply.frame());
                self.overhear(reply);
                self.observe(&request, &reply.frame());
            }
            Err(failure) => {
                if let (Failure::Uncertain { .. }, true) = (failure, request.ctrl().queued()) {
                    InFlightMotion::maybe_queued(&mut self.in_flight());
                }
                self.shared.known().failed(&request, failure);
            }
        }
        let result = result.map_err(|failure| match failure {
            Failure::Lost => self.gone(),
            failure => explain(&request, failure),
        });
        match done.to {
            To::Caller(reply) => drop(reply.send(result)),
            To::Halt(number) => self.halt_answered(number, result.map(drop)),
            To::Settling => self.settles(result.map(drop)),
            To::Poll => self.polled(),
            To::Jog(reply, jog) => self.jog_began(result.map(drop), reply, jog),
            To::JogStop => self.jog_stopped(result),
            To::JogPose => self.jog_pose(result),
            To::JogLook(jog, asked) => self.jog_seen(result, jog, asked),
            To::Nobody => {}
        }
    }
}
