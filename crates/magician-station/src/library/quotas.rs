//! Limits up to which a library may be filled.

use std::fmt;

use magician::{Message, message};

use crate::api::Role;

/// Number and size of programs: used, or allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(clippy::exhaustive_structs, reason = "two numbers")]
pub struct LibraryUse {
    /// Number of programs.
    pub programs: usize,
    /// Their total size, bytes.
    pub bytes: u64,
}

impl LibraryUse {
    /// Adds one program of this size.
    #[must_use]
    pub const fn with(self, bytes: u64) -> Self {
        Self {
            programs: self.programs + 1,
            bytes: self.bytes.saturating_add(bytes),
        }
    }
}

/// Limits up to which each role may fill a library.
///
/// Files do not record who stored them, so a quota is a fill level and not a share: students may
/// fill the library up to their level, and the room above it is reserved for teachers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::exhaustive_structs, reason = "a level for each role that puts")]
pub struct LibraryQuotas {
    /// Fill level for students.
    pub students: LibraryUse,
    /// Fill level of the whole library.
    pub all: LibraryUse,
}

impl Default for LibraryQuotas {
    /// 1000 programs and 1 GiB, of which students may fill three quarters. A choice: enough for a
    /// school year, and no threat to an ordinary disk.
    fn default() -> Self {
        const ALL: LibraryUse = LibraryUse {
            programs: 1000,
            bytes: 1024 * 1024 * 1024,
        };
        Self {
            students: LibraryUse {
                programs: ALL.programs / 4 * 3,
                bytes: ALL.bytes / 4 * 3,
            },
            all: ALL,
        }
    }
}

impl LibraryQuotas {
    /// Returns the fill level for a role.
    #[must_use]
    pub fn of(&self, role: Role) -> LibraryUse {
        match role {
            Role::Teacher => self.all,
            Role::Student | Role::Viewer => self.students,
        }
    }

    /// Checks whether a role may store a program of `bytes` beside `others`. `before` is the size
    /// of the program that it replaces, if any; a replacement that does not grow always passes.
    ///
    /// # Errors
    /// [`OverQuota`] if it does not fit.
    pub fn check(
        &self,
        role: Role,
        others: LibraryUse,
        before: Option<u64>,
        bytes: u64,
    ) -> Result<(), OverQuota> {
        let quota = self.of(role);
        let after = others.with(bytes);
        let fits = match before {
            // A smaller replacement passes even above the level, or a full library could not be
            // reduced.
            Some(before) => bytes <= before || after.bytes <= quota.bytes,
            None => after.programs <= quota.programs && after.bytes <= quota.bytes,
        };
        if fits {
            return Ok(());
        }
        let used = before.map_or(others, |before| others.with(before));
        let all = self.all;
        Err(OverQuota {
            role,
            quota,
            all,
            used,
        })
    }

    /// Returns the largest program, bytes, that a role may store beside `others`.
    #[must_use]
    pub fn room(&self, role: Role, others: LibraryUse, before: Option<u64>) -> u64 {
        let room = self.of(role).bytes.saturating_sub(others.bytes);
        // A replacement of the same size always fits.
        room.max(before.unwrap_or(0))
    }
}

/// Refusal of a program that exceeds a quota.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::exhaustive_structs, reason = "what a refusal says")]
pub struct OverQuota {
    /// Role of the request.
    pub role: Role,
    /// Fill level for that role.
    pub quota: LibraryUse,
    /// Fill level of the library.
    pub all: LibraryUse,
    /// Current use.
    pub used: LibraryUse,
}

impl OverQuota {
    /// Returns the refusal as a sentence.
    #[must_use]
    pub fn sentence(&self) -> Message {
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let (quota, all, used) = (self.quota, self.all, self.used);
        let (programs, whole) = (all.programs, mib(all.bytes));
        let (count, size) = (used.programs, mib(used.bytes));
        if quota == all {
            message!(
                "the library takes {programs} programs and {whole} MiB, and {count} with {size:.1} \
                    MiB are used: remove some",
                programs,
                whole,
                count,
                size
            )
        } else {
            message!(
                "students may fill {own} of the {programs} programs and {part} of the {whole} MiB \
                    of the library, and {count} with {size:.1} MiB are used: remove some",
                own = quota.programs,
                programs,
                part = mib(quota.bytes),
                whole,
                count,
                size
            )
        }
    }
}

impl fmt::Display for OverQuota {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence())
    }
}
