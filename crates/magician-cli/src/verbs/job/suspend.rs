//! Ctrl-Z while a job runs, as a state machine without terminal and arm.
//!
//! On a request to suspend, the job pauses, the terminal is restored, and the process stops. When
//! it is continued, the job resumes, with two exceptions: it stays paused if the user had paused it
//! before, or if it burns, because only a person may light the laser again.

use magician_job::PauseError;

use crate::interrupt::Control;

/// Next action of the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Act {
    Nothing,
    /// Pause the job and report the result to [`Suspension::paused`].
    Pause,
    /// Restore the terminal and stop this process.
    Stop,
    /// Take the terminal again and resume the job.
    GoOn,
    /// Take the terminal again; the job stays paused.
    Stay {
        /// True if it stays paused only because it burns.
        dark: bool,
    },
    /// No reaction: the job is ending, and this program with it.
    Ends,
}

/// Progress of a suspension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    #[default]
    Not,
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
    held: bool,
    /// True if the process was continued before it had stopped.
    cancelled: bool,
    /// True if another request to suspend came after the process was stopped.
    again: bool,
}

impl Suspension {
    pub(super) const fn new(burns: bool) -> Self {
        Self {
            phase: Phase::Not,
            burns,
            held: false,
            cancelled: false,
            again: false,
        }
    }

    /// Records that the user pauses or resumes the job.
    pub(super) const fn holds(&mut self, held: bool) {
        self.held = held;
    }

    /// Handles an event of job control. `paused` is true if the job is paused or pausing.
    pub(super) fn hears(&mut self, control: Control, paused: bool) -> Act {
        match (self.phase, control) {
            (Phase::Not, Control::Continue) => Act::Nothing,
            (Phase::Not, Control::Suspend) => {
                self.phase = Phase::Pausing;
                self.held |= paused;
                (self.cancelled, self.again) = (false, false);
                Act::Pause
            }
            (Phase::Pausing, control) => {
                self.cancelled = control == Control::Continue;
                Act::Nothing
            }
            (Phase::Stopped, Control::Suspend) => {
                self.again = true;
                Act::Nothing
            }
            (Phase::Stopped, Control::Continue) if self.again => {
                self.again = false;
                Act::Stop
            }
            (Phase::Stopped, Control::Continue) => self.goes_on(),
        }
    }

    /// Handles the result of pausing.
    pub(super) fn paused(&mut self, paused: Result<(), PauseError>) -> Act {
        match paused {
            Err(_) => {
                self.phase = Phase::Not;
                Act::Ends
            }
            Ok(()) if self.cancelled => self.goes_on(),
            Ok(()) => {
                self.phase = Phase::Stopped;
                Act::Stop
            }
        }
    }

    const fn goes_on(&mut self) -> Act {
        self.phase = Phase::Not;
        if self.held {
            Act::Stay { dark: false }
        } else if self.burns {
            self.held = true;
            Act::Stay { dark: true }
        } else {
            Act::GoOn
        }
    }
}

#[cfg(test)]
mod tests {
    use Control::{Continue, Suspend};

    use super::*;

    #[test]
    fn a_job_pauses_before_its_program_stops_and_goes_on_with_it() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::GoOn);
        assert_eq!(suspension.hears(Continue, false), Act::Nothing);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
    }

    #[test]
    fn what_burns_or_was_paused_before_stays_paused() {
        let mut suspension = Suspension::new(true);
        for dark in [true, false] {
            assert_eq!(suspension.hears(Suspend, !dark), Act::Pause);
            assert_eq!(suspension.paused(Ok(())), Act::Stop);
            assert_eq!(suspension.hears(Continue, true), Act::Stay { dark });
        }
        // After the user has resumed the job, suspension works as at first.
        suspension.holds(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::Stay { dark: true });

        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        // The user pauses by a JSON line while the suspension is in progress.
        suspension.holds(true);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::Stay { dark: false });
    }

    #[test]
    fn a_second_wish_on_the_way_changes_nothing_and_a_going_on_takes_it_back() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.hears(Suspend, true), Act::Nothing);
        assert_eq!(suspension.hears(Continue, true), Act::Nothing);
        assert_eq!(suspension.hears(Suspend, true), Act::Nothing);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::GoOn);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.hears(Continue, true), Act::Nothing);
        assert_eq!(suspension.paused(Ok(())), Act::GoOn);
    }

    #[test]
    fn a_wish_that_comes_with_the_going_on_is_followed_after_it() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Suspend, true), Act::Nothing);
        assert_eq!(suspension.hears(Continue, true), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::GoOn);
    }

    #[test]
    fn a_job_that_ends_on_the_way_is_not_waited_for_twice() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.paused(Err(PauseError::Ending)), Act::Ends);
    }
}
