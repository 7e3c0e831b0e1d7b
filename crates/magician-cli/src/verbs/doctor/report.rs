//! Output of findings: one line each for people as they come, one JSON object at the end for
//! programs.

use std::future::Future;

use magician::report::FenceReport;
use magician_measure::{Diagnosis, DiagnosisObserver, Finding, Measured, NoArm};
use serde::Serialize;
use serde_json::{Value, json};

use crate::columns::wrap;
use crate::failure::{Failure, Kind};

use crate::output::Output;
use crate::progress::{Bar, announce_wait};
use crate::voice::Command;

/// Columns of the checks' names.
const CHECK_WIDTH: usize = 16;
/// Columns before a finding's text.
const INDENT: usize = CHECK_WIDTH + 2;

/// Prints findings for people.
pub(super) struct FindingPrinter<'o> {
    pub(super) out: &'o mut Output,
    /// True with JSON: nothing is printed before the end.
    pub(super) quiet: bool,
}

impl DiagnosisObserver for FindingPrinter<'_> {
    type Failure = Failure;

    fn found(&mut self, finding: &Finding) -> Result<(), Failure> {
        if self.quiet {
            Ok(())
        } else {
            show(finding, self.out)
        }
    }

    fn attend<T>(
        &mut self,
        what: &'static str,
        work: impl Future<Output = T>,
    ) -> impl Future<Output = T> {
        announce_wait(self.quiet, what, work)
    }

    fn count(&mut self, what: &'static str, total: u64) -> impl FnMut(u64) {
        let bar = Bar::begin(self.quiet, what, total);
        move |done| bar.at(done)
    }
}

impl From<NoArm> for Failure {
    fn from(none: NoArm) -> Self {
        match none {
            NoArm::FailedCheck(kind, message) => Self::new(Kind::Driver(kind), message),
            NoArm::Failed(error) => error.into(),
        }
    }
}

/// Finding as JSON.
#[derive(Serialize)]
struct Check<'f> {
    check: &'static str,
    ok: Option<bool>,
    value: Value,
    unit: Option<&'static str>,
    text: &'f str,
    hint: Option<String>,
}

impl<'f> From<&'f Finding> for Check<'f> {
    fn from(finding: &'f Finding) -> Self {
        let value = match &finding.value {
            Measured::Text(text) => json!(text),
            Measured::Count(count) => json!(count),
            Measured::Number(number) => json!(number),
            Measured::Identity {
                name,
                serial_number,
                firmware,
                uptime_s,
            } => json!({
                "name": name, "serial_number": serial_number, "firmware": firmware, "uptime_s": uptime_s,
            }),
            Measured::Fence(fence) => json!(FenceReport::from(&**fence)),
            _ => Value::Null,
        };
        Self {
            check: finding.check,
            ok: finding.ok,
            value,
            unit: finding.unit,
            text: &finding.text,
            hint: hint(finding),
        }
    }
}

/// Returns the advice, worded for the command line.
fn hint(finding: &Finding) -> Option<String> {
    let advice = finding.advice.as_ref()?;
    match (finding.check, &finding.value) {
        ("window", Measured::Count(some)) => Some(format!(
            "--window {some} or MAGICIAN_WINDOW={some} uses it, in programs Options::window({some})"
        )),
        _ => Some(advice.said(&Command)),
    }
}

/// All findings as JSON.
#[derive(Serialize)]
struct Report<'f> {
    port: Option<&'f str>,
    ok: bool,
    window: Option<usize>,
    turnaround_ms: Option<f64>,
    checks: Vec<Check<'f>>,
}

/// Writes the JSON object. `whole` is true if the examination was completed.
pub(super) fn write_json(found: &Diagnosis, whole: bool, out: &mut Output) -> Result<(), Failure> {
    out.json(&Report {
        port: found.port.as_deref(),
        ok: whole && found.wrong() == 0,
        window: found.window,
        turnaround_ms: found.turnaround_ms,
        checks: found.findings.iter().map(Check::from).collect(),
    })
}

fn show(finding: &Finding, out: &mut Output) -> Result<(), Failure> {
    let paint = out.paint;
    let name = format!("{:<CHECK_WIDTH$}", finding.check.replace('_', " "));
    let room = out.width().saturating_sub(INDENT);
    let mut lines = wrap(&finding.text, room).into_iter();
    let first = lines.next().unwrap_or_default();
    let name = paint.name(name);
    match finding.ok {
        Some(true) => out.line(format_args!("{} {name}{first}", paint.good("✓")))?,
        Some(false) => out.line(format_args!("{} {name}{first}", paint.error("✗")))?,
        None => out.line(format_args!("{} {name}{first}", paint.note("-")))?,
    }
    for line in lines {
        out.line(format_args!("{:INDENT$}{line}", ""))?;
    }
    let hint = hint(finding).map_or_else(Vec::new, |hint| wrap(&hint, room.saturating_sub(2)));
    for (at, line) in hint.iter().enumerate() {
        let arrow = if at == 0 { "→" } else { " " };
        out.line(format_args!("{:INDENT$}{} {line}", "", paint.note(arrow)))?;
    }
    // Flushed per finding, since the next may take seconds.
    out.flush()
}
