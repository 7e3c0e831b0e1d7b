//! The line: in use, broken, looked for, found again.
//!
//! A line that was found is not trusted at once. A connection of its own asks who is there (`greeting.rs`); only when that
//! is the arm of before, the line is handed to the connection that knows the indices, which then reads how far the arm
//! has come. Until that is settled every call is refused. Nothing is sent again.

use std::future::Future;
use std::io;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use magician_protocol::NoArgs;
use magician_protocol::commands::{
    DeviceSn, DeviceTime, QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
};
use tokio::time::Instant;

use super::greeting::{Greeting, Met};
use super::wire::Wire;
use super::{Driver, To};
use crate::arm::events::Event;
use crate::arm::link::Link;
use crate::connection::{Failure, Micros, Request};
use crate::transport::Line;
use crate::{Error, ErrorKind, Result};

/// How soon after its loss a line is looked for, and how often.
const FIRST_LOOK: Micros = 100_000;
const LOOK: Micros = 250_000;
/// How often where another arm was found.
const STRANGER: Micros = 1_000_000;
/// How soon the arm is asked what it can be told by: programs that are done by then do not pay for it.
pub(super) const INTRODUCTION: Micros = 100_000;
/// How long an arm may take to answer what is of no hurry.
const PATIENCE: Duration = Duration::from_millis(500);
/// How long one that was found again may take to tell how far it is.
const SETTLING: Duration = Duration::from_secs(1);

/// Opens the line again.
pub(in crate::arm) type Opener = Box<dyn FnMut() -> Opening + Send>;
type Opening = Pin<Box<dyn Future<Output = Result<Line>> + Send>>;

/// The line, and the way to it.
pub(super) struct State {
    opener: Option<Opener>,
    stage: Stage,
    /// How it was lost, until it is up again.
    lost: Option<Lost>,
}

// There is one of it in a task that is boxed anyway.
#[allow(clippy::large_enum_variant)]
enum Stage {
    Up(Wire),
    /// Found again, and the arm tells how far it is.
    Settling {
        wire: Wire,
        /// Answers that have not come.
        left: usize,
        reset: bool,
    },
    Greeting(Greeting),
    Opening(Opening),
    /// The instant of the next look, if there is to be one.
    Lost(Option<Micros>),
}

/// How it was lost.
struct Lost {
    since: Instant,
    error: Broken,
    /// What is wrong, when it is not only that the line broke.
    stranger: Option<String>,
}

/// An I/O error that can be told any number of times.
enum Broken {
    System(i32),
    Kind(io::ErrorKind),
}

impl From<&io::Error> for Broken {
    fn from(error: &io::Error) -> Self {
        (error.raw_os_error()).map_or_else(|| Self::Kind(error.kind()), Self::System)
    }
}

impl Broken {
    fn error(&self) -> io::Error {
        match self {
            Self::System(code) => io::Error::from_raw_os_error(*code),
            Self::Kind(kind) => (*kind).into(),
        }
    }
}

impl State {
    pub(super) fn up(
        transport: Box<dyn crate::transport::Transport>,
        opener: Option<Opener>,
    ) -> Self {
        Self {
            opener,
            stage: Stage::Up(Wire::new(transport)),
            lost: None,
        }
    }

    /// The line to the arm, for those who do not wait until it has settled.
    pub(super) fn wire(&mut self) -> Option<&mut Wire> {
        match &mut self.stage {
            Stage::Up(wire) | Stage::Settling { wire, .. } => Some(wire),
            Stage::Greeting(_) | Stage::Opening(_) | Stage::Lost(_) => None,
        }
    }

    /// Closes the line, and looks for it no more.
    pub(super) fn let_go(&mut self) {
        self.opener = None;
        self.stage = Stage::Lost(None);
    }

    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        match &self.stage {
            Stage::Lost(look) => *look,
            Stage::Greeting(greeting) => greeting.poll_timeout(),
            Stage::Up(_) | Stage::Settling { .. } | Stage::Opening(_) => None,
        }
    }

    pub(super) fn let_time_pass(&mut self, now: Micros) {
        if let Stage::Greeting(greeting) = &mut self.stage {
            greeting.let_time_pass(now);
        }
    }
}

