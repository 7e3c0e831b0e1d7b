//! A stream of queued commands over a [`Connection`].
//!
//! The stream keeps enough commands in the arm that it never runs dry, and no more than may run on
//! if the host dies. It accounts for every command: finished, not taken, or reported as uncertain.
//!
//! A [`Stream`] does no I/O and reads no clock. Its methods are of the same kinds as the
//! connection's, and callers use them in the same loop:
//!
//! * queries: `&self` methods, which change nothing;
//! * our own side: [`offer`](Stream::offer) a command while there is [`room`](Stream::room),
//!   [`finish`](Stream::finish) after the last one, [`interrupt`](Stream::interrupt) when the line
//!   is lost or the arm is stopped, [`reset`](Stream::reset) when the connection reports a reset of
//!   the controller;
//! * [`answered`](Stream::answered): the connection has ended a request;
//! * time: [`advance`](Stream::advance) submits what is due. Call it after each of the calls above,
//!   and at the instant that [`poll_timeout`](Stream::poll_timeout) returns;
//! * output: [`poll_event`](Stream::poll_event), until it returns `None`.
//!
//! The same calls give the same results. Memory is bounded and allocated at the start: offered
//! commands wait in [`MAX_WAITING`] places, and a command is kept until the arm has certainly
//! finished it, at most [`MAX_KEPT`] of them.
//!
//! # How much is in the arm
//!
//! *Credit* is the number of places in the queue minus the commands accepted and not finished (by
//! their indices) minus those in flight. Left space is read now and then as a cross-check; the
//! lower of both numbers counts. If they disagree in three consecutive readings, left space wins:
//! fewer places are used from then on ([`StreamEvent::Places`]), or, if commands are missing from
//! the queue, it was cleared and the stream fails.
//!
//! The *horizon* bounds how long the arm moves on if the host dies: the total time of all commands
//! that are accepted or in flight and not finished, counting the current one whole. Two commands
//! are allowed regardless of their times, so that the arm always has the next one. An unknown time
//! fills the horizon. With [`start`](StreamSettings::start) off there is no horizon: a caller that
//! only fills a queue decides when it runs.
//!
//! # Stopped first, then started
//!
//! A program that fits (all of it offered, `finish` called, within places and horizon) is put in
//! while the queue is stopped, and then started: nothing moves unless all of it was taken. A longer
//! program is put in up to the horizon, started, and continued. A queue with earlier commands in it
//! is not stopped, because a stop would cut short a WAIT of theirs; nor is it stopped for a single
//! command. The stream decides whether a program fits as soon as it is finished or too many
//! commands are offered; for a caller that does neither, it waits 20 ms.
//!
//! # Which clock
//!
//! Times of commands are in the arm's time. It is assumed to pass like the connection's, until a
//! call of [`leap_clock`](Stream::leap_clock) declares that the arm is in virtual time.
//!
//! # The laser
//!
//! The laser can be lit in two ways.
//!
//! The laser of a path (`CPLECmd`) goes out when the path comes to rest (model section 8). Such
//! segments stream like others, with the shorter [`laser_horizon`](StreamSettings::laser_horizon),
//! and if nothing follows they end dark by themselves.
//!
//! The laser that `SetEndEffectorLaser` switches on burns until it is switched off. So a running
//! queue never receives the command that lights it without the command for switching it off. The
//! commands from one to the other are a *chunk*, which is put in whole while the queue is stopped
//! and empty, and then started. A chunk longer than the laser's horizon or the queue is split at
//! the end of a command: the stream inserts a command that switches the laser off and another that
//! lights it again for the next chunk.
//!
//! The seams between chunks are visible in the work. There is one every second, or every 30
//! segments if these are short and the queue has 32 places. At each seam the arm stands still and
//! dark for 0.1 to 0.2 s while the next chunk goes in. It brakes before the seam and accelerates
//! after it at full power, so the line is darker there. For an even line use `CPLECmd`.
//!
//! A program that ends with the laser lit is left so. A laser that is lit through its IO pins, or
//! was lit before the stream, is not recognised as switched: the shorter horizon then applies only
//! to items with [`Item::laser`] set.
//!
//! # Above window 1
//!
//! If one of several commands in flight is lost, the arm may start the next one from another
//! position, and an absolute line from another start is another line. So only commands for which
//! such a loss changes nothing share the window: dark absolute segments of a path, as long as the
//! line to the new vertex, from any unconfirmed position, passes all vertices in between
//! within [`LINE_TOLERANCE`]. Whichever of them is lost, the same line is drawn. Corners, segments
//! that raise or lower the tool, point-to-point moves and all commands that switch something wait
//! until everything before them is confirmed, and travel alone.
//!
//! When a command is lost between others, the stream stops the queue (the current segment ends at
//! its end point), clears it and waits until it has drained. Current index and pose then show at
//! which vertex the arm stands. Segments up to that vertex are drawn; the stream continues with the
//! next one, so nothing is drawn twice or skipped. After three such losses its window is one. If
//! the arm stands at none of the possible vertices, or a command that must not run twice is in
//! doubt, the stream fails and sends nothing more. If commands of others wait in the queue, or its
//! start is the caller's, the stream may not clear it, and commands travel one at a time.
//!
//! # Continuing after an interruption
//!
//! Nothing resumes by itself. [`leftover`](Stream::leftover) returns the commands not
//! known to be finished, and [`resume`](Stream::resume) finds out their fate (current index and
//! left space until they are stable, then the pose) before it sends anything. If the readings do
//! not add up, the result is a [`StreamFailure`] with both values.

