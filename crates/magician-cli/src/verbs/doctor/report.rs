//! What was found: a line each for people as it comes, one object at the end for programs.

use magician::{Error, ErrorKind};
use serde::Serialize;
use serde_json::Value;

use crate::columns::wrap;
use crate::failure::{Failure, Kind};
use crate::output::Output;

/// Columns of the names of checks.
const NAME: usize = 16;
/// Columns before a finding's text.
const INDENT: usize = NAME + 2;

/// One thing that was looked at.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Finding {
    check: &'static str,
    /// `None`: not looked at, or nothing to judge.
    ok: Option<bool>,
    value: Value,
    unit: Option<&'static str>,
    text: String,
    /// What to do.
    hint: Option<String>,
}

impl Finding {
    fn new(check: &'static str, ok: Option<bool>, text: impl Into<String>) -> Self {
        Self {
            check,
            ok,
            value: Value::Null,
            unit: None,
            text: text.into(),
            hint: None,
        }
    }

    /// As it should be.
    pub(super) fn good(check: &'static str, text: impl Into<String>) -> Self {
        Self::new(check, Some(true), text)
    }

    /// Not as it should be.
    pub(super) fn bad(check: &'static str, text: impl Into<String>) -> Self {
        Self::new(check, Some(false), text)
    }

    /// Good or bad.
    pub(super) fn judged(check: &'static str, ok: bool, text: impl Into<String>) -> Self {
        Self::new(check, Some(ok), text)
    }

    /// Worth knowing, or not looked at.
    pub(super) fn note(check: &'static str, text: impl Into<String>) -> Self {
        Self::new(check, None, text)
    }

    pub(super) fn value(mut self, value: impl Into<Value>) -> Self {
        self.value = value.into();
        self
    }

    pub(super) fn unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit);
        self
    }

    pub(super) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Adds what to do, if it is not as it should be.
    pub(super) fn cure(self, hint: impl Into<String>) -> Self {
        match self.ok {
            Some(true) => self,
            _ => self.hint(hint),
        }
    }
}

/// All findings.
#[derive(Debug, Default, Serialize)]
pub(super) struct Report {
    pub(super) port: Option<String>,
    ok: bool,
    /// The window to set, as far as it is known.
    pub(super) window: Option<usize>,
    pub(super) turnaround_ms: Option<f64>,
    checks: Vec<Finding>,
    #[serde(skip)]
    json: bool,
    /// The last finding says why there is no arm.
    #[serde(skip)]
    ended: bool,
}

impl Report {
    pub(super) fn new(json: bool) -> Self {
        Self {
            json,
            ..Self::default()
        }
    }

    /// Whether people see nothing of the work.
    pub(super) fn quiet(&self) -> bool {
        self.json
    }

    /// How many checks failed.
    pub(super) fn wrong(&self) -> usize {
        let wrong = self.checks.iter().filter(|check| check.ok == Some(false));
        wrong.count()
    }

    /// Notes a finding and shows it.
    pub(super) fn add(&mut self, finding: Finding, out: &mut Output) -> Result<(), Failure> {
        if !self.json {
            show(&finding, out)?;
        }
        self.checks.push(finding);
        Ok(())
    }

    /// A finding with which the search for an arm ends.
    pub(super) fn end(&mut self, finding: Finding, kind: ErrorKind, out: &mut Output) -> Failure {
        let message = finding.text.clone();
        if let Err(failure) = self.add(finding, out) {
            return failure;
        }
        self.ended = true;
        Failure::new(Kind::Driver(kind), message)
    }

    /// The same for an error of the driver, which says what to do itself.
    pub(super) fn end_with(
        &mut self,
        check: &'static str,
        error: Error,
        out: &mut Output,
    ) -> Failure {
        if let Err(failure) = self.add(Finding::bad(check, error.to_string()), out) {
            return failure;
        }
        self.ended = true;
        Failure::from(error)
    }

    /// Whether people know already why there is no arm.
    pub(super) fn explains(&self) -> bool {
        self.ended && !self.json
    }

    /// The one object; `whole` says that the examination came to its end.
    pub(super) fn write_json(&mut self, whole: bool, out: &mut Output) -> Result<(), Failure> {
        self.ok = whole && self.wrong() == 0;
        out.json(self)
    }
}

fn show(finding: &Finding, out: &mut Output) -> Result<(), Failure> {
    let paint = out.paint;
    let name = format!("{:<NAME$}", finding.check.replace('_', " "));
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
    for (at, line) in wrap(
        finding.hint.as_deref().unwrap_or_default(),
        room.saturating_sub(2),
    )
    .iter()
    .enumerate()
    .filter(|_| finding.hint.is_some())
    {
        let arrow = if at == 0 { "→" } else { " " };
        out.line(format_args!("{:INDENT$}{} {line}", "", paint.note(arrow)))?;
    }
    // Over each finding some time passes.
    out.flush()
}
