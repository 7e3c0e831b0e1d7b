//! The driver task between the handles and their line.
//!
//! It owns the connection and the transport, stops the arm when the last handle is dropped, and
//! reconnects a broken line. It is one future: each round reads what has arrived, takes messages,
//! lets timers expire, feeds the running program and writes; without more work it sleeps until a
//! byte, a message or a deadline comes. Its parts are methods of [`Driver`], in a file each.

mod answers;
mod explain;
mod halt;
#[cfg(all(test, unix, feature = "sim"))]
mod held_up;
mod identification;
mod jog;
mod lead;
mod line;
mod messages;
mod polls;
mod publish;
mod search;
mod shutdown;
mod streaming;
mod wire;
#[cfg(all(test, feature = "sim"))]
mod work;

use std::future::{Future, poll_fn};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use magician_protocol::FrameBuf;
use tokio::sync::{broadcast, mpsc, oneshot};
use tokio::task::yield_now;
use tokio::time::{Instant, Sleep, sleep_until};

use super::Shared;
use super::events::Event;
use crate::Result;
use crate::connection::{Connection, Micros, Settings, Ticket};
use crate::gate::JogId;
use crate::transport::Line;
pub(super) use explain::{command_name, sets_going};
use halt::Halting;
use jog::Jogging;
pub(super) use jog::{JogStart, OwnJog};
use lead::VirtualTimeDriver;
pub(super) use line::Opener;
use line::State;
pub(super) use messages::Message;
use polls::Polls;
pub(crate) use shutdown::SHUTDOWN;
pub(super) use streaming::{Program, RunEnd, RunProgress};

/// Rounds before other tasks get a turn. Choice: without a limit a run on a virtual arm, which is
/// always ready, would starve them.
const MAX_ROUNDS_PER_TURN: usize = 64;
/// Time without being polled, us, after which bytes may have arrived unseen. Choice.
const UNPOLLED_THRESHOLD: Micros = 20_000;
/// Delay of a timer, us, that means a suspended process (stopped, or the computer asleep). Choice:
/// far above the delays of a busy machine.
const SUSPEND_THRESHOLD: Micros = 500_000;
/// Most reads in a row before timers are checked, on a line that never runs empty.
const MAX_READS_PER_ROUND: usize = 256;
/// Most writes in a row before the line is read again: one frame for each place of the widest
/// window.
const MAX_WRITES_PER_ROUND: usize = 8;

/// Request in flight.
struct Waiting {
    ticket: Ticket,
    request: FrameBuf,
    to: ReplyTarget,
}

/// Receiver of a reply.
enum ReplyTarget {
    /// A handle.
    Caller(oneshot::Sender<Result<FrameBuf>>),
    /// A stop from outside of any task, by its number.
    Halt(u64),
    /// State reads on a reconnected line.
    Settling,
    /// State watches.
    Poll,
    /// The caller that starts a jog.
    Jog(oneshot::Sender<Result<()>>, JogId),
    /// The end of a jog.
    JogStop,
    JogPose,
    /// Position of a jog, and the time of the request.
    JogLook(JogId, Micros),
    /// No receiver; only the picture sees the answer.
    Discard,
}

/// Reason for the end of a round.
enum RoundEnd {
    /// The line was not read for a while, or not since a request arrived; the system has to be
    /// asked for new bytes.
    Away,
    /// All handles are gone.
    Left,
    /// The last frames of a shutdown are sent.
    ShutdownSent,
}

