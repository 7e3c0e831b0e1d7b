//! Control of a class with a planted bug.

use std::collections::BTreeSet;
use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::control::{
    ArmId, Control, Effect, JobClaim, PersonId, RequestId, SessionId, WorkKind,
};

use super::{ARMS, Model, PAGES, TEACHER};

/// Planted bug.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bug {
    /// A pupil counts as a teacher.
    NotIdentified,
    /// Slots are checked at their start and not at their end.
    SlotForgotten,
    /// A place belongs to the socket and ends with it.
    PlaceOfSocket,
    /// A person has a place per arm.
    PlacePerArm,
    /// The last in the queue is served first.
    JumpsQueue,
    /// Motion continues when the arm is frozen.
    MovesFrozen,
    /// The holder may move a frozen arm.
    StartsFrozen,
    /// A turn does not end.
    EndlessTurn,
    /// A teacher who takes an arm ends the turn.
    TakeEndsTurn,
    /// Motion continues after the end of a turn or a slot.
    WorkContinues,
    /// The next person is notified but gets no lease.
    NextWithoutLease,
    /// A job starts at any idle arm, regardless of the turn.
    JobIgnoresTurn,
    /// A new job goes before waiting jobs.
    JobJumpsQueue,
    /// A job whose owner has left waits for ever.
    JobForgotten,
    /// A turn that was ended continues.
    EndForgotten,
    /// Passing a turn removes the person from the queue.
    NextLosesPlace,
    /// A turn is passed although no one is waiting.
    NextToNobody,
}

/// Each bug, and the invariant that it breaks first.
pub(crate) const BUGS: [(Bug, &str); 17] = [
    (Bug::NotIdentified, "who holds an arm has its turn"),
    (Bug::SlotForgotten, "nobody holds outside of a slot"),
    (Bug::PlaceOfSocket, "a reload keeps the place"),
    (Bug::PlacePerArm, "a person has at most one place"),
    (Bug::JumpsQueue, "the queue keeps its order"),
    (Bug::MovesFrozen, "frozen arms do not move"),
    (Bug::StartsFrozen, "frozen arms do not move"),
    (Bug::EndlessTurn, "what is due is in the future"),
    (Bug::TakeEndsTurn, "a turn and a place are kept"),
    (Bug::WorkContinues, "what moves belongs to the holder"),
    (
        Bug::NextWithoutLease,
        "the holder that is told is the holder",
    ),
    (
        Bug::JobIgnoresTurn,
        "a job begins beside nobody else's turn",
    ),
    (Bug::JobJumpsQueue, "jobs keep their order"),
    (Bug::JobForgotten, "an arm is not idle while a job waits"),
    (Bug::EndForgotten, "a turn that is ended is over"),
    (Bug::NextLosesPlace, "a turn and a place are kept"),
    (Bug::NextToNobody, "a turn and a place are kept"),
];

/// Returns the person for a forged number.
pub(crate) fn known(person: PersonId) -> PersonId {
    PersonId(person.0 % 100)
}

#[derive(Clone)]
pub(crate) struct Mutant {
    pub(crate) control: Control,
    bug: Option<Bug>,
}

impl Mutant {
    pub(crate) fn new(arms: usize, bug: Option<Bug>) -> Self {
        let control = Control::new(arms);
        Self { control, bug }
    }

    fn has(&self, bug: Bug) -> bool {
        self.bug == Some(bug)
    }

    pub(crate) fn identify(&mut self, now: HostInstant, session: SessionId, person: PersonId) {
        if !self.has(Bug::NotIdentified) {
            self.control.identify(now, session, Some(person));
        }
    }

    pub(crate) fn join(&mut self, now: HostInstant, person: PersonId, any: bool) {
        let arms = if any { &ARMS[..] } else { &ARMS[..1] };
        if self.has(Bug::PlacePerArm) {
            // The schedule of the second arm does not know forged numbers.
            for arm in arms {
                let forged = PersonId(person.0 + 100 * arm.0);
                let _ = { &mut self.control }.join_turn(now, forged, BTreeSet::from([ARMS[0]]));
            }
            return;
        }
        let before: Vec<_> = self.control.places().cloned().collect();
        let arms: BTreeSet<_> = arms.iter().copied().collect();
        let _ = self.control.join_turn(now, person, arms);
        if self.has(Bug::JumpsQueue) {
            for place in before.iter().filter(|place| place.person != person) {
                self.control.leave_turn(now, place.person);
                let _ = { &mut self.control }.join_turn(now, place.person, place.arms.clone());
            }
        }
    }

