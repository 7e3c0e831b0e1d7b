//! Admission of connections: which one gives way when a listener has more than it can keep.
//!
//! Anybody can connect to a listener and then say nothing, or one byte a second. A listener that waits for such a connection
//! keeps out those who want to stop an arm. So a place is earned by what a connection has shown, not by having come first: a
//! connection that has sent nothing whole is a stranger, strangers have few places of their own, and the one that has been
//! silent longest gives way to a new one at once. What has shown a claim (a login, a frame) gives way to no stranger. Loopback
//! has places that connections from elsewhere cannot use up.
//!
//! [`AdmissionTable`] decides this for all listeners: those of the virtual arm and the proxy, of a station's HTTP and
//! WebSockets, and of the link. It has no clock and does no I/O: the listener tells what happens and closes what gives way.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::time::Duration;

use magician_protocol::HostInstant;

/// Where a connection comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(clippy::exhaustive_enums, reason = "there is no third place")]
pub enum Origin {
    /// This machine.
    Loopback,
    /// Any other machine.
    Elsewhere,
}

impl Origin {
    /// Origin of a connection whose other end has this address.
    #[must_use]
    pub fn of(address: IpAddr) -> Self {
        if address.to_canonical().is_loopback() {
            Self::Loopback
        } else {
            Self::Elsewhere
        }
    }
}

/// Places of a listener.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(
    clippy::exhaustive_structs,
    reason = "each listener writes its own down"
)]
pub struct AdmissionLimits {
    /// Most strangers from this machine, at least 1.
    pub loopback_strangers: usize,
    /// Most strangers from elsewhere, at least 1.
    pub strangers: usize,
    /// Most connections with a claim.
    pub claims: usize,
    /// Places for claims that only loopback may take, of `claims`.
    pub kept_for_loopback: usize,
    /// A claim that was not heard of for this long gives way to another claim. `None` if claims last until they end.
    pub idle: Option<Duration>,
}

/// No place: every place for a claim is in use by a connection that gives way to nobody.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::exhaustive_structs, reason = "it says one thing")]
pub struct NoPlace;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Standing {
    /// Stranger that has sent nothing whole since it came or since its last request was answered.
    Silent,
    /// Stranger that has sent something whole without showing who it is.
    Heard,
    /// Claim whose request is still on its way, or whose answer is.
    Slow,
    /// Claim that is being served.
    Served,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    origin: Origin,
    standing: Standing,
    /// When it took on this standing; of a claim, when it was heard of last.
    since: HostInstant,
    /// Order of arrival, for places of one instant.
    arrival: u64,
}

impl Place {
    fn is_claim(&self) -> bool {
        self.standing >= Standing::Slow
    }
}

/// Order in which connections give way: silent ones first, of these the oldest.
fn yields_first<K>((_, place): &(&K, &Place)) -> (Standing, HostInstant, u64) {
    (place.standing, place.since, place.arrival)
}

/// Connections of a listener by a key of the listener's choice, and what each has shown.
///
/// ```
/// use magician_host::admission::{AdmissionLimits, AdmissionTable, Origin};
/// use magician_protocol::HostInstant;
///
/// let limits = AdmissionLimits {
///     loopback_strangers: 1,
///     strangers: 1,
///     claims: 8,
///     kept_for_loopback: 1,
///     idle: None,
/// };
/// let mut table = AdmissionTable::new(limits);
/// let now = HostInstant::ZERO;
/// assert_eq!(table.open(now, "silent", Origin::Elsewhere), None);
/// assert_eq!(table.open(now, "local", Origin::Loopback), None);
/// assert_eq!(table.open(now, "newer", Origin::Elsewhere), Some("silent"));
/// assert_eq!(table.claim(now, "newer"), Ok(None));
/// assert_eq!(table.open(now, "third", Origin::Elsewhere), None);
/// ```
#[derive(Clone, Debug)]
pub struct AdmissionTable<K> {
    limits: AdmissionLimits,
    places: BTreeMap<K, Place>,
    arrivals: u64,
}

impl<K: Copy + Ord> AdmissionTable<K> {
    /// Creates a table without connections.
    #[must_use]
    pub const fn new(limits: AdmissionLimits) -> Self {
        Self {
            limits,
            places: BTreeMap::new(),
            arrivals: 0,
        }
    }

