//! Rates of faults, and their text form.

use std::fmt;
use std::str::FromStr;

use crate::connection::Micros;
use crate::{Error, Result};

/// Rates of faults, with the seed.
///
/// Rates are probabilities from 0 to 1. A byte has at most one fault, so the sum of the rates of
/// bytes is at most 1. A chunk is the input of one push: a frame, a write, a datagram. The text
/// form is a list of `key=value` separated by commas, in any order; omitted faults are off:
///
/// | key | fault |
/// |---|---|
/// | `replace` | a byte is replaced by another value |
/// | `flip` | one bit of a byte is flipped |
/// | `drop` | a byte is lost |
/// | `insert` | an extra byte is inserted before this one |
/// | `duplicate` | a byte is duplicated |
/// | `swap` | a byte is swapped with the next one of its chunk |
/// | `drop-chunk` | a chunk is lost |
/// | `duplicate-chunk` | a chunk is duplicated |
/// | `swap-chunk` | a chunk waits for at most `hold-ms` (50) to be overtaken by the next one: reordered, or late |
/// | `late-chunk` | a chunk is delayed by up to `late-ms` (500) and may be overtaken meanwhile, as datagrams are |
/// | `stall` | the line stalls at a chunk for `stall-min-ms` (0) to `stall-ms` (100) |
/// | `rechunk` | a chunk is delivered in up to four pieces at different times, or together with the next |
/// | `unplug` | the plug is pulled at a chunk for `unplug-ms` (200); the chunk and everything under way are lost |
/// | `reset` | the controller restarts at a chunk, which is lost |
/// | `only` | `requests` or `replies`: the other direction has no faults |
/// | `seed` | seed of the random numbers (0) |
///
/// ```
/// use magician_host::faults::Faults;
///
/// let faults: Faults = "flip=1e-4, drop=0.05, seed=7".parse()?;
/// assert_eq!((faults.flip, faults.drop, faults.seed), (1e-4, 0.05, 7));
/// assert_eq!(faults.to_string(), "flip=1e-4,drop=5e-2,seed=7");
/// let error = "flop=1".parse::<Faults>().unwrap_err();
/// assert!(error.to_string().contains("flip"));
/// # Ok::<(), magician_host::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faults {
    /// Rate of bytes replaced by another value.
    pub replace: f64,
    /// Rate of bytes with one bit flipped.
    pub flip: f64,
    /// Rate of bytes lost.
    pub drop: f64,
    /// Rate of bytes before which another one is inserted.
    pub insert: f64,
    /// Rate of bytes duplicated.
    pub duplicate: f64,
    /// Rate of bytes swapped with the next one of their chunk.
    pub swap: f64,
    /// Rate of chunks lost.
    pub drop_chunk: f64,
    /// Rate of chunks duplicated.
    pub duplicate_chunk: f64,
    /// Rate of chunks that wait to be overtaken by the next one.
    pub swap_chunk: f64,
    /// Rate of chunks delayed individually.
    pub late_chunk: f64,
    /// Rate of chunks at which the line stalls.
    pub stall: f64,
    /// Rate of chunks delivered in other pieces.
    pub rechunk: f64,
    /// Rate of chunks at which the plug is pulled.
    pub unplug: f64,
    /// Rate of chunks at which the controller restarts.
    pub reset: f64,
    /// Longest wait of a chunk for the next one to overtake it, us.
    pub hold_for: Micros,
    /// Longest delay of an individually delayed chunk, us.
    pub late_for: Micros,
    /// Shortest stall, us.
    pub stall_least: Micros,
    /// Longest stall, us.
    pub stall_for: Micros,
    /// Time that the plug stays out, us.
    pub unplug_for: Micros,
    /// Direction with the faults. `None` for both.
    pub only: Option<Side>,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// A direction of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// To the arm.
    Requests,
    /// From the arm.
    Replies,
}

impl Faults {
    /// No faults, with seed 0.
    pub const NONE: Self = Self {
        replace: 0.0,
        flip: 0.0,
        drop: 0.0,
        insert: 0.0,
        duplicate: 0.0,
        swap: 0.0,
        drop_chunk: 0.0,
        duplicate_chunk: 0.0,
        swap_chunk: 0.0,
        late_chunk: 0.0,
        stall: 0.0,
        rechunk: 0.0,
        unplug: 0.0,
        reset: 0.0,
        hold_for: 50_000,
        late_for: 500_000,
        stall_least: 0,
        stall_for: 100_000,
        unplug_for: 200_000,
        only: None,
        seed: 0,
    };
}

