use magician_protocol::commands::{
    EMotor, QueuedCmdClear, QueuedCmdForceStopExec, QueuedCmdStopExec, SetEndEffectorLaser,
};
use magician_protocol::{Ctrl, EncodeError, Flag, FrameBuf, Queueable, Readable, Writable};

use super::Micros;
use crate::gate::OUTPUTS;

/// Puts the laser out.
const LASER_OFF: SetEndEffectorLaser = SetEndEffectorLaser {
    enable_ctrl: Flag::OFF,
    on: Flag::OFF,
};

/// What goes first when several requests wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Priority {
    /// Overtakes everything and takes no place in the window.
    Stop,
    /// Sets and queued commands, in the order in which they were submitted.
    Stream,
    /// Reads; they may be overtaken, but not for ever.
    Poll,
}

/// Names one submitted request until its [`Event`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Ticket(pub(crate) u64);

/// A request to the controller: a frame, how urgent it is, and when its answer is no longer wanted.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    pub(super) frame: FrameBuf,
    pub(super) priority: Priority,
    pub(super) deadline: Micros,
    pub(super) repeatable: bool,
}

impl Request {
    /// A frame of any kind. Reads (Ctrl bit 0 clear) are polls, all else belongs to the stream.
    ///
    /// # Errors
    /// [`EncodeError::TooLong`] beyond 248 parameter bytes.
    pub fn raw(id: u8, ctrl: Ctrl, params: &[u8]) -> Result<Self, EncodeError> {
        FrameBuf::new(id, ctrl, params).map(Self::of)
    }

    /// Asks for a value.
    ///
    /// # Errors
    /// As [`Request::raw`].
    pub fn get<T: Readable>(query: &T::Query) -> Result<Self, EncodeError> {
        FrameBuf::get(query, T::ROW).map(Self::of)
    }

    /// Sets a value or orders an action, at once.
    ///
    /// # Errors
    /// As [`Request::raw`].
    pub fn set<T: Writable>(value: &T) -> Result<Self, EncodeError> {
        FrameBuf::encode(T::ROW.id, Ctrl::SET, value).map(Self::of)
    }

    /// Puts a command into the controller's queue.
    ///
    /// # Errors
    /// As [`Request::raw`].
    pub fn queued<T: Queueable>(value: &T) -> Result<Self, EncodeError> {
        FrameBuf::encode(T::ROW.id, Ctrl::QUEUED, value).map(Self::of)
    }

    /// The three requests that bring the arm to a stand, in their order: stop the queue and the
    /// motion, put the laser out, drop what waits.
    ///
    /// # Errors
    /// None in practice; as [`Request::raw`].
    pub fn halt() -> Result<[Self; 3], EncodeError> {
        let all = [
            Self::set(&QueuedCmdForceStopExec {})?,
            Self::set(&LASER_OFF)?,
            Self::set(&QueuedCmdClear {})?,
        ];
        Ok(all.map(|request| request.priority(Priority::Stop)))
    }

    /// The requests that switch both motor outputs off, and with them a belt: behind those of [`halt`](Self::halt), whoever
    /// started what runs there.
    ///
    /// # Errors
    /// None in practice; as [`Request::raw`].
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

    /// The two requests that leave the laser dark, in their order: put the laser out, hold the queue. The command under way
    /// finishes. A Clear belongs behind them once the arm stands: it may end the command where it is (model section 14).
    ///
    /// # Errors
    /// None in practice; as [`Request::raw`].
    pub fn dark() -> Result<[Self; 2], EncodeError> {
        let all = [Self::set(&LASER_OFF)?, Self::set(&QueuedCmdStopExec {})?];
        Ok(all.map(|request| request.priority(Priority::Stop)))
    }