    /// Number of connections with a place.
    #[must_use]
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// True if no connection has a place.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// True if a connection from there would get a place once it shows a claim. A listener that tells a new connection so at
    /// once asks before [`open`](Self::open).
    #[must_use]
    pub fn has_room(&self, now: HostInstant, origin: Origin) -> bool {
        self.place_for(now, origin, None).is_ok()
    }

    /// Earliest instant at which [`open`](Self::open) for this origin takes no place from a connection that took on its standing
    /// less than `grace` ago. `None` if that is now. A listener that waits for it lets each connection say who it is, however
    /// fast others come.
    #[must_use]
    pub fn opens_at(
        &self,
        now: HostInstant,
        origin: Origin,
        grace: Duration,
    ) -> Option<HostInstant> {
        if self.strangers_from(origin).count() < self.most_strangers(origin) {
            return None;
        }
        let first = self.strangers_from(origin).min_by_key(yields_first)?;
        let at = first.1.since + grace;
        (at > now).then_some(at)
    }

    /// A connection came. Returns the connection that gives way to it: the stranger from the same origin that has been silent
    /// longest or, if none is silent, the one whose request came first.
    #[must_use = "what gives way is to be closed"]
    pub fn open(&mut self, now: HostInstant, key: K, origin: Origin) -> Option<K> {
        self.arrivals += 1;
        let place = Place {
            origin,
            standing: Standing::Silent,
            since: now,
            arrival: self.arrivals,
        };
        self.places.insert(key, place);
        self.make_room(origin, key)
    }

    /// A connection has sent something whole. A stranger stays one; an idle claim is idle no more.
    pub fn heard(&mut self, now: HostInstant, key: K) {
        if let Some(place) = self.places.get_mut(&key) {
            place.since = now;
            place.standing = place.standing.max(Standing::Heard);
        }
    }

    /// A connection has shown a claim, but its request is not whole yet, or its answer not taken. Until [`claim`](Self::claim)
    /// it gives way to other claims, the oldest first. Returns the connection that gives way to it.
    #[must_use = "what gives way is to be closed"]
    pub fn begin(&mut self, now: HostInstant, key: K) -> Option<K> {
        let origin = self.places.get(&key)?.origin;
        let gone = if self.is_full(origin, [Some(key), None]) {
            self.yielding(now, origin, Some(key))
        } else {
            None
        };
        self.stand(now, key, Standing::Slow);
        self.remove(gone)
    }

    /// A connection has shown a claim and is served from now on: it gives way to nobody unless claims can be idle. Returns the
    /// connection that gives way to it.
    ///
    /// Nothing changes for a connection that is not in the table.
    ///
    /// # Errors
    /// [`NoPlace`]; the connection stands as before.
    pub fn claim(&mut self, now: HostInstant, key: K) -> Result<Option<K>, NoPlace> {
        let Some(origin) = self.places.get(&key).map(|place| place.origin) else {
            return Ok(None);
        };
        let gone = self.place_for(now, origin, Some(key))?;
        self.stand(now, key, Standing::Served);
        Ok(self.remove(gone))
    }

    /// The request of a connection is over: it is a silent stranger again. Returns the connection that gives way to it.
    #[must_use = "what gives way is to be closed"]
    pub fn end_request(&mut self, now: HostInstant, key: K) -> Option<K> {
        let origin = self.places.get(&key)?.origin;
        self.stand(now, key, Standing::Silent);
        self.make_room(origin, key)
    }

    /// A connection has ended, or counts elsewhere.
    pub fn close(&mut self, key: K) {
        self.places.remove(&key);
    }

    /// The system has no descriptor for a new connection. Returns the stranger that gives way: from elsewhere before loopback,
    /// silent before heard, oldest first.
    #[must_use = "what gives way is to be closed"]
    pub fn shed(&mut self) -> Option<K> {
        let strangers = self.places.iter().filter(|(_, place)| !place.is_claim());
        let first = strangers.min_by_key(|(_, place)| {
            let is_loopback = place.origin == Origin::Loopback;
            (is_loopback, place.standing, place.since, place.arrival)
        });
        let gone = first.map(|(key, _)| *key);
        self.remove(gone)
    }