impl Default for Faults {
    fn default() -> Self {
        Self::NONE
    }
}

/// Access to a number in [`Faults`].
type Field<T> = fn(&mut Faults) -> &mut T;

/// Keys of rates, with access to each. Those of bytes come first.
const RATES: [(&str, Field<f64>); 14] = [
    ("replace", |faults| &mut faults.replace),
    ("flip", |faults| &mut faults.flip),
    ("drop", |faults| &mut faults.drop),
    ("insert", |faults| &mut faults.insert),
    ("duplicate", |faults| &mut faults.duplicate),
    ("swap", |faults| &mut faults.swap),
    ("drop-chunk", |faults| &mut faults.drop_chunk),
    ("duplicate-chunk", |faults| &mut faults.duplicate_chunk),
    ("swap-chunk", |faults| &mut faults.swap_chunk),
    ("late-chunk", |faults| &mut faults.late_chunk),
    ("stall", |faults| &mut faults.stall),
    ("rechunk", |faults| &mut faults.rechunk),
    ("unplug", |faults| &mut faults.unplug),
    ("reset", |faults| &mut faults.reset),
];

/// Keys of times.
const TIMES: [(&str, Field<Micros>); 5] = [
    ("hold-ms", |faults| &mut faults.hold_for),
    ("late-ms", |faults| &mut faults.late_for),
    ("stall-min-ms", |faults| &mut faults.stall_least),
    ("stall-ms", |faults| &mut faults.stall_for),
    ("unplug-ms", |faults| &mut faults.unplug_for),
];

/// Largest time in a text, ms: a minute. Longer ones are mistakes.
const LONGEST_MS: u64 = 60_000;

impl Faults {
    /// True if no fault ever strikes.
    #[must_use]
    pub fn is_none(&self) -> bool {
        // A copy, because the accessors take `&mut`.
        RATES.iter().all(|(_, rate)| *rate(&mut { *self }) == 0.0)
    }

    /// Faults of one direction: these, or no faults if [`only`](Self::only) selects the other.
    /// Unplugging and restarts strike on the way to the arm, unless that direction has no faults.
    #[must_use]
    pub fn on(mut self, side: Side) -> Self {
        match self.only {
            Some(only) if only != side => Self {
                seed: self.seed,
                ..Self::default()
            },
            Some(_) => self,
            // An unplugging or a restart strikes the whole line, so one direction is enough.
            None => {
                if side == Side::Replies {
                    (self.unplug, self.reset) = (0.0, 0.0);
                }
                self
            }
        }
    }

    /// Checks the rates and times.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for a rate outside of 0 to 1,
    /// rates of bytes whose sum exceeds 1, and a shortest stall above the longest.
    pub fn check(&self) -> Result<()> {
        for (key, rate) in RATES {
            let rate = *rate(&mut { *self });
            if !(0.0..=1.0).contains(&rate) {
                return Err(Error::invalid(format!(
                    "the rate '{key}={rate}' is not a probability, 0 to 1"
                )));
            }
        }
        let bytes = self.replace + self.flip + self.drop + self.insert + self.duplicate + self.swap;
        // Ten times 0.1 may add up to slightly more than 1.
        if bytes > 1.0 + 1e-9 {
            return Err(Error::invalid(format!(
                "the rates of bytes (replace, flip, drop, insert, duplicate, swap) are {bytes} \
                 together: at most 1"
            )));
        }
        if self.stall_least > self.stall_for {
            return Err(Error::invalid(format!(
                "'stall-min-ms={}' is more than 'stall-ms={}'",
                self.stall_least / 1000,
                self.stall_for / 1000
            )));
        }
        Ok(())
    }

    fn set(&mut self, key: &str, value: &str) -> Result<()> {
        let bad = |right: &str| Error::invalid(format!("'{key}={value}': {right}"));
        if let Some((_, rate)) = RATES.iter().find(|(name, _)| *name == key) {
            *rate(self) = value
                .parse()
                .map_err(|_| bad("a rate is a number, 0 to 1"))?;
            return Ok(());
        }
        if let Some((_, time)) = TIMES.iter().find(|(name, _)| *name == key) {
            let ms = value.parse::<u64>().ok().filter(|ms| *ms <= LONGEST_MS);
            *time(self) = 1000 * ms.ok_or_else(|| bad("whole milliseconds, at most 60000"))?;
            return Ok(());
        }
        match (key, value) {
            ("seed", seed) => {
                self.seed = seed.parse().map_err(|_| bad("a seed is a whole number"))?;
            }
            ("only", "requests") => self.only = Some(Side::Requests),
            ("only", "replies") => self.only = Some(Side::Replies),
            ("only", _) => return Err(bad("requests or replies")),
            _ => {
                let known = (RATES.iter().map(|(name, _)| *name))
                    .chain(TIMES.iter().map(|(name, _)| *name))
                    .chain(["only", "seed"]);
                return Err(Error::invalid(format!(
                    "unknown fault '{key}'; known are {}",
                    known.collect::<Vec<_>>().join(", ")
                )));
            }
        }
        Ok(())
    }
}

