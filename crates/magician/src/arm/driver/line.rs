//! State of the line: up, lost, being searched for, found again.
//!
//! A reconnected line is not trusted at once. A separate connection identifies the arm
//! (`search.rs`, `identification.rs`). Only if it is the same arm, the line is handed to the
//! connection that knows the indices, which then reads how far the arm has come. Until this is
//! settled every call is refused. Nothing is retransmitted.

use std::future::Future;
use std::io;
use std::pin::Pin;
use std::task::Context;

use tokio::time::Instant;

use super::Driver;
use super::identification::Identification;
use super::wire::Wire;
use crate::arm::events::Event;
use crate::arm::homing::homes;
use crate::arm::link::Link;
use crate::connection::{Failure, Micros};
use crate::message;
use crate::transport::Line;
use crate::{Error, ErrorCode, Result};

/// Delay from the loss to the first search. Choice: soon enough for a loose plug.
const FIRST_RECONNECT_DELAY: Micros = 100_000;
/// Interval of the searches. Choice: rare enough for a missing adapter.
pub(super) const RECONNECT_INTERVAL: Micros = 250_000;

/// Opens the line again.
pub(in crate::arm) type Opener = Box<dyn FnMut() -> Opening + Send>;
pub(super) type Opening = Pin<Box<dyn Future<Output = Result<Line>> + Send>>;

/// The line and how to reopen it.
pub(super) struct State {
    pub(super) opener: Option<Opener>,
    pub(super) stage: Stage,
    /// Cause of the loss, until the line is up again.
    pub(super) lost: Option<Lost>,
}

// Only one exists, in a task that is boxed anyway.
#[allow(clippy::large_enum_variant)]
pub(super) enum Stage {
    Up(Wire),
    /// Found again; the arm reports how far its queue has come.
    Settling {
        wire: Wire,
        /// Missing answers.
        left: usize,
        reset: bool,
    },
    Identifying(Identification),
    Opening(Opening),
    /// Lost; the time of the next search, or `None` if it is not searched for.
    Lost(Option<Micros>),
}

/// Cause of a loss.
pub(super) struct Lost {
    since: Instant,
    error: StoredIoError,
    /// Description of another arm found in its place, if any.
    pub(super) other_arm: Option<crate::Message>,
}

/// I/O error that can be recreated any number of times, which [`io::Error`] cannot.
enum StoredIoError {
    System(i32),
    Kind(io::ErrorKind),
    /// Error of a stream supplied by the caller.
    Custom(io::ErrorKind, String),
}

impl From<&io::Error> for StoredIoError {
    fn from(error: &io::Error) -> Self {
        match (error.raw_os_error(), error.get_ref()) {
            // A system code recreates the error exactly; only custom errors need their text.
            (Some(code), _) => Self::System(code),
            (None, Some(text)) => Self::Custom(error.kind(), text.to_string()),
            (None, None) => Self::Kind(error.kind()),
        }
    }
}

impl StoredIoError {
    fn error(&self) -> io::Error {
        match self {
            Self::System(code) => io::Error::from_raw_os_error(*code),
            Self::Kind(kind) => (*kind).into(),
            Self::Custom(kind, text) => io::Error::new(*kind, text.as_str()),
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

    /// Returns the line, for callers that do not wait until it has settled.
    pub(super) fn wire(&mut self) -> Option<&mut Wire> {
        match &mut self.stage {
            Stage::Up(wire) | Stage::Settling { wire, .. } => Some(wire),
            Stage::Identifying(_) | Stage::Opening(_) | Stage::Lost(_) => None,
        }
    }

    /// Closes the line for good.
    pub(super) fn let_go(&mut self) {
        self.opener = None;
        self.stage = Stage::Lost(None);
    }

    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        match &self.stage {
            Stage::Lost(look) => *look,
            Stage::Identifying(identification) => identification.poll_timeout(),
            Stage::Up(_) | Stage::Settling { .. } | Stage::Opening(_) => None,
        }
    }

    pub(super) fn handle_timeout(&mut self, now: Micros) {
        if let Stage::Identifying(identification) = &mut self.stage {
            identification.handle_timeout(now);
        }
    }
}

/// Reading and writing.
impl Driver {
    /// True if the line is up and calls may use it.
    pub(super) fn link_is_up(&self) -> bool {
        matches!(self.line.stage, Stage::Up(_))
    }

