//! The phases of a stream: look at the arm, decide on a batch, stop, load, start, run; and after a
//! loss settle, halt, clear and drain.

use magician_protocol::commands::{QueuedCmdClear, QueuedCmdStartExec, QueuedCmdStopExec};
use magician_protocol::{ArmInstant, Ctrl, EncodeError, FrameBuf};

use super::item::{Entry, Fate, NextOffer};
use super::resume::{MOVING_PAUSE, QueueSnapshot};
use super::{Stream, StreamEvent};
use crate::REST_TIME;
use crate::connection::{Connection, Micros, Priority, Request};

/// Time that the first commands wait for more before the program counts as too long for a batch,
/// us.
// A choice: longer than a caller needs to offer a batch, and hardly noticed.
pub(super) const GATHER_TIME: Micros = 20_000;

/// State of an arm at the beginning of a stream, when no commands of others wait in its queue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beginning {
    /// Free places in the queue.
    pub left: u32,
    /// Index of the command finished last.
    pub current: u64,
    /// Pose of the arm: x, y, z in mm and r in degrees.
    pub pose: [f64; 4],
}

/// Phase of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phase {
    /// Waits for the first command and reads the state of the arm.
    Begin,
    /// Decides how many commands are put in before the queue is started.
    Choose,
    /// The queue is being stopped for a group of commands.
    Stop,
    /// The group is being put in.
    Load,
    /// The group is in the queue, and the stream checks whether the arm stands still. Holds the
    /// previous reading. A start during a motion may end the motion (model section 14).
    AwaitRest(Option<QueueSnapshot>),
    /// The queue is being started.
    Start,
    /// Commands flow.
    Run,
    /// A command was lost: waits for the other replies.
    Settle,
    /// The queue is being stopped after a loss.
    Halt,
    /// The stopped queue finishes the current command. Holds the previous reading. A Clear during a
    /// motion may end the motion (model section 14).
    AwaitStop(Option<QueueSnapshot>),
    Clear,
    /// The cleared queue drains; its left space, and the instant since which that is constant.
    Drain {
        since: ArmInstant,
        left: u32,
    },
    /// Finds out the fate of what was sent before an interruption.
    Resolve(Option<QueueSnapshot>),
    Ended,
}

impl Stream {
    /// Submits everything that is due.
    pub fn advance(&mut self, now: Micros, connection: &mut Connection) {
        self.now = now;
        let now = self.clock.at(now);
        if self.credit.places == 0 {
            self.credit.places = connection.capacity();
        }
        // If the connection sends one at a time, nothing can be lost between others.
        let window = self.settings.window.min(connection.window());
        (self.settings.window, self.window) = (window, self.window.min(window));
        self.retry_at = self.retry_at.filter(|at| *at > now);
        self.release_finished(connection);
        debug_assert!(self.entries.is_counted(), "{:?}", self.entries);
        if self.gap && self.phase != Phase::Settle {
            self.begin_recovery();
        }
        while !self.is_over() && self.step(now, connection) {}
        if !self.is_over() {
            self.read(now, connection);
        }
    }

    /// Performs one step of the phase. True if the phase has changed.
    fn step(&mut self, now: ArmInstant, to: &mut Connection) -> bool {
        let before = self.phase;
        match self.phase {
            Phase::Begin => self.begin(now, to),
            Phase::Choose => self.choose(now),
            Phase::Stop | Phase::Halt => self.control(Request::set(&QueuedCmdStopExec {}), to),
            Phase::Clear => self.control(Request::set(&QueuedCmdClear {}), to),
            Phase::Start => self.control(Request::set(&QueuedCmdStartExec {}), to),
            Phase::Load => self.load(now, to),
            Phase::Run => self.run(now, to),
            Phase::Settle => self.settle(now),
            // Phases that wait for readings; see `look_complete`.
            Phase::AwaitRest(_)
            | Phase::AwaitStop(_)
            | Phase::Drain { .. }
            | Phase::Resolve(_)
            | Phase::Ended => {}
        }
        self.phase != before
    }

