//! Results of many drawings over lines of one kind, measured on paper: one row of a table. Also
//! used by `cargo xtask soak lines`.

use std::time::Duration;

use magician::sim::world::Drawing;

use super::ink::Ink;

/// Deviation that cannot be seen, mm: half the arm's repeatability.
pub(crate) const INVISIBLE_DEVIATION: f64 = 0.1;

/// A drawing made over a lossy line.
pub(crate) struct Passage<'d> {
    /// Correct drawing.
    pub(crate) right: &'d Drawing,
    /// Actual drawing.
    pub(crate) drawn: &'d Drawing,
    /// True if it reported success without help.
    pub(crate) done: bool,
    /// Duration.
    pub(crate) took: Duration,
    /// Duration on a good line.
    pub(crate) usual: Duration,
}

/// Drawings over lines of one kind.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    pub(crate) name: String,
    pub(crate) runs: u64,
    /// Number that reported success without help.
    pub(crate) done: u64,
    /// Number that reported success with a wrong drawing: something is missing, extra, or drawn
    /// twice.
    pub(crate) wrong: u64,
    /// Over the successful ones: largest missing and extra lengths, largest deviation, and largest
    /// difference in total length; mm.
    pub(crate) missing: f64,
    pub(crate) extra: f64,
    pub(crate) off: f64,
    pub(crate) longer: f64,
    /// Longest duration, as a multiple of the usual one.
    pub(crate) slowest: f64,
}

impl Row {
    pub(crate) const TABLE_HEAD: &'static str = "| line | runs | done | done and wrong | missing, mm | too much, mm | off, mm | \
         length, mm | slowest |\n|---|---|---|---|---|---|---|---|---|";

    pub(crate) fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ..Self::default()
        }
    }

    /// Adds a drawing; returns its fault if it reported success wrongly.
    pub(crate) fn add(&mut self, passage: &Passage<'_>) -> Option<String> {
        self.runs += 1;
        if !passage.done {
            return None;
        }
        self.done += 1;
        let (right, drawn) = (Ink::of(passage.right), Ink::of(passage.drawn));
        let (missing, hole) = right.beyond(&drawn, INVISIBLE_DEVIATION);
        let (extra, stray) = drawn.beyond(&right, INVISIBLE_DEVIATION);
        let longer = drawn.length() - right.length();
        let slow = passage.took.as_secs_f64() / passage.usual.as_secs_f64().max(1e-3);
        self.missing = self.missing.max(missing);
        self.extra = self.extra.max(extra);
        self.off = self.off.max(hole).max(stray);
        self.longer = self.longer.max(longer.abs());
        self.slowest = self.slowest.max(slow);
        let wrong = missing > 0.0 || extra > 0.0 || longer.abs() > INVISIBLE_DEVIATION;
        self.wrong += u64::from(wrong);
        wrong.then(|| {
            format!(
                "{missing:.2} mm missing, {extra:.2} too much, {:.2} off, {longer:+.2} in all",
                hole.max(stray)
            )
        })
    }

    pub(crate) fn line(&self) -> String {
        let Self {
            name, runs, done, ..
        } = self;
        format!(
            "| {name} | {runs} | {done} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {:.1} |",
            self.wrong, self.missing, self.extra, self.off, self.longer, self.slowest
        )
    }
}
