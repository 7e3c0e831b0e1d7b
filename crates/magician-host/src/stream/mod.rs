//! Any number of queued commands, kept flowing through a [`Connection`]: never more in the arm than may run on when the
//! host dies, never less than keeps it moving, and every command accounted for.
//!
//! A [`Stream`] does no I/O and reads no clock. Its methods come in the kinds of the connection's, and a shell calls them
//! in the same round:
//!
//! * look: `&self` methods, which change nothing;
//! * our own side: [`offer`](Stream::offer) a command while there is [`room`](Stream::room), [`finish`](Stream::finish)
//!   when no more comes, [`interrupt`](Stream::interrupt) when the line is lost or the arm is stopped,
//!   [`reset`](Stream::reset) when the connection says that the controller was reset;
//! * [`answered`](Stream::answered): the connection has ended a request;
//! * time: [`advance`](Stream::advance) submits what is due. It is called after each of the calls above, and at the
//!   instant that [`poll_timeout`](Stream::poll_timeout) names;
//! * what comes out: [`poll_event`](Stream::poll_event), until it returns `None`.
//!
//! The same calls give the same results. Memory is bounded and taken when the stream is made: offered commands wait in
//! [`WAITING`] places, and a command is kept until the arm has certainly finished it, at most [`KEPT`] of them.
//!
//! # How much is in the arm
//!
//! *Credit* is the number of places minus the commands that were accepted and not finished, by their indices, minus those
//! in flight. Left space is read now and then beside it; the lower of both counts. When they disagree in three
//! readings in a row, left space wins: fewer places are used from then on
//! ([`StreamEvent::Places`]), or, if commands are missing from the queue, it was cleared and the stream fails.
//!
//! The *horizon* bounds what the arm does when the host dies: the times of all that is accepted or in flight and not
//! finished, the one under way counted whole. Two commands are allowed whatever they take, so that the arm always has the
//! next one. An unknown time fills the horizon. With [`start`](StreamSettings::start) off there is no horizon: a caller
//! that only fills a queue decides when it runs.
//!
//! # Stopped first, then started
//!
//! A program that fits (all of it offered, finished with `finish`, within places and horizon) is put in whole while the
//! queue is stopped and then started: nothing moves unless all of it was taken. A longer one is put in up to the horizon,
//! started, and goes on. A queue in which earlier commands wait is not stopped (a stop would cut short a WAIT of theirs),
//! nor is one stopped for a single command. Whether a program is a batch is known when it is finished or more than a batch
//! is offered; a caller that does neither is waited for 20 ms.
//!
//! # Whose time
//!
//! The times of commands are the arm's. Its clock is taken to be the connection's, until [`leapt`](Stream::leapt) says that the
//! arm is one in virtual time.
//!
//! # The laser
//!
//! There are two lights. The laser of a path (`CPLECmd`) goes out when the path comes to rest (model section 8): such
//! segments stream like others with the shorter [`laser_horizon`](StreamSettings::laser_horizon), and when nothing follows
//! they end dark by themselves. The laser that `SetEndEffectorLaser` switches burns until it is switched off, so it is
//! never lit by a queue that does not hold what puts it out again: from the command that lights it to the one that puts
//! it out is a *chunk*, which is put in whole while the queue is stopped and empty, and then started. A chunk that would
//! take longer than the laser's horizon, or more places than there are, is split at the end of a command: the stream
//! inserts a command that puts the laser out and one that lights it again for the next chunk. On the work this shows: at
//! every seam (once a second; with 32 places every 30 segments, if they are short) the arm stands still and dark while the
//! next chunk goes in, a tenth of a second or two, and because it brakes before the seam with the laser at full power and
//! speeds up after it, the line is darker there. For an even line use `CPLECmd`. A program that ends with
//! the laser lit is left as it was asked for. A laser lit through its IO pins or before the stream is not seen as switched;
//! for it, as for all that has [`Item::laser`] set, the shorter horizon holds.
//!
//! # Above window 1
//!
//! Between commands in flight one may be lost, and the arm may have begun the next one before anybody knows: from another
//! start, and an absolute line from another start is another line. So only what such a loss does not change shares the
//! window: dark absolute segments of a path, as long as every line from one of the places that are not beyond doubt to the
//! new one passes all those between within [`STRAIGHT`]. Whatever is lost of them, the same line is drawn. A corner, a
//! segment that lifts or lowers, a point-to-point move, and all that switches something waits until all before it is beyond
//! doubt, and travels alone.
//!
//! When a command is lost between others, the queue is stopped (the segment under way ends at its end point) and cleared, and
//! when it has drained, current index and pose tell at which vertex the arm stands. What leads there is drawn; it goes on
//! with the next one, from where that begins. Nothing is done twice, and nothing is gone back to. After three of these the
//! rest goes at window 1. If the arm stands at none of the vertices that it can have come to, or something that must not be
//! done twice is in doubt, the stream fails instead, and nothing goes again. Where commands of others wait in the queue, or
//! the caller starts it himself, nothing may be cleared, and commands go one by one.
//!
//! # Going on after an interruption
//!
//! Nothing is resumed by itself. [`leftover`](Stream::leftover) has what is not known to be finished, and
//! [`resume`](Stream::resume) finds out what became of it (current index and left space until they stand, then the pose)
//! before it sends anything; what does not add up is a [`StreamFailure`] with both values.

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
use item::{Entry, Fate, switched};
pub use line::STRAIGHT;
use reading::Reader;
pub use resume::Leftover;
use resume::POSE_TOLERANCE;

