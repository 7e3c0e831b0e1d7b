//! The task between the handles and their line: it owns the connection and the transport, it stops the arm when the last
//! handle goes, and it looks for a line that broke.
//!
//! It is one future that does everything there is to do and then sleeps until a byte, a message or an instant comes. Its
//! parts are methods of [`Driver`], a file each.

mod answers;
mod explain;
mod greeting;
mod halt;
#[cfg(all(test, unix, feature = "sim"))]
mod held_up;
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
pub(super) use streaming::{End, Program, Reached};

/// Rounds of reading and writing before other tasks get their turn.
const ROUNDS: usize = 64;
/// A task that was not served for so long may have missed something.
const AWAY: Micros = 20_000;
/// A timer that rings so late: the process was stopped, or the computer slept.
const SLEPT: Micros = 500_000;
/// Most reads in a row before time passes, on a line that is never empty.
const READS: usize = 256;
/// Most writes in a row before the line is read again: a frame for each place in the widest window.
const WRITES: usize = 8;

/// A request that is under way.
struct Waiting {
    ticket: Ticket,
    request: FrameBuf,
    to: To,
}

/// The receiver of a reply.
enum To {
    /// A handle.
    Caller(oneshot::Sender<Result<FrameBuf>>),
    /// A stop from outside of any task: its number.
    Halt(u64),
    /// What is read of an arm that was found again.
    Settling,
    /// The onlookers.
    Poll,
    /// The starter of a jog.
    Jog(oneshot::Sender<Result<()>>, JogId),
    /// The end of a jog.
    JogStop,
    JogPose,
    /// Where a jog is, and when that was asked.
    JogLook(JogId, Micros),
    /// None any more, or only observers of all traffic.
    Nobody,
}

/// Why the task's round ended.
enum Ended {
    /// The line was not read for a while, or not since a request came; the system is to be asked for new bytes.
    Away,
    /// The handles are gone.
    Left,
    /// The last frames of a shutdown are out.
    Farewell,
}

pub(super) struct Driver {
    connection: Connection,
    line: State,
    messages: mpsc::Receiver<Message>,
    /// A wish that is taken up when the line was looked at since it came.
    held: Option<Message>,
    shared: Arc<Shared>,
    waiting: Vec<Waiting>,
    /// The program that runs.
    program: Option<Program>,
    begun: Instant,
    timer: Pin<Box<Sleep>>,
    /// Stops from outside of any task that are not answered yet, and how many there were.
    halting: Vec<Halting>,
    halts: u64,
    /// A stop was asked for while there was no line: it is the first thing to be said over the next one.
    owes_halt: bool,
    /// When the arm is to be asked for it.
    introduction: Option<Micros>,
    /// The stop of handles that have gone is under way.
    leaving: bool,
    polls: Polls,
    jogging: Jogging,
    leading: VirtualTimeDriver,
    events: broadcast::Sender<Event>,
    /// When the task was served last.
    served: Micros,
    /// The line was looked at since.
    looked: bool,
    /// When the timer is to ring.
    rings: Option<Micros>,
    /// What the timer is set to.
    set: Option<Micros>,
    /// When this round began: all that happens in it happens then.
    now: Micros,
}

