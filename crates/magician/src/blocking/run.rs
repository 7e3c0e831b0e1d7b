//! Blocking version of a run.

use super::Arm;
use crate::preflight::Preflight;
use crate::{CommandSource, Progress, Result, RunSummary};

/// See [`crate::Run`].
#[derive(Debug)]
#[must_use = "it only runs while it is waited for"]
pub struct Run<C> {
    arm: Arm,
    run: crate::Run<C>,
}

impl<C: CommandSource> Run<C> {
    pub(super) fn new(arm: Arm, run: crate::Run<C>) -> Self {
        Self { arm, run }
    }

    /// See [`crate::Run::along`].
    pub fn along(self, course: Preflight) -> Self {
        Self {
            run: self.run.along(course),
            ..self
        }
    }

    /// See [`crate::Run::wait`].
    ///
    /// # Errors
    /// As there.
    pub fn wait(&mut self, progress: impl FnMut(Progress)) -> Result<RunSummary> {
        self.arm.owner.block(|_| self.run.wait(progress))
    }

    /// See [`crate::Run::is_interrupted`].
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.run.is_interrupted()
    }

    /// See [`crate::Run::ran`].
    #[must_use]
    pub fn ran(&self) -> RunSummary {
        self.run.ran()
    }
}
