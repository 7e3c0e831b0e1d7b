//! Motion that this connection has started and not seen finished: what must be stopped when its
//! owner goes away.

use magician_protocol::commands::{
    JogCmd, QueuedCmdClear, QueuedCmdForceStopExec, QueuedCmdStartExec, QueuedCmdStopExec,
};
use magician_protocol::{Frame, JogCommand, Row, Set, Writable};

use crate::connection::Failure;

/// True for a command that moves the arm when executed immediately, or that starts the queue.
#[must_use]
pub fn sets_in_motion(command: &Set) -> bool {
    match command {
        Set::JogCmd(jog) => jog.cmd != JogCommand::Stop,
        Set::QueuedCmdStartExec(_) => true,
        command => command.row().effect.moves_arm(),
    }
}

/// Motion of one connection. If in doubt it reports motion, because stopping an arm at rest does no
/// harm.
#[derive(Clone, Debug, Default)]
pub struct MotionInFlight {
    /// True if this connection started the queue, false if it stopped it. `None` if it left the
    /// queue as found.
    started: Option<bool>,
    /// Index of its last queued command.
    last: Option<u64>,
    /// Last current index read.
    current: u64,
    /// True for a motion outside the queue, or one without an end.
    outside_queue: bool,
    /// Number of queued commands handed to the connection that have not ended.
    unanswered: u32,
    /// True while a program runs.
    program: bool,
    /// Number of forced stops requested or sent.
    stops: u64,
    /// Value of `stops` when the arm was last seen at rest.
    stops_at_rest: u64,
}

/// Inputs.
impl MotionInFlight {
    pub(super) fn handed_over(&mut self, request: &Frame<'_>) {
        self.unanswered += u32::from(request.ctrl().queued());
    }

    pub(super) fn returned(&mut self, request: &Frame<'_>) {
        let queued = u32::from(request.ctrl().queued());
        self.unanswered = self.unanswered.saturating_sub(queued);
    }

    pub(super) fn program_runs(&mut self, program: bool) {
        self.program = program;
    }

    /// Notes a forced stop. Until the arm is seen at rest it brakes, and its current command still
    /// occupies its place in the queue.
    pub(super) fn stop_asked(&mut self) {
        self.stops += 1;
    }

    pub(super) fn stood_after(&mut self, stops: u64) {
        self.stops_at_rest = self.stops_at_rest.max(stops);
        self.outside_queue = false;
    }

    pub(super) fn sent(&mut self, request: &Frame<'_>) {
        let (id, ctrl) = (request.id(), request.ctrl());
        if !ctrl.write() && !ctrl.queued() {
            return;
        }
        if id == QueuedCmdStartExec::ROW.id {
            // The queue may run from now on, with or without a reply.
            self.started = self.started.filter(|started| *started);
        }
        if id == QueuedCmdForceStopExec::ROW.id {
            self.stop_asked();
        }
        if id == JogCmd::ROW.id {
            self.outside_queue |= request.params().get(1).is_some_and(|cmd| *cmd != 0);
        } else if !ctrl.queued() && Row::with_id(id).is_some_and(|row| row.effect.moves_arm()) {
            self.outside_queue = true;
        }
    }

    pub(super) fn answered(&mut self, request: &Frame<'_>) {
        match request.id() {
            id if id == QueuedCmdStartExec::ROW.id => self.started = Some(true),
            id if id == QueuedCmdStopExec::ROW.id => self.started = Some(false),
            id if id == QueuedCmdForceStopExec::ROW.id => {
                self.started = Some(false);
                self.outside_queue = false;
            }
            id if id == QueuedCmdClear::ROW.id => self.drop_waiting(),
            _ => {}
        }
    }

    pub(super) fn read_current(&mut self, current: u64) {
        self.current = current;
    }

    pub(super) fn accepted(&mut self, index: u64) {
        self.last = Some(index);
    }

    /// Notes a failure. `is_queued` is true if the request was for the queue, which may have taken
    /// it.
    pub(super) fn failed(&mut self, is_queued: bool, failure: &Failure) {
        if is_queued && matches!(failure, Failure::Uncertain { .. }) {
            // No index is known, so no reading can show its end: only a Clear or a reset ends it.
            self.last = Some(u64::MAX);
        }
    }

    /// Notes a reset: the queue is gone. Returns the first and last unfinished index. `None` if
    /// there was none.
    pub(super) fn reset(&mut self) -> Option<(u64, u64)> {
        let last = self.last.take().filter(|last| *last > self.current);
        let gone = last.map(|last| (self.current.saturating_add(1), last));
        (self.current, self.started) = (0, None);
        self.stops_at_rest = self.stops;
        gone
    }

    /// Notes that the queue was stopped and cleared on a restored line.
    pub(super) fn cleared(&mut self) {
        self.started = Some(false);
        self.drop_waiting();
    }

    /// Drops waiting commands. The current one continues, and its end still advances the current
    /// index.
    fn drop_waiting(&mut self) {
        let under_way = self.last.filter(|last| *last > self.current);
        self.last = under_way.map(|_| self.current.saturating_add(1));
    }
}

/// Queries.
impl MotionInFlight {
    /// True if this connection started the queue, false if it stopped it. `None` if it left the
    /// queue as found.
    #[must_use]
    pub const fn started(&self) -> Option<bool> {
        self.started
    }

    /// True if this connection stopped the queue and none of its programs is about to start it.
    #[must_use]
    pub fn stopped(&self) -> bool {
        self.started == Some(false) && !self.program
    }

    /// True if motion of this connection may be under way.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.outside_queue || self.runs_queue()
    }

    /// True if queued commands of this connection may be under way.
    #[must_use]
    pub fn runs_queue(&self) -> bool {
        let unfinished = self.last.is_some_and(|last| last > self.current);
        let queued = self.unanswered > 0 || unfinished;
        // A program fills a stopped queue and then starts it. If it went away in between, another
        // host would run its commands.
        self.program || queued && self.started != Some(false)
    }

    /// Number of forced stops requested or sent.
    #[must_use]
    pub const fn stops(&self) -> u64 {
        self.stops
    }

    /// True if the arm was not seen at rest since the last forced stop.
    #[must_use]
    pub const fn is_braking(&self) -> bool {
        self.stops > self.stops_at_rest
    }

    /// True if the arm was seen at rest after this many forced stops.
    #[must_use]
    pub const fn has_stood_after(&self, stops: u64) -> bool {
        self.stops_at_rest >= stops
    }
}
