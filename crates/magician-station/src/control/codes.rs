//! Wrong codes of a class: how many a name and an address may try. Without I/O, clock or text.
//!
//! Two bounds, because they are against two things. That of a name is against guessing: above it no code is looked at, not
//! even the right one. That of an address is against a flood: above it a wrong code costs the address nothing more and tells
//! it nothing, and a right one is let in, because pupils share addresses.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use magician_protocol::HostInstant;

/// Wrong codes of a name within [`WINDOW`]: enough for typing errors, too few for guessing 4 signs.
pub const NAME_TRIES: usize = 5;
/// Wrong codes of an address within [`WINDOW`]: a class behind one access point that mistypes.
pub const ADDRESS_TRIES: usize = 30;
/// For so long a wrong code counts.
pub const WINDOW: Duration = Duration::from_secs(60);
/// Names of nobody, and addresses, that are remembered at a time. The oldest are forgotten, which loses nothing but the
/// count of a name that has no right code, or of one of very many addresses.
const REMEMBERED: usize = 256;

/// Which bound was met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(clippy::exhaustive_enums, reason = "a try has a name and an address")]
pub enum CodeBound {
    /// That of the name: nothing was looked at.
    Name,
    /// That of the address: the code was wrong.
    Address,
}

/// Too many wrong codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(clippy::exhaustive_structs, reason = "a bound, its number, its time")]
pub struct TooManyCodes {
    /// The bound that was met.
    pub bound: CodeBound,
    /// Its number within [`WINDOW`].
    pub limit: usize,
    /// Time until the next try counts as one.
    pub wait: Duration,
}

/// Outcome of a try.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(clippy::exhaustive_enums, reason = "there is no third outcome")]
pub enum CodeTry {
    /// Name and code belong together.
    Right,
    /// They do not.
    Wrong,
}

/// Wrong codes within [`WINDOW`], by name and by address.
///
/// ```
/// use magician_protocol::HostInstant;
/// use magician_station::control::{CodeTry, WrongCodes};
///
/// let mut codes = WrongCodes::default();
/// let now = HostInstant::ZERO;
/// for nobody in 0..100 {
///     let _ = codes.attempt(now, &format!("nobody {nobody}"), false, "192.168.1.9", || false);
/// }
/// // A pupil behind the same address is let in with the right code.
/// assert_eq!(codes.attempt(now, "ada", true, "192.168.1.9", || true), Ok(CodeTry::Right));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct WrongCodes {
    /// Of pupils' names; never forgotten before their time, and as many as a class has at most.
    pupils: Tries,
    /// Of names that no pupil has. They are counted alike, so that the answers do not tell which names there are.
    nobodies: Tries,
    addresses: Tries,
}

impl WrongCodes {
    /// Takes a try of a name from an address. `is_pupil` says whether a pupil has the name, `is_right` looks at the code, and
    /// is asked only if the name is below its bound.
    ///
    /// # Errors
    /// [`TooManyCodes`] of the name, whatever the code; of the address for a wrong code.
    pub fn attempt(
        &mut self,
        now: HostInstant,
        name: &str,
        is_pupil: bool,
        address: &str,
        is_right: impl FnOnce() -> bool,
    ) -> Result<CodeTry, TooManyCodes> {
        for tries in [&mut self.pupils, &mut self.nobodies, &mut self.addresses] {
            tries.forget(now);
        }
        let of_name = if is_pupil {
            &mut self.pupils
        } else {
            &mut self.nobodies
        };
        if let Some(wait) = of_name.wait(now, name, NAME_TRIES) {
            return Err(TooManyCodes {
                bound: CodeBound::Name,
                limit: NAME_TRIES,
                wait,
            });
        }
        if is_right() {
            return Ok(CodeTry::Right);
        }
        // A guess counts for its name also where its address is above its bound: it was one.
        of_name.count(now, name);
        if let Some(wait) = self.addresses.wait(now, address, ADDRESS_TRIES) {
            return Err(TooManyCodes {
                bound: CodeBound::Address,
                limit: ADDRESS_TRIES,
                wait,
            });
        }
        self.addresses.count(now, address);
        while self.nobodies.0.len() > REMEMBERED {
            self.nobodies.forget_oldest();
        }
        while self.addresses.0.len() > REMEMBERED {
            self.addresses.forget_oldest();
        }
        Ok(CodeTry::Wrong)
    }

    /// Names and addresses that are remembered.
    #[must_use]
    pub fn remembered(&self) -> usize {
        self.pupils.0.len() + self.nobodies.0.len() + self.addresses.0.len()
    }
}

/// Instants of wrong codes by key, the oldest first.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct Tries(BTreeMap<String, VecDeque<HostInstant>>);

impl Tries {
    /// Forgets what does not count any more.
    fn forget(&mut self, now: HostInstant) {
        self.0.retain(|_, tries| {
            tries.retain(|at| now - *at < WINDOW);
            !tries.is_empty()
        });
    }

    /// Time until this key is below its bound. `None` if it is.
    fn wait(&self, now: HostInstant, key: &str, limit: usize) -> Option<Duration> {
        let tries = self.0.get(key)?;
        let blocks = tries.len().checked_sub(limit)?;
        tries.get(blocks).map(|at| WINDOW - (now - *at))
    }

    fn count(&mut self, now: HostInstant, key: &str) {
        self.0.entry(key.to_owned()).or_default().push_back(now);
    }

    /// Forgets the key whose last try is the oldest.
    fn forget_oldest(&mut self) {
        let oldest = { self.0.iter() }.min_by_key(|(_, tries)| tries.back().copied());
        if let Some(key) = oldest.map(|(key, _)| key.clone()) {
            self.0.remove(&key);
        }
    }
}