mod answer;
mod clock;
mod credit;
mod doubled;
mod drive;
mod entries;
mod event;
mod item;
mod laser;
mod line;
mod reading;
mod recover;
mod resume;
#[cfg(test)]
mod tests;

use std::time::Duration;

use magician_protocol::{ArmInstant, Ctrl, Field, FrameBuf, Range};

use crate::connection::{Connection, Micros, Priority, Request, Ticket};
use clock::Clock;
use credit::Credit;
pub use drive::Beginning;
use drive::Phase;
use entries::Entries;
use event::Events;
pub use event::{Refused, StreamEvent, StreamFailure};
pub use item::{ArmPace, Item, NextOffer, StreamSettings};
use item::{Entry, Fate, switched_laser_state};
pub use line::LINE_TOLERANCE;
use reading::Reader;
pub use resume::Leftover;
use resume::POSE_TOLERANCE;

/// Largest number of commands waiting in a stream. A choice: a full queue of 32 and some to spare.
pub const MAX_WAITING: usize = 40;
/// Largest number of commands kept that are in the controller or on their way. A choice, as
/// [`MAX_WAITING`].
pub const MAX_KEPT: usize = 40;
/// Room for commands that the stream inserts: two for each chunk that may be split while all places
/// are taken.
const INSERTED_CAPACITY: usize = 8;

