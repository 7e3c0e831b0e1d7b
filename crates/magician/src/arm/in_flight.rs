use magician_protocol::commands::{
    JogCmd, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdForceStopExec, QueuedCmdStartExec,
    QueuedCmdStopExec,
};
use magician_protocol::{
    Frame, FrameBuf, JogCommand, Layout, QueuedCmdIndex, Readable, Row, Set, Writable,
};

/// Whether the command of an id moves the arm.
pub(super) fn moves(id: u8) -> bool {
    Row::with_id(id).is_some_and(|row| row.effect.moves_arm())
}

/// Whether a command that is done at once moves the arm, or lets a queue do so that stands.
#[must_use]
pub fn sets_in_motion(command: &Set) -> bool {
    match command {
        Set::JogCmd(jog) => jog.cmd != JogCommand::Stop,
        Set::QueuedCmdStartExec(_) => true,
        command => command.row().effect.moves_arm(),
    }
}

/// What a handle has set going and not seen finished: what has to be stopped when it goes.
///
/// It errs towards more: a stop of an arm that stands still does no harm.
#[derive(Clone, Debug, Default)]
pub(super) struct InFlightMotion {
    /// Whether this handle started (or stopped) the queue; `None`: it found it as it is.
    started: Option<bool>,
    /// The index of its last queued command.
    last: Option<u64>,
    /// The last index known to be finished.
    current: u64,
    /// A motion outside the queue, or one without an end.
    free: bool,
    /// Queued commands that are handed to the connection and have not ended.
    unanswered: u32,
    /// A program runs.
    program: bool,
    /// Forced stops that were asked for or sent, and how many of them there were when the arm was
    /// last seen to stand.
    stops: u64,
    stood: u64,
}

impl InFlightMotion {
    /// A request is handed to the connection.
    pub(super) fn begins(&mut self, request: &Frame<'_>) {
        self.unanswered += u32::from(request.ctrl().queued());
    }

    /// A request has ended.
    pub(super) fn ends(&mut self, request: &Frame<'_>) {
        let queued = u32::from(request.ctrl().queued());
        self.unanswered = self.unanswered.saturating_sub(queued);
    }

    /// A forced stop is asked for: until the arm is seen to stand it brakes, and the command that it
    /// was at still takes its place in the queue.
    pub(super) fn brakes(&mut self) {
        self.stops += 1;
    }

    /// Forced stops so far.
    pub(super) fn stops(&self) -> u64 {
        self.stops
    }

    /// True if the arm was not seen to stand since the last forced stop.
    pub(super) fn is_braking(&self) -> bool {
        self.stops > self.stood
    }

    /// True if the arm was seen to stand after this many forced stops.
    pub(super) fn has_stood_after(&self, stops: u64) -> bool {
        self.stood >= stops
    }

    /// The arm was seen to stand, by looks that all followed this many forced stops.
    pub(super) fn stood_after(&mut self, stops: u64) {
        self.stood = self.stood.max(stops);
        self.stands_still();
    }

    /// A program begins or ends.
    pub(super) fn runs(&mut self, program: bool) {
        self.program = program;
    }

    /// A request goes out.
    pub(super) fn sends(&mut self, request: &Frame<'_>) {
        let (id, ctrl, params) = (request.id(), request.ctrl(), request.params());
        if !ctrl.write() && !ctrl.queued() {
            return;
        }
        if id == QueuedCmdStartExec::ROW.id {
            // It may run from here on, whether that is answered or not.
            self.started = self.started.filter(|started| *started);
        }
        if id == QueuedCmdForceStopExec::ROW.id {
            self.brakes();
        }
        if id == JogCmd::ROW.id {
            self.free |= params.get(1).is_some_and(|cmd| *cmd != 0);
        } else if moves(id) && !ctrl.queued() {
            self.free = true;
        }
    }

    /// A request was answered.
    pub(super) fn answered(&mut self, request: &Frame<'_>, reply: &FrameBuf) {
        let reply = reply.frame();
        match request.id() {
            id if id == QueuedCmdStartExec::ROW.id => self.started = Some(true),
            id if id == QueuedCmdStopExec::ROW.id => self.started = Some(false),
            id if id == QueuedCmdForceStopExec::ROW.id => {
                self.started = Some(false);
                self.free = false;
            }
            // The command under way goes on, and with its end the current index.
            id if id == QueuedCmdClear::ROW.id => {
                let under_way = self.last.filter(|last| *last > self.current);
                self.last = under_way.map(|_| self.current.saturating_add(1));
            }
            id if id == <QueuedCmdCurrentIndex as Readable>::ROW.id => {
                if let Ok(read) = QueuedCmdCurrentIndex::decode(reply.params()) {
                    self.current = read.queued_cmd_current_index;
                }
            }
            _ if request.ctrl().queued() => {
                let index = QueuedCmdIndex::decode(reply.params());
                self.last = index.ok().map(|index| index.0).or(self.last);
            }
            _ => {}
        }
    }

    /// A queued command may have been taken.
    pub(super) fn maybe_queued(&mut self) {
        self.last = Some(u64::MAX);
    }

    /// The arm was reset: its queue is gone. The indices that had not finished, if there are any.
    pub(super) fn reset(&mut self) -> Option<(u64, u64)> {
        let last = self.last.take().filter(|last| *last > self.current);
        let gone = last.map(|last| (self.current.saturating_add(1), last));
        (self.current, self.started) = (0, None);
        self.stood = self.stops;
        gone
    }

    /// Two equal poses: nothing outside the queue moves.
    pub(super) fn stands_still(&mut self) {
        self.free = false;
    }

    /// Whether this handle started the queue, as far as it knows.
    pub(super) fn started(&self) -> Option<bool> {
        self.started
    }

    /// Whether this handle stopped the queue, and nothing of it is about to start it.
    pub(super) fn stopped(&self) -> bool {
        self.started == Some(false) && !self.program
    }

    /// Whether motion of this handle may be under way.
    pub(super) fn moving(&self) -> bool {
        self.free || self.runs_queue()
    }

    /// Whether commands of this handle in the queue may be under way.
    pub(super) fn runs_queue(&self) -> bool {
        let unfinished = self.last.is_some_and(|last| last > self.current);
        let queued = self.unanswered > 0 || unfinished;
        // A program fills a stopped queue before it starts it: left there, others would run it.
        self.program || queued && self.started != Some(false)
    }

    /// The queue was held and emptied on a line that was found again; the command under way goes on.
    pub(super) fn cleared(&mut self) {
        self.started = Some(false);
        let under_way = self.last.filter(|last| *last > self.current);
        self.last = under_way.map(|_| self.current.saturating_add(1));
    }
}
