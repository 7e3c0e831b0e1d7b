//! The queue of a station: everything that wants an arm and does not have it, in order of arrival.
//!
//! Three kinds of claims share one list: a request for the lease of a particular arm, which waits
//! for it or asks its holder; the place of a person who takes turns at any of several arms; and a
//! job. The list stores order and nothing else. The rules are elsewhere: who may have an arm and
//! when a job may start (`policy`), how long a turn lasts and what ends it (`turns`), how a lease
//! passes (`lease`).
//!
//! A free arm goes first to requests that wait, then to the first that asked its holder, then to
//! turns, then to jobs.

#[cfg(feature = "class")]
use std::collections::BTreeSet;
#[cfg(feature = "class")]
use std::time::Duration;

use magician_protocol::HostInstant;

use super::{ArmId, RequestId, SessionId};
#[cfg(feature = "class")]
use super::{JobId, PersonId};

/// Entry of the queue.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Claim {
    Lease(LeaseRequest),
    #[cfg(feature = "class")]
    Turn(TurnPlace),
    #[cfg(feature = "class")]
    Job(JobClaim),
}

/// Request for the lease of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct LeaseRequest {
    pub(super) arm: ArmId,
    pub(super) session: SessionId,
    pub(super) request: RequestId,
    /// True if the session asks the holder, false if it waits until the lease is free.
    pub(super) is_ask: bool,
    /// Instant at which the wait is over, or at which the holder's time to answer is over.
    pub(super) until: HostInstant,
}

/// Place of a person in the queue.
#[cfg(feature = "class")]
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TurnPlace {
    /// The person.
    pub person: PersonId,
    /// Acceptable arms; the person gets the first of them that is free.
    pub arms: BTreeSet<ArmId>,
    /// Rest of an interrupted turn (inner `None`: unlimited). `None` if no turn has begun.
    pub(super) left: Option<Option<Duration>>,
    /// True if the turn came while the person was away. Others go first until the person is back.
    pub missed: bool,
}

/// Job that waits for its arm.
#[cfg(feature = "class")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct JobClaim {
    /// The job.
    pub job: JobId,
    /// The arm.
    pub arm: ArmId,
    /// Owner. `None` for a teacher.
    pub person: Option<PersonId>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Claims(Vec<Claim>);

impl Claim {
    fn request(&self) -> Option<&LeaseRequest> {
        match self {
            Self::Lease(request) => Some(request),
            #[cfg(feature = "class")]
            Self::Turn(_) | Self::Job(_) => None,
        }
    }

    fn request_mut(&mut self) -> Option<&mut LeaseRequest> {
        match self {
            Self::Lease(request) => Some(request),
            #[cfg(feature = "class")]
            Self::Turn(_) | Self::Job(_) => None,
        }
    }
}

impl Claims {
    /// Removes and returns the first claim that matches.
    fn take_claim(&mut self, which: impl Fn(&Claim) -> bool) -> Option<Claim> {
        let at = self.0.iter().position(which)?;
        Some(self.0.remove(at))
    }
}

/// Requests for leases.
impl Claims {
    pub(super) fn push_request(&mut self, request: LeaseRequest) {
        self.0.push(Claim::Lease(request));
    }

    /// Returns the requests for an arm: the waiting ones in order, then the asking ones.
    pub(super) fn requests(&self, arm: ArmId) -> impl Iterator<Item = &LeaseRequest> {
        // One list holds both kinds; their order within a kind is that of arrival.
        let of = move |asks| {
            let requests = self.0.iter().filter_map(Claim::request);
            requests.filter(move |request| request.arm == arm && request.is_ask == asks)
        };
        of(false).chain(of(true))
    }

    /// Returns the requests that wait for the lease of an arm, in order.
    pub(super) fn waiting_requests(&self, arm: ArmId) -> impl Iterator<Item = &LeaseRequest> {
        self.requests(arm).filter(|request| !request.is_ask)
    }

    /// Returns the requests that ask the holder of an arm.
    pub(super) fn asking_requests_mut(
        &mut self,
        arm: ArmId,
    ) -> impl Iterator<Item = &mut LeaseRequest> {
        let requests = self.0.iter_mut().filter_map(Claim::request_mut);
        requests.filter(move |request| request.arm == arm && request.is_ask)
    }

    /// Removes and returns all requests that match.
    pub(super) fn take(&mut self, which: impl Fn(&LeaseRequest) -> bool) -> Vec<LeaseRequest> {
        let of = |claim: &mut Claim| claim.request().is_some_and(&which);
        let taken = self.0.extract_if(.., of);
        taken.filter_map(|claim| claim.request().copied()).collect()
    }

    /// Removes and returns the first request that matches.
    pub(super) fn take_first(
        &mut self,
        which: impl Fn(&LeaseRequest) -> bool,
    ) -> Option<LeaseRequest> {
        let claim = self.take_claim(|claim| claim.request().is_some_and(&which))?;
        claim.request().copied()
    }