/// Most commands that wait in a stream.
pub const WAITING: usize = 40;
/// Most commands that a stream keeps which are in the controller or on their way.
pub const KEPT: usize = 40;
/// Two of the stream's own for each chunk that may be split while all places are taken.
const SPARE: usize = 8;

/// A queued program on its way to the arm; see the [module](self).
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
/// // It looks at the arm before it sends anything.
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
    /// Repeatable commands that may be in flight at present.
    window: usize,
    gaps: usize,
    /// Something was lost between others.
    gap: bool,
    /// No more comes.
    ended: bool,
    /// When more comes, unless that.
    expects: NextOffer,
    /// `Finished` was told.
    told: bool,
    /// The laser stays lit after the command offered last.
    lit: bool,
    /// The stream has stopped the queue and not started it since.
    stopped: bool,
    /// Starts of the queue in a row that were not answered.
    starts: u8,
    /// Commands of the group that goes in while the queue is stopped which have not gone out; `None`: as many as may.
    group: Option<usize>,
    control: Option<Ticket>,
    /// Nothing is submitted before, because the connection had no room.
    retry_at: Option<ArmInstant>,
    /// When the first command was seen to wait for more.
    gathers: Option<ArmInstant>,
    /// Commands of the caller that were accepted, and the first and last index given.
    accepted: u64,
    first: Option<u64>,
    last: Option<u64>,
    /// The index that has to come next.
    expected: Option<u64>,
    /// The command that was accepted last.
    newest: Option<Entry>,
    /// Its index may be too low ([`Connection::is_last_a_guess`]), or that of what was found in the queue.
    guessed: bool,
    confirmed: Option<u64>,
    /// Where the arm stands after what was finished and let go, when that is known.
    stood: Option<[f64; 4]>,
    /// The same as a place, also for a segment of which nothing but its command is known.
    place: Option<[f64; 3]>,
    /// The current index when the queue was cleared last, or when the stream began.
    cleared_at: u64,
    /// The index given last before the stream's first, or before its first since the queue was cleared.
    base: u64,
    /// What it was about when it ended.
    was: Phase,
    /// On resuming: commands that turned out to have been taken.
    found: usize,
    /// On resuming: the queue was stopped and cleared meanwhile.
    cleared: bool,
    starved: u64,
    dry: bool,
    clock: Clock,
    /// What the connection's clock showed last.
    now: Micros,
    /// How the arm was when it began, if that was read for it.
    beginning: Option<Beginning>,
}

