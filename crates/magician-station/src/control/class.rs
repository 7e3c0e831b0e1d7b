//! Classes: persons and their turns, the schedule, and freezing of arms.
//!
//! A person is anyone who signed in, with any number of pages. Control knows a session as one of
//! three: *identified* as a person; identified as nobody in particular (a page without a name); or
//! never [identified](Control::identify), which makes it a teacher's. Turns, slots and freezes do
//! not bind a teacher.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician_protocol::HostInstant;

use super::claims::{JobClaim, TurnPlace};
use super::{ArmId, Control, Effect, JobId, LeaseEnd, PersonId, Refusal, SessionId, WorkEnd};

/// Warnings before the end of a turn: times at which [`Effect::TurnEnding`] is emitted. A minute to
/// finish, ten seconds to let go; a choice.
pub const TURN_END_WARNINGS: [Duration; 2] = [Duration::from_secs(60), Duration::from_secs(10)];

/// Rules of turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TurnRules {
    /// Length of a turn. `None` for no end.
    pub length: Option<Duration>,
    /// Time that the arm is kept for a person who is away.
    pub grace: Duration,
    /// True if a job that is running at the end of a turn continues to its end.
    pub finish_job: bool,
}

/// Time slot of the schedule, in which certain persons may hold an arm.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Slot {
    /// Start. `None` once the slot has started.
    pub from: Option<HostInstant>,
    /// End.
    pub until: HostInstant,
    /// Persons who may hold the arm.
    pub who: BTreeSet<PersonId>,
}

impl Slot {
    pub(super) fn is_open(&self, now: HostInstant) -> bool {
        self.from.is_none_or(|from| from <= now) && now < self.until
    }
}

/// Reason why a person gets no place in the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum QueueRefusal {
    /// No turns are set.
    NoTurns,
    /// The schedule gives the person none of the arms.
    Schedule,
}

/// State of a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TurnState {
    /// The person has the lease.
    Running {
        /// End of the turn. `None`: the person ends it.
        ends: Option<HostInstant>,
    },
    /// The person is away: the arm is kept.
    Kept {
        /// Instant until which it is kept.
        until: HostInstant,
        /// Rest of the turn. `None` for no end.
        left: Option<Duration>,
    },
    /// A teacher has the arm.
    Suspended {
        /// Rest of the turn. `None` for no end.
        left: Option<Duration>,
    },
}

/// Turn at an arm.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Turn {
    /// The person whose turn it is.
    pub person: PersonId,
    /// State.
    pub state: TurnState,
    /// Arms that the person accepted when joining. Needed if the turn goes back to the queue.
    pub(super) arms: BTreeSet<ArmId>,
    /// Number of warnings of [`TURN_END_WARNINGS`] already given.
    pub(super) warnings_given: usize,
}

/// State of an arm within the class.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct ArmClass {
    pub(super) turn: Option<Turn>,
    pub(super) frozen: Option<HostInstant>,
    /// Slots of the schedule. `None` leaves the arm open at any time.
    pub(super) slots: Option<Vec<Slot>>,
    /// Persons who may never hold the arm, because their group uses other arms.
    pub(super) barred: BTreeSet<PersonId>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct ClassState {
    pub(super) rules: Option<TurnRules>,
    pub(super) persons: BTreeMap<SessionId, Option<PersonId>>,
    pub(super) arms: Vec<ArmClass>,
}

impl ClassState {
    pub(super) fn new(arms: usize) -> Self {
        Self {
            arms: vec![ArmClass::default(); arms],
            ..Self::default()
        }
    }

    pub(super) fn forget(&mut self, session: SessionId) {
        self.persons.remove(&session);
    }

    /// Applies a change to every instant.
    pub(super) fn each_instant(&mut self, mut change: impl FnMut(&mut HostInstant)) {
        for arm in &mut self.arms {
            match arm.turn.as_mut().map(|turn| &mut turn.state) {
                Some(TurnState::Running { ends: Some(ends) }) => change(ends),
                Some(TurnState::Kept { until, .. }) => change(until),
                // The other states have no instant: turns without end, and suspended ones.
                _ => {}
            }
            arm.frozen.iter_mut().for_each(&mut change);
            for slot in arm.slots.iter_mut().flatten() {
                slot.from.iter_mut().for_each(&mut change);
                change(&mut slot.until);
            }
        }
    }

