//! Faults of lines.

/// Serial line: corrupted, lost and added bytes; lost, late and fragmented frames; a pulled plug;
/// an arm that restarts.
pub(crate) const SERIAL_FAULTS: [&str; 6] = [
    "replace=1e-3,drop=1e-4",
    "flip=5e-4,insert=2e-4,duplicate=2e-4",
    "drop-chunk=0.03,stall=0.01,rechunk=0.1",
    "unplug=4e-3,unplug-ms=700,replace=2e-4",
    "drop-chunk=0.15",
    "reset=2e-3,drop-chunk=0.01",
];

/// Network: lost, late and reordered datagrams; and the same with duplicates.
pub(crate) const NETWORK_FAULTS: [&str; 2] = [
    "drop-chunk=0.05,swap-chunk=0.05,late-chunk=0.02,late-ms=300",
    "drop-chunk=0.05,swap-chunk=0.05,duplicate-chunk=0.01",
];
