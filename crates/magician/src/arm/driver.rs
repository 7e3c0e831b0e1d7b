//! The task between a handle and its line: it owns the connection and the transport, and it is the
//! one that stops the arm when the handle goes.

use std::future::{Future, poll_fn};
use std::io;
use std::pin::Pin;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use magician_protocol::commands::{JogCmd, QueuedCmdStartExec};
use magician_protocol::{Frame, FrameBuf, Row, Writable};
use tokio::sync::{mpsc, oneshot};
use tokio::task::yield_now;
use tokio::time::{Instant, Sleep, sleep_until};

use super::exposure::{Exposure, moves};
use super::{Mishap, Shared};
use crate::connection::{Connection, Event, Failure, Micros, Priority, Request, Stats, Ticket};
use crate::transport::Transport;
use crate::{Error, ErrorKind, Result};

/// How long a handle that goes gives the arm to confirm the stop.
const FAREWELL: Duration = Duration::from_millis(500);
/// Rounds of reading and writing before other tasks get their turn.
const ROUNDS: usize = 64;
/// A task that was not served for so long may have missed something.
const AWAY: Micros = 20_000;

/// A handle's wish. Nearly all are requests, so their size is no waste.
#[allow(clippy::large_enum_variant)]
pub(super) enum Message {
    Submit {
        request: Request,
        deadline: Instant,
        /// Stops before this was begun.
        stops: u64,
        reply: oneshot::Sender<Result<FrameBuf>>,
    },
    Stats(oneshot::Sender<(Stats, u32)>),
}

struct Waiting {
    ticket: Ticket,
    request: FrameBuf,
    reply: Option<oneshot::Sender<Result<FrameBuf>>>,
}

/// Why the task's round ended.
enum Ended {
    /// Nobody looked at the line for a while; the system is to be asked what has come.
    Away,
    /// The handle is gone.
    Left,
    /// The line broke.
    Broken(io::Error),
    /// The farewell is said.
    Farewell,
}

pub(super) struct Driver {
    connection: Connection,
    transport: Box<dyn Transport>,
    messages: mpsc::Receiver<Message>,
    shared: Arc<Shared>,
    waiting: Vec<Waiting>,
    out: Option<(FrameBuf, usize)>,
    begun: Instant,
    timer: Pin<Box<Sleep>>,
    name: String,
    /// The stop of a handle that has gone is under way.
    leaving: bool,
    broken: bool,
    /// When the task was served last.
    served: Micros,
    /// The line was looked at since.
    looked: bool,
}

impl Driver {
    pub(super) fn new(
        connection: Connection,
        transport: Box<dyn Transport>,
        messages: mpsc::Receiver<Message>,
        shared: Arc<Shared>,
        name: String,
    ) -> Self {
        let begun = Instant::now();
        Self {
            connection,
            transport,
            messages,
            shared,
            waiting: Vec::new(),
            out: None,
            begun,
            timer: Box::pin(sleep_until(begun)),
            name,
            leaving: false,
            broken: false,
            served: 0,
            looked: false,
        }
    }

    /// Serves the handle until it goes, then stops what it set going.
    pub(super) async fn run(mut self) {
        match self.serve().await {
            Ended::Broken(error) => self.refuse_all(error).await,
            Ended::Left | Ended::Farewell | Ended::Away => {
                if self.say_farewell() {
                    let _ = self.serve().await;
                }
            }
        }
    }

    async fn serve(&mut self) -> Ended {
        loop {
            match poll_fn(|cx| self.poll(cx)).await {
                // This gives the runtime the time to ask the system.
                Ended::Away => yield_now().await,
                ended => return ended,
            }
        }
    }

