//! Admission: strangers never displace a claim, and strangers from elsewhere never displace a
//! connection from loopback.

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
enum Standing {
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

/// Admission table under test, with the expected standing of each connection.
struct AdmissionRig {
    table: AdmissionTable<u32>,
    present: BTreeMap<u32, (Origin, Standing)>,
    next: u32,
    now: HostInstant,
}

impl AdmissionRig {
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

    fn set_standing(&mut self, key: u32, standing: Standing) {
        self.present.entry(key).and_modify(|one| one.1 = standing);
    }

    /// Performs an event, and checks that the connection that it evicts, if any, may be evicted.
    fn apply(&mut self, event: Event) {
        self.now += Duration::from_millis(1);
        let before = self.present.clone();
        let (by, evicted) = match event {
            Event::Open(origin) => {
                self.next += 1;
                self.present.insert(self.next, (origin, Standing::Stranger));
                let evicted = self.table.open(self.now, self.next, origin);
                (Some(self.next), evicted)
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
                    let evicted = self.table.begin(self.now, key);
                    self.set_standing(key, Standing::Slow);
                    (Some(key), evicted)
                }
                None => (None, None),
            },
            Event::Claim(at) => match self.nth(at) {
                Some(key) => match self.table.claim(self.now, key) {
                    Ok(evicted) => {
                        self.set_standing(key, Standing::Served);
                        (Some(key), evicted)
                    }
                    Err(NoPlace) => (Some(key), None),
                },
                None => (None, None),
            },
            Event::EndRequest(at) => match self.nth(at) {
                Some(key) => {
                    let evicted = self.table.end_request(self.now, key);
                    self.set_standing(key, Standing::Stranger);
                    (Some(key), evicted)
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
        if let Some(evicted) = evicted {
            let was = before.get(&evicted).copied().expect("one that was there");
            self.present.remove(&evicted);
            let by = by.and_then(|by| self.present.get(&by)).copied();
            assert_ne!(
                was.1,
                Standing::Served,
                "{event:?} took the place of {was:?}"
            );
            if was.1 == Standing::Slow {
                let by = by.expect("somebody").1;
                assert_ne!(
                    by,
                    Standing::Stranger,
                    "{event:?} took the place of {was:?}"
                );
            }
            if let Some((Origin::Elsewhere, Standing::Stranger)) = by {
                assert_eq!(was.0, Origin::Elsewhere, "{event:?} took loopback's place");
            }
        }
        assert_eq!(self.table.len(), self.present.len());
        self.check_limits();
    }

    fn check_limits(&self) {
        let count = |test: &dyn Fn(&(Origin, Standing)) -> bool| {
            self.present.values().filter(|one| test(one)).count()
        };
        let stranger = |of| move |one: &(Origin, Standing)| *one == (of, Standing::Stranger);
        assert!(count(&stranger(Origin::Loopback)) <= LIMITS.loopback_strangers);
        assert!(count(&stranger(Origin::Elsewhere)) <= LIMITS.strangers);
        assert!(count(&|one| one.1 == Standing::Served) <= LIMITS.claims);
        let remote_claim = |one: &(Origin, Standing)| *one == (Origin::Elsewhere, Standing::Served);
        assert!(count(&remote_claim) <= LIMITS.claims - LIMITS.kept_for_loopback);
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
    fn strangers_displace_no_claim_and_remote_ones_no_loopback_connection(
        events in vec(event(), 1..120),
    ) {
        let mut rig = AdmissionRig::new(LIMITS);
        for event in events {
            rig.apply(event);
        }
    }

    #[test]
    fn loopback_stranger_stays_however_many_remote_ones_come(
        before in 0..10_usize,
        after in vec(prop_oneof![Just(None), Just(Some(()))], 1..200),
    ) {
        let mut rig = AdmissionRig::new(LIMITS);
        for _ in 0..before {
            rig.apply(Event::Open(Origin::Elsewhere));
        }
        rig.apply(Event::Open(Origin::Loopback));
        let local = rig.next;
        for heard in after {
            rig.apply(Event::Open(Origin::Elsewhere));
            if heard.is_some() {
                rig.table.heard(rig.now, rig.next);
            }
        }
        prop_assert!(rig.present.contains_key(&local));
        prop_assert_eq!(rig.table.claim(rig.now, local), Ok(None));
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

/// Connections from one origin stay silent. Each arrives 1 ms after the previous one was opened,
/// and waits until the table admits it.
#[test]
fn delayed_connections_leave_each_stranger_its_grace_time() {
    let grace = Duration::from_millis(100);
    for origin in [Origin::Loopback, Origin::Elsewhere] {
        let mut table = AdmissionTable::new(LIMITS);
        let mut opened = BTreeMap::new();
        let mut now = HostInstant::ZERO;
        let mut evicted = 0;
        for key in 0..200 {
            if let Some(at) = table.opens_at(now, origin, grace) {
                assert!(at > now && at <= now + grace);
                now = at;
                assert_eq!(table.opens_at(now, origin, grace), None);
            }
            opened.insert(key, now);
            if let Some(silent) = table.open(now, key, origin) {
                assert!(now - opened[&silent] >= grace, "{silent} at {now:?}");
                evicted += 1;
            }
            now += Duration::from_millis(1);
        }
        assert!(evicted > 190, "{evicted}");
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
    // Strangers that have sent a request give way after silent ones.
    table.heard(later, 0);
    let at = table.opens_at(later, Origin::Elsewhere, grace);
    assert_eq!(at, Some(now + grace));
    assert_eq!(table.claim(later, 1), Ok(None));
    assert_eq!(table.opens_at(later, Origin::Elsewhere, grace), None);
}
