//! Places of a listener by the descriptors that its process may have.

use magician::admission::AdmissionLimits;

use crate::station::{SILENT_SOCKETS, SOCKETS};

/// Descriptors that connections leave to everything else: the runtime, arms, files of tokens, programs, recordings and the
/// journal.
const KEPT_FREE: usize = 64;
/// Fewest places of each kind, however few descriptors there are.
const FEWEST: usize = 4;

/// Descriptors that are asked for where a process begins with fewer, as with 256 on macOS: all places fit into them.
#[cfg(unix)]
const USUAL: u64 = 1024;

/// Most descriptors that this process may have, after asking for the usual number. `None` if the system does not tell.
pub(super) fn limit() -> Option<usize> {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, getrlimit, setrlimit};
        let mut limit = getrlimit(Resource::Nofile);
        let most = limit.maximum.unwrap_or(USUAL);
        if limit.current.is_some_and(|now| now < most.min(USUAL)) {
            limit.current = Some(most.min(USUAL));
            // Where it may not be more, there are fewer places.
            let _ = setrlimit(Resource::Nofile, limit);
        }
        usize::try_from(getrlimit(Resource::Nofile).current?).ok()
    }
    #[cfg(not(unix))]
    None
}

/// These places, or as many as there are descriptors for beside sockets and files.
pub(super) fn within(limits: AdmissionLimits, descriptors: Option<usize>) -> AdmissionLimits {
    let wanted = limits.loopback_strangers + limits.strangers + limits.claims;
    let left = descriptors.map_or(wanted, |all| {
        all.saturating_sub(KEPT_FREE + SOCKETS + SILENT_SOCKETS)
    });
    if left >= wanted {
        return limits;
    }
    let share = |places: usize| (places * left / wanted).max(FEWEST);
    let claims = share(limits.claims);
    AdmissionLimits {
        loopback_strangers: share(limits.loopback_strangers),
        strangers: share(limits.strangers),
        claims,
        kept_for_loopback: share(limits.kept_for_loopback).min(claims / 2),
        idle: limits.idle,
    }
}

#[cfg(test)]
mod tests {
    use super::super::listen::LIMITS;
    use super::*;

    #[test]
    fn connections_leave_descriptors_for_files() {
        for descriptors in [240, 256, 300, 512, 800] {
            let limits = within(LIMITS, Some(descriptors));
            let places = limits.loopback_strangers + limits.strangers + limits.claims;
            let used = places + SOCKETS + SILENT_SOCKETS + KEPT_FREE;
            assert!(used <= descriptors, "{descriptors}: {limits:?}");
            assert!(limits.kept_for_loopback < limits.claims);
        }
    }

    #[test]
    fn usual_number_of_descriptors_changes_nothing() {
        for descriptors in [None, Some(1024), Some(usize::MAX)] {
            assert_eq!(within(LIMITS, descriptors), LIMITS);
        }
        let few = within(LIMITS, Some(0));
        assert_eq!((few.strangers, few.kept_for_loopback), (FEWEST, 2));
    }
}
