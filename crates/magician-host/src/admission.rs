//! Admission control: which connection gives way when a listener has too many.
//!
//! Any peer can connect to a listener and then send nothing, or a byte a second. A listener that
//! waits for such a connection locks out users who want to stop an arm. So places are earned by
//! behaviour and not by order of arrival: a connection that has not sent a complete request is a
//! *stranger*; strangers have few places, and the stranger silent for longest gives way to a new
//! one at once. A connection that has shown a *claim* (a login, a frame) gives way to no stranger.
//! Connections from this machine have places that others cannot use up.
//!
//! [`AdmissionTable`] decides this for all listeners: those of the virtual arm and the proxy, HTTP
//! and WebSockets of a station, and the link. It has no clock and does no I/O: the listener reports
//! events and closes the connections that give way.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::time::Duration;

use magician_protocol::HostInstant;

/// Origin of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(clippy::exhaustive_enums, reason = "there is no third place")]
pub enum Origin {
    /// This machine.
    Loopback,
    /// Any other machine.
    Elsewhere,
}

impl Origin {
    /// Origin of a connection whose peer has this address.
    #[must_use]
    pub fn of(address: IpAddr) -> Self {
        if address.to_canonical().is_loopback() {
            // Canonical: an IPv4 peer on a dual-stack socket has the form ::ffff:127.0.0.1.
            Self::Loopback
        } else {
            Self::Elsewhere
        }
    }
}

/// Numbers of connections that a listener admits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(
    clippy::exhaustive_structs,
    reason = "each listener writes its own down"
)]
pub struct AdmissionLimits {
    /// Largest number of strangers from this machine, at least 1.
    pub loopback_strangers: usize,
    /// Largest number of strangers from elsewhere, at least 1.
    pub strangers: usize,
    /// Largest number of connections with a claim.
    pub claims: usize,
    /// Number of places for claims, out of `claims`, that only loopback may take.
    pub kept_for_loopback: usize,
    /// Silence after which a claim gives way to another claim. `None` if claims last until they
    /// end.
    pub idle: Option<Duration>,
}

/// Error if every place for a claim is in use by a connection that does not give way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::exhaustive_structs, reason = "it says one thing")]
pub struct NoPlace;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Standing {
    /// Stranger that has sent no complete request since it came or since its last request was
    /// answered.
    Silent,
    /// Stranger that has sent a complete request without identifying itself.
    Heard,
    /// Claim whose request or reply is still being transferred.
    Slow,
    /// Claim that is being served.
    Served,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    origin: Origin,
    standing: Standing,
    /// Instant at which it got this standing or was last heard, whichever is later.
    since: HostInstant,
    /// Order of arrival, which breaks ties between equal instants.
    arrival: u64,
}

impl Place {
    fn is_claim(&self) -> bool {
        self.standing >= Standing::Slow
    }
}

/// Sort key of the order in which connections give way: by standing, silent first, then the oldest.
fn yields_first<K>((_, place): &(&K, &Place)) -> (Standing, HostInstant, u64) {
    (place.standing, place.since, place.arrival)
}

