//! Limits on connections, derived from the number of file descriptors that the process may have.
//!
//! A process that runs out of descriptors can neither accept a stop nor open a file. So the places
//! of connections are scaled down until enough descriptors stay free for everything else.

use magician::admission::AdmissionLimits;

use crate::station::{MAX_SOCKETS, SILENT_SOCKETS};

/// Descriptors reserved for everything but connections: the runtime, arms, and the files of tokens,
/// programs, recordings and the journal.
const RESERVED_DESCRIPTORS: usize = 64;
/// Least number of places of each kind, however few descriptors there are.
const MIN_PLACES: usize = 4;

/// Number of descriptors that is requested if the process starts with fewer, such as 256 on macOS.
/// All places fit into it.
#[cfg(unix)]
const REQUESTED_DESCRIPTORS: u64 = 1024;

/// Returns the number of descriptors that the process may have, after raising the soft limit if it
/// is low. `None` if the system does not report it.
pub(super) fn limit() -> Option<usize> {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, getrlimit, setrlimit};
        let mut limit = getrlimit(Resource::Nofile);
        let most = limit.maximum.unwrap_or(REQUESTED_DESCRIPTORS);
        if limit
            .current
            .is_some_and(|now| now < most.min(REQUESTED_DESCRIPTORS))
        {
            limit.current = Some(most.min(REQUESTED_DESCRIPTORS));
            // May fail: then the places are scaled down.
            let _ = setrlimit(Resource::Nofile, limit);
        }
        usize::try_from(getrlimit(Resource::Nofile).current?).ok()
    }
    #[cfg(not(unix))]
    None
}

/// Scales the places down to the descriptors that sockets and files leave free.
pub(super) fn within(limits: AdmissionLimits, descriptors: Option<usize>) -> AdmissionLimits {
    let wanted = limits.loopback_strangers + limits.strangers + limits.claims;
    let left = descriptors.map_or(wanted, |all| {
        // A socket needs a descriptor besides those of connections.
        all.saturating_sub(RESERVED_DESCRIPTORS + MAX_SOCKETS + SILENT_SOCKETS)
    });
    if left >= wanted {
        return limits;
    }
    let share = |places: usize| (places * left / wanted).max(MIN_PLACES);
    let claims = share(limits.claims);
    AdmissionLimits {
        loopback_strangers: share(limits.loopback_strangers),
        strangers: share(limits.strangers),
        claims,
        // At least half of the claims stay open to clients from elsewhere.
        kept_for_loopback: share(limits.kept_for_loopback).min(claims / 2),
        idle: limits.idle,
    }
}

#[cfg(test)]
mod tests {
    use super::super::listen::LIMITS;
    use super::*;

    #[test]
    fn connection_limits_reserve_descriptors_for_files() {
        for descriptors in [240, 256, 300, 512, 800] {
            let limits = within(LIMITS, Some(descriptors));
            let places = limits.loopback_strangers + limits.strangers + limits.claims;
            let used = places + MAX_SOCKETS + SILENT_SOCKETS + RESERVED_DESCRIPTORS;
            assert!(used <= descriptors, "{descriptors}: {limits:?}");
            assert!(limits.kept_for_loopback < limits.claims);
        }
    }

    #[test]
    fn default_descriptor_limit_keeps_the_admission_limits() {
        for descriptors in [None, Some(1024), Some(usize::MAX)] {
            assert_eq!(within(LIMITS, descriptors), LIMITS);
        }
        let few = within(LIMITS, Some(0));
        assert_eq!((few.strangers, few.kept_for_loopback), (MIN_PLACES, 2));
    }
}