    /// Returns the earliest deadline of the class.
    pub(super) fn next(&self) -> Option<HostInstant> {
        let arms = self.arms.iter().flat_map(|arm| {
            let turn = arm.turn.as_ref().and_then(|turn| match turn.state {
                // While the arm is frozen the clock of the turn stands still.
                TurnState::Running { ends: Some(ends) } if arm.frozen.is_none() => Some(
                    TURN_END_WARNINGS
                        .get(turn.warnings_given)
                        .map_or(ends, |before| ends - *before),
                ),
                TurnState::Kept { until, .. } => Some(until),
                _ => None,
            });
            let slots = arm.slots.iter().flatten();
            slots
                .map(|slot| slot.from.unwrap_or(slot.until))
                .chain(turn)
        });
        arms.min()
    }
}

impl Control {
    /// Identifies a session as a person, or as nobody in particular (`None`). Sessions of teachers
    /// are not identified.
    pub fn identify(&mut self, now: HostInstant, session: SessionId, person: Option<PersonId>) {
        self.class.persons.insert(session, person);
        // The person may have a kept turn, which goes on now.
        self.note_person_present(now, session);
    }

    /// Sets the rules of turns. `None` removes turns and queue.
    pub fn set_turns(&mut self, now: HostInstant, rules: Option<TurnRules>) {
        self.class.rules = rules;
        if rules.is_none() {
            self.claims.drop_places(|_| true);
            // Leases are left alone: without turns anyone may hold an arm.
            self.class.arms.iter_mut().for_each(|arm| arm.turn = None);
        }
        // A person who holds an arm without a turn gets one now.
        for arm in self.arm_ids() {
            if let Some(holder) = self.holder(arm) {
                let turn = self.person(holder).and_then(|person| self.turn_of(person));
                if turn.is_some_and(|at| at != arm) {
                    // A person has at most one turn.
                    self.end_lease(now, arm, LeaseEnd::Over);
                    continue;
                }
                self.note_turn_granted(now, arm, holder);
                if !self.may_hold(now, holder, arm) {
                    self.end_lease(now, arm, LeaseEnd::Over);
                }
            }
        }
        self.emit_turns_changed();
        self.advance(now);
    }

    /// Sets the slots of the schedule for an arm. `None` opens it at any time.
    pub fn set_slots(&mut self, now: HostInstant, arm: ArmId, slots: Option<Vec<Slot>>) {
        self.class_mut(arm).slots = slots;
        self.end_passed_slots(now, arm);
        self.advance(now);
    }

    /// Sets the persons who may never have an arm, regardless of the schedule. Their leases, turns
    /// and waits there end.
    pub fn bar(&mut self, now: HostInstant, arm: ArmId, persons: BTreeSet<PersonId>) {
        self.class_mut(arm).barred = persons;
        self.end_passed_slots(now, arm);
    }

    /// True if a person is barred from an arm.
    #[must_use]
    pub fn is_barred(&self, arm: ArmId, person: PersonId) -> bool {
        self.class(arm).barred.contains(&person)
    }

    /// Removes turn and place of a person who has left the class.
    pub fn forget_person(&mut self, now: HostInstant, person: PersonId) {
        self.leave_turn(now, person);
    }

    /// Adds a person to the queue for a turn at any of these arms that the schedule grants, now or
    /// later. No effect if the person has a turn, or waits for the same arms.
    ///
    /// # Errors
    /// [`QueueRefusal`] if there are no turns, or if the person may have none of the arms.
    pub fn join_turn(
        &mut self,
        now: HostInstant,
        person: PersonId,
        mut arms: BTreeSet<ArmId>,
    ) -> Result<(), QueueRefusal> {
        if self.class.rules.is_none() || arms.is_empty() {
            return Err(QueueRefusal::NoTurns);
        }
        if self.turn_of(person).is_some() {
            return Ok(());
        }
        // A slot that opens later counts: the person may wait for it.
        arms.retain(|arm| self.opens(now, *arm, person).is_some());
        if arms.is_empty() {
            return Err(QueueRefusal::Schedule);
        }
        let same = |place: &TurnPlace| place.person == person && place.arms == arms;
        if !self.claims.places().any(same) {
            // Joining for other arms gives up the old place, so that a person stands in the queue
            // only once.
            self.claims.drop_places(|place| place.person == person);
            self.claims.push_place(TurnPlace {
                person,
                arms,
                left: None,
                missed: false,
            });
            self.emit_turns_changed();
        }
        self.advance(now);
        Ok(())
    }

