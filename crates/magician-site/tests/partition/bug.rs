//! Planted bugs, which the search has to find.

/// A planted bug.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bug {
    /// The loss of a line does not end its socket.
    LineOutlived,
    /// Sessions of a killed station survive, without their lines.
    LeaseOutlivesKill,
    /// A restarted station has lost its schedule.
    ScheduleForgotten,
    /// The schedule uses the clock of the last sender instead of the station's.
    ForeignClock,
}

/// Each bug, and the first law that it breaks.
pub(crate) const BUGS: [(Bug, &str); 4] = [
    (Bug::LineOutlived, "a lease ends with its line"),
    (Bug::LeaseOutlivesKill, "a lease ends with its line"),
    (Bug::ScheduleForgotten, "nobody holds outside of a slot"),
    (Bug::ForeignClock, "nobody holds outside of a slot"),
];
