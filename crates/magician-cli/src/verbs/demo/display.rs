//! Progress of the demo: one updated line on a terminal, one line per cube elsewhere.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use magician::commands::Pose;

use super::scene::CUBES;
use crate::failure::Failure;
use crate::output::Output;

/// Interval between updates of the line.
const UPDATE_INTERVAL: Duration = Duration::from_millis(60);
/// Terminal width for the wide form of the line, in columns.
const MIN_WIDE_WIDTH: usize = 100;

/// Progress of the arm.
pub(super) struct DisplayState {
    /// Cubes at their destination.
    pub(super) placed: usize,
    pub(super) pose: Pose,
    /// Index of the command that finished last.
    pub(super) index: u64,
    /// Free places in the queue.
    pub(super) left: u32,
}

pub(super) struct Display<'o> {
    out: &'o mut Output,
    quiet: bool,
    places: u32,
    bar: Option<ProgressBar>,
    reported: Option<usize>,
    shown: Option<Instant>,
}

impl<'o> Display<'o> {
    /// Creates a display that prints nothing if `quiet`.
    pub(super) fn new(quiet: bool, out: &'o mut Output, places: u32) -> Self {
        let live = !quiet && io::stdout().is_terminal();
        let wide = out.width() >= MIN_WIDE_WIDTH;
        Self {
            out,
            quiet,
            places,
            bar: live.then(|| bar(wide)),
            reported: None,
            shown: None,
        }
    }

    pub(super) fn title(&mut self, title: &str) -> Result<(), Failure> {
        self.write(&format!("  {title}\n"))
    }

    /// Prints what begins, without a line feed.
    pub(super) fn begin(&mut self, step: &str) -> Result<(), Failure> {
        self.write(&format!("  {step} ... "))
    }

    /// Completes the line with the arm's position.
    pub(super) fn end(&mut self, pose: &Pose) -> Result<(), Failure> {
        let [j1, j2, j3, j4] = pose.joint_angle;
        let Pose { x, y, z, .. } = pose;
        self.write(&format!(
            "done ({j1},{j2},{j3},{j4}) -> x {x:.2} y {y:.2} z {z:.2}\n"
        ))
    }

    /// True if it is time for an update.
    pub(super) fn due(&mut self) -> bool {
        let due = !self.quiet
            && self
                .shown
                .is_none_or(|shown| shown.elapsed() >= UPDATE_INTERVAL);
        if due {
            self.shown = Some(Instant::now());
        }
        due
    }

    /// Updates the line.
    pub(super) fn show(&mut self, state: &DisplayState) -> Result<(), Failure> {
        let DisplayState { pose, index, .. } = state;
        let place = format!("{:6.1} {:6.1} {:6.1}", pose.x, pose.y, pose.z);
        let taken = self.places.saturating_sub(state.left);
        let queue = format!("queue {taken:>2}/{}", self.places);
        if let Some(bar) = &self.bar {
            bar.set_position(state.placed as u64);
            bar.set_message(if self.out.width() >= MIN_WIDE_WIDTH {
                format!("  pose {place}   {queue}   index {index}")
            } else {
                format!("{place}  {queue}  index {index}")
            });
            return Ok(());
        }
        if self.reported.replace(state.placed) == Some(state.placed) {
            return Ok(());
        }
        let step = picking();
        let count = CUBES.len();
        self.write(&format!(
            "  {step:<20} {}/{count}   pose {place}   {queue}   index {index}\n",
            state.placed
        ))
    }

    /// Ends the updates and leaves the last line on the screen.
    pub(super) fn finish(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish();
        }
    }

    fn write(&mut self, text: &str) -> Result<(), Failure> {
        if self.quiet {
            return Ok(());
        }
        self.out.write_all(text.as_bytes())?;
        self.out.flush()
    }
}

fn picking() -> String {
    format!("picking {} cubes", CUBES.len())
}

fn bar(wide: bool) -> ProgressBar {
    let bar = ProgressBar::new(CUBES.len() as u64).with_prefix(picking());
    let template = if wide {
        "  {prefix:20} [{bar:14}]  {pos}/{len} {msg}"
    } else {
        "  {prefix} [{bar:6}] {pos}/{len} {msg}"
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("##-"));
    }
    bar
}