    /// Ends the turn of a person and removes the place in the queue.
    pub fn leave_turn(&mut self, now: HostInstant, person: PersonId) {
        if self.claims.drop_places(|place| place.person == person) {
            self.emit_turns_changed();
        }
        if let Some(arm) = self.turn_of(person) {
            self.end_turn(now, arm);
        }
        self.advance(now);
    }

    /// Ends the turn at an arm early. The person gets no new place.
    pub fn finish_turn(&mut self, now: HostInstant, arm: ArmId) {
        if self.class(arm).turn.is_some() {
            self.end_turn(now, arm);
            self.advance(now);
        }
    }

    /// Passes the turn at an arm to the next person who is present. The person who had it goes to
    /// the end of the queue.
    ///
    /// # Errors
    /// [`Refusal::Unknown`] if the arm has no turn, or no present person who may have the arm is
    /// waiting.
    pub fn pass_turn(&mut self, now: HostInstant, arm: ArmId) -> Result<(), Refusal> {
        let turn = self.class(arm).turn.clone().ok_or(Refusal::Unknown)?;
        let waits = self
            .claims
            .places()
            .filter(|place| self.is_next(now, arm, place));
        let is_here = |person: &PersonId| self.session_of_person(*person).is_some();
        let persons: Vec<_> = waits.map(|place| place.person).collect();
        let Some(next) = persons.iter().position(is_here) else {
            return Err(Refusal::Unknown);
        };
        for person in &persons[..next] {
            // Skipped: their turn came while they were away.
            self.claims.miss(*person);
        }
        self.claims.push_place(TurnPlace {
            person: turn.person,
            arms: turn.arms,
            left: None,
            // An absent person must not block the queue.
            missed: self.session_of_person(turn.person).is_none(),
        });
        self.end_turn(now, arm);
        self.advance(now);
        Ok(())
    }

    /// Removes places of persons to whom the schedule grants none of the arms that they wait for.
    pub fn drop_closed_places(&mut self, now: HostInstant) {
        let closed: Vec<_> = { self.claims.places() }
            .filter(|place| {
                let mut arms = place.arms.iter();
                arms.all(|arm| self.opens(now, *arm, place.person).is_none())
            })
            .map(|place| place.person)
            .collect();
        if self
            .claims
            .drop_places(|place| closed.contains(&place.person))
        {
            self.emit_turns_changed();
        }
    }

    /// Freezes an arm: stops it and refuses all motion except by teachers. A job that burns ends at
    /// once. Another job pauses; [`stop_frozen`](Self::stop_frozen) ends it if that takes too long.
    pub fn freeze(&mut self, now: HostInstant, arm: ArmId, by: Option<SessionId>) {
        if self.class(arm).frozen.is_none() {
            self.class_mut(arm).frozen = Some(now);
            self.emit_turns_changed();
        }
        // Requests of teachers end as well: a freeze stops everything at the arm.
        let requests = self.stop(now, arm);
        let job = self.arm(arm).job;
        let running = job.filter(|job| job.phase.is_under_way());
        self.effects.push_back(Effect::EndWork {
            arm,
            requests,
            // A running job pauses or ends by itself, with the laser off: a stop would cut its
            // line.
            stop: running.is_none(),
            why: WorkEnd::Stop(by),
        });
        if let Some(job) = running {
            let (job, pause) = (job.id, !job.burns);
            self.effects.push_back(Effect::EndJob { arm, job, pause });
        }
    }

    /// Ends the job of a frozen arm if it has not paused yet.
    pub fn stop_frozen(&mut self, arm: ArmId) {
        let job = self.arm(arm).job.filter(|_| self.is_frozen(arm));
        if let Some(job) = job.filter(|job| job.phase.is_under_way()) {
            let (job, pause) = (job.id, false);
            self.effects.push_back(Effect::EndJob { arm, job, pause });
        }
    }