impl FromStr for Faults {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut faults = Self::default();
        let mut seen: Vec<&str> = Vec::new();
        for part in text.split(',').map(str::trim) {
            if part.is_empty() {
                continue;
            }
            let Some((key, value)) = part.split_once('=') else {
                return Err(Error::invalid(format!(
                    "'{part}' is not a fault: write key=value, flip=1e-4 for one"
                )));
            };
            let key = key.trim();
            // Before the check for repetition, so that an invalid value is the error reported.
            faults.set(key, value.trim())?;
            if seen.contains(&key) {
                return Err(Error::invalid(format!("'{key}' is given twice")));
            }
            seen.push(key);
        }
        faults.check()?;
        Ok(faults)
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Mutable only because the table has one accessor for reading and writing.
        let (mut own, mut usual) = (*self, Self::default());
        for (key, rate) in RATES {
            let rate = *rate(&mut own);
            // `{:e}` would write 1e0.
            if rate == 1.0 {
                write!(f, "{key}=1,")?;
            } else if rate != 0.0 {
                write!(f, "{key}={rate:e},")?;
            }
        }
        for (key, time) in TIMES {
            if time(&mut own) != time(&mut usual) {
                write!(f, "{key}={},", *time(&mut own) / 1000)?;
            }
        }
        match self.only {
            Some(Side::Requests) => f.write_str("only=requests,")?,
            Some(Side::Replies) => f.write_str("only=replies,")?,
            None => {}
        }
        write!(f, "seed={}", self.seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    #[test]
    fn every_key_survives_being_written() {
        for (key, _) in RATES {
            let text = format!("{key}=2.5e-1,seed=3");
            assert_eq!(text.parse::<Faults>().unwrap().to_string(), text);
        }
        let all = "replace=1e-1,swap-chunk=1,hold-ms=7,stall-ms=0,unplug-ms=1,only=replies,seed=18446744073709551615";
        assert_eq!(all.parse::<Faults>().unwrap().to_string(), all);
        assert_eq!("".parse::<Faults>().unwrap(), Faults::default());
        assert_eq!(Faults::default().to_string(), "seed=0");
        assert!(Faults::default().is_none());
        assert!(!all.parse::<Faults>().unwrap().is_none());
    }

    #[test]
    fn says_what_is_right() {
        for (text, hint) in [
            ("flop=1", "known are replace, flip"),
            ("flip", "key=value"),
            ("flip=x", "0 to 1"),
            ("flip=1.5", "0 to 1"),
            ("flip=-1", "0 to 1"),
            ("flip=nan", "0 to 1"),
            ("flip=0.6,drop=0.6", "at most 1"),
            ("flip=0.1,flip=0.2", "twice"),
            ("stall-ms=1e3", "milliseconds"),
            ("stall-min-ms=101", "more than 'stall-ms=100'"),
            ("stall-ms=18446744073709551615", "60000"),
            ("only=both", "requests or replies"),
            ("seed=-1", "whole number"),
        ] {
            let error = text.parse::<Faults>().unwrap_err();
            assert_eq!(error.kind(), ErrorKind::InvalidInput);
            assert!(error.to_string().contains(hint), "{text}: {error}");
        }
    }

    #[test]
    fn one_direction_may_be_clean_and_the_plug_is_pulled_once() {
        let faults: Faults = "flip=0.5,unplug=0.5,only=replies".parse().unwrap();
        assert!(faults.on(Side::Requests).is_none());
        assert_eq!(faults.on(Side::Replies), faults);
        let both: Faults = "flip=0.5,unplug=0.5,reset=0.5".parse().unwrap();
        assert_eq!(both.on(Side::Requests), both);
        let replies = both.on(Side::Replies);
        assert_eq!(
            (replies.flip, replies.unplug, replies.reset),
            (0.5, 0.0, 0.0)
        );
    }
}
