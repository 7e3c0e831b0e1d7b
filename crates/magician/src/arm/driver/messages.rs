//! Messages from the handles to the driver task.

use std::task::{Context, Poll};

use magician_protocol::commands::JogCmd;
use magician_protocol::{Frame, FrameBuf, Writable};
use tokio::sync::oneshot;
use tokio::time::Instant;

use super::explain::{explain, halts, sets_going, stops_at_once};
use super::jog::JogStart;
use super::{Driver, Program, ReplyTarget, RoundEnd, Waiting, micros};
use crate::Result;
use crate::arm::shared::QueueFault;
use crate::connection::{Failure, Priority, Request, Stats, Ticket};
use crate::gate::frame_jogs;

/// Message from a handle to the driver task. Not boxed: almost every message is a request.
#[allow(clippy::large_enum_variant)]
pub(in crate::arm) enum Message {
    Submit {
        request: Request,
        deadline: Instant,
        /// Stops before the call began.
        stops: u64,
        reply: oneshot::Sender<Result<FrameBuf>>,
    },
    /// Runs a program.
    Run(Box<Program>),
    Stats(oneshot::Sender<(Stats, u32)>),
    /// Boxed: with a fence it holds the whole trajectory of the jog.
    Jog(Box<JogStart>),
    /// Shared state has changed; the task has to look at it.
    Wake,
    /// Ends the connection, even if other handles exist.
    Close,
}

impl Driver {
    /// Takes the messages of the handles; returns a reason if they end this round of the task.
    pub(super) fn take_messages(&mut self, cx: &mut Context<'_>) -> Option<RoundEnd> {
        loop {
            let message = match self.held.take() {
                Some(held) => held,
                None => match self.messages.poll_recv(cx) {
                    Poll::Pending => break,
                    Poll::Ready(None | Some(Message::Close)) => return Some(RoundEnd::Left),
                    Poll::Ready(Some(message)) if self.may_be_preceded() => {
                        self.held = Some(message);
                        if let Some(wire) = self.line.wire() {
                            wire.ask();
                        }
                        return Some(RoundEnd::Away);
                    }
                    Poll::Ready(Some(message)) => message,
                },
            };
            self.take_message(message);
        }
        self.take_halts();
        None
    }

    /// True if unread bytes may precede the request in a message. Such a reply has no receiver and
    /// could be taken for the answer to that request. Replies that arrive after the request cannot
    /// be distinguished anyway.
    fn may_be_preceded(&self) -> bool {
        self.link_is_up() && self.connection.must_read_before_submit() && self.connection.is_idle()
    }

    fn take_message(&mut self, message: Message) {
        match message {
            Message::Wake | Message::Close => {}
            Message::Run(program) => self.take_program(program),
            Message::Jog(start) => self.start_jog(start),
            Message::Stats(reply) => {
                let answer = (self.connection.stats(), self.connection.capacity());
                // The caller may have given up.
                let _ = reply.send(answer);
            }
            Message::Submit {
                request,
                deadline,
                stops,
                reply,
            } => self.take_request(request, deadline, stops, reply),
        }
    }

    fn take_request(
        &mut self,
        request: Request,
        deadline: Instant,
        stops: u64,
        reply: oneshot::Sender<Result<FrameBuf>>,
    ) {
        let frame = request.frame().frame();
        let over = stops != self.shared.stops();
        if over && sets_going(&frame) {
            // A queue fault since the call began also counts as a stop, and its error says more.
            let fault = self
                .shared
                .queue_fault(Some(stops))
                .map(QueueFault::into_result);
            let _ = reply.send(fault.unwrap_or_else(|| Err(explain(&frame, Failure::Stopped))));
        } else if !self.link_is_up() {
            self.owe(&frame);
            let _ = reply.send(Err(self.gone()));
        } else {
            if frame_jogs(&frame) {
                // Only handles that relay other programs send one.
                self.shared.gate().note_foreign_jog();
                self.carry_out_gate();
            }
            self.steer_program(&frame);
            // Stop commands overtake pending requests.
            let request = if stops_at_once(&frame) {
                request.priority(Priority::Stop)
            } else {
                request
            };
            self.submit(request, deadline, ReplyTarget::Caller(reply));
        }
    }

    /// Takes the stops requested from outside of any task.
    fn take_halts(&mut self) {
        let Some(waiters) = self.shared.take_halt() else {
            return;
        };
        if self.link_is_up() {
            return self.halt(waiters);
        }
        self.owe_halt();
        for waiter in waiters {
            waiter.tell(Err(self.gone()));
        }
    }

    /// Sends a stop on a line that has not settled yet, or remembers it for the next line.
    fn owe_halt(&mut self) {
        if self.link_is_open() {
            self.halt(Vec::new());
        } else {
            self.owes_halt = true;
        }
    }

    /// Remembers a stop that has no line, as the first frame of the next.
    pub(super) fn owe(&mut self, request: &Frame<'_>) {
        if !halts(request) {
            return;
        }
        if request.id() == JogCmd::ROW.id {
            // The gate repeats the stop of a jog, so nothing else has to be remembered.
            self.end_any_jog()
        } else {
            self.owe_halt()
        }
    }

    pub(super) fn submit(&mut self, request: Request, deadline: Instant, to: ReplyTarget) {
        let deadline = micros(deadline.saturating_duration_since(self.begun));
        let frame = *request.frame();
        if halts(&frame.frame()) && !matches!(to, ReplyTarget::JogStop) {
            self.stop_jogs();
        }
        let ticket = self.connection.submit(request.deadline(deadline));
        self.await_answer(ticket, frame, to);
    }

    /// Registers a request whose answer is awaited.
    pub(super) fn await_answer(&mut self, ticket: Ticket, request: FrameBuf, to: ReplyTarget) {
        self.shared.picture().handed_over(&request.frame());
        self.waiting.push(Waiting {
            ticket,
            request,
            to,
        });
    }

    /// Cancels requests whose caller has gone.
    pub(super) fn withdraw(&mut self, cx: &mut Context<'_>) {
        for one in &mut self.waiting {
            if let ReplyTarget::Caller(reply) = &mut one.to
                && reply.poll_closed(cx).is_ready()
            {
                one.to = ReplyTarget::Discard;
                self.connection.cancel(one.ticket);
            }
        }
    }
}