impl Driver {
    /// `opener` opens the line again when it breaks; `introduce` asks the arm for what it can be told by.
    pub(super) fn new(
        line: Line,
        window: usize,
        opener: Option<Opener>,
        introduce: bool,
        messages: mpsc::Receiver<Message>,
        (shared, events): (Arc<Shared>, broadcast::Sender<Event>),
    ) -> Self {
        let settings = Settings {
            window,
            ..line.settings
        };
        let begun = shared.begun;
        let introduce = introduce && opener.is_some();
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
            introduction: introduce.then_some(search::INTRODUCTION),
            leaving: false,
            polls: Polls::default(),
            jogging: Jogging::default(),
            leading: VirtualTimeDriver::default(),
            events,
            served: 0,
            looked: false,
            rings: None,
            set: None,
            now: 0,
        }
    }

    /// Serves the handles until they go, then stops what they set going.
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
                // This gives the runtime the time to ask the system.
                Ended::Away => yield_now().await,
                Ended::Left | Ended::Farewell => return,
            }
        }
    }

    /// A round ends where it began if nothing went out: what comes then wakes the task.
    fn poll(&mut self, cx: &mut Context<'_>) -> Poll<Ended> {
        self.look_at_clock();
        self.note_sleep();
        if self.was_away() {
            return Poll::Ready(Ended::Away);
        }
        for round in 0..ROUNDS {
            if round > 0 {
                self.look_at_clock();
            }
            // All that has come comes first: it may be what a timeout is about to give up.
            let more = self.read_all(cx);
            self.let_time_pass();
            if !self.leaving
                && let Some(ended) = self.take_messages(cx)
            {
                // After an `Away` the system was asked: what is held comes up with the line read.
                self.looked = true;
                return Poll::Ready(ended);
            }
            self.let_time_pass();
            self.heed_stop();
            // Answers come before what they make due, so that it goes out in the same round.
            self.tell();
            self.withdraw(cx);
            self.do_what_is_due();
            let ended = self.drive_program(cx);
            let wrote = self.write_all(cx);
            let told = self.tell();
            if self.leaving && (self.waiting.is_empty() || !self.link_is_up()) {
                return Poll::Ready(Ended::Farewell);
            }
            let busy = more || wrote || told || ended;
            if !busy && !self.go_on_in_time() && self.sleep(cx).is_pending() {
                self.looked = false;
                return Poll::Pending;
            }
        }
        cx.waker().wake_by_ref();
        Poll::Pending
    }

    /// Whether a reply without a waiter may lie unread, to be taken for the answer to what this task asks
    /// next by itself. A task that shares its thread is woken before the runtime has asked the system what came meanwhile.
    fn was_away(&mut self) -> bool {
        let now = self.now();
        let idle = now.saturating_sub(std::mem::replace(&mut self.served, now));
        let at_rest = self.connection.is_idle();
        let owed = self.link_is_up() && self.connection.is_owed();
        let away = !self.looked && owed && (at_rest || idle > AWAY);
        self.looked = true;
        away
    }

    /// Reads until nothing more is there; whether another round has to look, because there may be, or the line has changed.
    fn read_all(&mut self, cx: &mut Context<'_>) -> bool {
        let reads = (0..READS).take_while(|_| self.read(cx)).count();
        reads == READS || reads > 0 && !self.link_is_up()
    }

    /// Writes all that may go out; whether anything did.
    fn write_all(&mut self, cx: &mut Context<'_>) -> bool {
        (0..WRITES).take_while(|_| self.write(cx)).count() > 0
    }

    /// A process that was stopped or slept: no deadline ran meanwhile.
    fn note_sleep(&mut self) {
        let (now, since) = (self.now(), self.served);
        let late = self.rings.take().map_or(0, |at| now.saturating_sub(at));
        if late < SLEPT {
            return;
        }
        let slept = now.saturating_sub(since);
        tracing::debug!(slept, "{}: this program was held up", self.shared.name);
        self.connection.slept(since, now);
        self.shared.note_sleep(slept);
    }

    fn let_time_pass(&mut self) {
        let now = self.now();
        if self.connection.poll_timeout().is_some_and(|at| at <= now) {
            self.connection.handle_timeout(now);
        }
        self.line.let_time_pass(now);
    }

    /// Our own requests whose time has come.
    fn do_what_is_due(&mut self) {
        if self.leaving {
            return;
        }
        let now = self.now();
        if self.link_is_up() {
            self.introduce(now);
            self.poll_state(now);
        }
        if self.link_is_open() {
            self.mind_jog(now);
        }
    }

    /// When something is due next.
    fn next_timeout(&self) -> Option<Micros> {
        let up = self.link_is_up() && !self.leaving;
        let program = (self.program.as_ref()).and_then(|program| program.stream.poll_timeout());
        let open = self.link_is_open() && !self.leaving;
        let due = [
            self.connection.poll_timeout(),
            self.line.poll_timeout().filter(|_| !self.leaving),
            self.introduction.filter(|_| up),
            program,
            self.polls.poll_timeout().filter(|_| up),
            self.jog_timeout().filter(|_| open),
            self.leading.poll_timeout().filter(|_| up),
        ];
        due.into_iter().flatten().min()
    }

    /// Pending with the timer set, or ready when its instant has come.
    fn sleep(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.rings = self.next_timeout();
        let Some(at) = self.rings else {
            return Poll::Pending;
        };
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

    /// The instant so many microseconds from the beginning.
    fn at(&self, time: Micros) -> Instant {
        self.begun + Duration::from_micros(time)
    }
}

pub(in crate::arm) fn micros(time: Duration) -> Micros {
    Micros::try_from(time.as_micros()).unwrap_or(Micros::MAX)
}