    pub(crate) fn take(&mut self, now: HostInstant, arm: ArmId, request: RequestId) {
        let turn = self.control.turn(now, arm).map(|(turn, _)| turn.person);
        if self.has(Bug::TakeEndsTurn)
            && let Some(person) = turn
        {
            self.control.leave_turn(now, person);
        }
        self.control.take(now, TEACHER, arm, request);
    }

    pub(crate) fn finish_turn(&mut self, now: HostInstant, arm: ArmId) {
        if !self.has(Bug::EndForgotten) {
            self.control.finish_turn(now, arm);
        }
    }

    pub(crate) fn pass_turn(&mut self, now: HostInstant, arm: ArmId) {
        let turn = self.control.turn(now, arm).map(|(turn, _)| turn.clone());
        let passed = self.control.pass_turn(now, arm).is_ok();
        let Some(turn) = turn else { return };
        if self.has(Bug::NextLosesPlace) && passed {
            self.control.leave_turn(now, turn.person);
        }
        if self.has(Bug::NextToNobody) && !passed {
            self.control.finish_turn(now, arm);
        }
    }

    pub(crate) fn gone(&mut self, now: HostInstant, session: SessionId) {
        self.control.leave(now, session);
        if self.has(Bug::PlaceOfSocket)
            && let Some(person) = Model::person(session)
        {
            self.control.leave_turn(now, person);
        }
    }

    pub(crate) fn begin(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        request: RequestId,
        kind: WorkKind,
    ) -> bool {
        let frozen = self.has(Bug::StartsFrozen) && self.control.is_frozen(arm);
        if frozen {
            self.control.free(now, arm);
        }
        let begun = self.control.begin(now, session, arm, request, kind);
        if frozen {
            self.control.freeze(now, arm, None);
            while self.control.poll_effect().is_some() {}
        }
        begun.is_ok()
    }

    pub(crate) fn pass(&mut self, now: HostInstant) {
        if self.has(Bug::SlotForgotten) {
            self.control.set_slots(now, ARMS[1], None);
        }
        if !self.has(Bug::EndlessTurn) {
            self.control.handle_timeout(now);
        }
    }

    pub(crate) fn queue_job(&mut self, claim: JobClaim) {
        let jumps = self.has(Bug::JobJumpsQueue);
        let place = if jumps { 0 } else { usize::MAX };
        self.control.queue_job(claim, place);
    }

    /// Removes and returns the next job that may start at an arm.
    pub(crate) fn next_job(&mut self, now: HostInstant, arm: ArmId) -> Option<JobClaim> {
        let next = if self.has(Bug::JobIgnoresTurn) {
            self.control.jobs(arm).next().copied()
        } else {
            self.control.next_job(now, arm, |_| true)
        };
        let here = |person| {
            let mut pages = PAGES.iter().filter(|(_, of)| *of == person);
            pages.any(|(page, _)| self.control.back_until(*page).is_none())
        };
        let next = next.filter(|next| !self.has(Bug::JobForgotten) || next.person.is_none_or(here));
        self.control.take_job(next?.job)
    }

    pub(crate) fn freeze(&mut self, now: HostInstant, arm: ArmId) {
        self.control.freeze(now, arm, None);
    }

    pub(crate) fn effects(&mut self, frozen: bool) -> Vec<Effect> {
        let effects: Vec<_> = std::iter::from_fn(|| self.control.poll_effect()).collect();
        let drops = |effect: &Effect| match (effect, self.bug) {
            (Effect::EndWork { .. }, Some(Bug::MovesFrozen)) => frozen,
            (Effect::EndWork { .. }, Some(Bug::WorkContinues)) => !frozen,
            (Effect::TurnLease { .. }, Some(Bug::NextWithoutLease)) => true,
            _ => false,
        };
        effects
            .into_iter()
            .filter(|effect| !drops(effect))
            .collect()
    }
}

/// Waiting time of zero.
pub(crate) const AT_ONCE: Duration = Duration::ZERO;