/// Bytes.
impl Driver {
    /// Whether the line is there and calls go over it.
    pub(super) fn link_is_up(&self) -> bool {
        matches!(self.line.stage, Stage::Up(_))
    }

    /// Whether the line to the arm is there, for what is to be said before anything else.
    pub(super) fn link_is_open(&self) -> bool {
        matches!(self.line.stage, Stage::Up(_) | Stage::Settling { .. })
    }

    /// Reads what has come, or looks for the line; whether anything happened.
    pub(super) fn read(&mut self, cx: &mut Context<'_>) -> bool {
        let now = self.now();
        if let Some(wire) = self.line.wire() {
            return match wire.read(cx, now, &mut self.connection) {
                Ok(read) => read,
                Err(error) => self.lose(&error),
            };
        }
        // Whoever leaves waits for no line.
        !self.leaving && self.look_for_it(cx, now)
    }

    pub(super) fn write(&mut self, cx: &mut Context<'_>) -> bool {
        let now = self.now();
        let Some(wire) = self.line.wire() else {
            return false;
        };
        let shared = &self.shared;
        let begins = |frame: &magician_protocol::FrameBuf| {
            tracing::trace!(frame = ?frame, "to {}", shared.name);
            shared.exposure().sends(&frame.frame());
        };
        match wire.write(cx, now, &mut self.connection, begins) {
            Ok(wrote) => wrote,
            Err(error) => self.lose(&error),
        }
    }

    /// The line broke. Everything under way ends as the connection says.
    fn lose(&mut self, error: &io::Error) -> bool {
        let first = self.line.lost.is_none();
        self.line.lost.get_or_insert_with(|| Lost {
            since: Instant::now(),
            error: Broken::from(error),
            stranger: None,
        });
        self.look_again(if first { FIRST_LOOK } else { LOOK });
        let under_way: Vec<_> = self.waiting.iter().map(|one| one.request).collect();
        under_way.iter().for_each(|one| self.owe(&one.frame()));
        self.interrupt_jog();
        self.polls.interrupt();
        if let Some(program) = &mut self.program {
            program.stream.interrupt(Failure::Lost);
        }
        self.connection.interrupt();
        if first {
            tracing::warn!("{}", self.gone());
        }
        self.publish_loss();
        if first {
            let why = self.gone().to_string().into();
            self.happens(Event::LinkLost { why });
        }
        true
    }

    fn look_again(&mut self, pause: Micros) {
        let sought = self.line.opener.is_some();
        let look = self.now().saturating_add(pause);
        self.line.stage = Stage::Lost(sought.then_some(look));
    }

    /// Why a call fails while there is no line.
    pub(super) fn gone(&self) -> Error {
        let Some(lost) = &self.line.lost else {
            return Error::new(ErrorKind::Port, "the line to the arm broke");
        };
        if let Some(stranger) = &lost.stranger {
            return Error::new(ErrorKind::Port, stranger);
        }
        let source = lost.error.error();
        if self.line.opener.is_none() {
            return Error::gone(&self.shared.name, source);
        }
        let message = format!(
            "the connection to {} broke off: {source}; it is being looked for again",
            self.shared.name
        );
        Error::new(ErrorKind::Port, message).with_source(source)
    }

    fn publish_loss(&self) {
        if let Some(lost) = &self.line.lost {
            let sought = self.line.opener.is_some();
            let link = Link::lost(lost.since, self.gone().to_string(), sought);
            self.publish_link(link);
        }
    }
}

/// The way back.
impl Driver {
    /// Goes on with looking for the line; whether anything happened.
    fn look_for_it(&mut self, cx: &mut Context<'_>, now: Micros) -> bool {
        match &mut self.line.stage {
            Stage::Lost(Some(look)) if *look <= now => {
                let Some(opener) = &mut self.line.opener else {
                    return false;
                };
                self.line.stage = Stage::Opening(opener());
                true
            }
            Stage::Opening(opening) => {
                let Poll::Ready(opened) = opening.as_mut().poll(cx) else {
                    return false;
                };
                match opened {
                    Ok(line) => {
                        let greeting = Greeting::new(now, line, self.serial.is_some());
                        self.line.stage = Stage::Greeting(greeting);
                    }
                    Err(error) => {
                        tracing::debug!(%error, "{}: not found yet", self.shared.name);
                        self.look_again(LOOK);
                    }
                }
                true
            }
            Stage::Greeting(greeting) => {
                let (busy, met) = greeting.go_on(cx, now);
                if let Some(met) = met {
                    self.meet(met);
                }
                busy
            }
            Stage::Lost(_) | Stage::Up(_) | Stage::Settling { .. } => false,
        }
    }