/// Look.
impl Stream {
    /// A stream without commands.
    #[must_use]
    pub fn new(settings: StreamSettings) -> Self {
        let settings = StreamSettings {
            window: settings.window.max(1),
            ..settings
        };
        Self {
            settings,
            entries: Entries::with_capacity(WAITING + KEPT + SPARE),
            phase: Phase::Begin,
            credit: Credit::new(),
            reader: Reader::new(),
            events: Events::new(),
            window: settings.window,
            gaps: 0,
            gap: false,
            ended: false,
            expects: NextOffer::AtOnce,
            told: false,
            lit: false,
            stopped: false,
            starts: 0,
            group: None,
            control: None,
            retry_at: None,
            gathers: None,
            accepted: 0,
            first: None,
            last: None,
            expected: None,
            newest: None,
            guessed: false,
            confirmed: None,
            stood: None,
            place: None,
            cleared_at: 0,
            base: 0,
            was: Phase::Begin,
            found: 0,
            cleared: false,
            starved: 0,
            dry: false,
            clock: Clock::default(),
            now: 0,
            beginning: None,
        }
    }

    /// As [`new`](Self::new), for an arm at rest that was looked at just now: it need not be looked at once more.
    #[must_use]
    pub fn beginning(settings: StreamSettings, beginning: Beginning) -> Self {
        Self {
            beginning: Some(beginning),
            ..Self::new(settings)
        }
    }

    /// How many commands may be offered at present.
    #[must_use]
    pub fn room(&self) -> usize {
        if self.ended || self.is_over() {
            0
        } else {
            WAITING.saturating_sub(self.entries.waiting())
        }
    }

    /// Whether nothing goes out any more: everything is finished, or it has failed.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.told || self.phase == Phase::Over
    }

    /// Index of the command accepted last.
    #[must_use]
    pub fn last_index(&self) -> Option<u64> {
        self.last
    }

    /// How it behaves.
    #[must_use]
    pub fn settings(&self) -> &StreamSettings {
        &self.settings
    }

    /// The command that was given this index, while it is not known to be finished.
    #[must_use]
    pub fn item_at(&self, index: u64) -> Option<&Item> {
        let at = self.entries.find(|entry| entry.index() == Some(index))?;
        self.entries.get(at).map(|entry| &entry.item)
    }

    /// Whether commands wait, here or with its caller, that would go out if the arm had finished some.
    #[must_use]
    pub fn wants_room(&self) -> bool {
        self.flows() && (self.next().is_some() || self.waits_for_one())
    }

    /// Whether it would send more if there was more, and there is about to be.
    #[must_use]
    pub fn starves(&self) -> bool {
        self.has_nothing() && self.expects == NextOffer::AtOnce
    }

    /// Whether it would send more if there was more.
    #[must_use]
    pub fn has_nothing(&self) -> bool {
        !self.ended && !self.is_over() && self.next().is_none()
    }

    /// How many commands of the caller the arm has finished, as far as was read.
    #[must_use]
    pub fn finished(&self) -> u64 {
        let left = self.unfinished().filter(|entry| !entry.inserted).count();
        self.accepted.saturating_sub(left as u64)
    }

    /// More comes when a command has ended.
    fn waits_for_one(&self) -> bool {
        self.has_nothing() && self.expects == NextOffer::AfterOne
    }

    fn waiting(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(|entry| entry.is_waiting())
    }

    /// The place of the first command that waits.
    fn next(&self) -> Option<usize> {
        self.entries.next()
    }

    fn flying(&self) -> usize {
        self.entries.flying()
    }

    /// What is in the controller and not finished, as far as was read, in order.
    fn unfinished(&self) -> impl Iterator<Item = &Entry> {
        let current = self.reader.current;
        (self.entries.iter()).filter(move |entry| entry.index().is_some_and(|at| at > current))
    }
}

/// Our own side.
impl Stream {
    /// Takes the next command.
    ///
    /// # Errors
    /// [`Refused`]; nothing was taken.
    pub fn offer(&mut self, item: Item) -> Result<(), Refused> {
        if self.ended || self.is_over() {
            return Err(Refused::Over);
        }
        if self.room() == 0 {
            return Err(Refused::Full);
        }
        if !item.command.row().queueable {
            return Err(Refused::NotQueueable);
        }
        // Lists alone have a length: the frame itself is made when the command goes out.
        let is_list = |field: &Field| matches!(field.range, Range::AtMost(..));
        let checked = item.command.check_fields(is_list);
        if checked.is_err_and(|error| matches!(error.range, Range::AtMost(..))) {
            return Err(Refused::TooLong);
        }
        self.lit = switched(&item.command).unwrap_or(self.lit);
        self.entries.push(Entry::new(item, self.lit));
        Ok(())
    }

