//! The gate with a planted bug.

use magician_host::connection::Micros;
use magician_host::gate::{
    Gate, GateEffect, JogEnd, JogId, JogKind, JogRequest, Motors, OUTPUTS, frame_jogs,
};
use magician_protocol::{Frame, Stepper};

use crate::model::KEEP;

/// Planted bug.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Bug {
    /// A raw jog is sent unchanged.
    RawJog,
    /// A jog of another axis replaces the current one.
    JogOverJog,
    /// A stop does not switch the motors off.
    BeltForgotten,
    /// The end of a connection does not switch off the motors that it started.
    BeltOutlivesHolder,
    /// Dropping a guard does not end its jog.
    HolderDies,
    /// A jog that was released while the arm came to rest begins.
    ReleasedBegins,
    /// A waiting jog begins although a stop was sent.
    WaitingOutlivesStop,
    /// A jog continues beyond its deadline.
    NoDeadline,
    /// Fence and end of an axis do not bound a jog.
    NoBound,
    /// A later bound extends a jog.
    BoundExtends,
    /// A jog that is kept up too late continues.
    LateKeepRevives,
    /// The guard of an ended jog keeps up the current one.
    KeepOfAnother,
    /// A bound of an ended jog ends the current one.
    BoundOfAnother,
    /// Every end of a jog is reported as not kept up.
    ReasonLost,
    /// The stop of pieces is sent over the next line, like that of the arm's own jog.
    PiecesOwed,
    /// An arm that was not seen at rest counts as at rest.
    RestUnseen,
    /// A reversal that was not sent leaves the previous jog without a holder.
    ReversalLost,
    /// The guard of a jog is not notified of its end.
    OverUntold,
}

const HELD: &str = "what moves without an end has a holder";
const REASON: &str = "a jog ends for the reason of its deadline";
const REST: &str = "a jog begins at rest, or reverses on its axis";

/// Each bug, with the law that it breaks first.
pub(crate) const BUGS: [(Bug, &str); 18] = [
    (Bug::RawJog, HELD),
    (Bug::JogOverJog, REST),
    (Bug::BeltForgotten, "after a stop nothing runs"),
    (Bug::BeltOutlivesHolder, "a motor ends with its holder"),
    (Bug::HolderDies, HELD),
    (Bug::ReleasedBegins, "what is let go of does not begin"),
    (Bug::WaitingOutlivesStop, "what a stop ended does not begin"),
    (Bug::NoDeadline, HELD),
    (Bug::NoBound, HELD),
    (Bug::BoundExtends, HELD),
    (Bug::LateKeepRevives, HELD),
    (Bug::KeepOfAnother, HELD),
    (Bug::BoundOfAnother, REASON),
    (Bug::ReasonLost, REASON),
    (
        Bug::PiecesOwed,
        "the end of pieces is not owed over the next line",
    ),
    (Bug::RestUnseen, REST),
    (Bug::ReversalLost, HELD),
    (Bug::OverUntold, "a guard is told the end of its jog"),
];

/// Methods of [`Gate`], with at most one bug.
#[derive(Clone, Hash)]
pub(crate) struct Mutant {
    pub(crate) gate: Gate,
    pub(crate) motors: Motors,
    bug: Option<Bug>,
    waiting: Option<JogRequest>,
    /// Latest bound of the current jog.
    latest: Option<Micros>,
}

impl Mutant {
    pub(crate) fn new(bug: Option<Bug>) -> Self {
        Self {
            gate: Gate::new(),
            motors: Motors::default(),
            bug,
            waiting: None,
            latest: None,
        }
    }

    /// The same state with instants relative to `now`.
    pub(crate) fn rebased(&self, now: Micros) -> Self {
        Self {
            gate: self.gate.rebased(now),
            latest: self.latest.map(|latest| latest.saturating_sub(now)),
            ..self.clone()
        }
    }

    fn has(&self, bug: Bug) -> bool {
        self.bug == Some(bug)
    }

