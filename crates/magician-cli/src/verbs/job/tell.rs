//! Progress of a run: a bar on a terminal, a line every few seconds elsewhere, objects with
//! `--json`.

use std::cell::{Cell, RefCell};
use std::io::{self, Write};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use magician_job::report::{format_duration, with_advice};
use magician_job::{JobProgress, PauseReason};
use magician_program::Diagnostic;
use magician_protocol::visible_lines;
use serde::Serialize;
use serde_json::json;

use super::keys::is_in_front;
use super::tui::Shared;
use crate::output::Output;
use crate::paint::{draws_on_stderr, obeys, tell};
use crate::voice::Command;

/// Interval between lines where there is no bar. A choice.
const LINES: Duration = Duration::from_secs(3);
/// Shortest interval between progress objects. A choice.
const OBJECTS: Duration = Duration::from_millis(100);
/// Delay before the bar appears, so that short runs do not flash one. A choice.
const PATIENCE: Duration = Duration::from_millis(300);

/// Reports the progress of a run.
pub(super) struct ProgressReporter<'o> {
    /// Output for JSON objects.
    out: RefCell<&'o mut Output>,
    json: bool,
    bar: Option<ProgressBar>,
    /// Model of the full-screen picture, if there is one.
    screen: Option<Shared>,
    told: Cell<Instant>,
    begun: Instant,
    steps: Option<u64>,
    /// Speed in percent of the program's.
    speed: Cell<u8>,
}

#[derive(Serialize)]
struct Object {
    event: &'static str,
    step: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<u64>,
    /// Loop, from 1.
    #[serde(rename = "loop")]
    round: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    share: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds_left: Option<f64>,
    /// Time without an answer of the arm while the driver waits for one, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds_silent: Option<f64>,
}

impl<'o> ProgressReporter<'o> {
    pub(super) fn new(
        out: &'o mut Output,
        json: bool,
        steps: Option<u64>,
        screen: Option<Shared>,
    ) -> Self {
        let live = !json && screen.is_none() && obeys(&io::stderr());
        Self {
            out: RefCell::new(out),
            json,
            bar: live.then(|| bar(steps)),
            screen,
            told: Cell::new(Instant::now()),
            begun: Instant::now(),
            steps,
            speed: Cell::new(100),
        }
    }

    /// Formats as `2:10 left, at 50 %`.
    fn left(&self, left: Option<Duration>) -> Option<String> {
        let left = left.map(|left| format!("{} left", format_duration(left)));
        let speed = Some(self.speed.get()).filter(|speed| *speed != 100);
        let speed = speed.map(|speed| format!("at {speed} %"));
        let said: Vec<String> = [left, speed].into_iter().flatten().collect();
        (!said.is_empty()).then(|| said.join(", "))
    }

    /// Returns the bar if this process is in the foreground. In the background the line belongs to
    /// the shell.
    fn bar_in_front(&self) -> Option<&ProgressBar> {
        self.bar.as_ref().filter(|_| is_in_front())
    }

    /// Reports a new speed, in percent.
    pub(super) fn speed(&self, percent: u8) {
        self.object(&json!({"event": "speed", "percent": percent}));
        self.speed.set(percent);
        if self.bar.is_none() {
            self.say(&format!("speed {percent} %"));
        }
    }

