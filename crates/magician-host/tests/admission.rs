//! Admission: whatever strangers do, a claim keeps its place, and so does loopback.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_host::admission::{AdmissionLimits, AdmissionTable, NoPlace, Origin};
use magician_protocol::HostInstant;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const LIMITS: AdmissionLimits = AdmissionLimits {
    loopback_strangers: 2,
    strangers: 3,
    claims: 4,
    kept_for_loopback: 1,
    idle: None,
};

/// Standing of a connection according to the test's own bookkeeping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    Stranger,
    Slow,
    Served,
}

#[derive(Clone, Copy, Debug)]
enum Event {
    Open(Origin),
    Heard(usize),
    Begin(usize),
    Claim(usize),
    EndRequest(usize),
    Close(usize),
    Shed,
}

fn event() -> impl Strategy<Value = Event> {
    let origin = prop_oneof![3 => Just(Origin::Elsewhere), 1 => Just(Origin::Loopback)];
    prop_oneof![
        6 => origin.prop_map(Event::Open),
        2 => (0..40_usize).prop_map(Event::Heard),
        2 => (0..40_usize).prop_map(Event::Begin),
        3 => (0..40_usize).prop_map(Event::Claim),
        1 => (0..40_usize).prop_map(Event::EndRequest),
        1 => (0..40_usize).prop_map(Event::Close),
        1 => Just(Event::Shed),
    ]
}

/// A table, with the test's account of places.
struct Hall {
    table: AdmissionTable<u32>,
    present: BTreeMap<u32, (Origin, Known)>,
    next: u32,
    now: HostInstant,
}

impl Hall {
    fn new(limits: AdmissionLimits) -> Self {
        Self {
            table: AdmissionTable::new(limits),
            present: BTreeMap::new(),
            next: 0,
            now: HostInstant::ZERO,
        }
    }

    fn nth(&self, at: usize) -> Option<u32> {
        let count = self.present.len().max(1);
        self.present.keys().nth(at % count).copied()
    }

    fn is_known(&mut self, key: u32, known: Known) {
        self.present.entry(key).and_modify(|one| one.1 = known);
    }

    /// Performs an event, and checks the connection that gives way against the laws.
    fn live(&mut self, event: Event) {
        self.now += Duration::from_millis(1);
        let before = self.present.clone();
        let (by, gone) = match event {
            Event::Open(origin) => {
                self.next += 1;
                self.present.insert(self.next, (origin, Known::Stranger));
                let gone = self.table.open(self.now, self.next, origin);
                (Some(self.next), gone)
            }
            Event::Heard(at) => {
                let key = self.nth(at);
                if let Some(key) = key {
                    self.table.heard(self.now, key);
                }
                (key, None)
            }
            Event::Begin(at) => match self.nth(at) {
                Some(key) => {
                    let gone = self.table.begin(self.now, key);
                    self.is_known(key, Known::Slow);
                    (Some(key), gone)
                }
                None => (None, None),
            },
            Event::Claim(at) => match self.nth(at) {
                Some(key) => match self.table.claim(self.now, key) {
                    Ok(gone) => {
                        self.is_known(key, Known::Served);
                        (Some(key), gone)
                    }
                    Err(NoPlace) => (Some(key), None),
                },
                None => (None, None),
            },
            Event::EndRequest(at) => match self.nth(at) {
                Some(key) => {
                    let gone = self.table.end_request(self.now, key);
                    self.is_known(key, Known::Stranger);
                    (Some(key), gone)
                }
                None => (None, None),
            },
            Event::Close(at) => {
                let key = self.nth(at);
                if let Some(key) = key {
                    self.table.close(key);
                    self.present.remove(&key);
                }
                (None, None)
            }
            Event::Shed => (None, self.table.shed()),
        };
        if let Some(gone) = gone {
            let was = before.get(&gone).copied().expect("one that was there");
            self.present.remove(&gone);
            let by = by.and_then(|by| self.present.get(&by)).copied();
            assert_ne!(was.1, Known::Served, "{event:?} took the place of {was:?}");
            if was.1 == Known::Slow {
                let by = by.expect("somebody").1;
                assert_ne!(by, Known::Stranger, "{event:?} took the place of {was:?}");
            }
            if let Some((Origin::Elsewhere, Known::Stranger)) = by {
                assert_eq!(was.0, Origin::Elsewhere, "{event:?} took loopback's place");
            }
        }
        assert_eq!(self.table.len(), self.present.len());
        self.count();
    }

