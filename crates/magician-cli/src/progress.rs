//! Telling that something takes its time: a live line on a terminal, a line elsewhere, nothing with
//! `--json`.

use std::cell::Cell;
use std::future::Future;
use std::io::{self, IsTerminal, Write};
use std::pin::pin;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

use crate::paint::obeys;

/// Waits shorter than this need no telling.
const PATIENCE: Duration = Duration::from_secs(1);
const FRAME: Duration = Duration::from_millis(100);
const FACES: [char; 4] = ['|', '/', '-', '\\'];

/// Waits for `work`; says what it waits for if that takes longer than a second.
pub(crate) async fn attended<T>(quiet: bool, what: &str, work: impl Future<Output = T>) -> T {
    let mut work = pin!(work);
    if quiet {
        return work.await;
    }
    let begun = Instant::now();
    if let Ok(done) = timeout(PATIENCE, &mut work).await {
        return done;
    }
    if !obeys(&io::stderr()) {
        let _ = writeln!(io::stderr(), "{what} ...");
        return work.await;
    }
    let mut frames = interval(FRAME);
    frames.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let _clear = Clear;
    for face in FACES.into_iter().cycle() {
        tokio::select! {
            biased;
            done = &mut work => return done,
            _ = frames.tick() => {
                // Short, so that a `^C` behind it stays on its line.
                let seconds = begun.elapsed().as_secs();
                let _ = write!(io::stderr(), "\r{face} {what} {seconds} s\x1b[K");
            }
        }
    }
    work.await
}

/// A bar on stderr while something is counted, gone afterwards; elsewhere than on a terminal a line, if it takes longer
/// than a second.
pub(crate) struct Bar {
    shown: ProgressBar,
    /// What is to be said where there is no bar, and since when it is due.
    line: Cell<Option<(&'static str, Instant)>>,
}

impl Bar {
    /// From 0 to `total`.
    pub(crate) fn begin(quiet: bool, what: &'static str, total: u64) -> Self {
        let at_terminal = io::stderr().is_terminal();
        let target = if !quiet && at_terminal {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(total), target);
        let style = ProgressStyle::with_template("{spinner} {msg} {bar:30} {pos}/{len}");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what.to_owned());
        bar.tick();
        let line = (!quiet && !at_terminal).then(|| (what, Instant::now() + PATIENCE));
        Self {
            shown: bar,
            line: Cell::new(line),
        }
    }

    /// So many are done.
    pub(crate) fn at(&self, done: u64) {
        if let Some((what, _)) = self.line.get().filter(|(_, due)| *due <= Instant::now()) {
            let _ = writeln!(io::stderr(), "{what} ...");
            self.line.set(None);
        }
        self.shown.set_position(done);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.shown.finish_and_clear();
    }
}

/// Takes the live line off the screen, also when the wait is given up.
struct Clear;

impl Drop for Clear {
    fn drop(&mut self) {
        let _ = write!(io::stderr(), "\r\x1b[K");
    }
}