    /// True if the driver refuses the frame.
    pub(crate) fn refuses(&self, frame: &Frame<'_>) -> bool {
        frame_jogs(frame) && !self.has(Bug::RawJog)
    }

    /// Current jog instead of the one meant.
    fn mistaken(&self, jog: JogId, bug: Bug) -> JogId {
        let running = self.gate.running().filter(|_| self.has(bug));
        running.unwrap_or(jog)
    }

    /// True if it continues.
    pub(crate) fn keep(&mut self, jog: JogId, now: Micros) -> bool {
        let jog = self.mistaken(jog, Bug::KeepOfAnother);
        if self.has(Bug::LateKeepRevives) {
            self.gate.hold(jog, now + KEEP);
        }
        self.gate.keep(jog, now).is_ok()
    }

    pub(crate) fn bound(&mut self, jog: JogId, at: Micros, why: JogEnd) {
        if self.has(Bug::NoBound) {
            return;
        }
        if self.has(Bug::BoundExtends) {
            self.latest = self.latest.max(Some(at));
        }
        let jog = self.mistaken(jog, Bug::BoundOfAnother);
        self.gate.bound(jog, at, why);
    }

    pub(crate) fn ask(&mut self, mut request: JogRequest) {
        if self.has(Bug::PiecesOwed) {
            request.kind = JogKind::Own;
        }
        let before = self.gate.clone();
        self.gate.request(request);
        let waits = before.running().is_some() && self.gate.is_ending();
        if self.has(Bug::JogOverJog) && waits {
            self.gate = before;
            self.gate.close();
            self.gate.request(request);
        }
        self.waiting = self.gate.is_ending().then_some(request);
    }

    pub(crate) fn not_begun(&mut self, jog: JogId) {
        if self.has(Bug::ReversalLost) {
            self.gate.close()
        } else {
            self.gate.not_begun(jog)
        }
    }

    pub(crate) fn release(&mut self, jog: JogId) {
        let waits = self.gate.is_ending();
        match self.bug {
            Some(Bug::HolderDies) if !waits => {}
            Some(Bug::ReleasedBegins) if waits => {}
            _ => self.gate.release(jog),
        }
    }

    pub(crate) fn handle_timeout(&mut self, now: Micros) {
        let due = self.gate.poll_timeout().filter(|(at, _)| *at <= now);
        match (self.bug, due, self.gate.running()) {
            (Some(Bug::NoDeadline), ..) => {}
            (Some(Bug::BoundExtends), Some((_, why)), _)
                if why != JogEnd::NotKept && self.latest > Some(now) => {}
            (Some(Bug::ReasonLost), Some(_), Some(jog)) => self.gate.end_one(jog, JogEnd::NotKept),
            _ => self.gate.handle_timeout(now),
        }
    }

    pub(crate) fn stop(&mut self) -> Vec<Stepper> {
        self.gate.stop();
        if let Some(waiting) = self.waiting.filter(|_| self.has(Bug::WaitingOutlivesStop)) {
            while self.gate.poll_effect().is_some() {}
            self.gate.request(waiting);
        }
        if self.has(Bug::BeltForgotten) {
            Vec::new()
        } else {
            OUTPUTS.to_vec()
        }
    }

    pub(crate) fn rested(&mut self, seen: bool) {
        self.gate.finish_stop(seen || self.has(Bug::RestUnseen));
    }

    pub(crate) fn held_motors(&self, moving: bool) -> Vec<Stepper> {
        if self.has(Bug::BeltOutlivesHolder) {
            Vec::new()
        } else {
            self.motors.held(moving).collect()
        }
    }

    /// Effects of an event.
    pub(crate) fn effects(&mut self) -> Vec<GateEffect> {
        let mut out = Vec::new();
        while let Some(effect) = self.gate.poll_effect() {
            match effect {
                GateEffect::Over(..) if self.has(Bug::OverUntold) => {}
                effect => out.push(effect),
            }
        }
        if !self.gate.is_ending() {
            self.waiting = None;
        }
        out
    }
}