    /// A request of a whole frame. Its priority is that of its kind: queued commands and sets before readings.
    #[must_use]
    pub fn of(frame: FrameBuf) -> Self {
        let priority = match frame.frame().ctrl() {
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

    /// Puts it into another lane.
    #[must_use]
    pub fn priority(mut self, priority: Priority) -> Self {
        self.priority = priority;
        self
    }

    /// The instant at which it ends at the latest, answered or not.
    #[must_use]
    pub fn deadline(mut self, at: Micros) -> Self {
        self.deadline = at;
        self
    }

    /// Says that this queued command means the same wherever it is begun from, so that a program may go on with it after
    /// a gap: a motion to an absolute place. Only such commands share a window above 1. An increment, a wait, a counted
    /// pulse is none; those travel alone.
    #[must_use]
    pub fn repeatable(mut self) -> Self {
        self.repeatable = true;
        self
    }

    /// The frame that goes out.
    #[must_use]
    pub fn frame(&self) -> &FrameBuf {
        &self.frame
    }
}

/// Why a request ended without an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Failure {
    /// No answer by the deadline, and nothing was done or it does not matter whether it was.
    Timeout {
        /// How often the frame went out.
        sent: u32,
    },
    /// The command went out and the controller may or may not have taken it. `from` and `to`
    /// are the indices it (and what was in flight with it) would have been given; absent for an
    /// immediate command and before the first accepted index.
    Uncertain {
        /// First index in doubt.
        from: Option<u64>,
        /// Last index in doubt.
        to: Option<u64>,
    },
    /// The controller's queue has no room; nothing was stored.
    QueueFull,
    /// The controller answered that it refuses the command (Ctrl bit 2, errata E05).
    Refused,
    /// The answer to a queued command carries no index.
    NoIndex,
    /// A stop overtook the command before it went out, the controller was reset, the caller withdrew it, or above window
    /// 1 a gap opened before it; it was dropped.
    Stopped,
    /// The line broke before it was answered; nothing was done or it does not matter whether it was. For a queued command
    /// this is certain: the controller has not taken it.
    Lost,
    /// It did not go out: the queue was cleared, and the command that ran then has not finished.
    Draining,
    /// Too many requests wait; this one was not taken.
    Busy,
}

/// What a [`Connection`](super::Connection) has to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::large_enum_variant)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Event {
    /// A request has ended, with the frame that answers it. When a lost answer to a queued command
    /// was made up for by reading the queue, the frame is the one that was lost.
    Done {
        /// The request.
        ticket: Ticket,
        /// Its answer, or why there is none.
        result: Result<FrameBuf, Failure>,
    },
    /// The indices or the controller's clock went backwards: it was reset. What it had queued is gone, and nothing of it
    /// is sent again.
    Reset,
    /// The controller has given these indices to commands that this connection did not send, or
    /// sent once: the line doubled a datagram, or another host shares the arm.
    Unaccounted {
        /// First index.
        from: u64,
        /// Last index.
        to: u64,
    },
}

/// How a [`Connection`](super::Connection) behaves.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Most requests in flight, 1 to 8; on an unordered link always 1, and on an arm that breaks the index law
    /// ([`Connection::law`](super::Connection::law)). Above 1 [repeatable](Request::repeatable) queued commands travel
    /// together once the law was seen to hold; a gap among them is reported as an interval and nothing is sent again.
    pub window: usize,
    /// True if at [window](Self::window) 1 a read may be in flight together with one queued command,
    /// on an ordered link and once the law was seen to hold. After a loss from such a pair reads wait
    /// their turn for a while. False for links that take few bytes at once.
    pub reads_beside: bool,
    /// Whether the link keeps the order of bytes (serial, TCP). UDP does not.
    pub ordered: bool,
    /// How long a request and its answer may be under way together at most, in us: what a frame that is no longer waited
    /// for can do harm. On an ordered link it only bounds the wait for a dead line. On an unordered one it is what counts
    /// before the first answer; then it is eight times the longest round trip of the last minute, late answers among
    /// them, but no longer than this and no shorter than [`shortest`](Self::shortest).
    pub lifetime: Micros,
    /// The shortest [`lifetime`](Self::lifetime) on an unordered link, us. The same value as there: none is measured.
    pub shortest: Micros,
    /// On an unordered link, how long after a datagram went out a second copy of it may come, in us; 0: none ever comes
    /// twice. Where two round trips are longer, it is those. Queued commands go out so far apart, and current index and left space are read in between: the arm would
    /// take a command twice, and where the next one is lost at the same time no index tells.
    pub echo: Micros,
    /// Places in the controller's queue (model section 14). A larger number read from the
    /// controller replaces it.
    pub capacity: u32,
    /// First guess of the time to an answer, us.
    pub initial_timeout: Micros,
    /// Shortest time after which an answer counts as lost, us. A premature timeout makes the doubt
    /// it fears, so it is far above the 1 to 12 ms of the real arm (model section 15).
    pub floor: Micros,
    /// Longest time after which an answer counts as lost, us.
    pub ceiling: Micros,
    /// Bits a second of a serial line (10 to the byte). Frames are then handed out so late that no more than 1 ms of
    /// earlier ones has still to pass, and a stop waits for at most that and the frame under way. `None`: as they come.
    pub baud: Option<u32>,
    /// The controller's clock does not keep step with the one here: an arm in virtual time. It shows a reset only by going
    /// back, not by falling behind.
    pub free_clock: bool,
}

impl Settings {
    /// For a serial port or TCP: bytes arrive in order or not at all.
    pub const ORDERED: Self = Self {
        window: 1,
        reads_beside: false,
        ordered: true,
        lifetime: 60_000_000,
        shortest: 60_000_000,
        echo: 0,
        capacity: 32,
        initial_timeout: 500_000,
        floor: 100_000,
        ceiling: 2_000_000,
        baud: None,
        free_clock: false,
    };

    /// For UDP: datagrams may be lost, doubled and overtake each other, for 0.2 to two seconds, as round trips are.
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
