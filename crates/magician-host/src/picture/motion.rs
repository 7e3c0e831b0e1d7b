//! Motion that this connection has set going and not seen finished: what a stop has to end when its holder goes.

use magician_protocol::commands::{
    JogCmd, QueuedCmdClear, QueuedCmdForceStopExec, QueuedCmdStartExec, QueuedCmdStopExec,
};
use magician_protocol::{Frame, JogCommand, Row, Set, Writable};

use crate::connection::Failure;

/// True for a command that moves the arm when it is done at once, or that lets a stopped queue do so.
#[must_use]
pub fn sets_in_motion(command: &Set) -> bool {
    match command {
        Set::JogCmd(jog) => jog.cmd != JogCommand::Stop,
        Set::QueuedCmdStartExec(_) => true,
        command => command.row().effect.moves_arm(),
    }
}

/// Motion of one connection. It errs towards more: a stop of an arm that stands does no harm.
#[derive(Clone, Debug, Default)]
pub struct MotionInFlight {
    /// True if this connection started the queue, false if it stopped it; `None` if it found the queue as it is.
    started: Option<bool>,
    /// Index of its last queued command.
    last: Option<u64>,
    /// Last index that was read.
    current: u64,
    /// A motion outside of the queue, or one without an end.
    free: bool,
    /// Queued commands that were handed to the connection and have not ended.
    unanswered: u32,
    /// A program runs.
    program: bool,
    /// Forced stops that were asked for or sent.
    stops: u64,
    /// How many of them there were when the arm was last seen to stand.
    stood: u64,
}

/// What becomes known.
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

    /// Until the arm is seen to stand it brakes, and the command that it was at still takes its place in the queue.
    pub(super) fn stop_asked(&mut self) {
        self.stops += 1;
    }

    pub(super) fn stood_after(&mut self, stops: u64) {
        self.stood = self.stood.max(stops);
        self.free = false;
    }

    pub(super) fn sent(&mut self, request: &Frame<'_>) {
        let (id, ctrl) = (request.id(), request.ctrl());
        if !ctrl.write() && !ctrl.queued() {
            return;
        }
        if id == QueuedCmdStartExec::ROW.id {
            // The queue may run from here on, whether that is answered or not.
            self.started = self.started.filter(|started| *started);
        }
        if id == QueuedCmdForceStopExec::ROW.id {
            self.stop_asked();
        }
        if id == JogCmd::ROW.id {
            self.free |= request.params().get(1).is_some_and(|cmd| *cmd != 0);
        } else if !ctrl.queued() && Row::with_id(id).is_some_and(|row| row.effect.moves_arm()) {
            self.free = true;
        }
    }

    pub(super) fn answered(&mut self, request: &Frame<'_>) {
        match request.id() {
            id if id == QueuedCmdStartExec::ROW.id => self.started = Some(true),
            id if id == QueuedCmdStopExec::ROW.id => self.started = Some(false),
            id if id == QueuedCmdForceStopExec::ROW.id => {
                self.started = Some(false);
                self.free = false;
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

    /// `is_queued`: the request was for the queue, which may have taken it.
    pub(super) fn failed(&mut self, is_queued: bool, failure: &Failure) {
        if is_queued && matches!(failure, Failure::Uncertain { .. }) {
            self.last = Some(u64::MAX);
        }
    }

    /// The arm was reset, and its queue is gone. Returns the indices, first and last, that had not finished.
    pub(super) fn reset(&mut self) -> Option<(u64, u64)> {
        let last = self.last.take().filter(|last| *last > self.current);
        let gone = last.map(|last| (self.current.saturating_add(1), last));
        (self.current, self.started) = (0, None);
        self.stood = self.stops;
        gone
    }

    /// The queue was held and emptied on a line that was found again.
    pub(super) fn cleared(&mut self) {
        self.started = Some(false);
        self.drop_waiting();
    }

    /// The command under way goes on, and with its end the current index.
    fn drop_waiting(&mut self) {
        let under_way = self.last.filter(|last| *last > self.current);
        self.last = under_way.map(|_| self.current.saturating_add(1));
    }
}

/// What is known.
impl MotionInFlight {
    /// True if this connection started the queue, false if it stopped it; `None` if it found the queue as it is.
    #[must_use]
    pub const fn started(&self) -> Option<bool> {
        self.started
    }

    /// True if this connection stopped the queue, and no program of it is about to start it.
    #[must_use]
    pub fn stopped(&self) -> bool {
        self.started == Some(false) && !self.program
    }

    /// True if motion of this connection may be under way.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.free || self.runs_queue()
    }

    /// True if queued commands of this connection may be under way.
    #[must_use]
    pub fn runs_queue(&self) -> bool {
        let unfinished = self.last.is_some_and(|last| last > self.current);
        let queued = self.unanswered > 0 || unfinished;
        // A program fills a stopped queue before it starts it: left there, others would run it.
        self.program || queued && self.started != Some(false)
    }

    /// Number of forced stops that were asked for or sent.
    #[must_use]
    pub const fn stops(&self) -> u64 {
        self.stops
    }

    /// True if the arm was not seen to stand since the last forced stop.
    #[must_use]
    pub const fn is_braking(&self) -> bool {
        self.stops > self.stood
    }

    /// True if the arm was seen to stand after this many forced stops.
    #[must_use]
    pub const fn has_stood_after(&self, stops: u64) -> bool {
        self.stood >= stops
    }
}
