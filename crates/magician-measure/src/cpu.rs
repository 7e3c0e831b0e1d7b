use std::time::Duration;

/// Processor time that this process has used, all threads and the system's work for it; `None` where the system does
/// not tell.
#[must_use]
#[cfg(unix)]
pub fn processor_time() -> Option<Duration> {
    use rustix::time::{ClockId, clock_gettime};

    Duration::try_from(clock_gettime(ClockId::ProcessCPUTime)).ok()
}

/// Processor time that this process has used, all threads and the system's work for it; `None` where the system does
/// not tell.
#[must_use]
#[cfg(not(unix))]
pub fn processor_time() -> Option<Duration> {
    None
}