    fn poll(&mut self, cx: &mut Context<'_>) -> Poll<Ended> {
        if self.was_away() {
            return Poll::Ready(Ended::Away);
        }
        for _ in 0..ROUNDS {
            // What has come comes first: it may be what a timeout is about to give up.
            let read = match self.read(cx) {
                Ok(read) => read,
                Err(error) => return Poll::Ready(Ended::Broken(error)),
            };
            self.let_time_pass();
            if !self.leaving && self.take_messages(cx).is_ready() {
                return Poll::Ready(Ended::Left);
            }
            self.let_time_pass();
            self.withdraw(cx);
            let wrote = match self.write(cx) {
                Ok(wrote) => wrote,
                Err(error) => return Poll::Ready(Ended::Broken(error)),
            };
            let told = self.tell();
            if self.leaving && self.waiting.is_empty() {
                return Poll::Ready(Ended::Farewell);
            }
            if !read && !wrote && !told && self.sleep(cx).is_pending() {
                self.looked = false;
                return Poll::Pending;
            }
        }
        cx.waker().wake_by_ref();
        Poll::Pending
    }

    /// Whether an answer that nobody waits for any more may lie unread, to be taken for the answer
    /// to what is asked next. A task that shares its thread is woken by a wish before the runtime
    /// has asked the system what came meanwhile; between two blocking calls it does not run at all.
    fn was_away(&mut self) -> bool {
        let now = self.now();
        let idle = now.saturating_sub(std::mem::replace(&mut self.served, now));
        let at_rest = self.connection.is_idle();
        let away = !self.looked && self.connection.is_owed() && (at_rest || idle > AWAY);
        self.looked = true;
        away
    }

    fn let_time_pass(&mut self) {
        let now = self.now();
        if self.connection.poll_timeout().is_some_and(|at| at <= now) {
            self.connection.handle_timeout(now);
        }
    }

    /// Withdraws what nobody waits for any more.
    fn withdraw(&mut self, cx: &mut Context<'_>) {
        for one in &mut self.waiting {
            let closed = |reply: &mut oneshot::Sender<_>| reply.poll_closed(cx).is_ready();
            if one.reply.as_mut().is_some_and(closed) {
                one.reply = None;
                self.connection.cancel(one.ticket);
            }
        }
    }

    /// Ready when the handle is gone.
    fn take_messages(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        while let Poll::Ready(message) = self.messages.poll_recv(cx) {
            match message {
                None => return Poll::Ready(()),
                Some(Message::Stats(reply)) => {
                    let answer = (self.connection.stats(), self.connection.capacity());
                    let _ = reply.send(answer);
                }
                Some(Message::Submit {
                    request,
                    deadline,
                    stops,
                    reply,
                }) => {
                    let frame = request.frame().frame();
                    let over = stops != self.shared.stops.load(Ordering::SeqCst);
                    if over && sets_going(&frame) {
                        let _ = reply.send(Err(explain(&frame, Failure::Stopped)));
                    } else {
                        self.submit(request, deadline, Some(reply));
                    }
                }
            }
        }
        Poll::Pending
    }

    fn submit(
        &mut self,
        request: Request,
        deadline: Instant,
        reply: Option<oneshot::Sender<Result<FrameBuf>>>,
    ) {
        let deadline = micros(deadline.saturating_duration_since(self.begun));
        let frame = *request.frame();
        let ticket = self.connection.submit(request.deadline(deadline));
        self.waiting.push(Waiting {
            ticket,
            request: frame,
            reply,
        });
    }

    fn write(&mut self, cx: &mut Context<'_>) -> io::Result<bool> {
        if self.out.is_none() {
            let now = self.now();
            self.out = self.connection.poll_transmit(now).map(|frame| (frame, 0));
            if let Some((frame, _)) = &self.out {
                tracing::trace!(frame = ?frame, "to {}", self.name);
                self.exposure(|exposure| exposure.sends(&frame.frame()));
            }
        }
        let Some((frame, written)) = &mut self.out else {
            return Ok(false);
        };
        let rest = frame.bytes().get(*written..).unwrap_or_default();
        match self.transport.poll_write(cx, rest) {
            Poll::Pending => Ok(false),
            Poll::Ready(Err(error)) => Err(error),
            Poll::Ready(Ok(0)) => Err(io::ErrorKind::WriteZero.into()),
            Poll::Ready(Ok(count)) => {
                *written += count;
                if *written >= frame.bytes().len() {
                    self.out = None;
                }
                Ok(true)
            }
        }
    }