    /// Runs `work` while the bar is removed from the terminal.
    pub(super) fn suspended(&self, work: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(work),
            None => work(),
        }
    }

    /// Reports the progress and the time left.
    pub(super) fn at(&self, progress: &JobProgress, left: Option<Duration>) {
        let JobProgress { step, silent, .. } = *progress;
        if let Some(screen) = &self.screen {
            let mut model = screen.borrow_mut();
            (model.step, model.round) = (step, progress.iteration);
            model.left = waits(silent).or_else(|| self.left(left));
            return;
        }
        if self.bar.is_some() {
            if let Some(bar) = self
                .bar_in_front()
                .filter(|_| self.begun.elapsed() >= PATIENCE)
            {
                bar.set_position(step);
                let left = || self.left(left);
                bar.set_message(waits(silent).or_else(left).unwrap_or_default());
                bar.tick();
            }
            return;
        }
        let pause = if self.json { OBJECTS } else { LINES };
        if self.told.get().elapsed() < pause {
            return;
        }
        self.told.set(Instant::now());
        let share = self.steps.map(|steps| step as f64 / steps.max(1) as f64);
        if self.json {
            let object = Object {
                event: "progress",
                step,
                round: progress.iteration,
                steps: self.steps,
                share: share.map(|share| (share * 1e4).round() / 1e4),
                seconds_silent: (!silent.is_zero()).then(|| silent.as_secs_f64().floor()),
                seconds_left: left.map(|left| (left.as_secs_f64() * 10.0).round() / 10.0),
            };
            self.object(&object);
            return;
        }
        let done = match (self.steps, share) {
            (Some(steps), Some(share)) => {
                format!("{step} of {steps} steps done, {:.0} %", share * 100.0)
            }
            _ => format!("{step} steps done"),
        };
        let left = || self.left(left);
        let more = waits(silent).or_else(left);
        let more = more.map(|more| format!(", {more}")).unwrap_or_default();
        let _ = writeln!(io::stderr(), "{done}{more}");
    }

    /// Writes a JSON object.
    pub(super) fn object(&self, object: &impl Serialize) {
        // A missing reader must not stop the arm. The final object will report the failure.
        if let (true, Ok(mut out)) = (self.json, self.out.try_borrow_mut()) {
            let _ = out.event(object).and_then(|()| out.flush());
        }
    }

    /// Reports that the job is stopping or has ended.
    pub(super) fn ends(&self, stopped: bool) {
        self.does(if stopped { "stopping" } else { "ending" });
    }

    /// Shows the job's activity on the full-screen picture.
    fn does(&self, what: &'static str) {
        if let Some(screen) = &self.screen {
            screen.borrow_mut().doing = what;
        }
    }

    /// Reports that the job is about to pause.
    pub(super) fn pausing(&self) {
        self.does("pausing ...");
        if let Some(bar) = self.bar_in_front() {
            bar.set_message("pausing ...");
            bar.tick();
        }
    }

    /// Reports that the job is paused.
    pub(super) fn paused(&self, reason: PauseReason, part: Option<u64>, text: Option<&str>) {
        let reason = reason.name();
        self.object(&json!({"event": "paused", "part": part, "reason": reason}));
        self.does("paused: p resumes");
        let text = text.map(|text| visible_lines(text).to_string());
        if let Some(text) = text
            .as_deref()
            .filter(|_| self.bar.is_some() || self.screen.is_some())
        {
            self.say(text);
        }
        match &self.bar {
            Some(bar) => {
                bar.set_message("paused: p resumes, space stops");
                bar.tick();
            }
            None => match text {
                Some(text) if self.screen.is_none() => self.say(&format!("paused: {text}")),
                _ => self.say("paused"),
            },
        }
    }

    /// Reports that the job is resumed.
    pub(super) fn resumed(&self) {
        self.object(&json!({"event": "resumed"}));
        self.does("running");
        if self.bar.is_none() {
            self.say("resumed");
        } else if let Some(bar) = self.bar_in_front() {
            bar.set_message("");
        }
    }

    /// Reports a note.
    pub(super) fn note(&self, note: &Diagnostic) {
        if !self.json {
            let text = with_advice(&Command, note.message.as_str().to_owned(), note);
            return self.say(&format!("note: {}", visible_lines(&text)));
        }
        if let Ok(mut out) = self.out.try_borrow_mut() {
            // A missing reader must not stop the arm.
            let _ = out.note_at_once(note, true);
        }
    }

    /// Prints a message for people on a separate line.
    pub(super) fn say(&self, text: &str) {
        if self.json {
            return;
        }
        if let Some(screen) = &self.screen {
            screen.borrow_mut().note(text);
            return;
        }
        match &self.bar {
            Some(bar) => bar.suspend(|| tell(text)),
            None => tell(text),
        }
    }
}

/// Formats as `waiting for the arm's reply, 4 s`; `None` below one second.
fn waits(silent: Duration) -> Option<String> {
    let seconds = silent.as_secs();
    (seconds > 0).then(|| format!("waiting for the arm's reply, {seconds} s"))
}

impl Drop for ProgressReporter<'_> {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn bar(steps: Option<u64>) -> ProgressBar {
    let bar = match steps {
        Some(steps) => ProgressBar::new(steps),
        None => ProgressBar::no_length(),
    };
    bar.set_draw_target(ProgressDrawTarget::stderr());
    let template = match steps {
        Some(_) => "{bar:24} {percent:>3} %  {pos}/{len} steps done  {msg}",
        None => "{spinner} {pos} steps done  {msg}",
    };
    let signs = if draws_on_stderr() {
        "█▉▊▋▌▍▎▏ "
    } else {
        "=> "
    };
    let ascii = ["|", "/", "-", "\\", " "];
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars(signs).tick_strings(&ascii));
    }
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_like_clocks() {
        let shown = |seconds| format_duration(Duration::from_secs_f64(seconds));
        assert_eq!(shown(0.4), "0:00");
        assert_eq!(shown(83.2), "1:23");
        assert_eq!(shown(3_725.0), "1:02:05");
    }
}
