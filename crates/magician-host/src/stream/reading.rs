//! Readings of current index, left space and pose: what is read, how often, and what it shows.
//!
//! Each reading costs line time, so the stream reads as rarely as it can: seldom while there is
//! room for more commands, otherwise when the queue is expected to have made enough progress.

use magician_protocol::commands::{Pose, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{ArmInstant, FrameBuf, NoArgs, Readable};

use super::drive::Beginning;
use super::item::{ArmPace, Entry, NextOffer};
use super::resume::QueueSnapshot;
use super::{Stream, StreamEvent, StreamFailure};
use crate::connection::{Connection, Failure, Micros, Priority, Request, Ticket};

/// Shortest time between two readings, us.
// A choice: leaves most of an idle line to others.
pub(super) const MIN_READ_INTERVAL: Micros = 10_000;
/// Longest time between two readings while something is under way, us.
// A choice: times from a check may be wrong.
const MAX_READ_INTERVAL: Micros = 200_000;
/// Longest time before a reading at the end of a single command whose time is known, us.
const MAX_END_WAIT: Micros = 10_000_000;
/// Time between two readings while commands flow and there is room for many more, us. A reading
/// that cannot travel beside a command costs as much line time as a command.
const FLOWING_READ_INTERVAL: Micros = 400_000;
/// Shortest time between two readings of left space while the stream waits for the arm, us. The
/// cross-check finds lost commands, so it is frequent while the line is idle.
const CROSS_CHECK_INTERVAL: Micros = 50_000;
/// The same while commands keep the line busy, us.
const BUSY_CROSS_CHECK_INTERVAL: Micros = 1_000_000;

/// A request of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reading {
    Left,
    Current,
    Pose,
}

/// Reads the queue: left space if wanted, then the current index, then the pose if wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reader {
    flight: Option<(Reading, Ticket)>,
    /// Requests that the reading in progress has yet to make.
    rest: [Option<Reading>; 3],
    /// Instant of the next reading.
    due: Option<ArmInstant>,
    /// True if that reading is a poll, needed only because the arm does not report the end of a
    /// command.
    awaits_news: bool,
    wants_left: bool,
    wants_pose: bool,
    /// True if the reading in progress, or the last one, includes the pose.
    pub(super) has_pose: bool,
    /// True if the planned reading is for the end of the only command, so the current index alone
    /// decides.
    ends: bool,
    /// True if the planned reading is not urgent.
    seldom: bool,
    /// Index of the command finished last; 0 before the first reading.
    pub(super) current: u64,
    known: bool,
    /// True if a lower current index was read last; the next reading decides whether to believe it.
    lower: bool,
    /// Instant at which the current index last advanced or was first read, or at which the queue
    /// began to run. [`ArmInstant::MAX`] in a resumed stream before its first reading.
    changed: ArmInstant,
    misses: u32,
    /// Left space read last, and when.
    pub(super) left: u32,
    left_at: Option<ArmInstant>,
    /// Last index accepted when left space was requested, and the largest possible number of queued
    /// commands when it arrived.
    accepted: Option<u64>,
    at_most: u32,
    compares: bool,
    pub(super) pose: [f64; 4],
}

impl Reader {
    pub(super) fn new() -> Self {
        Self {
            flight: None,
            rest: [None; 3],
            due: None,
            awaits_news: false,
            wants_left: false,
            wants_pose: false,
            has_pose: false,
            ends: false,
            seldom: false,
            current: 0,
            known: false,
            lower: false,
            changed: ArmInstant::ZERO,
            misses: 0,
            left: 0,
            left_at: None,
            accepted: None,
            at_most: 0,
            compares: false,
            pose: [0.0; 4],
        }
    }

    /// Creates the reader of a resumed stream, which knows the commands finished before.
    pub(super) fn after(current: u64) -> Self {
        Self {
            current,
            known: true,
            changed: ArmInstant::MAX,
            ..Self::new()
        }
    }