pub(super) struct Driver {
    connection: Connection,
    line: State,
    messages: mpsc::Receiver<Message>,
    /// Message that waits until the line has been read once more.
    held: Option<Message>,
    shared: Arc<Shared>,
    waiting: Vec<Waiting>,
    /// Running program.
    program: Option<Program>,
    begun: Instant,
    timer: Pin<Box<Sleep>>,
    /// Unanswered stops from outside of any task, and their number so far.
    halting: Vec<Halting>,
    halts: u64,
    /// True if a stop was requested while the line was lost: it is sent first on the next one.
    owes_halt: bool,
    /// Time at which the arm is asked for its identity.
    identity_read_at: Option<Micros>,
    /// True during shutdown, after the last handle.
    leaving: bool,
    polls: Polls,
    jogging: Jogging,
    leading: VirtualTimeDriver,
    events: broadcast::Sender<Event>,
    /// Time of the last poll.
    served: Micros,
    /// True if the line was read since.
    looked: bool,
    /// Time for which the timer is needed.
    timer_due: Option<Micros>,
    /// Time to which the timer is set.
    set: Option<Micros>,
    /// Time of this round: everything in it happens then.
    now: Micros,
}

impl Driver {
    /// Creates the driver. `opener` reopens the line after a break. With `reads_identity` the
    /// driver reads the identity of the arm soon after the start.
    pub(super) fn new(
        line: Line,
        window: usize,
        opener: Option<Opener>,
        reads_identity: bool,
        messages: mpsc::Receiver<Message>,
        (shared, events): (Arc<Shared>, broadcast::Sender<Event>),
    ) -> Self {
        let settings = Settings {
            window,
            ..line.settings
        };
        let begun = shared.begun;
        let reads_identity = reads_identity && opener.is_some();
        Self {
            connection: Connection::new(settings),
            line: State::up(line.transport, opener),
            messages,
            held: None,
            shared,
            waiting: Vec::new(),
            program: None,
            begun,
            timer: Box::pin(sleep_until(begun)),
            halting: Vec::new(),
            halts: 0,
            owes_halt: false,
            identity_read_at: reads_identity.then_some(search::IDENTITY_READ_DELAY),
            leaving: false,
            polls: Polls::default(),
            jogging: Jogging::default(),
            leading: VirtualTimeDriver::default(),
            events,
            served: 0,
            looked: false,
            timer_due: None,
            set: None,
            now: 0,
        }
    }

    /// Serves the handles until they are gone, then stops the motion they started.
    pub(super) async fn run(mut self) {
        self.serve().await;
        if self.say_farewell() {
            self.serve().await;
            self.warn_of_what_goes_on();
        }
    }

    async fn serve(&mut self) {
        loop {
            match poll_fn(|cx| self.poll(cx)).await {
                // This lets the runtime ask the system for new bytes.
                RoundEnd::Away => yield_now().await,
                RoundEnd::Left | RoundEnd::ShutdownSent => return,
            }
        }
    }

    /// Runs rounds until there is nothing to do. Bytes that arrive later wake the task.
    fn poll(&mut self, cx: &mut Context<'_>) -> Poll<RoundEnd> {
        self.look_at_clock();
        self.note_suspension();
        if self.was_away() {
            return Poll::Ready(RoundEnd::Away);
        }
        for round in 0..MAX_ROUNDS_PER_TURN {
            if round > 0 {
                self.look_at_clock();
            }
            // Received bytes come first: they may answer a request that is about to time out.
            let more = self.read_all(cx);
            self.handle_timeout();
            if !self.leaving
                && let Some(ended) = self.take_messages(cx)
            {
                // After `Away` the system was asked, so the held message is taken once the line
                // was read.
                self.looked = true;
                return Poll::Ready(ended);
            }
            self.handle_timeout();
            self.heed_stop();
            // Answers are delivered before new requests are due, so that these go out in the same
            // round.
            self.tell();
            self.withdraw(cx);
            self.do_what_is_due();
            let ended = self.drive_program(cx);
            let wrote = self.write_all(cx);
            let told = self.tell();
            if self.leaving && (self.waiting.is_empty() || !self.link_is_up()) {
                return Poll::Ready(RoundEnd::ShutdownSent);
            }
            let busy = more || wrote || told || ended;
            if !busy && !self.go_on_in_time() && self.sleep(cx).is_pending() {
                self.looked = false;
                return Poll::Pending;
            }
        }
        // Still busy after all rounds: yield, and continue at the next poll.
        cx.waker().wake_by_ref();
        Poll::Pending
    }

