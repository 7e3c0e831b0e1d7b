//! Requests, their outcomes, the events of a connection, and its settings.

use magician_protocol::commands::{
    EMotor, QueuedCmdClear, QueuedCmdForceStopExec, QueuedCmdStopExec, SetEndEffectorLaser,
};
use magician_protocol::{Ctrl, EncodeError, Flag, FrameBuf, Queueable, Readable, Writable};

use super::Micros;
use crate::gate::OUTPUTS;

const LASER_OFF: SetEndEffectorLaser = SetEndEffectorLaser {
    enable_ctrl: Flag::OFF,
    on: Flag::OFF,
};

/// Order of transmission when several requests wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Priority {
    /// Overtakes everything and occupies no place in the window.
    Stop,
    /// Sets and queued commands, in the order of submission.
    Stream,
    /// Reads. They may be overtaken, but do not starve.
    Poll,
}

/// Identifies a submitted request until its [`Event`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Ticket(pub(crate) u64);

/// A request to the controller: a frame, its priority and its deadline.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    pub(super) frame: FrameBuf,
    pub(super) priority: Priority,
    pub(super) deadline: Micros,
    pub(super) repeatable: bool,
}

impl Request {
    /// Creates a request from any frame. Reads (Ctrl bits 0 and 1 clear) are polls, all others
    /// belong to the stream.
    ///
    /// # Errors
    /// [`EncodeError::TooLong`] for more than 248 parameter bytes.
    pub fn raw(id: u8, ctrl: Ctrl, params: &[u8]) -> Result<Self, EncodeError> {
        FrameBuf::new(id, ctrl, params).map(Self::of)
    }

    /// Requests a value.
    ///
    /// # Errors
    /// Same as [`Request::raw`].
    pub fn get<T: Readable>(query: &T::Query) -> Result<Self, EncodeError> {
        FrameBuf::get(query, T::ROW).map(Self::of)
    }

    /// Sets a value or performs an action, immediately.
    ///
    /// # Errors
    /// Same as [`Request::raw`].
    pub fn set<T: Writable>(value: &T) -> Result<Self, EncodeError> {
        FrameBuf::encode(T::ROW.id, Ctrl::SET, value).map(Self::of)
    }

    /// Queues a command in the controller.
    ///
    /// # Errors
    /// Same as [`Request::raw`].
    pub fn queued<T: Queueable>(value: &T) -> Result<Self, EncodeError> {
        FrameBuf::encode(T::ROW.id, Ctrl::QUEUED, value).map(Self::of)
    }

    /// The three requests that bring the arm to a standstill, in order: stop the queue and the
    /// motion, switch the laser off, clear the queue.
    ///
    /// # Errors
    /// Never in practice; as [`Request::raw`].
    pub fn halt() -> Result<[Self; 3], EncodeError> {
        let all = [
            Self::set(&QueuedCmdForceStopExec {})?,
            Self::set(&LASER_OFF)?,
            // Last, so that nothing queued meanwhile survives.
            Self::set(&QueuedCmdClear {})?,
        ];
        Ok(all.map(|request| request.priority(Priority::Stop)))
    }

    /// The requests that switch both motor outputs off, and with them a conveyor, even if another
    /// program started it. They follow those of [`halt`](Self::halt).
    ///
    /// # Errors
    /// Never in practice; as [`Request::raw`].
    pub fn motors_off() -> Result<[Self; 2], EncodeError> {
        let [first, second] = OUTPUTS.map(|index| {
            Self::set(&EMotor {
                index,
                is_enabled: Flag::OFF,
                speed: 0,
            })
        });
        Ok([first?, second?].map(|request| request.priority(Priority::Stop)))
    }

    /// The two requests that leave the laser off, in order: switch the laser off, stop the queue.
    /// The running command finishes.
    ///
    /// Clear the queue only once the arm stands still: a Clear may end the command where it is
    /// (model section 14).
    ///
    /// # Errors
    /// Never in practice; as [`Request::raw`].
    pub fn laser_off() -> Result<[Self; 2], EncodeError> {
        let all = [Self::set(&LASER_OFF)?, Self::set(&QueuedCmdStopExec {})?];
        Ok(all.map(|request| request.priority(Priority::Stop)))
    }

    /// Creates a request from a whole frame. Queued commands and sets get [`Priority::Stream`],
    /// reads [`Priority::Poll`].
    #[must_use]
    pub fn of(frame: FrameBuf) -> Self {
        let priority = match frame.frame().ctrl() {
            // Bit 1 alone also queues (errata E07).
            ctrl if ctrl.write() || ctrl.queued() => Priority::Stream,
            _ => Priority::Poll,
        };
        Self {
            frame,
            priority,
            deadline: Micros::MAX,
            repeatable: false,
        }
    }

    /// Sets the priority.
    #[must_use]
    pub fn priority(mut self, priority: Priority) -> Self {
        self.priority = priority;
        self
    }

    /// Sets the deadline, at which the request ends with or without a reply.
    #[must_use]
    pub fn deadline(mut self, at: Micros) -> Self {
        self.deadline = at;
        self
    }

    /// Declares that this queued command has the same effect wherever it starts from, as a motion
    /// to an absolute position does.
    ///
    /// A program may continue with such a command after a gap, so only these share a larger window.
    /// Increments, waits and counted pulses are not repeatable and travel alone.
    #[must_use]
    pub fn repeatable(mut self) -> Self {
        self.repeatable = true;
        self
    }

    /// Frame that is sent.
    #[must_use]
    pub fn frame(&self) -> &FrameBuf {
        &self.frame
    }
}

