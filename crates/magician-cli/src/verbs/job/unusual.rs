//! Jobs that are probably a mistake: a drawing scaled below a tenth, or more than two hours of work.

use std::time::Duration;

use magician::words::Preflight;
use magician::{JointAngles, ToolBias};
use magician_program::{AppliedPlacement, Diagnostic, DiagnosticCode, Report};

use super::Made;
use super::tell::clock;
use crate::context::Context;
use crate::failure::Failure;
use crate::permission::Asks;

/// A job that takes longer than this is asked about.
const LONG: Duration = Duration::from_secs(2 * 3600);

impl Made {
    /// Warnings about the job, from the result of a check.
    pub(super) fn warnings(&self, report: &Report) -> Vec<Diagnostic> {
        let mut warnings = Vec::new();
        if let Some(placed) = self.placed.filter(AppliedPlacement::is_tiny) {
            let percent = 100.0 * placed.scale;
            let what = format!("it becomes very small: {percent:.1} % of its size");
            warnings.push(Diagnostic::of_file(what).coded(DiagnosticCode::Placed));
        }
        if let Some(time) = report.time.filter(|time| *time > LONG) {
            let what = format!("it takes {}", clock(time));
            warnings.push(Diagnostic::of_file(what).coded(DiagnosticCode::Long));
        }
        warnings
    }

    /// Asks for confirmation before a real arm begins an unusual job.
    pub(super) fn confirm_unusual(
        &self,
        from: u64,
        asks: Asks,
        context: &mut Context,
    ) -> Result<(), Failure> {
        let start = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
        let rest = self.program.remaining(from, start);
        let report = rest
            .map_err(|problem| self.source.failure(&problem))?
            .check();
        let warnings: Vec<String> = (self.warnings(&report).into_iter())
            .map(|warning| warning.message)
            .collect();
        if warnings.is_empty() {
            return Ok(());
        }
        context.confirm(asks, &warnings.join(", and "))
    }
}