/// Connections of a listener, by a key of the listener's choice, with what each has shown.
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

    /// True if a connection of this origin would get a place once it shows a claim.
    ///
    /// A listener that refuses new connections at once asks this before [`open`](Self::open).
    #[must_use]
    pub fn has_room(&self, now: HostInstant, origin: Origin) -> bool {
        self.place_for(now, origin, None).is_ok()
    }

    /// Instant at which the stranger that [`open`](Self::open) for this origin would displace has
    /// had `grace` since it got its standing. `None` if that is past, or if a place is free.
    ///
    /// A listener that waits until then gives each connection time to identify itself, however fast
    /// others arrive.
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

    /// Adds a new connection. Returns the connection that gives way to it: the stranger of the same
    /// origin that has been silent longest or, if none is silent, the one whose last request is
    /// oldest.
    #[must_use = "what gives way is to be closed"]
    pub fn open(&mut self, now: HostInstant, key: K, origin: Origin) -> Option<K> {
        // Two connections may arrive at the same instant, so their order is counted.
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

    /// Notes that a connection has sent a complete request. A stranger stays a stranger; a claim is
    /// no longer idle.
    pub fn heard(&mut self, now: HostInstant, key: K) {
        if let Some(place) = self.places.get_mut(&key) {
            place.since = now;
            // Never lowers a claim.
            place.standing = place.standing.max(Standing::Heard);
        }
    }

    /// Notes that a connection has shown a claim while its request or its reply is still being
    /// transferred.
    ///
    /// Until [`claim`](Self::claim) it gives way to other claims, the oldest first. Returns the
    /// connection that gives way to it.
    #[must_use = "what gives way is to be closed"]
    pub fn begin(&mut self, now: HostInstant, key: K) -> Option<K> {
        let origin = self.places.get(&key)?.origin;
        // With all places in use an older slow or idle claim gives way; without one, this claim
        // exceeds the limit.
        let gone = if self.is_full(origin, [Some(key), None]) {
            self.yielding(now, origin, Some(key))
        } else {
            None
        };
        self.stand(now, key, Standing::Slow);
        self.remove(gone)
    }

    /// Notes that a connection has shown a claim and is served from now on. It gives way to no
    /// connection unless claims can be idle. Returns the connection that gives way to it.
    ///
    /// Has no effect on a connection outside the table.
    ///
    /// # Errors
    /// [`NoPlace`]; the connection keeps its standing.
    pub fn claim(&mut self, now: HostInstant, key: K) -> Result<Option<K>, NoPlace> {
        let Some(origin) = self.places.get(&key).map(|place| place.origin) else {
            return Ok(None);
        };
        let gone = self.place_for(now, origin, Some(key))?;
        self.stand(now, key, Standing::Served);
        Ok(self.remove(gone))
    }

    /// Notes that the request of a connection is over: it is a silent stranger again. Returns the
    /// connection that gives way to it.
    #[must_use = "what gives way is to be closed"]
    pub fn end_request(&mut self, now: HostInstant, key: K) -> Option<K> {
        let origin = self.places.get(&key)?.origin;
        self.stand(now, key, Standing::Silent);
        self.make_room(origin, key)
    }

    /// Removes a connection that has ended, or is counted elsewhere.
    pub fn close(&mut self, key: K) {
        self.places.remove(&key);
    }

    /// Removes a stranger because the system has no descriptor for a new connection. Returns it:
    /// from elsewhere before loopback, silent before heard, oldest first.
    #[must_use = "what gives way is to be closed"]
    pub fn shed(&mut self) -> Option<K> {
        let strangers = self.places.iter().filter(|(_, place)| !place.is_claim());
        let first = strangers.min_by_key(|(_, place)| {
            // A local user who wants to stop the arm must be able to connect.
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

    /// Removes a stranger of this origin if there are too many, except `newest`.
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

    /// Largest number of strangers of this origin.
    fn most_strangers(&self, origin: Origin) -> usize {
        let most = match origin {
            Origin::Loopback => self.limits.loopback_strangers,
            Origin::Elsewhere => self.limits.strangers,
        };
        // Without a place for strangers no connection could ever show a claim.
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

    /// Largest number of claims from elsewhere.
    fn most_elsewhere(&self) -> usize {
        let limits = self.limits;
        // Saturates for a listener that reserves more places for loopback than it has.
        limits.claims.saturating_sub(limits.kept_for_loopback)
    }

    /// True if there is no place for another claim of this origin, not counting those in `but`.
    fn is_full(&self, origin: Origin, but: [Option<K>; 2]) -> bool {
        let is_beyond = origin == Origin::Elsewhere
            && self.claims_from(Origin::Elsewhere, but) >= self.most_elsewhere();
        is_beyond || self.claims(but).count() >= self.limits.claims
    }

    /// Finds a place for the claim of connection `of`. Returns `None` if one is free, otherwise the
    /// claim that gives way.
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
        // A claim that exceeds the limit (see `begin`) frees no place when it gives way.
        if gone.is_some() && !self.is_full(origin, [of, gone]) {
            Ok(gone)
        } else {
            Err(NoPlace)
        }
    }

    /// Claim that gives way to another one of this origin: the one not heard for longest. `None` if
    /// no claim gives way.
    fn yielding(&self, now: HostInstant, origin: Origin, but: Option<K>) -> Option<K> {
        let has_yielded = |place: &Place| match (place.standing, self.limits.idle) {
            // An incomplete request has not earned its place yet.
            (Standing::Slow, _) => true,
            (_, Some(idle)) => now - place.since >= idle,
            (_, None) => false,
        };
        let but = [but, None];
        let is_beyond = self.claims_from(Origin::Elsewhere, but) >= self.most_elsewhere();
        let spare = self.claims_from(Origin::Loopback, but) > self.limits.kept_for_loopback;
        // A claim from elsewhere may displace one from loopback only above the reserved places.
        let may_go = |place: &Place| match (origin, place.origin) {
            (Origin::Loopback, _) | (_, Origin::Elsewhere) => true,
            (Origin::Elsewhere, Origin::Loopback) => spare && !is_beyond,
        };
        let yielding = self.claims(but);
        let yielding = yielding.filter(|(_, place)| has_yielded(place) && may_go(place));
        yielding.min_by_key(yields_first).map(|(key, _)| *key)
    }
}