    /// Processes the state of an arm at rest that another caller has read.
    pub(super) fn was_told(&mut self, now: ArmInstant, beginning: &Beginning) {
        (self.left, self.left_at) = (beginning.left, Some(now));
        (self.current, self.known, self.changed) = (beginning.current, true, now);
        (self.pose, self.has_pose) = (beginning.pose, true);
    }

    /// Queue and pose of the reading that ended just now.
    pub(super) fn snapshot(&self, now: ArmInstant) -> QueueSnapshot {
        QueueSnapshot {
            at: now,
            current: self.current,
            left: self.left,
            pose: self.pose,
        }
    }

    pub(super) fn poll_timeout(&self) -> Option<ArmInstant> {
        self.due.filter(|_| !self.is_busy())
    }

    /// Same as [`poll_timeout`](Self::poll_timeout), for a clock that leaps from one end of a
    /// command to the next.
    pub(super) fn poll_leap(&self) -> Option<ArmInstant> {
        self.poll_timeout().filter(|_| !self.awaits_news)
    }

    /// Advances the next reading, because the arm has finished something.
    pub(super) fn hear(&mut self, now: ArmInstant) {
        if self.due.is_some() {
            self.look(now);
        }
    }

    fn is_busy(&self) -> bool {
        self.flight.is_some() || self.rest.iter().any(Option::is_some)
    }

    /// True if a reading is in progress or planned.
    pub(super) fn is_planned(&self) -> bool {
        self.is_busy() || self.due.is_some()
    }

    /// Notes that the arm begins with what it has.
    pub(super) fn begins(&mut self, now: ArmInstant) {
        (self.changed, self.misses) = (now, 0);
    }

    /// Instant at which the arm began its current command, as far as was observed.
    pub(super) fn begun(&self) -> ArmInstant {
        self.changed
    }

    /// Plans the next reading for `at` at the latest.
    pub(super) fn look(&mut self, at: ArmInstant) {
        if self.due.is_none_or(|due| at <= due) {
            (self.due, self.awaits_news) = (Some(at), false);
        }
    }

    /// Plans a full reading for `at`: left space, current index and, if `pose`, the pose.
    pub(super) fn look_closely(&mut self, at: ArmInstant, pose: bool) {
        (self.wants_left, self.wants_pose) = (true, pose);
        self.look(at);
    }

    /// Includes left space in the next reading.
    pub(super) fn want_left(&mut self) {
        self.wants_left = true;
    }
}

fn request(reading: Reading) -> Option<Request> {
    let request = match reading {
        Reading::Left => Request::get::<QueuedCmdLeftSpace>(&NoArgs),
        Reading::Current => Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
        Reading::Pose => Request::get::<Pose>(&NoArgs),
    };
    request.ok()
}

impl Stream {
    /// Begins a reading that is due, or continues the current one.
    pub(super) fn read(&mut self, now: ArmInstant, to: &mut Connection) {
        let flies = self.flows() && self.flying() > 0;
        let reader = &mut self.reader;
        if !reader.is_busy() && reader.due.is_some_and(|due| due <= now) {
            // While commands flow, their own replies show most losses.
            let check = if flies {
                BUSY_CROSS_CHECK_INTERVAL
            } else {
                CROSS_CHECK_INTERVAL
            };
            let stale = reader
                .left_at
                .is_none_or(|at| at.after_micros(check) <= now);
            let ends = std::mem::take(&mut reader.ends);
            // At the end of the only command the current index alone decides.
            let left = reader.wants_left || stale && !ends;
            reader.rest = [
                left.then_some(Reading::Left),
                Some(Reading::Current),
                reader.wants_pose.then_some(Reading::Pose),
            ];
            (reader.compares, reader.has_pose) = (left, reader.wants_pose);
            (reader.due, reader.awaits_news) = (None, false);
            (reader.wants_left, reader.wants_pose) = (false, false);
        }
        if reader.flight.is_some() {
            return;
        }
        // Requests go one at a time, in this order: the current index read after left space bounds
        // it.
        let Some(reading) = reader.rest.iter_mut().find_map(Option::take) else {
            return;
        };
        if reading == Reading::Left {
            self.reader.accepted = self.last;
        }
        if let Some(request) = request(reading) {
            let ticket = self.submit(request, Priority::Poll, to);
            self.reader.flight = Some((reading, ticket));
        }
    }

