//! Settings that a verb changes for its own time and gives back, in the words of the command.

pub(crate) use magician_job::{Access, SavedSettings, Settled};

/// The note for the user, if there is something to say.
pub(crate) fn note(settled: &Settled) -> Option<String> {
    let before = "an earlier command ended without restoring the arm's settings";
    Some(match settled {
        Settled::Nothing => return None,
        Settled::Restored(names) => format!("{before}; restored now: {}", names.join(", ")),
        Settled::Left(names) => format!(
            "{before}; the next command that moves or sets restores: {}",
            names.join(", ")
        ),
        Settled::Later(names) => format!(
            "{before}; the first command after the arm's queue is empty restores: {}",
            names.join(", ")
        ),
        Settled::Damaged(path) => format!(
            "{before}, and {path} is damaged: compare the speeds with `magician get PTPCommonParams` and `magician get CPParams`"
        ),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    })
}