    fn stand(&mut self, now: HostInstant, key: K, standing: Standing) {
        if let Some(place) = self.places.get_mut(&key) {
            place.standing = standing;
            place.since = now;
        }
    }

    fn remove(&mut self, gone: Option<K>) -> Option<K> {
        let gone = gone?;
        self.places.remove(&gone).map(|_| gone)
    }

    /// Removes a stranger of this origin if there are too many, but not the one that needs the room.
    fn make_room(&mut self, origin: Origin, newest: K) -> Option<K> {
        if self.strangers_from(origin).count() <= self.most_strangers(origin) {
            return None;
        }
        let others = self.strangers_from(origin);
        let others = others.filter(|(key, _)| **key != newest);
        let gone = others.min_by_key(yields_first).map(|(key, _)| *key);
        self.remove(gone)
    }

    fn strangers_from(&self, origin: Origin) -> impl Iterator<Item = (&K, &Place)> {
        let from_there = move |place: &Place| place.origin == origin && !place.is_claim();
        { self.places.iter() }.filter(move |(_, place)| from_there(place))
    }

    /// Most strangers from there.
    fn most_strangers(&self, origin: Origin) -> usize {
        let most = match origin {
            Origin::Loopback => self.limits.loopback_strangers,
            Origin::Elsewhere => self.limits.strangers,
        };
        most.max(1)
    }

    fn claims(&self, but: [Option<K>; 2]) -> impl Iterator<Item = (&K, &Place)> {
        let claims = self.places.iter().filter(|(_, place)| place.is_claim());
        claims.filter(move |(key, _)| !but.contains(&Some(**key)))
    }

    fn claims_from(&self, origin: Origin, but: [Option<K>; 2]) -> usize {
        let of = |(_, place): &(&K, &Place)| place.origin == origin;
        self.claims(but).filter(of).count()
    }

    /// Most claims from elsewhere.
    fn most_elsewhere(&self) -> usize {
        let limits = self.limits;
        limits.claims.saturating_sub(limits.kept_for_loopback)
    }

    /// True if no place is free for one more claim from there beside all but these.
    fn is_full(&self, origin: Origin, but: [Option<K>; 2]) -> bool {
        let is_beyond = origin == Origin::Elsewhere
            && self.claims_from(Origin::Elsewhere, but) >= self.most_elsewhere();
        is_beyond || self.claims(but).count() >= self.limits.claims
    }

    /// A place for the claim of one connection: free, or that of the claim that is returned.
    fn place_for(
        &self,
        now: HostInstant,
        origin: Origin,
        of: Option<K>,
    ) -> Result<Option<K>, NoPlace> {
        if !self.is_full(origin, [of, None]) {
            return Ok(None);
        }
        let gone = self.yielding(now, origin, of);
        // A request that begins while all places are in use stands beside them: its end makes no place.
        if gone.is_some() && !self.is_full(origin, [of, gone]) {
            Ok(gone)
        } else {
            Err(NoPlace)
        }
    }

    /// The claim that gives way to one more from there, if any does: the one that was not heard of for longest.
    fn yielding(&self, now: HostInstant, origin: Origin, but: Option<K>) -> Option<K> {
        let has_yielded = |place: &Place| match (place.standing, self.limits.idle) {
            (Standing::Slow, _) => true,
            (_, Some(idle)) => now - place.since >= idle,
            (_, None) => false,
        };
        let but = [but, None];
        let is_beyond = self.claims_from(Origin::Elsewhere, but) >= self.most_elsewhere();
        let spare = self.claims_from(Origin::Loopback, but) > self.limits.kept_for_loopback;
        let may_go = |place: &Place| match (origin, place.origin) {
            (Origin::Loopback, _) | (_, Origin::Elsewhere) => true,
            (Origin::Elsewhere, Origin::Loopback) => spare && !is_beyond,
        };
        let yielding = self.claims(but);
        let yielding = yielding.filter(|(_, place)| has_yielded(place) && may_go(place));
        yielding.min_by_key(yields_first).map(|(key, _)| *key)
    }
}