    fn begin(&mut self, now: ArmInstant, to: &Connection) {
        if self.next().is_none() {
            if self.ended {
                self.phase = Phase::Run;
            }
        } else if let Some(beginning) = self.beginning.take() {
            self.reader.was_told(now, &beginning);
            self.begun(to.last_index().map(|index| index.0));
        } else if !self.reader.is_planned() {
            self.reader.look_closely(now, self.settings.start);
        }
    }

    /// Evaluates the first complete reading.
    fn begun(&mut self, last: Option<u64>) {
        let places = self.credit.places.max(self.reader.left);
        self.credit.places = places;
        self.credit.foreign = places - self.reader.left;
        let tail = self
            .reader
            .current
            .saturating_add(self.credit.foreign.into());
        self.base = tail.max(last.unwrap_or(0));
        // A running or foreign queue moves the arm, so its pose says nothing about the start.
        if self.settings.start && self.credit.foreign == 0 {
            let [x, y, z, _] = self.reader.pose;
            (self.last_pose, self.last_position) = (Some(self.reader.pose), Some([x, y, z]));
        }
        self.cleared_at = self.base;
        self.phase = if self.settings.start {
            Phase::Choose
        } else {
            Phase::Run
        };
    }

    /// Evaluates a complete reading for the current phase.
    pub(super) fn look_complete(&mut self, now: ArmInstant, last: Option<u64>) {
        match self.phase {
            // The reading began in an earlier phase and lacks the pose.
            Phase::AwaitRest(_) | Phase::AwaitStop(_) | Phase::Drain { .. } if !self.reader.has_pose => {
                self.reader.look_closely(now, true);
            }
            Phase::AwaitRest(Some(before))
            | Phase::AwaitStop(Some(before))
            | Phase::Resolve(Some(before))
                // Two equal readings prove that the arm stands only if they are far enough apart.
                if now.micros_since(before.at) < REST_TIME =>
            {
                self.look_again(before.at);
            }
            Phase::Begin => self.begun(last),
            Phase::AwaitRest(before) => {
                self.phase = match (self.stands(now, before), before) {
                    (true, _) => Phase::Start,
                    (false, None) => Phase::AwaitRest(Some(self.reader.snapshot(now))),
                    // The arm moves: an unanswered start got through, or commands of others run.
                    (false, Some(_)) => self.started(now),
                }
            }
            Phase::AwaitStop(before) => {
                self.phase = if self.stands(now, before) {
                    Phase::Clear
                } else {
                    Phase::AwaitStop(Some(self.reader.snapshot(now)))
                }
            }
            Phase::Drain { since, left } => self.drained(now, since, left),
            Phase::Resolve(before) => self.resolve(now, before),
            // While commands flow, readings only report progress.
            _ => self.report_progress(),
        }
    }

    /// Decides how many commands are put in before the queue is started, and whether the queue is
    /// stopped for them.
    fn choose(&mut self, now: ArmInstant) {
        let Some(next) = self.next() else {
            self.phase = if self.stopped {
                Phase::Start
            } else {
                Phase::Run
            };
            return;
        };
        // A caller that announced a pause offers nothing soon.
        let gathered = self.expects != NextOffer::AtOnce
            || (self.gathering_since).is_some_and(|at| at.after_micros(GATHER_TIME) <= now);
        let lights = self
            .entries
            .get(next)
            .is_some_and(|entry| self.is_held(entry));
        let group = if lights {
            self.chunk(next, gathered).map(Some)
        } else {
            self.batch(gathered)
        };
        let Some(group) = group else {
            self.gathering_since = (!gathered).then(|| self.gathering_since.unwrap_or(now));
            return;
        };
        (self.group, self.gathering_since) = (group, None);
        let several = group.map_or_else(|| self.entries.waiting() > 1, |count| count > 1);
        let empty = self.is_empty();
        self.phase = if self.stopped {
            Phase::Load
        } else if lights || several && empty {
            Phase::Stop
        } else if empty && !self.settings.running {
            // Only while nothing can move: a start during a motion may end the motion.
            Phase::Start
        } else {
            Phase::Load
        };
        if self.phase == Phase::Start {
            self.group = None;
        }
    }