/// A program of queued commands on its way to the arm; see the [module](self).
///
/// ```
/// use magician_host::connection::{Connection, Settings};
/// use magician_host::stream::{Item, Stream, StreamSettings};
/// use magician_host::build;
///
/// let mut connection = Connection::new(Settings::ORDERED);
/// let mut stream = Stream::new(StreamSettings::default());
/// stream.offer(Item {
///     command: build::line_to(220.0, 0.0, 20.0, 0.0),
///     time: 800_000,
///     end: Some([220.0, 0.0, 20.0, 0.0]),
///     laser: false,
/// })?;
/// stream.finish();
/// stream.advance(0, &mut connection);
/// // The stream reads the state of the arm before it sends anything.
/// let first = connection.poll_transmit(0).unwrap();
/// assert!(!first.frame().ctrl().write());
/// # Ok::<(), magician_host::stream::Refused>(())
/// ```
#[derive(Debug)]
pub struct Stream {
    settings: StreamSettings,
    entries: Entries,
    phase: Phase,
    credit: Credit,
    reader: Reader,
    events: Events,
    /// Current limit of repeatable commands in flight.
    window: usize,
    gaps: usize,
    /// True if a command was lost between others.
    gap: bool,
    /// True if no more commands will be offered.
    ended: bool,
    /// Time of the next offer, unless `ended`.
    expects: NextOffer,
    /// True once `Finished` was reported.
    finished_reported: bool,
    /// True if the laser stays lit after the last command offered.
    lit: bool,
    /// True if the stream has stopped the queue and not started it since.
    stopped: bool,
    /// Consecutive unanswered starts of the queue.
    starts: u8,
    /// Number of commands still to be sent before the queue is started. `None`: no limit.
    group: Option<usize>,
    control: Option<Ticket>,
    /// Instant before which nothing is submitted, because the connection had no room.
    retry_at: Option<ArmInstant>,
    /// Instant at which the first command was seen waiting for more.
    gathering_since: Option<ArmInstant>,
    /// Commands of the caller that were accepted, and the first and last index given.
    accepted: u64,
    first: Option<u64>,
    last: Option<u64>,
    /// Index that must come next.
    expected: Option<u64>,
    /// Command accepted last.
    newest: Option<Entry>,
    /// True if the index of `newest`, or of a command found in the queue, may be too low
    /// ([`Connection::is_last_index_estimated`]).
    guessed: bool,
    confirmed: Option<u64>,
    /// Pose after the last command that was finished and released. `None` if unknown.
    last_pose: Option<[f64; 4]>,
    /// The same as a position, which is also known after a segment whose pose is unknown.
    last_position: Option<[f64; 3]>,
    /// Current index when the queue was last cleared, or when the stream began.
    cleared_at: u64,
    /// Last index given before the stream's first, or before its first since the queue was cleared.
    base: u64,
    /// Phase in which the stream ended.
    phase_at_end: Phase,
    /// On resuming: number of commands that turned out to have been taken.
    found: usize,
    /// On resuming: true if the queue was stopped and cleared meanwhile.
    cleared: bool,
    starve_count: u64,
    is_dry: bool,
    clock: Clock,
    /// Latest instant of the connection's clock.
    now: Micros,
    /// State of the arm at the beginning, if it was read for the stream.
    beginning: Option<Beginning>,
}

/// Construction and state.
impl Stream {
    /// Creates a stream without commands.
    #[must_use]
    pub fn new(settings: StreamSettings) -> Self {
        let settings = StreamSettings {
            // A window of 0 would send nothing.
            window: settings.window.max(1),
            ..settings
        };
        Self {
            settings,
            entries: Entries::with_capacity(MAX_WAITING + MAX_KEPT + INSERTED_CAPACITY),
            phase: Phase::Begin,
            credit: Credit::new(),
            reader: Reader::new(),
            events: Events::new(),
            window: settings.window,
            gaps: 0,
            gap: false,
            ended: false,
            expects: NextOffer::AtOnce,
            finished_reported: false,
            lit: false,
            stopped: false,
            starts: 0,
            group: None,
            control: None,
            retry_at: None,
            gathering_since: None,
            accepted: 0,
            first: None,
            last: None,
            expected: None,
            newest: None,
            guessed: false,
            confirmed: None,
            last_pose: None,
            last_position: None,
            cleared_at: 0,
            base: 0,
            phase_at_end: Phase::Begin,
            found: 0,
            cleared: false,
            starve_count: 0,
            is_dry: false,
            clock: Clock::default(),
            now: 0,
            beginning: None,
        }
    }