/// Reason why a request ended without an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Failure {
    /// No reply by the deadline. Nothing was done, or it does not matter whether it was.
    Timeout {
        /// Number of transmissions.
        sent: u32,
    },
    /// The command was sent, and the controller may or may not have taken it.
    ///
    /// `from` and `to` are the indices that it, and those in flight with it, would have been given;
    /// `None` for an immediate command and before the first accepted index.
    Uncertain {
        /// First uncertain index.
        from: Option<u64>,
        /// Last uncertain index.
        to: Option<u64>,
    },
    /// The controller's queue is full; nothing was stored.
    QueueFull,
    /// The controller refused the command (Ctrl bit 2, errata E05).
    Refused,
    /// The reply to a queued command carries no index.
    NoIndex,
    /// The request was not sent, or not retransmitted after a loss, because of a stop, a reset of
    /// the controller, its caller, or, above window 1, a gap before it. For a queued command it is
    /// certain that the controller has not taken it.
    Stopped,
    /// The line broke before a reply arrived. Nothing was done, or it does not matter whether it
    /// was. For a queued command it is certain that the controller has not taken it.
    Lost,
    /// The command was not sent: the queue was cleared, and the command running at that time has
    /// not finished.
    Draining,
    /// Too many requests wait; this one was refused.
    Busy,
}

/// An event of a [`Connection`](super::Connection).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::large_enum_variant)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Event {
    /// A request has ended. If the reply to a queued command was lost and readings of the queue
    /// show that the command was taken, the frame is a reconstruction of that reply.
    Done {
        /// Ticket of the request.
        ticket: Ticket,
        /// Reply, or the failure.
        result: Result<FrameBuf, Failure>,
    },
    /// The controller was reset: its indices or its clock went backwards. Its queue is lost, and
    /// nothing of it is retransmitted.
    Reset,
    /// The controller has given these indices to commands beyond those that this connection sent:
    /// the line duplicated a datagram, or another host shares the arm.
    Unaccounted {
        /// First index.
        from: u64,
        /// Last index.
        to: u64,
    },
}

/// Settings of a [`Connection`](super::Connection).
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Largest number of requests in flight, 1 to 8.
    ///
    /// Always 1 on an unordered link and on an arm that breaks the index law
    /// ([`Connection::law`](super::Connection::law)). Above 1, [repeatable](Request::repeatable)
    /// queued commands travel together once the arm was seen to follow the law; a gap among them is
    /// reported as an interval, and nothing is retransmitted.
    pub window: usize,
    /// True if at [window](Self::window) 1 a read may be in flight together with one queued
    /// command.
    ///
    /// Requires an ordered link and an arm that was seen to follow the index law. After a loss from
    /// such a pair, reads wait their turn for a while. Set it to false for links that accept few
    /// bytes at once.
    pub reads_beside: bool,
    /// True if the link keeps the order of bytes (serial, TCP). False for UDP.
    pub ordered: bool,
    /// Longest time that a request and its reply may be under way together, us. A frame that timed
    /// out can do harm for this long.
    ///
    /// On an ordered link it only bounds the wait for a dead line. On an unordered link it applies
    /// until the first reply; then the lifetime is eight times the longest round trip of the last
    /// minute (late replies included), at most this value and at least
    /// [`shortest`](Self::shortest).
    pub lifetime: Micros,
    /// Shortest [`lifetime`](Self::lifetime) on an unordered link, us. Equal values switch the
    /// measurement off.
    pub shortest: Micros,
    /// Time after which no second copy of a datagram arrives on an unordered link, us; at least two
    /// round trips are used. 0 if datagrams are never duplicated.
    ///
    /// Queued commands are sent this far apart, and current index and left space are read in
    /// between: the arm would execute a duplicate, and if the next command is lost at the same
    /// time, no index reveals it.
    pub echo: Micros,
    /// Capacity of the controller's queue, commands (model section 14). A larger number read from
    /// the controller replaces it.
    pub capacity: u32,
    /// Retransmission timeout before the first reply, us.
    pub initial_timeout: Micros,
    /// Shortest retransmission timeout, us. A premature timeout causes a doubt without need, so it
    /// is far above the 1 to 12 ms of the real arm (model section 15).
    pub floor: Micros,
    /// Longest retransmission timeout, us.
    pub ceiling: Micros,
    /// Baud rate of a serial line, 10 bits to the byte. `None`: frames are handed out as they come.
    ///
    /// With a rate, a frame is handed out only when at most 1 ms of earlier ones is left, so a stop
    /// waits for that and the current frame at most.
    pub baud: Option<u32>,
    /// True if the controller's clock does not keep pace with the host's, as for an arm in virtual
    /// time. The clock then shows a reset only by going back, not by falling behind.
    pub free_clock: bool,
}

impl Settings {
    /// Settings for a serial port or TCP: bytes arrive in order or not at all.
    pub const ORDERED: Self = Self {
        // Only queued commands that are repeatable gain from a window, so it is opt-in.
        window: 1,
        reads_beside: false,
        ordered: true,
        // Only bounds the wait for a dead line, so a minute does no harm.
        lifetime: 60_000_000,
        shortest: 60_000_000,
        echo: 0,
        // Model section 14.
        capacity: 32,
        // The timeouts are choices; `floor` above says what bounds them from below.
        initial_timeout: 500_000,
        floor: 100_000,
        ceiling: 2_000_000,
        baud: None,
        free_clock: false,
    };

    /// Settings for UDP: datagrams may be lost, duplicated and reordered, and may be under way for
    /// 0.2 to 2 s, depending on round trips.
    pub const DATAGRAMS: Self = Self {
        ordered: false,
        lifetime: 2_000_000,
        shortest: 200_000,
        echo: 100_000,
        initial_timeout: 700_000,
        floor: 200_000,
        ..Self::ORDERED
    };
}

impl Default for Settings {
    fn default() -> Self {
        Self::ORDERED
    }
}