    /// True if the queue is empty.
    fn is_empty(&self) -> bool {
        self.reader.left >= self.credit.places
            && self.entries.unfinished(self.reader.current).count == 0
    }

    /// Number of commands to put in before the queue is started. `Some(None)`: as many as possible.
    /// `None`: undecided until more are offered.
    fn batch(&self, gathered: bool) -> Option<Option<usize>> {
        let waiting = || self.waiting().map(|entry| &entry.item);
        let count = waiting().count();
        let time = waiting().fold(0, |sum: Micros, item| sum.saturating_add(item.time));
        let burns = self.waiting().any(Entry::burns);
        // A command that lights the laser permanently goes only into a stopped queue, and only an
        // empty queue is stopped.
        let held = self.waiting().any(|entry| self.is_held(entry)) && !self.is_empty();
        let places = self.credit().min(self.places());
        if held || count > places || time > self.horizon(burns) {
            return Some(None);
        }
        if self.ended {
            return Some(Some(count));
        }
        gathered.then_some(None)
    }

    fn control(&mut self, request: Result<Request, EncodeError>, to: &mut Connection) {
        if let (None, None, Ok(request)) = (self.control, self.retry_at, request) {
            self.control = Some(self.submit(request, Priority::Stream, to));
        }
    }

    fn load(&mut self, now: ArmInstant, to: &mut Connection) {
        self.send(now, to);
        // At window 1 no reading is needed: the command is answered, or the connection finds out
        // its fate.
        if self.flying() > 0 && self.window == 1 {
            return;
        }
        if self.flying() > 0 || self.retry_at.is_some() || self.credit.full {
            self.pace(now);
            return;
        }
        // Everything permitted was sent. If no group is incomplete, the queue can start.
        if self.group.is_none_or(|left| left == 0) {
            self.group = None;
            self.phase = match (self.stopped, self.settings.running) {
                // The queue was empty when it was stopped.
                (true, _) => Phase::Start,
                (false, true) => Phase::Run,
                (false, false) => {
                    self.reader.look_closely(now, true);
                    Phase::AwaitRest(None)
                }
            };
        } else {
            self.pace(now)
        }
    }

    fn run(&mut self, now: ArmInstant, to: &mut Connection) {
        self.send(now, to);
        let idle = self.entries.under_way(self.reader.current).count == 0;
        let next = self.next().and_then(|next| self.entries.get(next));
        if idle && next.is_some_and(|next| self.settings.start && self.is_held(next)) {
            self.phase = Phase::Choose;
        } else if self.ended && self.entries.is_empty() {
            self.finished_reported = true;
            self.events.push(StreamEvent::Finished { last: self.last });
        } else {
            self.pace(now);
        }
    }

    /// True if commands are sent while the arm runs.
    pub(super) fn flows(&self) -> bool {
        self.phase == Phase::Run
    }

    /// True if the queue must hold exactly what was counted.
    pub(super) fn takes_stock(&self) -> bool {
        use Phase::{AwaitRest, Load, Run, Start};
        matches!(self.phase, Load | AwaitRest(_) | Start | Run)
    }

    /// Notes that the queue runs.
    pub(super) fn started(&mut self, now: ArmInstant) -> Phase {
        (self.stopped, self.starts) = (false, 0);
        self.reader.begins(now);
        Phase::Run
    }

    /// True if nothing moves: two equal readings at least [`REST_TIME`] apart. Otherwise plans
    /// another reading.
    pub(super) fn stands(&mut self, now: ArmInstant, before: Option<QueueSnapshot>) -> bool {
        let read = self.reader.snapshot(now);
        let stands = before.is_some_and(|before| before.is_like(&read));
        if !stands {
            self.look_again(now);
        }
        stands
    }