    /// True if the line is open, for frames that precede everything else.
    pub(super) fn link_is_open(&self) -> bool {
        matches!(self.line.stage, Stage::Up(_) | Stage::Settling { .. })
    }

    /// Reads what has arrived, or searches for the line; true if anything happened.
    pub(super) fn read(&mut self, cx: &mut Context<'_>) -> bool {
        let now = self.now();
        if let Some(wire) = self.line.wire() {
            return match wire.read(cx, now, &mut self.connection) {
                Ok(read) => read,
                Err(error) => self.lose(&error),
            };
        }
        // A shutdown does not wait for a reconnect.
        !self.leaving && self.search_line(cx, now)
    }

    pub(super) fn write(&mut self, cx: &mut Context<'_>) -> bool {
        let now = self.now();
        let Some(wire) = self.line.wire() else {
            return false;
        };
        let shared = &self.shared;
        let begins = |frame: &magician_protocol::FrameBuf| {
            tracing::trace!(frame = ?frame, "to {}", shared.name);
            shared.picture().sent(now, &frame.frame());
            if homes(&frame.frame()) {
                shared.homings.begins();
            }
        };
        match wire.write(cx, now, &mut self.connection, begins) {
            Ok(wrote) => wrote,
            Err(error) => self.lose(&error),
        }
    }

    /// Handles the loss of the line. Requests in flight end as the connection decides.
    pub(super) fn lose(&mut self, error: &io::Error) -> bool {
        let first = self.line.lost.is_none();
        self.line.lost.get_or_insert_with(|| Lost {
            since: Instant::now(),
            error: StoredIoError::from(error),
            other_arm: None,
        });
        // A line that breaks again before it has settled is searched for less eagerly.
        self.schedule_search(if first {
            FIRST_RECONNECT_DELAY
        } else {
            RECONNECT_INTERVAL
        });
        let under_way: Vec<_> = self.waiting.iter().map(|one| one.request).collect();
        under_way.iter().for_each(|one| self.owe(&one.frame()));
        self.interrupt_jog();
        self.polls.interrupt();
        if let Some(program) = &mut self.program {
            program.stream.interrupt(Failure::Lost);
        }
        self.connection.interrupt();
        self.shared.picture().lost();
        self.shared.identity_cache().forget();
        // A refused access is reported by the call that it ends.
        if first && !self.is_refused() {
            tracing::warn!("{}", self.gone());
        }
        self.publish_loss();
        if first {
            let why = self.gone().to_string().into();
            self.happens(Event::LinkLost { why });
        }
        true
    }

    pub(super) fn schedule_search(&mut self, pause: Micros) {
        let sought = self.line.opener.is_some();
        let look = self.now().saturating_add(pause);
        self.line.stage = Stage::Lost(sought.then_some(look));
    }

    /// True if the line ended because the other end refused access.
    pub(super) fn is_refused(&self) -> bool {
        let lost = self.line.lost.as_ref();
        lost.is_some_and(|lost| lost.error.error().kind() == io::ErrorKind::PermissionDenied)
    }

    /// Returns the error of calls while the line is lost.
    pub(super) fn gone(&self) -> Error {
        let Some(lost) = &self.line.lost else {
            return Error::new(ErrorCode::LineLost, message!("the line to the arm broke"));
        };
        if let Some(other_arm) = &lost.other_arm {
            return Error::new(ErrorCode::AnotherArm, other_arm.clone());
        }
        let source = lost.error.error();
        if self.line.opener.is_none() || self.is_refused() {
            return Error::gone(&self.shared.name, source);
        }
        let message = message!(
            "the connection to {name} broke off: {cause}; it is being looked for again",
            name = self.shared.name,
            cause = source.to_string()
        );
        Error::new(ErrorCode::LineLost, message).with_source(source)
    }

    pub(super) fn publish_loss(&self) {
        if let Some(lost) = &self.line.lost {
            let sought = self.line.opener.is_some();
            let link = Link::lost(lost.since, self.gone().to_string(), sought);
            self.publish_link(link);
        }
    }
}
