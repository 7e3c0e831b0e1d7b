//! Fault injection: a bad line from a seed, for tests, soak runs and `--faults`.
//!
//! Bytes are replaced, flipped, lost, inserted, duplicated and swapped; datagrams are lost,
//! duplicated and reordered; lines stall, split chunks, are unplugged; the controller
//! restarts. [`Faults`] gives the rates (`flip=1e-4,drop=1e-5,seed=7`), and an [`Injector`] applies
//! them to one direction of a line. It has no I/O and no clock: the same seed and the same input
//! give the same output.
//!
//! ```
//! use magician_host::faults::{Faults, Injector, Passed};
//!
//! let faults: Faults = "drop=1,seed=7".parse()?;
//! let mut line = Injector::new(faults, faults.seed);
//! line.push(0, &[0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6]);
//! assert_eq!(line.poll(0), None, "every byte is lost");
//!
//! let mut line = Injector::new(Faults::default(), 7);
//! line.push(0, b"as it is");
//! assert_eq!(line.poll(0), Some(Passed::Bytes(b"as it is".to_vec())));
//! # Ok::<(), magician_host::Error>(())
//! ```

mod dice;
mod injector;
mod rates;

#[cfg(test)]
mod tests;

pub use dice::Dice;
pub use injector::{Injector, Passed, Tally};
pub use rates::{Faults, Side};
