use magician_protocol::commands::{QueuedCmdClear, QueuedCmdStartExec, QueuedCmdStopExec};
use magician_protocol::{ArmInstant, Ctrl, EncodeError, FrameBuf};

use super::item::{Entry, Fate, NextOffer};
use super::resume::{MOVING_PAUSE, QueueSnapshot};
use super::{Stream, StreamEvent};
use crate::REST_TIME;
use crate::connection::{Connection, Micros, Priority, Request};

/// How long the first commands wait for more, us, before it is decided that this is no batch.
pub(super) const GATHER: Micros = 20_000;

/// How an arm is when a stream begins: nothing of others waits in its queue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beginning {
    /// Free places in the queue.
    pub left: u32,
    /// The index of the command that was finished last.
    pub current: u64,
    /// Where the arm stands, x, y, z in mm and r in degrees.
    pub pose: [f64; 4],
}

/// What a stream is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phase {
    /// Waits for the first command and looks at the arm.
    Begin,
    /// Decides what goes in while the queue is stopped.
    Choose,
    /// The queue is being stopped, because a group goes in.
    Stop,
    /// A group goes in.
    Load,
    /// The group is in, and it shows whether something is under way; the last look. A start may end a motion (model
    /// section 14).
    Stand(Option<QueueSnapshot>),
    /// The queue is being started.
    Start,
    /// Commands flow.
    Run,
    /// Something was lost: the other answers are waited for.
    Settle,
    /// The queue is being stopped, because something was lost.
    Halt,
    /// The stopped queue finishes what is under way; the last look. A Clear may end a motion (model section 14).
    Brake(Option<QueueSnapshot>),
    Clear,
    /// The cleared queue finishes what is under way; its left space, and since when it stands.
    Drain {
        since: ArmInstant,
        left: u32,
    },
    /// Finds out what became of what was sent before an interruption.
    Resolve(Option<QueueSnapshot>),
    Over,
}

impl Stream {
    /// Submits what is due.
    pub fn advance(&mut self, now: Micros, connection: &mut Connection) {
        self.now = now;
        let now = self.clock.at(now);
        if self.credit.places == 0 {
            self.credit.places = connection.capacity();
        }
        // Where the connection sends one at a time, nothing may be lost between others, and nothing is gone back to.
        let window = self.settings.window.min(connection.window());
        (self.settings.window, self.window) = (window, self.window.min(window));
        self.retry_at = self.retry_at.filter(|at| *at > now);
        self.retire(connection);
        debug_assert!(self.entries.is_counted(), "{:?}", self.entries);
        if self.gap && self.phase != Phase::Settle {
            self.begin_recovery();
        }
        while !self.is_over() && self.step(now, connection) {}
        if !self.is_over() {
            self.read(now, connection);
        }
    }

    /// Does what the phase asks for; true when it has become another one.
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
            Phase::Stand(_)
            | Phase::Brake(_)
            | Phase::Drain { .. }
            | Phase::Resolve(_)
            | Phase::Over => {}
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

    /// The first look is complete.
    fn begun(&mut self, last: Option<u64>) {
        let places = self.credit.places.max(self.reader.left);
        self.credit.places = places;
        self.credit.strangers = places - self.reader.left;
        let tail = self
            .reader
            .current
            .saturating_add(self.credit.strangers.into());
        self.base = tail.max(last.unwrap_or(0));
        if self.settings.start && self.credit.strangers == 0 {
            let [x, y, z, _] = self.reader.pose;
            (self.stood, self.place) = (Some(self.reader.pose), Some([x, y, z]));
        }
        self.cleared_at = self.base;
        self.phase = if self.settings.start {
            Phase::Choose
        } else {
            Phase::Run
        };
    }

    /// A look is complete: what it means for the phase.
    pub(super) fn look_complete(&mut self, now: ArmInstant, last: Option<u64>) {
        match self.phase {
            // A look that began before says neither what is left nor where the arm stands.
            Phase::Stand(_) | Phase::Brake(_) | Phase::Drain { .. } if !self.reader.has_pose => {
                self.reader.look_closely(now, true);
            }
            Phase::Stand(Some(before))
            | Phase::Brake(Some(before))
            | Phase::Resolve(Some(before))
                if now.micros_since(before.at) < REST_TIME =>
            {
                self.look_again(before.at);
            }
            Phase::Begin => self.begun(last),
            Phase::Stand(before) => {
                self.phase = match (self.stands(now, before), before) {
                    (true, _) => Phase::Start,
                    (false, None) => Phase::Stand(Some(self.reader.snapshot(now))),
                    // A start that was not answered came through, or what others have put in runs without one.
                    (false, Some(_)) => self.started(now),
                }
            }
            Phase::Brake(before) => {
                self.phase = if self.stands(now, before) {
                    Phase::Clear
                } else {
                    Phase::Brake(Some(self.reader.snapshot(now)))
                }
            }
            Phase::Drain { since, left } => self.drained(now, since, left),
            Phase::Resolve(before) => self.resolve(now, before),
            _ => self.tell_progress(),
        }
    }

