//! Jobs that are probably a mistake: a drawing scaled below a tenth, one placed beside the arm, or
//! more than two hours of work.

use magician::preflight::Preflight;
use magician::{JointAngles, ToolBias};
use magician_job::report::warnings;

use super::PreparedJob;
use crate::context::Context;
use crate::failure::Failure;
use crate::permission::ConfirmationSource;

impl PreparedJob {
    /// Asks for confirmation before a real arm begins an unusual job.
    pub(super) fn confirm_unusual(
        &self,
        from: u64,
        asks: ConfirmationSource,
        context: &mut Context,
    ) -> Result<(), Failure> {
        let start = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
        let rest = self.prepared.program.remaining(from, start);
        let report = rest
            .map_err(|problem| self.source.failure(&problem))?
            .check();
        let warnings: Vec<String> = (warnings(&report, self.prepared.placed).into_iter())
            .map(|warning| warning.message.into())
            .collect();
        let beside = self.prepared.placed.and_then(|placed| placed.beside);
        let beside = beside
            .map(|side| format!("it does not fit in front of the arm and is placed at its {side}"));
        let warnings: Vec<String> = beside.into_iter().chain(warnings).collect();
        if warnings.is_empty() {
            return Ok(());
        }
        context.confirm(asks, &warnings.join(", and "))
    }
}