    /// Processes the result of a request. True if it was a reading of the stream.
    pub(super) fn reading_answered(
        &mut self,
        now: ArmInstant,
        ticket: Ticket,
        result: &Result<FrameBuf, Failure>,
        connection: &mut Connection,
    ) -> bool {
        let Some((reading, _)) = self.reader.flight.take_if(|(_, flying)| *flying == ticket) else {
            return false;
        };
        match result {
            Ok(frame) if self.note(now, reading, frame).is_some() => {
                if !self.reader.is_busy() {
                    self.looked(now, connection);
                }
            }
            // An unexpected reply, or no room in the connection: read again.
            Ok(_) | Err(Failure::Busy) => {
                self.reader.rest = [None; 3];
                self.reader
                    .look_closely(now.after_micros(MIN_READ_INTERVAL), true);
            }
            Err(failure) => self.fail(StreamFailure::Request(*failure)),
        }
        true
    }

    /// Processes a reply to another caller: its current index saves the stream a reading.
    /// Call [`advance`](Self::advance) afterwards.
    pub fn note_foreign_reply(&mut self, now: Micros, frame: &FrameBuf) {
        let now = self.clock.at(now);
        let view = frame.frame();
        let read = if view.ctrl().write() || view.ctrl().queued() {
            return;
        } else {
            view.read::<QueuedCmdCurrentIndex>()
        };
        let is_it = view.id() == <QueuedCmdCurrentIndex as Readable>::ROW.id;
        if let (true, true, Ok(read)) = (is_it, self.flows(), read) {
            self.note_current(now, read.queued_cmd_current_index);
            self.report_progress();
        }
    }

    fn note(&mut self, now: ArmInstant, reading: Reading, frame: &FrameBuf) -> Option<()> {
        let view = frame.frame();
        match reading {
            Reading::Left => {
                self.reader.left = view.read::<QueuedCmdLeftSpace>().ok()?.left_space;
                self.reader.left_at = Some(now);
                // Now, before the current index is read: the count must belong to this left space.
                self.reader.at_most = self.at_most();
            }
            Reading::Current => {
                let read = view.read::<QueuedCmdCurrentIndex>().ok()?;
                self.note_current(now, read.queued_cmd_current_index);
            }
            Reading::Pose => {
                let pose = view.read::<Pose>().ok()?;
                self.reader.pose = [pose.x, pose.y, pose.z, pose.r].map(f64::from);
            }
        }
        Some(())
    }

    fn note_current(&mut self, now: ArmInstant, read: u64) {
        let reader = &mut self.reader;
        if reader.known && read < reader.current {
            // On an unordered link a single lower reading may be old.
            if reader.lower {
                let (before, now) = (reader.current, Some(read));
                self.fail(StreamFailure::Reset { before, now });
            } else {
                reader.lower = true;
                reader.look(now);
            }
            return;
        }
        reader.misses = if read > reader.current {
            0
        } else {
            reader.misses.saturating_add(1)
        };
        if read > reader.current || !reader.known || reader.changed == ArmInstant::MAX {
            reader.changed = now;
        }
        (reader.current, reader.known, reader.lower) = (read, true, false);
        self.mark();
    }

    /// True if there is room for all commands sent before a reading can report more. The reading
    /// may then wait its turn among the commands without delaying any of them.
    fn has_room(&self) -> bool {
        self.credit() > self.window + 2
    }

