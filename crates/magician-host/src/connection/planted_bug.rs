//! Safeguards that tests switch off, to prove that a bug there would be noticed. Inactive outside
//! of tests.

/// A safeguard that a test can switch off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(test), allow(dead_code))]
pub(super) enum PlantedBug {
    /// A reply answers any request with its id.
    MatchById,
    /// A request is sent although a reply to an older one of its key may still arrive.
    NoFence,
    /// Any index is accepted.
    AcceptGaps,
    /// A queued command whose reply is lost is retransmitted.
    ResendBlindly,
    /// A damaged frame waits for its rest for ever.
    NoInterByteTimeout,
    /// On an unordered link "lost" is concluded from readings taken too early.
    NoLifetime,
    /// Over datagrams the next command is sent although a copy of the last may still arrive.
    NoDuplicateCheck,
    /// Requests dropped by a stop may be retransmitted.
    ResendAfterStop,
    /// Commands are accepted while a Clear may still be repeated.
    QueueWhileStopping,
    /// A loss in a window is judged while the command behind it is answered.
    JudgeInWindow,
    /// Commands in a window count as confirmed before all earlier frames are answered.
    ConfirmAtOnce,
    /// Reads continue beside queued commands although frames of such pairs were lost.
    PairAfterLoss,
    /// If the controller answers a read before the command ahead of it, the command's reply counts
    /// as that of another host's command.
    OneOrderOnly,
}

#[cfg(test)]
thread_local! {
    static PLANTED: std::cell::Cell<Option<PlantedBug>> = const { std::cell::Cell::new(None) };
}

/// True if this bug is planted.
#[cfg(test)]
pub(super) fn is_planted(bug: PlantedBug) -> bool {
    PLANTED.get() == Some(bug)
}

/// Always false outside of tests.
#[cfg(not(test))]
pub(super) const fn is_planted(_: PlantedBug) -> bool {
    false
}

/// Runs a check with a bug planted. True if the check noticed it.
#[cfg(test)]
pub(super) fn is_noticed(bug: PlantedBug, check: fn()) -> bool {
    PLANTED.set(Some(bug));
    let outcome = std::panic::catch_unwind(check);
    PLANTED.set(None);
    outcome.is_err()
}
