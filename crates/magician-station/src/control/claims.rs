//! The queue of a station: all who want an arm and do not have it, in the order in which they came.
//!
//! A claim is a request for the lease of an arm, which waits for it or asks its holder; a person who takes turns, at any of
//! some arms; or a job. They stand in one list. Policies say the rest: who may have an arm at all and when a job may begin
//! (`policy`), how long a turn is and what ends it (`turns`), and how a lease passes (`lease`). At an arm that is free the
//! requests that wait come first, then the first that asked its holder, then turns, then jobs.

#[cfg(feature = "class")]
use std::collections::BTreeSet;
#[cfg(feature = "class")]
use std::time::Duration;

use magician_protocol::HostInstant;

use super::{ArmId, RequestId, SessionId};
#[cfg(feature = "class")]
use super::{JobId, PersonId};

/// Somebody or something that wants an arm.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Claim {
    Lease(LeaseRequest),
    #[cfg(feature = "class")]
    Turn(Place),
    #[cfg(feature = "class")]
    Job(JobClaim),
}

/// A request for the lease of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct LeaseRequest {
    pub(super) arm: ArmId,
    pub(super) session: SessionId,
    pub(super) request: RequestId,
    /// True if it asks the holder, false if it waits until the lease is free.
    pub(super) asks: bool,
    /// When it has waited for long enough, or the holder has had its time to answer.
    pub(super) until: HostInstant,
}

/// A person's place in the queue.
#[cfg(feature = "class")]
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    /// The person.
    pub person: PersonId,
    /// Any of these arms will do.
    pub arms: BTreeSet<ArmId>,
    /// Rest of a turn that was begun. `None` for one that was not.
    pub(super) left: Option<Option<Duration>>,
    /// True if the person's turn came and the person did not: others go first until the person is there.
    pub missed: bool,
}

/// A job that waits for its arm.
#[cfg(feature = "class")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct JobClaim {
    /// The job.
    pub job: JobId,
    /// The arm.
    pub arm: ArmId,
    /// The owner. `None` for a teacher.
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
    /// Takes out the first claim of which this holds.
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

    /// The requests for the lease of an arm: those that wait in their order, then those that ask.
    pub(super) fn requests(&self, arm: ArmId) -> impl Iterator<Item = &LeaseRequest> {
        let of = move |asks| {
            let requests = self.0.iter().filter_map(Claim::request);
            requests.filter(move |request| request.arm == arm && request.asks == asks)
        };
        of(false).chain(of(true))
    }

    /// Those that wait for the lease of an arm, in their order.
    pub(super) fn waits(&self, arm: ArmId) -> impl Iterator<Item = &LeaseRequest> {
        self.requests(arm).filter(|request| !request.asks)
    }

    /// Those that ask the holder of an arm.
    pub(super) fn asks_mut(&mut self, arm: ArmId) -> impl Iterator<Item = &mut LeaseRequest> {
        let requests = self.0.iter_mut().filter_map(Claim::request_mut);
        requests.filter(move |request| request.arm == arm && request.asks)
    }

    /// Takes out the requests of which this holds.
    pub(super) fn take(&mut self, which: impl Fn(&LeaseRequest) -> bool) -> Vec<LeaseRequest> {
        let of = |claim: &mut Claim| claim.request().is_some_and(&which);
        let taken = self.0.extract_if(.., of);
        taken.filter_map(|claim| claim.request().copied()).collect()
    }

    /// Takes out the first of them.
    pub(super) fn take_first(
        &mut self,
        which: impl Fn(&LeaseRequest) -> bool,
    ) -> Option<LeaseRequest> {
        let claim = self.take_claim(|claim| claim.request().is_some_and(&which))?;
        claim.request().copied()
    }

    /// When the first of them is due.
    pub(super) fn next(&self) -> Option<HostInstant> {
        let requests = self.0.iter().filter_map(Claim::request);
        requests.map(|request| request.until).min()
    }

    /// Changes the instants, and gives up the order of claims that have nothing to do with each other.
    pub(super) fn canonical(&mut self, change: impl Fn(HostInstant) -> HostInstant) {
        for request in self.0.iter_mut().filter_map(Claim::request_mut) {
            request.until = change(request.until);
        }
        self.0.sort_by_key(|claim| match claim {
            Claim::Lease(request) => (u8::from(request.asks), request.arm),
            #[cfg(feature = "class")]
            Claim::Turn(_) => (2, ArmId(0)),
            #[cfg(feature = "class")]
            Claim::Job(job) => (3, job.arm),
        });
    }
}

/// Persons who take turns.
#[cfg(feature = "class")]
impl Claims {
    /// Who waits for a turn, in order.
    pub(super) fn places(&self) -> impl Iterator<Item = &Place> {
        self.0.iter().filter_map(|claim| match claim {
            Claim::Turn(place) => Some(place),
            Claim::Lease(_) | Claim::Job(_) => None,
        })
    }

    /// The place of a person who missed a turn.
    pub(super) fn missed_mut(&mut self, person: PersonId) -> Option<&mut Place> {
        let mut places = self.0.iter_mut().filter_map(|claim| match claim {
            Claim::Turn(place) => Some(place),
            Claim::Lease(_) | Claim::Job(_) => None,
        });
        places.find(|place| place.person == person && place.missed)
    }

    /// Notes that a person's turn came and the person did not.
    pub(super) fn miss(&mut self, person: PersonId) {
        for claim in &mut self.0 {
            if let Claim::Turn(place) = claim
                && place.person == person
            {
                place.missed = true;
            }
        }
    }

    pub(super) fn push_place(&mut self, place: Place) {
        self.0.push(Claim::Turn(place));
    }

    /// Puts a place before all others.
    pub(super) fn put_place_first(&mut self, place: Place) {
        self.0.insert(0, Claim::Turn(place));
    }

    /// Takes out the places of which this holds; whether there was one.
    pub(super) fn drop_places(&mut self, which: impl Fn(&Place) -> bool) -> bool {
        let before = self.0.len();
        { &mut self.0 }.retain(|claim| !matches!(claim, Claim::Turn(place) if which(place)));
        before != self.0.len()
    }

    /// Takes out the place of a person, who has one at most.
    pub(super) fn take_place(&mut self, person: PersonId) -> Option<Place> {
        let of = |claim: &Claim| matches!(claim, Claim::Turn(place) if place.person == person);
        match self.take_claim(of)? {
            Claim::Turn(place) => Some(place),
            Claim::Lease(_) | Claim::Job(_) => None,
        }
    }
}

/// Jobs.
#[cfg(feature = "class")]
impl Claims {
    /// The jobs that wait for an arm, in order.
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

    /// Puts a job at a place among those that wait for its arm, from 0; behind them where there are not so many.
    pub(super) fn insert_job(&mut self, claim: JobClaim, place: usize) {
        let of = |other: &Claim| matches!(other, Claim::Job(job) if job.arm == claim.arm);
        let mut others = (0..self.0.len()).filter(|at| of(&self.0[*at]));
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