    /// Evaluates a complete reading.
    fn looked(&mut self, now: ArmInstant, connection: &mut Connection) {
        // A lower current index is read again before anything is concluded.
        if self.reader.lower || self.is_over() {
            return;
        }
        if self.reader.compares && self.takes_stock() {
            let Self { reader, .. } = self;
            let (left, accepted, at_most) = (reader.left, reader.accepted, reader.at_most);
            if !self.compare(left, accepted, at_most, connection) {
                self.reader.look_closely(now, false);
            }
        }
        if self.is_over() {
            return;
        }
        self.note_dryness(connection.round_trip().unwrap_or(0));
        self.look_complete(now, connection.last_index().map(|index| index.0));
        self.release_finished(connection);
    }

    /// Counts how often the arm ran dry although there was work.
    fn note_dryness(&mut self, round_trip: Micros) {
        let dry = self.flows() && self.is_dry(round_trip);
        if dry && !self.is_dry {
            self.starve_count = self.starve_count.saturating_add(1);
            let times = self.starve_count;
            self.events.push(StreamEvent::Starved { times });
        }
        self.is_dry = dry;
    }

    /// True if the arm is idle although there is work, or will be before more can arrive. On a full
    /// line a reading never sees an empty queue, because it travels behind a command.
    fn is_dry(&self, round_trip: Micros) -> bool {
        if self.entries.unfinished(self.reader.current).count > 1 {
            return false;
        }
        let moves = |entry: &Entry| entry.item.time > 0;
        let accepted = self
            .entries
            .iter()
            .rev()
            .find(|entry| entry.index().is_some());
        let next = self.entries.iter().find(|entry| entry.index().is_none());
        if !accepted.is_some_and(moves) || !next.is_some_and(moves) {
            return false;
        }
        match self.unfinished().next() {
            None => true,
            Some(only) => self.flying() > 0 && only.item.time < round_trip,
        }
    }

    /// Plans the next reading. While there is room it comes seldom; otherwise when about three
    /// eighths of the queue should be done if more commands wait, and when all of it should be done
    /// if not. Nothing is planned if there is nothing to wait for.
    pub(super) fn pace(&mut self, now: ArmInstant) {
        let flows = self.flows() && self.flying() > 0 && self.has_room();
        if self.reader.is_planned() && (flows || !self.reader.seldom) {
            return;
        }
        self.reader.seldom = flows;
        if flows {
            return self.reader.look(now.after_micros(FLOWING_READ_INTERVAL));
        }
        let count = self.entries.unfinished(self.reader.current).count;
        if self.entries.kept() == 0 && !self.credit.full {
            return;
        }
        let ahead = if self.next().is_some() || self.waits_for_one() {
            // A choice: early enough to refill the queue before it runs dry, late enough to free
            // several places.
            (count * 3 / 8).max(1)
        } else {
            count
        };
        let times = self.unfinished().take(ahead).map(|entry| entry.item.time);
        let time = times.fold(0, Micros::saturating_add);
        let since = now.micros_since(self.reader.changed);
        let wait = match time.saturating_sub(since) {
            // The command takes longer than expected: read at growing intervals.
            0 => time.min(MIN_READ_INTERVAL << self.reader.misses.min(4)),
            wait => wait,
        };
        let last = self.next().is_none() && self.expects == NextOffer::AtOnce;
        let only = count == 1 && time < Micros::MAX && since < time && last;
        let wait = match self.settings.pace {
            _ if !only => wait.clamp(MIN_READ_INTERVAL, MAX_READ_INTERVAL),
            ArmPace::Faster if self.reader.misses == 0 && !self.clock.leaps() => 0,
            ArmPace::OnTime => wait.clamp(MIN_READ_INTERVAL, MAX_END_WAIT),
            _ if self.clock.leaps() => wait.clamp(MIN_READ_INTERVAL, MAX_END_WAIT),
            _ => wait.clamp(MIN_READ_INTERVAL, MAX_READ_INTERVAL),
        };
        // The reading comes when the only command ends, so the current index alone decides.
        self.reader.ends = only && (wait == 0 || since.saturating_add(wait) >= time);
        self.reader.look(now.after_micros(wait));
        self.reader.awaits_news = self.flows();
    }
}
