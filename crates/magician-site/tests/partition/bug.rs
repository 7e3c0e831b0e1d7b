//! What could be wrong with a site.

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bug {
    /// A line that is lost does not end its socket.
    LineOutlived,
    /// What a station knew of its sessions outlives its kill, without their lines.
    LeaseOutlivesKill,
    /// A station that starts again has forgotten its schedule.
    ScheduleForgotten,
    /// The schedule goes by the clock of whoever spoke last.
    ForeignClock,
}

/// Each bug, and the law that it breaks first.
pub(crate) const BUGS: [(Bug, &str); 4] = [
    (Bug::LineOutlived, "a lease ends with its line"),
    (Bug::LeaseOutlivesKill, "a lease ends with its line"),
    (Bug::ScheduleForgotten, "nobody holds outside of a slot"),
    (Bug::ForeignClock, "nobody holds outside of a slot"),
];