    /// Unfreezes an arm. The turn continues with the time it had left.
    pub fn free(&mut self, now: HostInstant, arm: ArmId) {
        let class = self.class_mut(arm);
        let Some(since) = class.frozen.take() else {
            return;
        };
        if let Some(Turn {
            state: TurnState::Running { ends: Some(ends) },
            ..
        }) = &mut class.turn
        {
            // The clock of the turn stood still while the arm was frozen.
            *ends += now - since;
        }
        self.emit_turns_changed();
        self.advance(now);
    }

    /// True if the arm is frozen.
    #[must_use]
    pub fn is_frozen(&self, arm: ArmId) -> bool {
        self.class(arm).frozen.is_some()
    }

    /// Returns the turn at an arm and the time left. `None` without a turn; the time is `None` for
    /// a turn without end.
    #[must_use]
    pub fn turn(&self, now: HostInstant, arm: ArmId) -> Option<(&Turn, Option<Duration>)> {
        let turn = self.class(arm).turn.as_ref()?;
        Some((turn, self.left(now, arm, turn)))
    }

    /// Returns the places that wait for a turn, in order.
    pub fn places(&self) -> impl Iterator<Item = &TurnPlace> {
        self.claims.places()
    }

    /// Returns the jobs that wait for an arm, in order.
    pub fn jobs(&self, arm: ArmId) -> impl Iterator<Item = &JobClaim> {
        self.claims.jobs(arm)
    }

    /// Returns a waiting job. `None` if the job does not wait.
    #[must_use]
    pub fn waiting_job(&self, job: JobId) -> Option<JobClaim> {
        self.claims.job(job).copied()
    }

    /// Inserts a job at this position, from 0, among the jobs that wait for its arm. Appends it if
    /// there are fewer. A job that waits already moves.
    pub fn queue_job(&mut self, claim: JobClaim, place: usize) {
        self.claims.take_job(claim.job);
        self.claims.insert_job(claim, place);
    }

    /// Removes and returns a waiting job. `None` if it does not wait.
    pub fn take_job(&mut self, job: JobId) -> Option<JobClaim> {
        self.claims.take_job(job)
    }

    /// Returns the first job for which `is_ready` holds and that may start at the arm now.
    #[must_use]
    pub fn next_job(
        &self,
        now: HostInstant,
        arm: ArmId,
        is_ready: impl Fn(JobId) -> bool,
    ) -> Option<JobClaim> {
        let mut jobs = self.claims.jobs(arm);
        let may = |claim: &&JobClaim| is_ready(claim.job) && self.may_begin(now, claim);
        jobs.find(may).copied()
    }

    /// Returns the rules of turns. `None` without turns.
    #[must_use]
    pub fn turn_rules(&self) -> Option<TurnRules> {
        self.class.rules
    }

    /// Returns the person of a session. `None` for a teacher and for nobody in particular.
    #[must_use]
    pub fn person(&self, session: SessionId) -> Option<PersonId> {
        self.class.persons.get(&session).copied().flatten()
    }

    /// True if turns, slots and freezes bind the session.
    #[must_use]
    pub fn is_bound(&self, session: SessionId) -> bool {
        self.class.persons.contains_key(&session)
    }

    /// Marks a job as endless: it does not continue after the end of a turn.
    pub fn mark_job_endless(&mut self, arm: ArmId, job: JobId) {
        if let Some(under_way) = &mut self.arm_mut(arm).job
            && under_way.id == job
        {
            under_way.endless = true;
        }
    }

    pub(super) fn class(&self, arm: ArmId) -> &ArmClass {
        &self.class.arms[arm.0 as usize]
    }

    pub(super) fn class_mut(&mut self, arm: ArmId) -> &mut ArmClass {
        &mut self.class.arms[arm.0 as usize]
    }
}

impl TurnRules {
    /// Number of warnings that a turn of this length skips, because it is no longer than they are.
    pub(super) fn skipped_warnings(&self) -> usize {
        // A turn of one minute would start with the warning of its end.
        let short = |before: &&Duration| self.length.is_some_and(|length| length <= **before);
        TURN_END_WARNINGS.iter().filter(short).count()
    }
}