    /// Plans the next reading of an arm that may move.
    pub(super) fn look_again(&mut self, after: ArmInstant) {
        self.reader
            .look_closely(after.after_micros(MOVING_PAUSE), true);
    }

    /// Submits everything that may be sent.
    fn send(&mut self, now: ArmInstant, to: &mut Connection) {
        while !self.gap && self.retry_at.is_none() && self.group != Some(0) {
            let Some(next) = self.next() else { return };
            self.cut(next);
            let Some(&entry) = self.entries.get(next) else {
                return;
            };
            let apart = self.group.is_none() && self.settings.start;
            if apart && (self.is_held(&entry) || !self.within_horizon(&entry)) {
                return;
            }
            if self.credit() == 0 || !self.may_fly(now, &entry) {
                return;
            }
            let Ok(frame) = FrameBuf::set(&entry.item.command, Ctrl::QUEUED) else {
                return;
            };
            let request = if self.window > 1 && entry.vertex().is_some() {
                Request::of(frame).repeatable()
            } else {
                Request::of(frame)
            };
            let ticket = self.submit(request, Priority::Stream, to);
            self.entries.set_fate(next, Fate::InFlight(ticket));
            if let Some(group) = &mut self.group {
                *group = group.saturating_sub(1);
            }
        }
    }

    /// True if a command may be in flight beside the others: segments of one line up to the window,
    /// all others alone and only if everything before is confirmed.
    fn may_fly(&mut self, now: ArmInstant, entry: &Entry) -> bool {
        let flying = self.flying();
        let shares = self.window > 1 && self.may_go_back() && self.keeps_line(entry);
        if flying > 0 {
            return shares && flying < self.window;
        }
        let certain = self.entries.unconfirmed(self.confirmed) == 0;
        // A command that must travel alone waits for confirmation of those before it. If none of
        // their replies is a settle point, a reading provides one.
        if !certain && !shares && !self.reader.is_planned() {
            self.reader.look(now);
        }
        certain || shares
    }

    /// Commands that were sent and are not confirmed.
    pub(super) fn unconfirmed(&self) -> impl Iterator<Item = &Entry> {
        let confirmed = self.confirmed;
        (self.entries.iter()).filter(move |entry| match entry.fate {
            Fate::Waiting => false,
            Fate::Accepted(index) => confirmed.is_none_or(|confirmed| index > confirmed),
            Fate::InFlight(_) | Fate::Doubtful => true,
        })
    }

    /// True if the queue may be cleared and all unconfirmed commands repeated. False if commands of
    /// others wait in it, or if the caller starts it.
    pub(super) fn may_go_back(&self) -> bool {
        let ours = self.settings.start && self.foreign_left(self.reader.current) == 0;
        ours && self.unconfirmed().all(|entry| entry.repeatable)
    }

    /// Releases commands that are finished and confirmed.
    pub(super) fn release_finished(&mut self, connection: &Connection) {
        let accepted = connection.confirmed_index().map(|index| index.0);
        if self.expected.is_some() {
            // The connection may have begun a new count and know nothing of earlier indices, so the
            // higher of both values holds.
            self.confirmed = self.confirmed.max(accepted.min(self.last));
        }
        self.mark();
        let (current, confirmed) = (self.reader.current, self.confirmed);
        let over = |index: u64| index <= current && confirmed.is_some_and(|all| index <= all);
        while self
            .entries
            .front()
            .is_some_and(|entry| entry.index().is_some_and(over))
        {
            self.release_first();
        }
    }

    /// Releases the first command, which is finished and confirmed.
    pub(super) fn release_first(&mut self) {
        if let Some(entry) = self.entries.pop() {
            (self.last_pose, self.last_position) = (entry.item.end, entry.place());
        }
    }

    /// Updates the counts of unfinished and unconfirmed commands to the present indices.
    pub(super) fn mark(&mut self) {
        self.entries.mark(self.reader.current, self.confirmed);
    }
}
