//! End of a job as clients see it: state, error and notes.

use magician::{Action, Arm, ErrorCode, ErrorKind, message};
use magician_job::report::{self, Note};
use magician_job::{Fault, JobError, JobOutcome, JournalError};
use magician_program::{Diagnostic, DiagnosticCode, PreparedProgram};
use serde_json::Value;

use super::program::report_value;
use super::world::{self, GripCount};
use crate::api::RpcError;
use crate::job::{self, ApiVoice};
use crate::order::JobEnd;
use crate::reading::to_value;

/// Notes for the holder at the end of a job: outputs left switched on, and grips that picked
/// nothing since `before`.
pub(super) fn notes_of(arm: &Arm, before: Option<GripCount>) -> Vec<Value> {
    let mut left = left_on(arm);
    let now = world::grip_count(arm);
    let before = before.unwrap_or(now);
    // Loading a scenario resets the counters, so they may be lower than before.
    let begun = now.grips.saturating_sub(before.grips);
    // `grips` counts every grip, `picks` only those that picked an object up.
    let missed = begun.saturating_sub(now.picks.saturating_sub(before.picks));
    if missed > 0 {
        let what = if begun == 1 {
            message!(
                "nothing was picked: no object was at the tool when it gripped, or the arm went on \
                    before it held it"
            )
        } else {
            message!(
                "nothing was picked {missed} times of {begun}: no object was at the tool when it \
                    gripped, or the arm went on before it held it",
                missed,
                begun
            )
        };
        let note =
            Diagnostic::of_file(what).help(message!("set the point lower, or let it wait longer"));
        left.push(note.coded(DiagnosticCode::NothingPicked));
    }
    let notes = Note::all(&ApiVoice, &left).into_iter();
    notes.filter_map(|note| to_value(&note).ok()).collect()
}

/// Returns a note for each output that is switched on at the end of a job.
fn left_on(arm: &Arm) -> Vec<Diagnostic> {
    let motors = arm.motors().running().into_iter().map(|motor| {
        let motor = u8::from(motor) + 1;
        let note = message!(
            "motor {motor} runs on until it is stopped, or the lease ends",
            motor
        );
        Diagnostic::of_file(note)
            .remedy(Action::Stop, "stops it")
            .coded(DiagnosticCode::LeftOn)
    });
    motors
        .chain(report::outputs_left_on(&arm.outputs()))
        .collect()
}

/// Returns the end of a job from its outcome.
pub(super) fn end_of(outcome: &JobOutcome, program: &PreparedProgram, digest: &str) -> JobEnd {
    let rounded = |value: f64| (value * 1000.0).round() / 1000.0;
    match outcome {
        Ok(done) => JobEnd {
            state: "done",
            error: None,
            lengths: Some([done.report.drawn, done.report.travelled].map(rounded)),
            notes: Vec::new(),
        },
        Err(error) if error.is_stop() => over("stopped", None),
        Err(error) => match &error.fault {
            Fault::Arm(fault) if fault.code() == ErrorCode::Stopped => over("stopped", None),
            // A lost line is not a fault of the program, so the job counts as interrupted.
            Fault::Arm(fault) if fault.kind() == ErrorKind::Port => {
                over("interrupted", Some(RpcError::from(&**fault)))
            }
            // Everything that is neither a stop nor a broken line.
            _ => over("failed", Some(fault_of(error, program, digest))),
        },
    }
}

pub(super) fn over(state: &'static str, error: Option<RpcError>) -> JobEnd {
    JobEnd {
        error,
        ..JobEnd::new(state)
    }
}

/// Code of the refusal to resume a job without a journal: a client may offer to start it again.
const NOTHING_TO_RESUME: &str = "nothing-to-resume";

fn fault_of(error: &JobError, program: &PreparedProgram, digest: &str) -> RpcError {
    let message = error.to_string();
    match &error.fault {
        Fault::Arm(error) => RpcError::from(&**error),
        Fault::Program(problem) => RpcError::from(magician::Error::from(problem.clone())),
        Fault::Refused { report, rest } => {
            let failed =
                RpcError::new(RpcError::CHECK_FAILED, message).with_sentence(&error.sentence());
            match report_value(&job::check_report(program, rest, report), digest) {
                Ok(report) => failed.with("report", report),
                Err(_) => failed,
            }
        }
        Fault::Doubt { span, .. } => RpcError::arm(ErrorKind::Uncertain, message)
            .with_sentence(&error.sentence())
            .with("from", span.least + 1)
            .with("to", span.most),
        Fault::Journal(JournalError::NotFound | JournalError::OtherPrograms(_)) => {
            RpcError::arm(ErrorKind::InvalidInput, message)
                .with_sentence(&error.sentence())
                .with("code", NOTHING_TO_RESUME)
        }
        // Faults that are neither the arm's nor the program's.
        _ => RpcError::arm(ErrorKind::InvalidInput, message).with_sentence(&error.sentence()),
    }
}
