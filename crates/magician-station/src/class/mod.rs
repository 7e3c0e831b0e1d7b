//! A class as files have it: its pupils and rules, and the schedule of its arms; and its pages for paper.

mod file;
mod pages;
mod schedule;

pub use file::{ClassFile, ClassRules, Pupil, is_pin};
pub use pages::{codes_page, results_page};
pub(crate) use pages::{picture, picture_svg};
pub use schedule::Schedule;
pub(crate) use schedule::{local_time, offset as offset_of};

/// Why a file of a class or a schedule cannot be used, in words for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClassError(pub String);

impl std::fmt::Display for ClassError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ClassError {}

fn wrong<T>(why: impl Into<String>) -> Result<T, ClassError> {
    Err(ClassError(why.into()))
}

/// A number that nobody can guess, by the keys that the system draws for hash maps.
#[must_use]
pub fn random() -> u64 {
    use std::hash::{BuildHasher, RandomState};
    // A thread draws once and counts on from there: a hash of the count by those keys tells nothing of the next.
    RandomState::new().hash_one(0_u8)
}
