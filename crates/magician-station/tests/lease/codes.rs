//! Random walks of tries by several names and addresses against the specification of wrong codes,
//! and planted bugs, each of which must be found.

use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::control::{
    CodeLimit, CodeTry, MAX_TRIES_PER_ADDRESS, MAX_TRIES_PER_NAME, TRY_WINDOW, TooManyCodes,
    WrongCodes,
};

const NAMES: [(&str, bool); 3] = [("ada", true), ("ben", true), ("nobody", false)];
const ADDRESSES: [&str; 2] = ["192.168.1.9", "192.168.1.10"];
/// Tries per walk, and number of walks.
const STEPS: usize = 400;
const WALKS: u64 = 40;

type Outcome = Result<CodeTry, TooManyCodes>;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bug {
    /// All names share a count.
    OneCountForAll,
    /// The limit of an address refuses right codes.
    AddressKeepsOut,
    /// A wrong code above the limit of its address does not count for its name.
    FreeGuesses,
    /// All addresses share a count.
    OneAddress,
    /// The reported limit is that of the other bound.
    OtherLimit,
    /// Tries never expire.
    NeverForgotten,
    /// The reported wait is always the whole window.
    WholeWindow,
}

const BUGS: [(Bug, &str); 7] = [
    (Bug::OneCountForAll, "a name below its bound is looked at"),
    (
        Bug::AddressKeepsOut,
        "the right code of a name below its bound gets in",
    ),
    (Bug::FreeGuesses, "five guesses of a name within a minute"),
    (
        Bug::OneAddress,
        "an address below its bound is told of a wrong code",
    ),
    (
        Bug::OtherLimit,
        "the limit is that of the bound that was met",
    ),
    (Bug::NeverForgotten, "the wait is what is left"),
    (Bug::WholeWindow, "the wait is what is left"),
];

#[derive(Clone, Copy, Debug)]
struct Step {
    now: HostInstant,
    name: (&'static str, bool),
    address: &'static str,
    right: bool,
}

/// Counts with a planted bug.
struct Mutant {
    codes: WrongCodes,
    bug: Option<Bug>,
}

impl Mutant {
    fn attempt(&mut self, step: Step) -> Outcome {
        let (mut name, is_pupil) = step.name;
        let (mut now, mut address) = (step.now, step.address);
        match self.bug {
            Some(Bug::OneCountForAll) => name = "all",
            Some(Bug::OneAddress) => address = "all",
            Some(Bug::NeverForgotten) => now = HostInstant::ZERO,
            _ => {}
        }
        let mut copy = self.codes.clone();
        let guessed = copy.attempt(now, name, is_pupil, address, || false);
        let above = matches!(guessed, Err(met) if met.bound == CodeLimit::Address);
        if self.bug == Some(Bug::AddressKeepsOut) && above
            || self.bug == Some(Bug::FreeGuesses) && above && !step.right
        {
            return guessed;
        }
        let outcome = self
            .codes
            .attempt(now, name, is_pupil, address, || step.right);
        outcome.map_err(|met| match self.bug {
            Some(Bug::OtherLimit) => TooManyCodes {
                limit: MAX_TRIES_PER_NAME + MAX_TRIES_PER_ADDRESS - met.limit,
                ..met
            },
            Some(Bug::WholeWindow) => TooManyCodes {
                wait: TRY_WINDOW,
                ..met
            },
            _ => met,
        })
    }
}

/// Random numbers with a fixed seed.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound as u64) as usize
    }
}

/// Checked wrong codes: time, name, address, and true if the address was below its limit.
#[derive(Default)]
struct Attempts(Vec<(HostInstant, &'static str, &'static str, bool)>);

impl Attempts {
    /// Returns the tries that count at this instant, oldest first.
    fn of(
        &self,
        now: HostInstant,
        is: impl Fn(&(HostInstant, &'static str, &'static str, bool)) -> bool,
    ) -> Vec<HostInstant> {
        let counts = self
            .0
            .iter()
            .filter(|guess| now - guess.0 < TRY_WINDOW && is(guess));
        counts.map(|guess| guess.0).collect()
    }
}

