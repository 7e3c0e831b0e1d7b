//! Ctrl-Z while a job runs, as a state machine without terminal and arm.
//!
//! On a request to suspend, the job pauses, the terminal is restored, and the process stops. When
//! it is continued, the job resumes, with two exceptions: it stays paused if the user had paused it
//! before, or if it burns, because only a person may light the laser again.

use magician_job::PauseError;

use crate::interrupt::Control;

/// Next action of the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SuspensionAction {
    Nothing,
    /// Pause the job and report the result to [`Suspension::paused`].
    Pause,
    /// Restore the terminal and stop this process.
    Stop,
    /// Take the terminal again and resume the job.
    Continue,
    /// Take the terminal again; the job stays paused.
    Stay {
        /// True if it stays paused only because it burns.
        dark: bool,
    },
    /// No reaction: the job is ending, and this program with it.
    End,
}

/// Progress of a suspension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    #[default]
    Idle,
    /// The job has been asked to pause.
    Pausing,
    /// The process has been stopped.
    Stopped,
}

/// Suspension of a job.
#[derive(Debug)]
pub(super) struct Suspension {
    phase: Phase,
    burns: bool,
    /// True if the user wants the job paused, whatever happens to this process.
    paused_by_user: bool,
    /// True if the process was continued before it had stopped.
    cancelled: bool,
    /// True if another request to suspend came after the process was stopped.
    suspend_again: bool,
}

impl Suspension {
    pub(super) const fn new(burns: bool) -> Self {
        Self {
            phase: Phase::Idle,
            burns,
            paused_by_user: false,
            cancelled: false,
            suspend_again: false,
        }
    }

    /// Records that the user pauses or resumes the job.
    pub(super) const fn note_user_pause(&mut self, paused_by_user: bool) {
        self.paused_by_user = paused_by_user;
    }

    /// Handles an event of job control. `paused` is true if the job is paused or pausing.
    pub(super) fn handle_control(&mut self, control: Control, paused: bool) -> SuspensionAction {
        match (self.phase, control) {
            (Phase::Idle, Control::Continue) => SuspensionAction::Nothing,
            (Phase::Idle, Control::Suspend) => {
                self.phase = Phase::Pausing;
                self.paused_by_user |= paused;
                (self.cancelled, self.suspend_again) = (false, false);
                SuspensionAction::Pause
            }
            (Phase::Pausing, control) => {
                self.cancelled = control == Control::Continue;
                SuspensionAction::Nothing
            }
            (Phase::Stopped, Control::Suspend) => {
                self.suspend_again = true;
                SuspensionAction::Nothing
            }
            (Phase::Stopped, Control::Continue) if self.suspend_again => {
                self.suspend_again = false;
                SuspensionAction::Stop
            }
            (Phase::Stopped, Control::Continue) => self.continued(),
        }
    }

    /// Handles the result of pausing.
    pub(super) fn handle_pause(&mut self, paused: Result<(), PauseError>) -> SuspensionAction {
        match paused {
            Err(_) => {
                self.phase = Phase::Idle;
                SuspensionAction::End
            }
            Ok(()) if self.cancelled => self.continued(),
            Ok(()) => {
                self.phase = Phase::Stopped;
                SuspensionAction::Stop
            }
        }
    }

    const fn continued(&mut self) -> SuspensionAction {
        self.phase = Phase::Idle;
        if self.paused_by_user {
            SuspensionAction::Stay { dark: false }
        } else if self.burns {
            self.paused_by_user = true;
            SuspensionAction::Stay { dark: true }
        } else {
            SuspensionAction::Continue
        }
    }
}

#[cfg(test)]
mod tests {
    use Control::{Continue, Suspend};
    use SuspensionAction as Action;

    use super::*;

    #[test]
    fn job_pauses_before_the_process_stops_and_continues_with_it() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.handle_control(Suspend, false), Action::Pause);
        assert_eq!(suspension.handle_pause(Ok(())), Action::Stop);
        assert_eq!(suspension.handle_control(Continue, true), Action::Continue);
        assert_eq!(suspension.handle_control(Continue, false), Action::Nothing);
        assert_eq!(suspension.handle_control(Suspend, false), Action::Pause);
    }

    #[test]
    fn burning_or_previously_paused_job_stays_paused() {
        let mut suspension = Suspension::new(true);
        for dark in [true, false] {
            assert_eq!(suspension.handle_control(Suspend, !dark), Action::Pause);
            assert_eq!(suspension.handle_pause(Ok(())), Action::Stop);
            assert_eq!(
                suspension.handle_control(Continue, true),
                Action::Stay { dark }
            );
        }
        // After the user has resumed the job, suspension works as at first.
        suspension.note_user_pause(false);
        assert_eq!(suspension.handle_control(Suspend, false), Action::Pause);
        assert_eq!(suspension.handle_pause(Ok(())), Action::Stop);
        assert_eq!(
            suspension.handle_control(Continue, true),
            Action::Stay { dark: true }
        );

        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.handle_control(Suspend, false), Action::Pause);
        // The user pauses by a JSON line while the suspension is in progress.
        suspension.note_user_pause(true);
        assert_eq!(suspension.handle_pause(Ok(())), Action::Stop);
        assert_eq!(
            suspension.handle_control(Continue, true),
            Action::Stay { dark: false }
        );
    }

    #[test]
    fn repeated_suspend_is_ignored_and_continue_cancels_it() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.handle_control(Suspend, false), Action::Pause);
        assert_eq!(suspension.handle_control(Suspend, true), Action::Nothing);
        assert_eq!(suspension.handle_control(Continue, true), Action::Nothing);
        assert_eq!(suspension.handle_control(Suspend, true), Action::Nothing);
        assert_eq!(suspension.handle_pause(Ok(())), Action::Stop);
        assert_eq!(suspension.handle_control(Continue, true), Action::Continue);
        assert_eq!(suspension.handle_control(Suspend, false), Action::Pause);
        assert_eq!(suspension.handle_control(Continue, true), Action::Nothing);
        assert_eq!(suspension.handle_pause(Ok(())), Action::Continue);
    }

    #[test]
    fn suspend_during_continue_is_executed_afterwards() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.handle_control(Suspend, false), Action::Pause);
        assert_eq!(suspension.handle_pause(Ok(())), Action::Stop);
        assert_eq!(suspension.handle_control(Suspend, true), Action::Nothing);
        assert_eq!(suspension.handle_control(Continue, true), Action::Stop);
        assert_eq!(suspension.handle_control(Continue, true), Action::Continue);
    }

    #[test]
    fn job_that_ends_while_pausing_is_not_awaited_again() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.handle_control(Suspend, false), Action::Pause);
        assert_eq!(
            suspension.handle_pause(Err(PauseError::Ending)),
            Action::End
        );
    }
}