    /// True if a reply without a receiver may lie unread, which would be taken for the answer to
    /// the task's next request. On a shared thread the task may be woken before the runtime has
    /// asked the system for new bytes.
    fn was_away(&mut self) -> bool {
        let now = self.now();
        // Time without a poll: on a busy thread bytes may have arrived in it.
        let idle = now.saturating_sub(std::mem::replace(&mut self.served, now));
        let at_rest = self.connection.is_idle();
        let owed = self.link_is_up() && self.connection.must_read_before_submit();
        let away = !self.looked && owed && (at_rest || idle > UNPOLLED_THRESHOLD);
        self.looked = true;
        away
    }

    /// Reads until nothing is left; true if another round has to read, because more may come or the
    /// line has changed.
    fn read_all(&mut self, cx: &mut Context<'_>) -> bool {
        let reads = (0..MAX_READS_PER_ROUND)
            .take_while(|_| self.read(cx))
            .count();
        reads == MAX_READS_PER_ROUND || reads > 0 && !self.link_is_up()
    }

    /// Writes everything that may be sent; true if anything was.
    fn write_all(&mut self, cx: &mut Context<'_>) -> bool {
        (0..MAX_WRITES_PER_ROUND)
            .take_while(|_| self.write(cx))
            .count()
            > 0
    }

    /// Excludes the time of a suspended process from all deadlines.
    fn note_suspension(&mut self) {
        let (now, since) = (self.now(), self.served);
        // The timer should have fired at `timer_due`; what it is late by is the suspension.
        let late = self.timer_due.take().map_or(0, |at| now.saturating_sub(at));
        if late < SUSPEND_THRESHOLD {
            return;
        }
        let slept = now.saturating_sub(since);
        tracing::debug!(slept, "{}: this program was held up", self.shared.name);
        self.connection.note_suspension(since, now);
        self.shared.note_suspension(slept);
    }

    fn handle_timeout(&mut self) {
        let now = self.now();
        if self.connection.poll_timeout().is_some_and(|at| at <= now) {
            self.connection.handle_timeout(now);
        }
        self.line.handle_timeout(now);
    }

    /// Sends the driver's own requests that are due.
    fn do_what_is_due(&mut self) {
        if self.leaving {
            return;
        }
        let now = self.now();
        if self.link_is_up() {
            self.read_identity(now);
            self.poll_state(now);
        }
        if self.link_is_open() {
            self.mind_jog(now);
        }
    }

    /// Returns the time of the next deadline.
    fn next_timeout(&self) -> Option<Micros> {
        let up = self.link_is_up() && !self.leaving;
        let program = (self.program.as_ref()).and_then(|program| program.stream.poll_timeout());
        let open = self.link_is_open() && !self.leaving;
        let due = [
            self.connection.poll_timeout(),
            self.line.poll_timeout().filter(|_| !self.leaving),
            self.identity_read_at.filter(|_| up),
            program,
            self.polls.poll_timeout().filter(|_| up),
            self.jog_timeout().filter(|_| open),
            self.leading.poll_timeout().filter(|_| up),
        ];
        due.into_iter().flatten().min()
    }

    /// Sets the timer and returns pending; ready if the deadline has passed.
    fn sleep(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.timer_due = self.next_timeout();
        let Some(at) = self.timer_due else {
            return Poll::Pending;
        };
        // Resetting a timer costs a lock in tokio, and most rounds do not change it.
        if self.set.replace(at) != Some(at) {
            self.timer
                .as_mut()
                .reset(self.begun + Duration::from_micros(at));
        }
        self.timer.as_mut().poll(cx)
    }

    fn look_at_clock(&mut self) {
        self.now = micros(self.begun.elapsed());
    }

    fn now(&self) -> Micros {
        self.now
    }

    /// Returns the instant `time` microseconds after the connection began.
    fn at(&self, time: Micros) -> Instant {
        self.begun + Duration::from_micros(time)
    }
}

pub(in crate::arm) fn micros(time: Duration) -> Micros {
    Micros::try_from(time.as_micros()).unwrap_or(Micros::MAX)
}