    /// Creates a stream as [`new`](Self::new), for an arm at rest whose state was read just now,
    /// which saves reading it again.
    #[must_use]
    pub fn beginning(settings: StreamSettings, beginning: Beginning) -> Self {
        Self {
            beginning: Some(beginning),
            ..Self::new(settings)
        }
    }

    /// Number of commands that may be offered at present.
    #[must_use]
    pub fn room(&self) -> usize {
        if self.ended || self.is_over() {
            0
        } else {
            MAX_WAITING.saturating_sub(self.entries.waiting())
        }
    }

    /// True if nothing is sent any more, because everything is finished or the stream has failed.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.finished_reported || self.phase == Phase::Ended
    }

    /// Index of the command accepted last. `None` before the first.
    #[must_use]
    pub fn last_index(&self) -> Option<u64> {
        self.last
    }

    /// Settings in force.
    #[must_use]
    pub fn settings(&self) -> &StreamSettings {
        &self.settings
    }

    /// Command with this index. `None` if unknown, or once it is known to be finished.
    #[must_use]
    pub fn item_at(&self, index: u64) -> Option<&Item> {
        // Finished commands are released, so an old index is not found.
        let at = self.entries.find(|entry| entry.index() == Some(index))?;
        self.entries.get(at).map(|entry| &entry.item)
    }

    /// True if commands wait, here or at the caller, and would be sent if the arm had finished
    /// some.
    #[must_use]
    pub fn wants_room(&self) -> bool {
        self.flows() && (self.next().is_some() || self.waits_for_one())
    }

    /// True if the stream could send more, and the next command is about to be offered.
    #[must_use]
    pub fn is_starving(&self) -> bool {
        self.is_out_of_commands() && self.expects == NextOffer::AtOnce
    }

    /// True if the stream could send more but has no command.
    #[must_use]
    pub fn is_out_of_commands(&self) -> bool {
        !self.ended && !self.is_over() && self.next().is_none()
    }

    /// Number of commands of the caller that the arm has finished, according to the latest reading.
    #[must_use]
    pub fn finished(&self) -> u64 {
        let left = self.unfinished().filter(|entry| !entry.inserted).count();
        self.accepted.saturating_sub(left as u64)
    }

    /// True if the caller offers the next command when the arm has finished one.
    fn waits_for_one(&self) -> bool {
        self.is_out_of_commands() && self.expects == NextOffer::AfterOne
    }

    fn waiting(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(|entry| entry.is_waiting())
    }

    /// Position of the first waiting command. `None` if none waits.
    fn next(&self) -> Option<usize> {
        self.entries.next()
    }

    fn flying(&self) -> usize {
        self.entries.flying()
    }

    /// Unfinished commands in the controller according to the latest reading, in order.
    fn unfinished(&self) -> impl Iterator<Item = &Entry> {
        let current = self.reader.current;
        (self.entries.iter()).filter(move |entry| entry.index().is_some_and(|at| at > current))
    }
}

/// Our own side.
impl Stream {
    /// Adds the next command of the program.
    ///
    /// # Errors
    /// [`Refused`]; the command was not added.
    pub fn offer(&mut self, item: Item) -> Result<(), Refused> {
        if self.ended || self.is_over() {
            return Err(Refused::Over);
        }
        if self.room() == 0 {
            return Err(Refused::Full);
        }
        // The controller would execute it immediately, before what waits.
        if !item.command.row().queueable {
            return Err(Refused::NotQueueable);
        }
        // Only lists have a variable length. The frame itself is encoded when the command is sent.
        let is_list = |field: &Field| matches!(field.range, Range::AtMost(..));
        let checked = item.command.check_fields(is_list);
        if checked.is_err_and(|error| matches!(error.range, Range::AtMost(..))) {
            return Err(Refused::TooLong);
        }
        // The laser stays as it is through commands that do not switch it.
        self.lit = switched_laser_state(&item.command).unwrap_or(self.lit);
        self.entries.push(Entry::new(item, self.lit));
        Ok(())
    }

