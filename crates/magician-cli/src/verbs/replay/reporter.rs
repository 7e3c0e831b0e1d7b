//! Results of a replay, as text and as JSON.

use magician_protocol::{FieldValue, visible};
use magician_record::replay::{Difference, DifferenceKind, Report};
use serde::Serialize;

use super::failed;
use crate::failure::Failure;
use crate::output::Output;

/// Reports differences as they are found.
pub(super) struct ReplayReporter<'o> {
    out: &'o mut Output,
    json: bool,
}

#[derive(Serialize)]
struct DifferenceObject<'a> {
    /// Seconds since the beginning of the trace.
    time: f64,
    #[serde(skip_serializing_if = "str::is_empty")]
    link: &'a str,
    id: u8,
    command: Option<&'static str>,
    difference: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    field: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    recorded: Option<FieldValue<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    replayed: Option<FieldValue<'a>>,
}

#[derive(Serialize)]
struct Summary {
    requests: u64,
    answers: u64,
    fields: u64,
    ignored: u64,
    unanswered: u64,
    undirected: u64,
    late: u64,
    differences: u64,
}

impl<'o> ReplayReporter<'o> {
    pub(super) fn new(out: &'o mut Output, json: bool) -> Self {
        Self { out, json }
    }

    pub(super) fn flush(&mut self) -> Result<(), Failure> {
        self.out.flush()
    }

    pub(super) fn difference(&mut self, found: &Difference) -> Result<(), Failure> {
        if self.json {
            return self.out.json(&DifferenceObject::of(found));
        }
        let time = found.time.as_micros();
        let (seconds, micros) = (time / 1_000_000, time % 1_000_000);
        let link = visible(&found.link);
        let place = self
            .out
            .paint
            .dim(format!("{seconds}.{micros:06} s  {link}"))
            .to_string();
        self.out.line(format_args!("{place}  {found}"))
    }

    /// Prints the summary. Fails if there was a difference.
    pub(super) fn end(&mut self, report: &Report) -> Result<(), Failure> {
        let summary = Summary {
            requests: report.requests,
            answers: report.answers,
            fields: report.fields,
            ignored: report.ignored,
            unanswered: report.unanswered,
            undirected: report.undirected,
            late: report.late,
            differences: report.found,
        };
        if self.json {
            self.out.json(&summary)?;
        } else {
            self.out.line(in_words(&summary))?;
        }
        match report.found {
            0 => Ok(()),
            1 => Err(failed("1 difference from the recorded session".to_owned())),
            found => Err(failed(format!(
                "{found} differences from the recorded session"
            ))),
        }
    }
}

impl<'a> DifferenceObject<'a> {
    fn of(found: &'a Difference) -> Self {
        let field = match found.what {
            DifferenceKind::Value(field) => Some(field.name),
            _ => None,
        };
        Self {
            time: found.time.as_micros() as f64 / 1e6,
            link: &found.link,
            id: found.id,
            command: Some(found.command).filter(|command| !command.is_empty()),
            difference: found.what.name(),
            field,
            recorded: found.shown(false),
            replayed: found.shown(true),
        }
    }
}

/// Formats as `120 requests, 118 answers the same in 540 fields; 2 unanswered in both`.
fn in_words(summary: &Summary) -> String {
    let several = |count: u64, what: &str| match count {
        1 => format!("1 {what}"),
        count => format!("{count} {what}s"),
    };
    let mut text = format!(
        "{}, {} compared in {}: {}",
        several(summary.requests, "request"),
        several(summary.answers, "answer"),
        several(summary.fields, "field"),
        match summary.differences {
            0 => "no differences".to_owned(),
            count => several(count, "difference"),
        }
    );
    let more = [
        (summary.ignored, "ignored by --ignore"),
        (
            summary.unanswered,
            "unanswered in both, or at the end of the trace",
        ),
        (
            summary.late,
            "poses of the adjacent period, requested within 5 ms of it",
        ),
        (summary.undirected, "packets of unknown direction left out"),
    ];
    for (count, what) in more {
        if count > 0 {
            text += &format!("; {count} {what}");
        }
    }
    text
}