    /// No more comes.
    pub fn finish(&mut self) {
        self.ended = true;
    }

    /// When the next command is offered, where none waits.
    pub fn expect(&mut self, next: NextOffer) {
        self.expects = next;
    }

    /// The line is lost, or a stop goes out: the stream ends with this failure. Call it before the connection's own
    /// `interrupt` or stop, and go on giving it the answers, so that it knows what became of what was in flight.
    pub fn interrupt(&mut self, failure: crate::connection::Failure) {
        self.fail(StreamFailure::Request(failure));
    }

    /// Its caller has gone: what was not sent yet will not be.
    pub fn withdraw(&self, connection: &mut Connection) {
        for (ticket, _) in self.under_way() {
            connection.cancel(ticket);
        }
        if let Some(ticket) = self.control {
            connection.cancel(ticket);
        }
    }

    /// The commands that the connection has and has not ended, with the frames that answers are to.
    pub fn under_way(&self) -> impl Iterator<Item = (Ticket, FrameBuf)> {
        self.entries.iter().filter_map(|entry| match entry.fate {
            Fate::Flying(ticket) => {
                let frame = FrameBuf::set(&entry.item.command, Ctrl::QUEUED).ok()?;
                Some((ticket, frame))
            }
            _ => None,
        })
    }

    /// The connection has told that the controller was reset: the stream ends, for what was queued is gone.
    pub fn reset(&mut self) {
        let before = self.reader.current;
        self.fail(StreamFailure::Reset { before, now: None });
    }

    /// An arm in virtual time: so much of its time has passed at once, and no more passes until the next call. `news`: it has finished
    /// something, and is to be looked at. Call [`advance`](Self::advance) afterwards.
    pub fn leapt(&mut self, now: Micros, time: Duration, news: bool) {
        let arm = self.clock.leap(now, time);
        if news {
            self.reader.hear(arm);
        }
    }

    /// From now on time passes again as by the connection's clock, as long as it does not leap.
    pub fn runs(&mut self, now: Micros) {
        self.clock.run(now);
    }

    /// The next thing to tell.
    pub fn poll_event(&mut self) -> Option<StreamEvent> {
        self.events.pop()
    }

    /// The instant at which [`advance`](Self::advance) is to be called, if any. There is none while its clock
    /// [leaps](Self::leapt).
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        self.clock.comes(self.due(self.reader.poll_timeout())?)
    }

    /// How much time may pass at once ([`leapt`](Self::leapt)) before something is due, if anything is; but not beyond the
    /// end of what the arm has, nor, if the stream [wants room](Self::wants_room), beyond that of a command.
    #[must_use]
    pub fn patience(&self, now: Micros) -> Option<Duration> {
        let due = self.due(self.reader.poll_leap())?;
        Some(due - self.clock.at(now))
    }

    /// The first of the instants at which something is due, by the arm's time.
    fn due(&self, look: Option<ArmInstant>) -> Option<ArmInstant> {
        if self.is_over() {
            return None;
        }
        let gathered = self.gathers.map(|at| at.after_micros(drive::GATHER));
        [look, self.retry_at, gathered].into_iter().flatten().min()
    }

    fn fail(&mut self, failure: StreamFailure) {
        if !self.is_over() {
            self.note_interruption();
            self.phase = Phase::Over;
            self.events.push(StreamEvent::Failed(failure));
        }
    }

    /// Puts a request into the connection; the answer has to come within the stream's patience.
    fn submit(&self, request: Request, priority: Priority, to: &mut Connection) -> Ticket {
        let deadline = self.now.saturating_add(self.settings.patience);
        to.submit(request.priority(priority).deadline(deadline))
    }
}
