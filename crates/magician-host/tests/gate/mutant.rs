//! The gate with a bug planted in it.

use magician_host::connection::Micros;
use magician_host::gate::{
    Gate, GateEffect, JogEnd, JogId, JogKind, JogRequest, Motors, OUTPUTS, frame_jogs,
};
use magician_protocol::{Frame, Stepper};

use crate::model::KEEP;

/// Planted bug.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Bug {
    /// A raw jog goes out as it came.
    RawJog,
    /// A jog of another axis replaces the one under way.
    JogOverJog,
    /// A stop leaves the motors alone.
    BeltForgotten,
    /// The end of a connection leaves the motors that it started alone.
    BeltOutlivesHolder,
    /// A guard that is dropped does not end its jog.
    HolderDies,
    /// A jog that was let go of while the arm came to rest begins.
    ReleasedBegins,
    /// A jog that waits begins although a stop came.
    WaitingOutlivesStop,
    /// A jog whose deadline has passed goes on.
    NoDeadline,
    /// A fence and the end of an axis do not bound a jog.
    NoBound,
    /// A later bound extends a jog.
    BoundExtends,
    /// A jog that is kept up too late goes on.
    LateKeepRevives,
    /// The guard of a jog that is over keeps up the one under way.
    KeepOfAnother,
    /// A bound of a jog that is over ends the one under way.
    BoundOfAnother,
    /// Whatever ends a jog in time, it was not kept up.
    ReasonLost,
    /// The end of pieces is owed over the next line, as that of the arm's own jog is.
    PiecesOwed,
    /// An arm that was not seen at rest counts as one that was.
    RestUnseen,
    /// A reversal that did not go out leaves the jog before without a holder.
    ReversalLost,
    /// The guard of a jog is not told that it is over.
    OverUntold,
}

const HELD: &str = "what moves without an end has a holder";
const REASON: &str = "a jog ends for the reason of its deadline";
const REST: &str = "a jog begins at rest, or reverses on its axis";

/// Each bug, and the law that it breaks first.
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

/// The methods of [`Gate`], with at most one bug.
#[derive(Clone, Hash)]
pub(crate) struct Mutant {
    pub(crate) gate: Gate,
    pub(crate) motors: Motors,
    bug: Option<Bug>,
    waiting: Option<JogRequest>,
    /// The latest bound of the jog under way.
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

    /// The same state with its instants counted from `now`.
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

    /// The jog under way instead of the one that is meant.
    fn mistaken(&self, jog: JogId, bug: Bug) -> JogId {
        let running = self.gate.running().filter(|_| self.has(bug));
        running.unwrap_or(jog)
    }

    /// True if it goes on.
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
        self.gate.ask(request);
        let waits = before.running().is_some() && self.gate.is_ending();
        if self.has(Bug::JogOverJog) && waits {
            self.gate = before;
            self.gate.close();
            self.gate.ask(request);
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
            self.gate.ask(waiting);
        }
        if self.has(Bug::BeltForgotten) {
            Vec::new()
        } else {
            OUTPUTS.to_vec()
        }
    }

    pub(crate) fn rested(&mut self, seen: bool) {
        self.gate.rested(seen || self.has(Bug::RestUnseen));
    }

    pub(crate) fn held_motors(&self, moving: bool) -> Vec<Stepper> {
        if self.has(Bug::BeltOutlivesHolder) {
            Vec::new()
        } else {
            self.motors.held(moving).collect()
        }
    }

    /// All effects of an event.
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
