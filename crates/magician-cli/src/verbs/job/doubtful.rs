//! What a person hardly wants: a drawing that became tiny, a job of many hours.

use std::time::Duration;

use magician::words::Preflight;
use magician::{JointAngles, ToolBias};
use magician_program::{NoteCode, Position, Problem, Report};

use super::Made;
use super::tell::clock;
use crate::context::Context;
use crate::failure::Failure;
use crate::permission::Asks;

/// A job that takes longer than this is asked about.
const LONG: Duration = Duration::from_secs(2 * 3600);

impl Made {
    /// What is doubtful about it, as a check found it.
    pub(super) fn doubts(&self, report: &Report) -> Vec<Problem> {
        let mut doubts = Vec::new();
        if let Some(placed) = self.placed.filter(Position::is_tiny) {
            let percent = 100.0 * placed.scale;
            let what = format!("it becomes very small: {percent:.1} % of its size");
            doubts.push(Problem::of_file(what).coded(NoteCode::Placed));
        }
        if let Some(time) = report.time.filter(|time| *time > LONG) {
            let what = format!("it takes {}", clock(time));
            doubts.push(Problem::of_file(what).coded(NoteCode::Long));
        }
        doubts
    }

    /// Asks a person before a real arm begins with what is doubtful.
    pub(super) fn permit_what_is_doubtful(
        &self,
        from: u64,
        asks: Asks,
        context: &mut Context,
    ) -> Result<(), Failure> {
        let start = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
        let rest = self.program.rest(from, start);
        let report = rest
            .map_err(|problem| self.source.failure(&problem))?
            .check();
        let doubts = self.doubts(&report);
        if doubts.is_empty() {
            return Ok(());
        }
        let doubts: Vec<String> = doubts.into_iter().map(|doubt| doubt.message).collect();
        context.permit_doubtful(asks, &doubts.join(", and "))
    }
}
