//! Progress of long work: an animated line on a terminal, one plain line elsewhere, nothing with
//! `--json`.

use std::cell::Cell;
use std::future::Future;
use std::io::{self, IsTerminal, Write};
use std::pin::pin;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

use crate::paint::is_terminal_with_escapes;

/// Waits shorter than this are not announced. A choice: most requests end sooner, and a line for
/// each would be noise.
const ANNOUNCE_DELAY: Duration = Duration::from_secs(1);
// Interval of the animation and its frames.
const FRAME_INTERVAL: Duration = Duration::from_millis(100);
const SPINNER_FRAMES: [char; 4] = ['|', '/', '-', '\\'];

/// Awaits `work`, and says after one second what it waits for.
pub(crate) async fn announce_wait<T>(quiet: bool, what: &str, work: impl Future<Output = T>) -> T {
    let mut work = pin!(work);
    if quiet {
        return work.await;
    }
    let begun = Instant::now();
    if let Ok(done) = timeout(ANNOUNCE_DELAY, &mut work).await {
        return done;
    }
    if !is_terminal_with_escapes(&io::stderr()) {
        let _ = writeln!(io::stderr(), "{what} ...");
        return work.await;
    }
    let mut frames = interval(FRAME_INTERVAL);
    // A terminal that was stalled must not receive the missed frames at once.
    frames.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let _clear = Clear;
    for face in SPINNER_FRAMES.into_iter().cycle() {
        tokio::select! {
            biased;
            done = &mut work => return done,
            _ = frames.tick() => {
                // Short, so that the `^C` which a terminal echoes behind it stays on the line.
                let seconds = begun.elapsed().as_secs();
                let _ = write!(io::stderr(), "\r{face} {what} {seconds} s\x1b[K");
            }
        }
    }
    work.await
}

/// Progress bar on stderr, removed at its end. Without a terminal one line is printed if the work
/// takes longer than a second.
pub(crate) struct Bar {
    shown: ProgressBar,
    /// Line to print where there is no bar, and when it is due.
    line: Cell<Option<(&'static str, Instant)>>,
}

impl Bar {
    /// Starts a bar that counts from 0 to `total`.
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
        let line = (!quiet && !at_terminal).then(|| (what, Instant::now() + ANNOUNCE_DELAY));
        Self {
            shown: bar,
            line: Cell::new(line),
        }
    }

    /// Sets the number of completed items.
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

/// Guard that erases the animated line, also if the wait is cancelled.
struct Clear;

impl Drop for Clear {
    fn drop(&mut self) {
        let _ = write!(io::stderr(), "\r\x1b[K");
    }
}