    /// Returns the earliest deadline of a request.
    pub(super) fn next(&self) -> Option<HostInstant> {
        let requests = self.0.iter().filter_map(Claim::request);
        requests.map(|request| request.until).min()
    }

    /// Shifts all instants and sorts unrelated claims, for the canonical form.
    pub(super) fn canonical(&mut self, change: impl Fn(HostInstant) -> HostInstant) {
        for request in self.0.iter_mut().filter_map(Claim::request_mut) {
            request.until = change(request.until);
        }
        // The sort is stable: the order within a key matters and stays.
        self.0.sort_by_key(|claim| match claim {
            Claim::Lease(request) => (u8::from(request.is_ask), request.arm),
            #[cfg(feature = "class")]
            Claim::Turn(_) => (2, ArmId(0)),
            #[cfg(feature = "class")]
            Claim::Job(job) => (3, job.arm),
        });
    }
}

/// Places of persons who take turns.
#[cfg(feature = "class")]
impl Claims {
    /// Returns the places that wait for a turn, in order.
    pub(super) fn places(&self) -> impl Iterator<Item = &TurnPlace> {
        self.0.iter().filter_map(|claim| match claim {
            Claim::Turn(place) => Some(place),
            Claim::Lease(_) | Claim::Job(_) => None,
        })
    }

    /// Returns the place of a person who missed a turn.
    pub(super) fn missed_mut(&mut self, person: PersonId) -> Option<&mut TurnPlace> {
        let mut places = self.0.iter_mut().filter_map(|claim| match claim {
            Claim::Turn(place) => Some(place),
            Claim::Lease(_) | Claim::Job(_) => None,
        });
        places.find(|place| place.person == person && place.missed)
    }

    /// Marks that a person missed the turn.
    pub(super) fn miss(&mut self, person: PersonId) {
        for claim in &mut self.0 {
            if let Claim::Turn(place) = claim
                && place.person == person
            {
                place.missed = true;
            }
        }
    }

    pub(super) fn push_place(&mut self, place: TurnPlace) {
        self.0.push(Claim::Turn(place));
    }

    /// Inserts a place before all others.
    pub(super) fn put_place_first(&mut self, place: TurnPlace) {
        self.0.insert(0, Claim::Turn(place));
    }

    /// Removes all places that match. Returns true if there were any.
    pub(super) fn drop_places(&mut self, which: impl Fn(&TurnPlace) -> bool) -> bool {
        let before = self.0.len();
        { &mut self.0 }.retain(|claim| !matches!(claim, Claim::Turn(place) if which(place)));
        before != self.0.len()
    }

    /// Removes and returns the place of a person. A person has at most one.
    pub(super) fn take_place(&mut self, person: PersonId) -> Option<TurnPlace> {
        let of = |claim: &Claim| matches!(claim, Claim::Turn(place) if place.person == person);
        match self.take_claim(of)? {
            Claim::Turn(place) => Some(place),
            Claim::Lease(_) | Claim::Job(_) => None,
        }
    }
}

/// Jobs that wait.
#[cfg(feature = "class")]
impl Claims {
    /// Returns the jobs that wait for an arm, in order.
    pub(super) fn jobs(&self, arm: ArmId) -> impl Iterator<Item = &JobClaim> {
        self.all_jobs().filter(move |claim| claim.arm == arm)
    }

    pub(super) fn job(&self, job: JobId) -> Option<&JobClaim> {
        self.all_jobs().find(|claim| claim.job == job)
    }

    fn all_jobs(&self) -> impl Iterator<Item = &JobClaim> {
        self.0.iter().filter_map(|claim| match claim {
            Claim::Job(job) => Some(job),
            Claim::Lease(_) | Claim::Turn(_) => None,
        })
    }

    /// Inserts a job at this position, from 0, among the jobs of its arm. Appends it if there are
    /// fewer.
    pub(super) fn insert_job(&mut self, claim: JobClaim, place: usize) {
        let of = |other: &Claim| matches!(other, Claim::Job(job) if job.arm == claim.arm);
        let mut others = (0..self.0.len()).filter(|at| of(&self.0[*at]));
        // Claims of other arms lie in between, so a position counts only the jobs of this arm.
        let at = others.nth(place).unwrap_or(self.0.len());
        self.0.insert(at, Claim::Job(claim));
    }

    pub(super) fn take_job(&mut self, job: JobId) -> Option<JobClaim> {
        let of = |claim: &Claim| matches!(claim, Claim::Job(known) if known.job == job);
        match self.take_claim(of)? {
            Claim::Job(job) => Some(job),
            Claim::Lease(_) | Claim::Turn(_) => None,
        }
    }
}
