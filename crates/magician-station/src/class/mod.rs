//! Classes: the file of pupils and rules, the schedule, and pages to print.

mod file;
mod pages;
mod schedule;

pub use file::{ClassFile, ClassRules, Pupil, is_pin};
pub use pages::{codes_page, results_page};
pub(crate) use pages::{picture, picture_svg};
pub use schedule::Schedule;
pub(crate) use schedule::{local_time, offset as offset_of};

use magician::Message;

/// Reason why a file of a class or a schedule cannot be used, as a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClassError(pub Message);

impl std::fmt::Display for ClassError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ClassError {}

fn invalid<T>(why: impl Into<Message>) -> Result<T, ClassError> {
    Err(ClassError(why.into()))
}

/// Returns an unpredictable number, derived from the random keys that the system gives to hash
/// maps.
#[must_use]
pub fn random() -> u64 {
    use std::hash::{BuildHasher, RandomState};
    // The keys are drawn once per thread and then incremented, but a keyed hash does not reveal the
    // next value.
    RandomState::new().hash_one(0_u8)
}
