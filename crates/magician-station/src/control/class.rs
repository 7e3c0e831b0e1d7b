//! A class at the arms: persons and their turns, who may hold an arm when, and what the teacher has frozen.
//!
//! A person is whoever signed in, at however many sockets; a session of nobody in particular that was never
//! [identified](Control::identify) is a teacher's, and no turn, slot or freeze binds it.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician_protocol::HostInstant;

use super::{ArmId, Control, Effect, JobId, LeaseEnd, PersonId, Refusal, SessionId, WorkEnd};

/// The end of a turn is told so long before.
pub const TOLD: [Duration; 2] = [Duration::from_secs(60), Duration::from_secs(10)];

/// What a request changes of a job that waits in the queue of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum QueuedChange {
    /// Takes it out.
    Stop,
    /// Gives it another place.
    Reorder,
    /// Lets it go on after a stop, whose reason its owner knows.
    Resume,
}

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

/// A person's place in the queue.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    /// Whose.
    pub person: PersonId,
    /// Any of these arms will do.
    pub arms: BTreeSet<ArmId>,
    /// What is left of a turn that was begun; none of one that was not.
    pub(super) left: Option<Option<Duration>>,
    /// It was this person's turn and nobody came: others go first until the person is there.
    pub missed: bool,
}

/// An arm as far as the class goes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct ArmClass {
    pub(super) turn: Option<Turn>,
    pub(super) frozen: Option<HostInstant>,
    /// None: at any time.
    pub(super) slots: Option<Vec<Slot>>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Class {
    pub(super) rules: Option<TurnRules>,
    pub(super) persons: BTreeMap<SessionId, Option<PersonId>>,
    pub(super) queue: Vec<Place>,
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
            self.class.queue.clear();
            self.class.arms.iter_mut().for_each(|arm| arm.turn = None);
        }
        // Who holds an arm without a turn has one from now on.
        for arm in self.arm_ids() {
            if let Some(holder) = self.holder(arm) {
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

    /// A person who is not one of the class any more: turn and place are gone.
    pub fn forget_person(&mut self, now: HostInstant, person: PersonId) {
        self.leave_turn(now, person);
    }

    /// A person wants a turn at any of these arms. Who has a turn at one of them, or waits for the same ones, keeps it.
    ///
    /// # Errors
    /// [`Refusal::Unknown`] while there are no turns.
    pub fn join_turn(
        &mut self,
        now: HostInstant,
        person: PersonId,
        arms: BTreeSet<ArmId>,
    ) -> Result<(), Refusal> {
        if self.class.rules.is_none() || arms.is_empty() {
            return Err(Refusal::Unknown);
        }
        if self.turn_of(person).is_some() {
            return Ok(());
        }
        let same = |place: &Place| place.person == person && place.arms == arms;
        if !self.class.queue.iter().any(same) {
            self.class.queue.retain(|place| place.person != person);
            self.class.queue.push(Place {
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
        let before = self.class.queue.len();
        self.class.queue.retain(|place| place.person != person);
        if before != self.class.queue.len() {
            self.turns_changed();
        }
        if let Some(arm) = self.turn_of(person) {
            self.end_turn(now, arm);
        }
        self.advance(now);
    }

    /// Stops an arm, and refuses all that moves it by anybody but a teacher. A job pauses.
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
            // A job comes to its pause by itself, with the laser off.
            stop: running.is_none(),
            why: WorkEnd::Stop(by),
        });
        if let Some(job) = running {
            let (job, pause) = (job.id, true);
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
    #[must_use]
    pub fn queue(&self) -> &[Place] {
        &self.class.queue
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

    /// Whether a session may have the lease of an arm now, were nobody else to have it.
    #[must_use]
    pub fn may_hold(&self, now: HostInstant, session: SessionId, arm: ArmId) -> bool {
        let Some(person) = self.class.persons.get(&session) else {
            return true;
        };
        if !self.is_in_slot(now, arm, *person) {
            return false;
        }
        if self.class.rules.is_none() {
            return true;
        }
        let Some(person) = *person else {
            return false;
        };
        match &self.class(arm).turn {
            Some(turn) => turn.person == person,
            None => {
                let mut queue = self.class.queue.iter();
                let behind =
                    queue.any(|place| place.person != person && self.is_next(now, arm, place));
                !behind && self.turn_of(person).is_none() && !self.job_runs(arm)
            }
        }
    }

    /// Whether a job that waits for an arm may begin now: one of this person, none for a teacher's.
    #[must_use]
    pub fn may_begin_queued(&self, now: HostInstant, arm: ArmId, person: Option<PersonId>) -> bool {
        let state = self.arm(arm);
        let idle = state.job.is_none() && state.jog.is_none() && state.work.is_empty();
        let holder = self.holder(arm);
        let own = holder.is_none_or(|holder| {
            self.person(holder) == person && self.is_bound(holder) == person.is_some()
        });
        let turn = self.class(arm).turn.as_ref();
        let turn = turn.is_none_or(|turn| Some(turn.person) == person);
        let slot = person.is_none() || self.is_in_slot(now, arm, person);
        idle && !state.queued && own && turn && slot && !self.is_frozen(arm)
    }

    /// Whether a session may change a job that waits for an arm so: a teacher, its owner, and the holder of the arm's
    /// lease, who also has it in the way. `owner` is `None` for a teacher's job.
    #[must_use]
    pub fn may_change_queued(
        &self,
        session: SessionId,
        arm: ArmId,
        owner: Option<PersonId>,
        change: QueuedChange,
    ) -> bool {
        if !self.is_bound(session) {
            return true;
        }
        let person = self.person(session);
        let owns = owner.is_some() && person == owner;
        let holds = self.holder(arm).is_some_and(|holder| {
            // Two pages of a person are one person.
            holder == session || person.is_some() && self.person(holder) == person
        });
        owns || holds && change != QueuedChange::Resume
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