    fn read(&mut self, cx: &mut Context<'_>) -> io::Result<bool> {
        let mut bytes = [0; 1024];
        match self.transport.poll_read(cx, &mut bytes) {
            Poll::Pending => Ok(false),
            Poll::Ready(Err(error)) => Err(error),
            Poll::Ready(Ok(0)) => Err(io::ErrorKind::UnexpectedEof.into()),
            Poll::Ready(Ok(count)) => {
                let now = self.now();
                let bytes = bytes.get(..count).unwrap_or_default();
                self.connection.receive(now, bytes);
                Ok(true)
            }
        }
    }

    /// Passes the connection's events on; whether there were any.
    fn tell(&mut self) -> bool {
        let mut told = false;
        while let Some(event) = self.connection.poll_event() {
            told = true;
            match event {
                Event::Done { ticket, result } => self.deliver(ticket, result),
                Event::Reset => {
                    tracing::warn!("{}: the arm was switched off and on, or reset", self.name);
                    let gone = self.exposure(Exposure::reset);
                    self.shared.mishap(Mishap::Reset(gone));
                }
                Event::Unaccounted { from, to } => {
                    tracing::warn!(
                        from,
                        to,
                        "{}: queued commands nobody here sent, or sent once",
                        self.name
                    );
                    self.shared.mishap(Mishap::Unaccounted { from, to });
                }
            }
        }
        told
    }

    fn deliver(&mut self, ticket: Ticket, result: Result<FrameBuf, Failure>) {
        let Some(at) = self.waiting.iter().position(|one| one.ticket == ticket) else {
            return;
        };
        let done = self.waiting.swap_remove(at);
        let request = done.request.frame();
        match &result {
            Ok(reply) => self.exposure(|exposure| exposure.answered(&request, reply)),
            Err(Failure::Uncertain { .. }) if request.ctrl().queued() => {
                self.exposure(Exposure::maybe_queued);
            }
            Err(_) => {}
        }
        let result = result.map_err(|failure| explain(&request, failure));
        if let Some(reply) = done.reply {
            let _ = reply.send(result);
        }
    }

    /// Pending with the timer set, or ready when its instant has come.
    fn sleep(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        let Some(at) = self.connection.poll_timeout() else {
            return Poll::Pending;
        };
        self.timer
            .as_mut()
            .reset(self.begun + Duration::from_micros(at));
        self.timer.as_mut().poll(cx)
    }

    /// What the handle has set going is to be stopped; false when there is nothing to do.
    fn say_farewell(&mut self) -> bool {
        self.leaving = true;
        let deadline = Instant::now() + FAREWELL;
        let requests = self.last_requests();
        // Nobody is there any more to hear these answers.
        self.waiting.clear();
        for request in requests {
            self.submit(request, deadline, None);
        }
        !self.waiting.is_empty()
    }

    fn last_requests(&self) -> Vec<Request> {
        if self.shared.detached.load(Ordering::SeqCst) {
            return Vec::new();
        }
        let unanswered = (self.waiting.iter()).any(|one| one.request.frame().ctrl().queued());
        let (moving, laser) = self.exposure(|exposure| {
            if unanswered {
                exposure.maybe_queued();
            }
            (exposure.moving(), exposure.laser())
        });
        let [stop, dark, clear] = match Request::halt() {
            Ok(halt) => halt.map(|request| request.priority(Priority::Stop)),
            Err(_) => return Vec::new(),
        };
        let wanted = [(moving, stop), (laser, dark), (moving, clear)];
        let wanted = wanted.into_iter().filter(|(wanted, _)| *wanted);
        wanted.map(|(_, request)| request).collect()
    }

