//! Bugs that tests plant, to show that they would be noticed. Outside of tests there are none.

/// A safeguard that can be taken away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(test), allow(dead_code))]
pub(super) enum PlantedBug {
    /// A reply answers whatever waits for its id.
    MatchById,
    /// A request goes out although an answer to an older one of its key may still come.
    NoFence,
    /// Any index is believed.
    AcceptGaps,
    /// A queued command whose answer is lost is sent again.
    ResendBlindly,
    /// A damaged frame waits for its rest for ever.
    NoInterByteTimeout,
    /// On an unordered link "lost" is concluded from readings made too early.
    NoLifetime,
    /// Over datagrams the next command goes out although a copy of the one before may still come.
    NoDuplicateCheck,
    /// What a stop dropped may go out once more.
    ResendAfterStop,
    /// Commands are accepted while a Clear may still be repeated.
    QueueWhileStopping,
    /// A loss in a window is judged while the command behind it is answered.
    JudgeInWindow,
    /// What was answered in a window counts as confirmed before all that was sent earlier is answered.
    ConfirmAtOnce,
    /// Reads go on beside queued commands although frames of such pairs were lost.
    PairAfterLoss,
    /// A controller that answers a read before the command ahead of it seems to be shared.
    OneOrderOnly,
}

#[cfg(test)]
thread_local! {
    static PLANTED: std::cell::Cell<Option<PlantedBug>> = const { std::cell::Cell::new(None) };
}

/// Whether this bug is planted.
#[cfg(test)]
pub(super) fn planted(flaw: PlantedBug) -> bool {
    PLANTED.get() == Some(flaw)
}

/// Whether this bug is planted: never.
#[cfg(not(test))]
pub(super) const fn planted(_: PlantedBug) -> bool {
    false
}

/// Runs a check with a bug planted; whether the check noticed.
#[cfg(test)]
pub(super) fn is_noticed(flaw: PlantedBug, check: fn()) -> bool {
    PLANTED.set(Some(flaw));
    let outcome = std::panic::catch_unwind(check);
    PLANTED.set(None);
    outcome.is_err()
}
