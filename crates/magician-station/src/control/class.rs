//! A class at the arms: persons and their turns, who may hold an arm when, and what the teacher has frozen.
//!
//! A person is whoever signed in, at however many sockets; a session of nobody in particular that was never
//! [identified](Control::identify) is a teacher's, and no turn, slot or freeze binds it.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician_protocol::HostInstant;

use super::claims::{JobClaim, Place};
use super::{ArmId, Control, Effect, JobId, LeaseEnd, PersonId, Refusal, SessionId, WorkEnd};

/// The end of a turn is told so long before.
pub const TOLD: [Duration; 2] = [Duration::from_secs(60), Duration::from_secs(10)];

/// How turns go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TurnRules {
    /// How long a turn is; none has no end.
    pub length: Option<Duration>,
    /// How long the arm waits for a person who is not there.
    pub grace: Duration,
    /// Whether a job that runs at the end of a turn goes on to its end.
    pub finish_job: bool,
}

/// A stretch of time in which persons may hold an arm.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Slot {
    /// When it begins; none when it has begun.
    pub from: Option<HostInstant>,
    /// When it ends.
    pub until: HostInstant,
    /// Who.
    pub who: BTreeSet<PersonId>,
}

impl Slot {
    pub(super) fn is_open(&self, now: HostInstant) -> bool {
        self.from.is_none_or(|from| from <= now) && now < self.until
    }
}

/// Why a person gets no place in the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NoQueue {
    /// There are no turns.
    NoTurns,
    /// The schedule lets the person have none of the arms.
    Schedule,
}

/// What a turn does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TurnState {
    /// Its person has the lease.
    Running {
        /// When it ends; none: when its person leaves it.
        ends: Option<HostInstant>,
    },
    /// Its person is not there: the arm waits.
    Kept {
        /// Until when.
        until: HostInstant,
        /// What is left of it.
        left: Option<Duration>,
    },
    /// A teacher has the arm.
    Suspended {
        /// What is left of it.
        left: Option<Duration>,
    },
}

/// The turn at an arm.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Turn {
    /// Whose.
    pub person: PersonId,
    /// What it does.
    pub state: TurnState,
    /// The arms that the person would have taken.
    pub(super) arms: BTreeSet<ArmId>,
    /// How many of [`TOLD`] were told.
    pub(super) told: usize,
}

/// An arm as far as the class goes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct ArmClass {
    pub(super) turn: Option<Turn>,
    pub(super) frozen: Option<HostInstant>,
    /// None: at any time.
    pub(super) slots: Option<Vec<Slot>>,
    /// Persons who may not have it at all, because their group has other arms.
    pub(super) barred: BTreeSet<PersonId>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Class {
    pub(super) rules: Option<TurnRules>,
    pub(super) persons: BTreeMap<SessionId, Option<PersonId>>,
    pub(super) arms: Vec<ArmClass>,
}

impl Class {
    pub(super) fn new(arms: usize) -> Self {
        Self {
            arms: vec![ArmClass::default(); arms],
            ..Self::default()
        }
    }

    pub(super) fn forget(&mut self, session: SessionId) {
        self.persons.remove(&session);
    }

    /// Changes all instants.
    pub(super) fn each_instant(&mut self, mut change: impl FnMut(&mut HostInstant)) {
        for arm in &mut self.arms {
            match arm.turn.as_mut().map(|turn| &mut turn.state) {
                Some(TurnState::Running { ends: Some(ends) }) => change(ends),
                Some(TurnState::Kept { until, .. }) => change(until),
                _ => {}
            }
            arm.frozen.iter_mut().for_each(&mut change);
            for slot in arm.slots.iter_mut().flatten() {
                slot.from.iter_mut().for_each(&mut change);
                change(&mut slot.until);
            }
        }
    }