    /// Somebody is at the end of the line, or nobody.
    fn meet(&mut self, met: Met) {
        match met {
            Err(why) => {
                tracing::debug!("{}: {why}", self.shared.name);
                self.look_again(LOOK);
            }
            Ok(said) => match (&self.serial, said) {
                (Some(known), Some(other)) if *known == other => self.settle(),
                (None, _) => self.settle(),
                (Some(known), other) => {
                    let stranger = self.stranger(known, other.as_deref());
                    self.refuse_stranger(stranger);
                }
            },
        }
    }

    fn stranger(&self, known: &str, other: Option<&str>) -> String {
        let other = other.map_or_else(
            || "it has no serial number".to_owned(),
            |other| format!("its serial number is {other}"),
        );
        format!(
            "another arm answers at {}: {other}, and this connection is to {known}; plug that one in again, or connect \
             anew",
            self.shared.name
        )
    }

    fn refuse_stranger(&mut self, stranger: String) {
        self.look_again(STRANGER);
        if let Some(lost) = &mut self.line.lost
            && lost.stranger.as_ref() != Some(&stranger)
        {
            tracing::warn!("{stranger}");
            lost.stranger = Some(stranger);
            self.publish_loss();
        }
    }

    /// It is the arm of before: how far has it come?
    fn settle(&mut self) {
        let stage = std::mem::replace(&mut self.line.stage, Stage::Lost(None));
        let Stage::Greeting(greeting) = stage else {
            return;
        };
        let requests = [
            Request::get::<DeviceTime>(&NoArgs),
            Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
            Request::get::<QueuedCmdLeftSpace>(&NoArgs),
        ];
        self.line.stage = Stage::Settling {
            wire: greeting.into_wire(),
            left: requests.len(),
            reset: false,
        };
        self.connection.restored();
        if self.owes_halt {
            self.halt(Vec::new());
        }
        let deadline = Instant::now() + SETTLING;
        for request in requests.into_iter().flatten() {
            self.submit(request, deadline, To::Settling);
        }
    }

    /// An answer of an arm that was found again.
    pub(super) fn settles(&mut self, answer: Result<()>) {
        let Stage::Settling { left, .. } = &mut self.line.stage else {
            return;
        };
        if answer.is_err() {
            // It fell silent again: what is known of it is not enough to go on.
            self.lose(&io::ErrorKind::TimedOut.into());
            return;
        }
        *left = left.saturating_sub(1);
        if *left > 0 {
            return;
        }
        let stage = std::mem::replace(&mut self.line.stage, Stage::Lost(None));
        if let Stage::Settling { wire, reset, .. } = stage {
            self.line.stage = Stage::Up(wire);
            self.line.lost = None;
            tracing::info!(reset, "{}: the line is up again", self.shared.name);
            self.publish_link(Link::Up);
            self.happens(Event::LinkFound { reset });
            if self.owes_halt {
                self.halt(Vec::new());
            }
        }
    }

    /// The arm was reset, perhaps while the line was gone.
    pub(super) fn note_reset(&mut self) {
        if let Stage::Settling { reset, .. } = &mut self.line.stage {
            *reset = true;
        }
    }

    /// Asks the arm, once, for what it can be told by, and for its clock, which tells whether it was reset.
    pub(super) fn introduce(&mut self, now: Micros) {
        if self.introduction.take_if(|at| *at <= now).is_none() {
            return;
        }
        let deadline = self.at(now) + PATIENCE;
        let requests = [
            Request::get::<DeviceSn>(&NoArgs),
            Request::get::<DeviceTime>(&NoArgs),
        ];
        for request in requests.into_iter().flatten() {
            self.submit(request, deadline, To::Nobody);
        }
    }
}