    /// The line is broken: every present and coming request is told so.
    async fn refuse_all(&mut self, error: io::Error) {
        self.broken = true;
        let gone = || {
            let error = error.raw_os_error().map_or_else(
                || io::Error::from(error.kind()),
                io::Error::from_raw_os_error,
            );
            Error::gone(&self.name, error)
        };
        for one in self.waiting.drain(..) {
            if let Some(reply) = one.reply {
                let _ = reply.send(Err(gone()));
            }
        }
        while let Some(message) = self.messages.recv().await {
            if let Message::Submit { reply, .. } = message {
                let _ = reply.send(Err(gone()));
            }
        }
    }

    fn exposure<T>(&self, with: impl FnOnce(&mut Exposure) -> T) -> T {
        let exposure: &Mutex<Exposure> = &self.shared.exposure;
        with(&mut exposure.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn now(&self) -> Micros {
        micros(self.begun.elapsed())
    }
}

impl Drop for Driver {
    /// The runtime goes before the farewell is over: what can still be written is written.
    fn drop(&mut self) {
        if self.broken || self.leaving && self.waiting.is_empty() {
            return;
        }
        let mut cx = Context::from_waker(Waker::noop());
        if let Some((frame, written)) = self.out.take() {
            let rest = frame.bytes().get(written..).unwrap_or_default();
            let _ = self.transport.poll_write(&mut cx, rest);
        }
        for request in self.last_requests() {
            let _ = self.transport.poll_write(&mut cx, request.frame().bytes());
        }
    }
}

pub(super) fn micros(time: Duration) -> Micros {
    Micros::try_from(time.as_micros()).unwrap_or(Micros::MAX)
}

/// The vendor's name of what a request does, or its id.
pub(super) fn command_name(request: &Frame<'_>) -> String {
    match Row::with_id(request.id()) {
        Some(row) => row.form_name(request.ctrl()).to_owned(),
        None => format!("command {}", request.id()),
    }
}

/// Whether a request is a movement, or lets the queue make one.
fn sets_going(request: &Frame<'_>) -> bool {
    let halts = request.id() == JogCmd::ROW.id && request.params().get(1) == Some(&0);
    let immediate = moves(request.id()) && request.ctrl().write() && !halts;
    request.ctrl().queued() || immediate || request.id() == QueuedCmdStartExec::ROW.id
}

fn explain(request: &Frame<'_>, failure: Failure) -> Error {
    let error = match failure {
        Failure::Timeout { sent: 0 } => Error::new(
            ErrorKind::Timeout,
            "it could not be sent in time: the arm did not answer what went before",
        ),
        Failure::Timeout { sent } => {
            let times = if sent == 1 { "once" } else { "again and again" };
            Error::new(
                ErrorKind::Timeout,
                format!("no answer; it was sent {times}"),
            )
        }
        Failure::Uncertain { from, to } => Error::uncertain(from, to),
        Failure::QueueFull => Error::new(
            ErrorKind::QueueFull,
            "the arm's queue is full; nothing was stored",
        ),
        Failure::Refused => Error::new(ErrorKind::Unexpected, "the arm refuses it"),
        Failure::NoIndex => Error::new(
            ErrorKind::Unexpected,
            "the answer to a queued command carries no index",
        ),
        Failure::Stopped => Error::new(
            ErrorKind::Closed,
            "a stop, or a reset of the arm, came first; it was not sent",
        ),
        Failure::Lost => Error::new(ErrorKind::Port, "the line to the arm broke"),
        Failure::Draining => Error::new(
            ErrorKind::Timeout,
            "it was not sent: the queue was cleared, and the command under way has not finished",
        ),
        Failure::Busy => Error::invalid("too many requests wait at once"),
    };
    error.with_command(command_name(request))
}