    fn count(&self) {
        let count = |test: &dyn Fn(&(Origin, Known)) -> bool| {
            self.present.values().filter(|one| test(one)).count()
        };
        let stranger = |of| move |one: &(Origin, Known)| *one == (of, Known::Stranger);
        assert!(count(&stranger(Origin::Loopback)) <= LIMITS.loopback_strangers);
        assert!(count(&stranger(Origin::Elsewhere)) <= LIMITS.strangers);
        assert!(count(&|one| one.1 == Known::Served) <= LIMITS.claims);
        let far = |one: &(Origin, Known)| *one == (Origin::Elsewhere, Known::Served);
        assert!(count(&far) <= LIMITS.claims - LIMITS.kept_for_loopback);
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 600,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn strangers_take_no_place_of_a_claim_and_those_from_elsewhere_none_of_loopback(
        events in vec(event(), 1..120),
    ) {
        let mut hall = Hall::new(LIMITS);
        for event in events {
            hall.live(event);
        }
    }

    #[test]
    fn stranger_from_loopback_stays_however_many_come_from_elsewhere(
        before in 0..10_usize,
        after in vec(prop_oneof![Just(None), Just(Some(()))], 1..200),
    ) {
        let mut hall = Hall::new(LIMITS);
        for _ in 0..before {
            hall.live(Event::Open(Origin::Elsewhere));
        }
        hall.live(Event::Open(Origin::Loopback));
        let local = hall.next;
        for heard in after {
            hall.live(Event::Open(Origin::Elsewhere));
            if heard.is_some() {
                hall.table.heard(hall.now, hall.next);
            }
        }
        prop_assert!(hall.present.contains_key(&local));
        prop_assert_eq!(hall.table.claim(hall.now, local), Ok(None));
    }
}

fn at(ms: u64) -> HostInstant {
    HostInstant::ZERO + Duration::from_millis(ms)
}

#[test]
fn longest_silent_unclaimed_peer_is_evicted_first() {
    let mut table = AdmissionTable::new(LIMITS);
    for key in 0..3 {
        assert_eq!(table.open(at(key), key, Origin::Elsewhere), None);
    }
    table.heard(at(10), 0);
    assert_eq!(table.open(at(11), 3, Origin::Elsewhere), Some(1));
    assert_eq!(table.open(at(12), 4, Origin::Elsewhere), Some(2));
    table.heard(at(13), 3);
    table.heard(at(14), 4);
    assert_eq!(table.open(at(15), 5, Origin::Elsewhere), Some(0));
}

#[test]
fn slow_claim_gives_way_to_a_claim_and_served_ones_do_not() {
    let mut table = AdmissionTable::new(LIMITS);
    for key in 0..4 {
        assert_eq!(table.open(at(key), key, Origin::Loopback), None);
        assert_eq!(table.begin(at(key), key), None);
    }
    assert_eq!(table.open(at(4), 4, Origin::Loopback), None);
    assert_eq!(table.begin(at(4), 4), Some(0));
    for key in 1..5 {
        assert_eq!(table.claim(at(5), key), Ok(None));
    }
    assert!(!table.has_room(at(6), Origin::Loopback));
    assert_eq!(table.open(at(6), 5, Origin::Loopback), None);
    assert_eq!(table.claim(at(6), 5), Err(NoPlace));
}

#[test]
fn claims_from_elsewhere_leave_a_place_for_loopback() {
    let mut table = AdmissionTable::new(LIMITS);
    for key in 0..3 {
        assert_eq!(table.open(at(key), key, Origin::Elsewhere), None);
        assert_eq!(table.claim(at(key), key), Ok(None));
    }
    assert!(!table.has_room(at(3), Origin::Elsewhere));
    assert!(table.has_room(at(3), Origin::Loopback));
    assert_eq!(table.open(at(3), 3, Origin::Loopback), None);
    assert_eq!(table.claim(at(3), 3), Ok(None));
}

#[test]
fn idle_claim_gives_way_to_a_claim_after_its_time() {
    let idle = Some(Duration::from_millis(100));
    let mut table = AdmissionTable::new(AdmissionLimits { idle, ..LIMITS });
    for key in 0..4 {
        assert_eq!(table.open(at(key), key, Origin::Loopback), None);
        assert_eq!(table.claim(at(key), key), Ok(None));
    }
    table.heard(at(50), 0);
    assert_eq!(table.open(at(99), 4, Origin::Loopback), None);
    assert_eq!(table.claim(at(99), 4), Err(NoPlace));
    assert_eq!(table.claim(at(101), 4), Ok(Some(1)));
}

#[test]
fn strangers_go_first_when_the_system_has_no_descriptors() {
    let mut table = AdmissionTable::new(LIMITS);
    assert_eq!(table.open(at(0), 0, Origin::Loopback), None);
    assert_eq!(table.open(at(1), 1, Origin::Elsewhere), None);
    assert_eq!(table.open(at(2), 2, Origin::Elsewhere), None);
    assert_eq!(table.claim(at(2), 2), Ok(None));
    assert_eq!(table.shed(), Some(1));
    assert_eq!(table.shed(), Some(0));
    assert_eq!(table.shed(), None);
}

/// Connections from one origin arrive every millisecond, each as soon as permitted, and stay
/// silent.
#[test]
fn connections_that_wait_for_their_instant_leave_each_its_grace() {
    let grace = Duration::from_millis(100);
    for origin in [Origin::Loopback, Origin::Elsewhere] {
        let mut table = AdmissionTable::new(LIMITS);
        let mut opened = BTreeMap::new();
        let mut now = HostInstant::ZERO;
        let mut gone = 0;
        for key in 0..200 {
            if let Some(at) = table.opens_at(now, origin, grace) {
                assert!(at > now && at <= now + grace);
                now = at;
                assert_eq!(table.opens_at(now, origin, grace), None);
            }
            opened.insert(key, now);
            if let Some(silent) = table.open(now, key, origin) {
                assert!(now - opened[&silent] >= grace, "{silent} at {now:?}");
                gone += 1;
            }
            now += Duration::from_millis(1);
        }
        assert!(gone > 190, "{gone}");
    }
}

#[test]
fn connection_opens_at_once_if_a_place_is_free_or_a_claim_exists() {
    let grace = Duration::from_secs(1);
    let now = HostInstant::ZERO;
    let mut table = AdmissionTable::new(LIMITS);
    for key in 0..3 {
        assert_eq!(table.opens_at(now, Origin::Elsewhere, grace), None);
        assert_eq!(table.open(now, key, Origin::Elsewhere), None);
    }
    let later = now + Duration::from_millis(400);
    let at = table.opens_at(later, Origin::Elsewhere, grace);
    assert_eq!(at, Some(now + grace));
    assert_eq!(table.opens_at(later, Origin::Loopback, grace), None);
    // Heard ones give way after silent ones.
    table.heard(later, 0);
    let at = table.opens_at(later, Origin::Elsewhere, grace);
    assert_eq!(at, Some(now + grace));
    assert_eq!(table.claim(later, 1), Ok(None));
    assert_eq!(table.opens_at(later, Origin::Elsewhere, grace), None);
}