    /// When something is due.
    pub(super) fn next(&self) -> Option<HostInstant> {
        let arms = self.arms.iter().flat_map(|arm| {
            let turn = arm.turn.as_ref().and_then(|turn| match turn.state {
                // While the arm is frozen the turn's clock stands.
                TurnState::Running { ends: Some(ends) } if arm.frozen.is_none() => {
                    Some(TOLD.get(turn.told).map_or(ends, |before| ends - *before))
                }
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
    /// Says who a session is: a person, or somebody who is none. Sessions of teachers are not identified.
    pub fn identify(&mut self, now: HostInstant, session: SessionId, person: Option<PersonId>) {
        self.class.persons.insert(session, person);
        self.person_is_here(now, session);
    }

    /// How turns go from now on; without rules there are none, and no queue.
    pub fn set_turns(&mut self, now: HostInstant, rules: Option<TurnRules>) {
        self.class.rules = rules;
        if rules.is_none() {
            self.claims.drop_places(|_| true);
            self.class.arms.iter_mut().for_each(|arm| arm.turn = None);
        }
        // Who holds an arm without a turn has one from now on.
        for arm in self.arm_ids() {
            if let Some(holder) = self.holder(arm) {
                let turn = self.person(holder).and_then(|person| self.turn_of(person));
                if turn.is_some_and(|at| at != arm) {
                    // A person has one turn.
                    self.end_lease(now, arm, LeaseEnd::Over);
                    continue;
                }
                self.turn_granted(now, arm, holder);
                if !self.may_hold(now, holder, arm) {
                    self.end_lease(now, arm, LeaseEnd::Over);
                }
            }
        }
        self.turns_changed();
        self.advance(now);
    }

    /// When persons may hold an arm; none: at any time.
    pub fn set_slots(&mut self, now: HostInstant, arm: ArmId, slots: Option<Vec<Slot>>) {
        self.class_mut(arm).slots = slots;
        self.slots_passed(now, arm);
        self.advance(now);
    }

    /// Says which persons may not have an arm, whatever the schedule says. Their leases, turns and
    /// waits there end.
    pub fn bar(&mut self, now: HostInstant, arm: ArmId, persons: BTreeSet<PersonId>) {
        self.class_mut(arm).barred = persons;
        self.slots_passed(now, arm);
    }

    /// True if a person may not have an arm, whatever the schedule says.
    #[must_use]
    pub fn is_barred(&self, arm: ArmId, person: PersonId) -> bool {
        self.class(arm).barred.contains(&person)
    }

    /// A person who is not one of the class any more: turn and place are gone.
    pub fn forget_person(&mut self, now: HostInstant, person: PersonId) {
        self.leave_turn(now, person);
    }

    /// A person wants a turn at any of these arms that the schedule lets the person have, now or later. Who has a turn at one
    /// of them, or waits for the same ones, keeps it.
    ///
    /// # Errors
    /// There are no turns, or the person may have none of the arms.
    pub fn join_turn(
        &mut self,
        now: HostInstant,
        person: PersonId,
        mut arms: BTreeSet<ArmId>,
    ) -> Result<(), NoQueue> {
        if self.class.rules.is_none() || arms.is_empty() {
            return Err(NoQueue::NoTurns);
        }
        if self.turn_of(person).is_some() {
            return Ok(());
        }
        arms.retain(|arm| self.opens(now, *arm, person).is_some());
        if arms.is_empty() {
            return Err(NoQueue::Schedule);
        }
        let same = |place: &Place| place.person == person && place.arms == arms;
        if !self.claims.places().any(same) {
            self.claims.drop_places(|place| place.person == person);
            self.claims.push_place(Place {
                person,
                arms,
                left: None,
                missed: false,
            });
            self.turns_changed();
        }
        self.advance(now);
        Ok(())
    }

    /// A person gives turn and place up.
    pub fn leave_turn(&mut self, now: HostInstant, person: PersonId) {
        if self.claims.drop_places(|place| place.person == person) {
            self.turns_changed();
        }
        if let Some(arm) = self.turn_of(person) {
            self.end_turn(now, arm);
        }
        self.advance(now);
    }

    /// Ends the turn at an arm before its time. Its person has no place.
    pub fn finish_turn(&mut self, now: HostInstant, arm: ArmId) {
        if self.class(arm).turn.is_some() {
            self.end_turn(now, arm);
            self.advance(now);
        }
    }

    /// Passes the turn at an arm to the next who waits for it. The person who had it gets the last place of the queue.
    ///
    /// # Errors
    /// [`Refusal::Unknown`] if the arm has no turn, or if nobody who is there and may have the arm waits for it.
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
            // Their turn has come without them.
            self.claims.miss(*person);
        }
        self.claims.push_place(Place {
            person: turn.person,
            arms: turn.arms,
            left: None,
            missed: self.session_of_person(turn.person).is_none(),
        });
        self.end_turn(now, arm);
        self.advance(now);
        Ok(())
    }

    /// Takes out the places of persons whom the schedule lets have none of the arms that they wait for.
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
            self.turns_changed();
        }
    }

    /// Stops an arm, and refuses all that moves it by anybody but a teacher. A job that burns ends at once; another one pauses,
    /// for which [`stop_frozen`](Self::stop_frozen) bounds the time.
    pub fn freeze(&mut self, now: HostInstant, arm: ArmId, by: Option<SessionId>) {
        if self.class(arm).frozen.is_none() {
            self.class_mut(arm).frozen = Some(now);
            self.turns_changed();
        }
        let requests = self.stop(now, arm);
        let job = self.arm(arm).job;
        let running = job.filter(|job| job.phase.is_under_way());
        self.effects.push_back(Effect::EndWork {
            arm,
            requests,
            // A job comes to its pause or end by itself, with the laser off.
            stop: running.is_none(),
            why: WorkEnd::Stop(by),
        });
        if let Some(job) = running {
            let (job, pause) = (job.id, !job.burns);
            self.effects.push_back(Effect::EndJob { arm, job, pause });
        }
    }

    /// Stops a frozen arm whose job has not come to its pause.
    pub fn stop_frozen(&mut self, arm: ArmId) {
        let job = self.arm(arm).job.filter(|_| self.is_frozen(arm));
        if let Some(job) = job.filter(|job| job.phase.is_under_way()) {
            let (job, pause) = (job.id, false);
            self.effects.push_back(Effect::EndJob { arm, job, pause });
        }
    }

    /// Lets an arm be moved again. The turn has what it had left.
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
            *ends += now - since;
        }
        self.turns_changed();
        self.advance(now);
    }

    /// Whether an arm is frozen.
    #[must_use]
    pub fn is_frozen(&self, arm: ArmId) -> bool {
        self.class(arm).frozen.is_some()
    }

    /// The turn at an arm, and what is left of it.
    #[must_use]
    pub fn turn(&self, now: HostInstant, arm: ArmId) -> Option<(&Turn, Option<Duration>)> {
        let turn = self.class(arm).turn.as_ref()?;
        Some((turn, self.left(now, arm, turn)))
    }

    /// Who waits for a turn, in order.
    pub fn places(&self) -> impl Iterator<Item = &Place> {
        self.claims.places()
    }

    /// The jobs that wait for an arm, in order.
    pub fn jobs(&self, arm: ArmId) -> impl Iterator<Item = &JobClaim> {
        self.claims.jobs(arm)
    }

    /// A job that waits. None where it does not.
    #[must_use]
    pub fn waiting_job(&self, job: JobId) -> Option<JobClaim> {
        self.claims.job(job).copied()
    }

    /// Puts a job at a place among those that wait for its arm, from 0; behind them where there are not so many. One that
    /// waits already leaves its place.
    pub fn queue_job(&mut self, claim: JobClaim, place: usize) {
        self.claims.take_job(claim.job);
        self.claims.insert_job(claim, place);
    }

    /// Takes out a job that waits.
    pub fn take_job(&mut self, job: JobId) -> Option<JobClaim> {
        self.claims.take_job(job)
    }

    /// The first job that waits for an arm and may begin now, of those of which this holds.
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

    /// The rules of turns, if there are turns.
    #[must_use]
    pub fn turn_rules(&self) -> Option<TurnRules> {
        self.class.rules
    }

    /// Whose a session is: none for a teacher, and for somebody who is no person in particular.
    #[must_use]
    pub fn person(&self, session: SessionId) -> Option<PersonId> {
        self.class.persons.get(&session).copied().flatten()
    }

    /// Whether a session is bound by turns, slots and freezes.
    #[must_use]
    pub fn is_bound(&self, session: SessionId) -> bool {
        self.class.persons.contains_key(&session)
    }

    /// An endless job does not go on to its end when a turn is over.
    pub fn job_is_endless(&mut self, arm: ArmId, job: JobId) {
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
    /// What is not told of a turn that is not longer than that.
    pub(super) fn told(&self) -> usize {
        let short = |before: &&Duration| self.length.is_some_and(|length| length <= **before);
        TOLD.iter().filter(short).count()
    }
}
