//! Settings that a verb changes temporarily and restores, and the note about them.

pub(crate) use magician_job::{Access, RecoveredSettings, SavedSettings};

/// Returns the note for the user; `None` if there is nothing to report.
pub(crate) fn note(settled: &RecoveredSettings) -> Option<String> {
    let before = "an earlier command ended without restoring the arm's settings";
    Some(match settled {
        RecoveredSettings::Nothing => return None,
        RecoveredSettings::Restored(names) => {
            format!("{before}; restored now: {}", names.join(", "))
        }
        RecoveredSettings::Outstanding(names) => format!(
            "{before}; the next command that moves or sets restores: {}",
            names.join(", ")
        ),
        RecoveredSettings::Deferred(names) => format!(
            "{before}; the first command after the arm's queue is empty restores: {}",
            names.join(", ")
        ),
        RecoveredSettings::Damaged(path) => format!(
            "{before}, and {path} is damaged: compare the speeds with `magician get PTPCommonParams` and `magician get CPParams`"
        ),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    })
}
