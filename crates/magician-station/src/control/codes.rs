//! Rate limits for wrong codes of a class, per name and per address. No I/O, no clock, no text.
//!
//! The two limits answer two threats. The limit of a name stops guessing: while it is exceeded no
//! code is checked, not even the right one. The limit of an address stops a flood: while it is
//! exceeded a wrong code is refused without counting further, but the right code still works,
//! because the pupils of a class share an address.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use magician_protocol::HostInstant;

/// Wrong codes per name within [`TRY_WINDOW`]. Enough for typing errors, too few to guess 4
/// characters.
pub const MAX_TRIES_PER_NAME: usize = 5;
/// Wrong codes per address within [`TRY_WINDOW`]. Enough for a class behind one access point that
/// mistypes.
pub const MAX_TRIES_PER_ADDRESS: usize = 30;
/// Time for which a wrong code counts.
pub const TRY_WINDOW: Duration = Duration::from_secs(60);
/// Most unknown names, and most addresses, that are remembered. When there are more the oldest
/// entry is dropped. That loses only the count of a name without a right code, or of one address
/// among very many.
const MAX_REMEMBERED: usize = 256;

/// Limit that was exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(clippy::exhaustive_enums, reason = "a try has a name and an address")]
pub enum CodeLimit {
    /// Limit of the name: the code was not checked.
    Name,
    /// Limit of the address: the code was wrong.
    Address,
}

/// Refusal because of too many wrong codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(clippy::exhaustive_structs, reason = "a bound, its number, its time")]
pub struct TooManyCodes {
    /// Limit that was exceeded.
    pub bound: CodeLimit,
    /// Value of the limit: tries within [`TRY_WINDOW`].
    pub limit: usize,
    /// Time until the next try is accepted.
    pub wait: Duration,
}

/// Result of a try.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(clippy::exhaustive_enums, reason = "there is no third outcome")]
pub enum CodeTry {
    /// The code belongs to the name.
    Right,
    /// The code does not belong to the name.
    Wrong,
}

/// Counts of wrong codes within [`TRY_WINDOW`], by name and by address.
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
    /// Counts of pupils' names. Not dropped early: a class bounds their number.
    pupils: Tries,
    /// Counts of names that no pupil has. Counted in the same way, so that an answer does not
    /// reveal which names exist.
    unknown_names: Tries,
    addresses: Tries,
}

impl WrongCodes {
    /// Checks a try. `is_pupil` says that a pupil has the name. `is_right` compares the code, and
    /// is called only if the name is below its limit.
    ///
    /// # Errors
    /// [`TooManyCodes`] if the name is above its limit, or if the code is wrong and the address is
    /// above its limit.
    pub fn attempt(
        &mut self,
        now: HostInstant,
        name: &str,
        is_pupil: bool,
        address: &str,
        is_right: impl FnOnce() -> bool,
    ) -> Result<CodeTry, TooManyCodes> {
        for tries in [
            &mut self.pupils,
            &mut self.unknown_names,
            &mut self.addresses,
        ] {
            tries.forget(now);
        }
        let of_name = if is_pupil {
            &mut self.pupils
        } else {
            &mut self.unknown_names
        };
        if let Some(wait) = of_name.wait(now, name, MAX_TRIES_PER_NAME) {
            return Err(TooManyCodes {
                bound: CodeLimit::Name,
                limit: MAX_TRIES_PER_NAME,
                wait,
            });
        }
        // After the limit of the name, before that of the address: the right code passes behind a
        // shared address, but not under guessing.
        if is_right() {
            return Ok(CodeTry::Right);
        }
        // Counts for the name even if the address is above its limit, or many addresses could guess
        // one name.
        of_name.count(now, name);
        if let Some(wait) = self.addresses.wait(now, address, MAX_TRIES_PER_ADDRESS) {
            return Err(TooManyCodes {
                bound: CodeLimit::Address,
                limit: MAX_TRIES_PER_ADDRESS,
                wait,
            });
        }
        self.addresses.count(now, address);
        // Only attackers make many unknown names, so memory is bounded here.
        while self.unknown_names.0.len() > MAX_REMEMBERED {
            self.unknown_names.forget_oldest();
        }
        while self.addresses.0.len() > MAX_REMEMBERED {
            self.addresses.forget_oldest();
        }
        Ok(CodeTry::Wrong)
    }

    /// Returns the number of remembered names and addresses.
    #[must_use]
    pub fn remembered(&self) -> usize {
        self.pupils.0.len() + self.unknown_names.0.len() + self.addresses.0.len()
    }
}

/// Instants of wrong codes by key, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct Tries(BTreeMap<String, VecDeque<HostInstant>>);

impl Tries {
    /// Drops tries older than [`TRY_WINDOW`].
    fn forget(&mut self, now: HostInstant) {
        self.0.retain(|_, tries| {
            tries.retain(|at| now - *at < TRY_WINDOW);
            !tries.is_empty()
        });
    }

    /// Returns the time until the key is below its limit. `None` if it is below now.
    fn wait(&self, now: HostInstant, key: &str, limit: usize) -> Option<Duration> {
        let tries = self.0.get(key)?;
        // The try whose expiry brings the count below the limit.
        let blocks = tries.len().checked_sub(limit)?;
        tries.get(blocks).map(|at| TRY_WINDOW - (now - *at))
    }

    fn count(&mut self, now: HostInstant, key: &str) {
        self.0.entry(key.to_owned()).or_default().push_back(now);
    }

    /// Drops the key whose last try is the oldest.
    fn forget_oldest(&mut self) {
        let oldest = { self.0.iter() }.min_by_key(|(_, tries)| tries.back().copied());
        if let Some(key) = oldest.map(|(key, _)| key.clone()) {
            self.0.remove(&key);
        }
    }
}
