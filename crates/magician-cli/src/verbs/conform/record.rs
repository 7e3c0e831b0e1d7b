//! Results as JSON: one object per case, and a summary.

use std::time::Duration;

use magician_conform::{Case, Confidence, Mismatch, Outcome, hex};
use serde::Serialize;

use super::{Printer, Tally};
use crate::failure::Failure;
use crate::output::Output;

/// Case as JSON.
#[derive(Serialize)]
pub(super) struct Record<'a> {
    case: &'a str,
    chapter: &'a str,
    title: &'a str,
    source: &'a str,
    confidence: Confidence,
    tags: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<Vec<&'a str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    outcome: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<Details<'a>>,
}

#[derive(Serialize)]
struct Details<'a> {
    line: usize,
    step: &'a str,
    sent: String,
    expected: &'a str,
    got: &'a str,
    received: String,
}

#[derive(Serialize)]
struct Total {
    summary: Summary,
}

#[derive(Serialize)]
struct Summary {
    passed: usize,
    failed: usize,
    skipped: usize,
    seconds: f64,
}

impl<'a> Record<'a> {
    /// Creates the record of a case with its steps, for the list.
    pub(super) fn listed(case: &'a Case) -> Self {
        Self {
            case: &case.id,
            chapter: case.chapter(),
            title: &case.title,
            source: &case.source,
            confidence: case.confidence,
            tags: case.tags(),
            steps: Some(case.steps().collect()),
            outcome: None,
            reason: None,
            failure: None,
        }
    }

    fn done(case: &'a Case, outcome: &'a Outcome) -> Self {
        let (word, reason, failure) = match outcome {
            Outcome::Passed => ("passed", None, None),
            Outcome::Failed(mismatch) => ("failed", None, Some(Details::from(&**mismatch))),
            Outcome::Skipped(reason) => ("skipped", Some(reason.as_str()), None),
        };
        Self {
            steps: None,
            outcome: Some(word),
            reason,
            failure,
            ..Self::listed(case)
        }
    }
}

impl<'a> From<&'a Mismatch> for Details<'a> {
    fn from(mismatch: &'a Mismatch) -> Self {
        Self {
            line: mismatch.line,
            step: &mismatch.step,
            sent: hex(&mismatch.sent),
            expected: &mismatch.expected,
            got: &mismatch.got,
            received: hex(&mismatch.received),
        }
    }
}

/// Writes one object per line.
pub(super) struct Records<'o> {
    pub(super) out: &'o mut Output,
}

impl Printer for Records<'_> {
    fn case(&mut self, case: &Case, outcome: &Outcome) -> Result<(), Failure> {
        self.out.json(&Record::done(case, outcome))?;
        self.out.flush()
    }

    fn end(&mut self, tally: Tally, took: Duration) -> Result<(), Failure> {
        let Tally {
            passed,
            failed,
            skipped,
        } = tally;
        let summary = Summary {
            passed,
            failed,
            skipped,
            seconds: took.as_secs_f64(),
        };
        self.out.json(&Total { summary })
    }
}
