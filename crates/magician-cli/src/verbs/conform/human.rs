//! Results for people: one line per chapter, and details of failed cases.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_conform::{Case, Mismatch, Outcome, hex, in_words as frame_in_words};
use magician_protocol::{Direction, Frame, FrameBuf};

use super::{Printer, Tally, fitted, in_words};
use crate::failure::Failure;
use crate::output::Output;

/// Columns of the chapters' names.
const CHAPTER_WIDTH: usize = 13;
/// Indentation of the details of a failure, in columns.
const DETAIL_INDENT: usize = 14;

/// Collects the results of a chapter and writes them at its end.
pub(super) struct Lines<'o> {
    out: &'o mut Output,
    details: bool,
    chapter: String,
    tally: Tally,
    /// Failures to describe below the chapter's line.
    failures: Vec<(String, Mismatch)>,
    remarks: Vec<String>,
    reasons: BTreeMap<String, usize>,
}

impl<'o> Lines<'o> {
    pub(super) fn new(out: &'o mut Output, details: bool) -> Self {
        Self {
            out,
            details,
            chapter: String::new(),
            tally: Tally::default(),
            failures: Vec::new(),
            remarks: Vec::new(),
            reasons: BTreeMap::new(),
        }
    }

    fn end_chapter(&mut self) -> Result<(), Failure> {
        if self.chapter.is_empty() {
            return Ok(());
        }
        let paint = self.out.paint;
        let name = format!("{:<CHAPTER_WIDTH$}", self.chapter);
        self.out
            .line(format_args!("{}{}", paint.name(name), in_words(self.tally)))?;
        for remark in std::mem::take(&mut self.remarks) {
            self.out.line(format_args!("  {}", paint.dim(remark)))?;
        }
        for (title, mismatch) in std::mem::take(&mut self.failures) {
            self.failure(&title, &mismatch)?;
        }
        self.tally = Tally::default();
        self.chapter.clear();
        // Flushed per chapter: the next one may take minutes on a real arm.
        self.out.flush()
    }

    fn failure(&mut self, title: &str, mismatch: &Mismatch) -> Result<(), Failure> {
        let paint = self.out.paint;
        self.out
            .line(format_args!("  {} {title}", paint.error("failed")))?;
        let step = match mismatch.line {
            0 => mismatch.step.clone(),
            line => format!("{} (line {line})", mismatch.step),
        };
        self.write_detail("step", &step)?;
        if !mismatch.sent.is_empty() {
            self.write_detail("sent", &hex(&mismatch.sent))?;
            if let Some(frame) = Frame::new(&mismatch.sent) {
                self.write_detail(
                    "",
                    &frame_in_words(&FrameBuf::from(frame), Direction::Request),
                )?;
            }
        }
        self.write_detail("expected", &mismatch.expected)?;
        self.write_detail("got", &mismatch.got)?;
        if mismatch.received.is_empty() {
            Ok(())
        } else {
            self.write_detail("", &hex(&mismatch.received))
        }
    }

    fn write_detail(&mut self, name: &str, text: &str) -> Result<(), Failure> {
        let paint = self.out.paint;
        for (at, part) in fitted(text, DETAIL_INDENT, self.out).iter().enumerate() {
            let name = if at == 0 { name } else { "" };
            let name = format!("{name:<10}");
            self.out
                .line(format_args!("    {}{part}", paint.dim(name)))?;
        }
        Ok(())
    }
}

impl Printer for Lines<'_> {
    fn case(&mut self, case: &Case, outcome: &Outcome) -> Result<(), Failure> {
        if case.chapter() != self.chapter {
            self.end_chapter()?;
            self.chapter = case.chapter().to_owned();
        }
        self.tally.count(outcome);
        match outcome {
            Outcome::Passed => {}
            Outcome::Failed(mismatch) => {
                let (id, title, source) = (&case.id, &case.title, &case.source);
                let title = format!("{id}: {title} [{}: {source}]", case.confidence);
                self.failures.push((title, (**mismatch).clone()));
            }
            Outcome::Skipped(reason) => {
                if self.details {
                    self.remarks.push(format!("skipped {}: {reason}", case.id));
                }
                let kind = reason.split(':').next().unwrap_or_default().to_owned();
                *self.reasons.entry(kind).or_default() += 1;
            }
        }
        Ok(())
    }

    fn end(&mut self, tally: Tally, took: Duration) -> Result<(), Failure> {
        self.end_chapter()?;
        let seconds = took.as_secs_f64();
        self.out.line(format_args!(
            "{:<CHAPTER_WIDTH$}{} in {seconds:.1} s",
            "all",
            in_words(tally)
        ))?;
        for (reason, count) in std::mem::take(&mut self.reasons) {
            self.out.line(format_args!(
                "{:<CHAPTER_WIDTH$}{count} skipped: {reason}",
                ""
            ))?;
        }
        Ok(())
    }
}