/// Returns the first invariant that a walk breaks.
fn walk(seed: u64, bug: Option<Bug>) -> Option<&'static str> {
    let mut random = Random(seed * 2 + 1);
    let mut mutant = Mutant {
        codes: WrongCodes::default(),
        bug,
    };
    let (mut seen, mut now) = (Attempts::default(), HostInstant::ZERO);
    // Every other walk has a flood from one address, so that its limit is reached.
    let flood = seed.is_multiple_of(2);
    for _ in 0..STEPS {
        now += Duration::from_millis([0, 10, 300, 2500][random.below(4)]);
        let of_flood = flood && random.below(4) > 0;
        let nobodies = ["n1", "n2", "n3", "n4", "n5", "n6", "n7", "n8"];
        let name = if of_flood {
            (nobodies[random.below(8)], false)
        } else {
            NAMES[random.below(NAMES.len())]
        };
        let address = ADDRESSES[if of_flood { 0 } else { random.below(2) }];
        let step = Step {
            now,
            name,
            address,
            right: name.1 && random.below(4) == 0,
        };
        let of_name = seen.of(now, |guess| guess.1 == name.0);
        let of_address = seen.of(now, |guess| guess.2 == address && guess.3);
        let left = |counts: &[HostInstant], limit: usize| {
            TRY_WINDOW - (now - counts[counts.len() - limit])
        };
        let outcome = mutant.attempt(step);
        let law = if of_name.len() >= MAX_TRIES_PER_NAME {
            match outcome {
                Err(met) if met.bound == CodeLimit::Name => {
                    violated_limit(met, MAX_TRIES_PER_NAME, left(&of_name, MAX_TRIES_PER_NAME))
                }
                _ => Some("five guesses of a name within a minute"),
            }
        } else if matches!(outcome, Err(met) if met.bound == CodeLimit::Name) {
            match mutant.bug {
                // Never forgetting shows as a reported wait that is wrong.
                Some(Bug::NeverForgotten) => Some("the wait is what is left"),
                _ => Some("a name below its bound is looked at"),
            }
        } else if step.right {
            (outcome != Ok(CodeTry::Right))
                .then_some("the right code of a name below its bound gets in")
        } else {
            let below = of_address.len() < MAX_TRIES_PER_ADDRESS;
            seen.0.push((now, name.0, address, below));
            match outcome {
                Ok(CodeTry::Wrong) if below => None,
                Err(met) if !below => violated_limit(
                    met,
                    MAX_TRIES_PER_ADDRESS,
                    left(&of_address, MAX_TRIES_PER_ADDRESS),
                ),
                Ok(CodeTry::Right) => Some("a wrong code is wrong"),
                _ => Some("an address below its bound is told of a wrong code"),
            }
        };
        if law.is_some() {
            return law;
        }
    }
    None
}

fn violated_limit(met: TooManyCodes, limit: usize, left: Duration) -> Option<&'static str> {
    if met.limit != limit {
        return Some("the limit is that of the bound that was met");
    }
    (met.wait != left || left.is_zero()).then_some("the wait is what is left")
}

#[test]
fn wrong_code_limits_hold_on_random_walks() {
    for seed in 0..WALKS {
        assert_eq!(walk(seed, None), None, "walk {seed}");
    }
}

#[test]
fn every_planted_code_bug_is_found() {
    for (bug, law) in BUGS {
        let found: Vec<_> = (0..WALKS)
            .filter_map(|seed| walk(seed, Some(bug)))
            .collect();
        assert!(found.contains(&law), "{bug:?}: {found:?}");
    }
}

/// A flood of names and addresses uses bounded memory and does not affect a pupil's count.
#[test]
fn unknown_names_and_addresses_are_bounded_but_pupils_kept() {
    let mut codes = WrongCodes::default();
    let now = HostInstant::ZERO;
    for _ in 0..MAX_TRIES_PER_NAME {
        let _ = codes.attempt(now, "ada", true, "10.0.0.1", || false);
    }
    for number in 0..5000 {
        let (name, address) = (format!("nobody {number}"), format!("10.1.0.{number}"));
        let tried = codes.attempt(now, &name, false, &address, || false);
        assert_eq!(tried, Ok(CodeTry::Wrong), "{number}");
    }
    assert!(codes.remembered() <= 600, "{}", codes.remembered());
    let locked = codes.attempt(now, "ada", true, "10.0.0.2", || true);
    assert!(
        locked.is_err(),
        "five wrong codes are not forgotten: {locked:?}"
    );
}