    /// Declares that no more commands will be offered.
    pub fn finish(&mut self) {
        self.ended = true;
    }

    /// Declares when the next command will be offered, if none waits.
    pub fn expect(&mut self, next: NextOffer) {
        self.expects = next;
    }

    /// Ends the stream with a failure, because the line is lost or a stop is sent.
    ///
    /// Call this before the connection's own `interrupt` or stop. Continue to pass the answers to
    /// the stream, so that it learns the fate of the commands in flight.
    pub fn interrupt(&mut self, failure: crate::connection::Failure) {
        self.fail(StreamFailure::Request(failure));
    }

    /// Withdraws the commands that were not sent yet, because the caller has gone.
    pub fn withdraw(&self, connection: &mut Connection) {
        for (ticket, _) in self.under_way() {
            connection.cancel(ticket);
        }
        if let Some(ticket) = self.control {
            connection.cancel(ticket);
        }
    }

    /// Requests of commands that the connection has not ended, with their frames.
    pub fn under_way(&self) -> impl Iterator<Item = (Ticket, FrameBuf)> {
        self.entries.iter().filter_map(|entry| match entry.fate {
            Fate::InFlight(ticket) => {
                let frame = FrameBuf::set(&entry.item.command, Ctrl::QUEUED).ok()?;
                Some((ticket, frame))
            }
            _ => None,
        })
    }

    /// Reports that the controller was reset. The stream ends, because its queue is lost.
    pub fn reset(&mut self) {
        let before = self.reader.current;
        self.fail(StreamFailure::Reset { before, now: None });
    }

    /// Advances the clock of an arm in virtual time by `time`; it then stands until the next call.
    ///
    /// `news` is true if the arm has finished something and must be read. Call
    /// [`advance`](Self::advance) afterwards.
    pub fn leap_clock(&mut self, now: Micros, time: Duration, news: bool) {
        let arm = self.clock.leap(now, time);
        if news {
            self.reader.hear(arm);
        }
    }

    /// Lets the arm's time pass with the connection's clock again, until the next leap.
    pub fn run_clock(&mut self, now: Micros) {
        self.clock.run(now);
    }

    /// Returns the next event. `None` if all were returned.
    pub fn poll_event(&mut self) -> Option<StreamEvent> {
        self.events.pop()
    }

    /// Instant at which [`advance`](Self::advance) must be called. `None` if nothing is due, and
    /// while the clock [leaps](Self::leap_clock).
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        self.clock.comes(self.due(self.reader.poll_timeout())?)
    }

    /// Longest [leap](Self::leap_clock) of the clock before something is due. `None` if nothing is.
    ///
    /// The leap must not go beyond the end of the arm's last command nor, if the stream [wants
    /// room](Self::wants_room), beyond the end of the current one.
    #[must_use]
    pub fn patience(&self, now: Micros) -> Option<Duration> {
        let due = self.due(self.reader.poll_leap())?;
        Some(due - self.clock.at(now))
    }

    /// Next instant at which something is due, in the arm's time. `None` if nothing is.
    fn due(&self, look: Option<ArmInstant>) -> Option<ArmInstant> {
        if self.is_over() {
            return None;
        }
        let gathered = self
            .gathering_since
            .map(|at| at.after_micros(drive::GATHER_TIME));
        [look, self.retry_at, gathered].into_iter().flatten().min()
    }

    fn fail(&mut self, failure: StreamFailure) {
        // Only the first failure counts; later ones are its consequences.
        if !self.is_over() {
            self.note_interruption();
            self.phase = Phase::Ended;
            self.events.push(StreamEvent::Failed(failure));
        }
    }

    /// Submits a request with the stream's patience as deadline.
    fn submit(&self, request: Request, priority: Priority, to: &mut Connection) -> Ticket {
        let deadline = self.now.saturating_add(self.settings.patience);
        to.submit(request.priority(priority).deadline(deadline))
    }
}
