//! What could be wrong with a site.

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bug {
    /// Whoever has an arm of the name does what was meant for one of them.
    HeardByAll,
    /// A packet that is missing is not missed.
    GapIsFilled,
    /// The request for a session, doubled by the network, opens two.
    OpenedTwice,
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
pub(crate) const BUGS: [(Bug, &str); 7] = [
    (
        Bug::HeardByAll,
        "a command is carried out by the station that is meant",
    ),
    (
        Bug::GapIsFilled,
        "what a line carries is obeyed in order, without a gap",
    ),
    (Bug::OpenedTwice, "a line has one session"),
    (Bug::LineOutlived, "a lease ends with its line"),
    (Bug::LeaseOutlivesKill, "a lease ends with its line"),
    (Bug::ScheduleForgotten, "nobody holds outside of a slot"),
    (Bug::ForeignClock, "nobody holds outside of a slot"),
];