    /// Decides what goes in while the queue is stopped.
    fn choose(&mut self, now: ArmInstant) {
        let Some(next) = self.next() else {
            self.phase = if self.stopped {
                Phase::Start
            } else {
                Phase::Run
            };
            return;
        };
        // Nothing comes soon where the caller has said so.
        let gathered = self.expects != NextOffer::AtOnce
            || (self.gathers).is_some_and(|at| at.after_micros(GATHER) <= now);
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
            self.gathers = (!gathered).then(|| self.gathers.unwrap_or(now));
            return;
        };
        (self.group, self.gathers) = (group, None);
        let several = group.map_or_else(|| self.entries.waiting() > 1, |count| count > 1);
        let empty = self.is_empty();
        self.phase = if self.stopped {
            Phase::Load
        } else if lights || several && empty {
            Phase::Stop
        } else if empty && !self.settings.running {
            // While nothing can move: a start in the middle of a motion may end it.
            Phase::Start
        } else {
            Phase::Load
        };
        if self.phase == Phase::Start {
            self.group = None;
        }
    }

    /// Whether nothing is in the queue.
    fn is_empty(&self) -> bool {
        self.reader.left >= self.credit.places
            && self.entries.unfinished(self.reader.current).count == 0
    }

    /// How many commands go in before the queue is started: `Some(None)` as many as may, `None` when more have to be
    /// offered before it can be told.
    fn batch(&self, gathered: bool) -> Option<Option<usize>> {
        let waiting = || self.waiting().map(|entry| &entry.item);
        let count = waiting().count();
        let time = waiting().fold(0, |sum: Micros, item| sum.saturating_add(item.time));
        let burns = self.waiting().any(Entry::burns);
        // What lights the laser for good only goes into a queue that is stopped, and only an empty one is.
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
        // One alone is answered, or the connection finds out what became of it.
        if self.flying() > 0 && self.window == 1 {
            return;
        }
        if self.flying() > 0 || self.retry_at.is_some() || self.credit.full {
            self.pace(now);
            return;
        }
        // What may go has gone: where there is no group to complete, nothing can be added to what is in.
        if self.group.is_none_or(|left| left == 0) {
            self.group = None;
            self.phase = match (self.stopped, self.settings.running) {
                // It was empty when it was stopped.
                (true, _) => Phase::Start,
                (false, true) => Phase::Run,
                (false, false) => {
                    self.reader.look_closely(now, true);
                    Phase::Stand(None)
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
            self.told = true;
            self.events.push(StreamEvent::Finished { last: self.last });
        } else {
            self.pace(now);
        }
    }

    /// Whether commands go in while the arm runs.
    pub(super) fn flows(&self) -> bool {
        self.phase == Phase::Run
    }

    /// Whether the queue holds what was counted.
    pub(super) fn takes_stock(&self) -> bool {
        use Phase::{Load, Run, Stand, Start};
        matches!(self.phase, Load | Stand(_) | Start | Run)
    }

    /// The queue runs.
    pub(super) fn started(&mut self, now: ArmInstant) -> Phase {
        (self.stopped, self.starts) = (false, 0);
        self.reader.begins(now);
        Phase::Run
    }

    /// True if nothing moves: two looks at least [`REST_TIME`] apart are alike. If not, another look is planned.
    pub(super) fn stands(&mut self, now: ArmInstant, before: Option<QueueSnapshot>) -> bool {
        let read = self.reader.snapshot(now);
        let stands = before.is_some_and(|before| before.is_like(&read));
        if !stands {
            self.look_again(now);
        }
        stands
    }

    /// Plans the next look at an arm that may move.
    pub(super) fn look_again(&mut self, after: ArmInstant) {
        self.reader
            .look_closely(after.after_micros(MOVING_PAUSE), true);
    }

    /// Submits all that may go out.
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
            self.entries.set_fate(next, Fate::Flying(ticket));
            if let Some(group) = &mut self.group {
                *group = group.saturating_sub(1);
            }
        }
    }

    /// Whether a command may be in flight beside those that are: segments of one line up to the window, everything else
    /// alone, and only when all before it is beyond doubt.
    fn may_fly(&mut self, now: ArmInstant, entry: &Entry) -> bool {
        let flying = self.flying();
        let shares = self.window > 1 && self.may_go_back() && self.keeps_line(entry);
        if flying > 0 {
            return shares && flying < self.window;
        }
        let certain = self.entries.unconfirmed(self.confirmed) == 0;
        if !certain && !shares && !self.reader.is_planned() {
            self.reader.look(now);
        }
        certain || shares
    }

    /// What went out and is not beyond doubt.
    pub(super) fn unconfirmed(&self) -> impl Iterator<Item = &Entry> {
        let confirmed = self.confirmed;
        (self.entries.iter()).filter(move |entry| match entry.fate {
            Fate::Waiting => false,
            Fate::Accepted(index) => confirmed.is_none_or(|confirmed| index > confirmed),
            Fate::Flying(_) | Fate::Doubtful => true,
        })
    }

    /// Whether the queue may be cleared and all that is not beyond doubt be done once more: not where commands of others
    /// wait in it, nor where it is the caller's to start.
    pub(super) fn may_go_back(&self) -> bool {
        let ours = self.settings.start && self.strangers_left(self.reader.current) == 0;
        ours && self.unconfirmed().all(|entry| entry.repeatable)
    }

    /// Lets go of what is finished and beyond doubt.
    pub(super) fn retire(&mut self, connection: &Connection) {
        let accepted = connection.confirmed_index().map(|index| index.0);
        if self.expected.is_some() {
            // A new count of the connection's knows nothing of what was accepted before.
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
            self.let_go();
        }
    }

    /// The first command is done and beyond doubt.
    pub(super) fn let_go(&mut self) {
        if let Some(entry) = self.entries.pop() {
            (self.stood, self.place) = (entry.item.end, entry.place());
        }
    }

    /// Has what is unfinished and unconfirmed counted from here on by what is known now.
    pub(super) fn mark(&mut self) {
        self.entries.mark(self.reader.current, self.confirmed);
    }
}
