//! Processor time of this process.

use std::time::Duration;

/// Returns the processor time used by this process, including all threads and the system's work for
/// it; `None` if the system does not report it.
#[must_use]
#[cfg(unix)]
pub fn processor_time() -> Option<Duration> {
    use rustix::time::{ClockId, clock_gettime};

    Duration::try_from(clock_gettime(ClockId::ProcessCPUTime)).ok()
}

/// Returns the processor time used by this process, including all threads and the system's work for
/// it; `None` if the system does not report it.
#[must_use]
#[cfg(not(unix))]
pub fn processor_time() -> Option<Duration> {
    None
}
