//! Telling that something takes its time: a spinner on a terminal, a line elsewhere, nothing with
//! `--json`.

use std::future::Future;
use std::io::{self, IsTerminal, Write};
use std::pin::pin;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use tokio::time::timeout;

/// Waits shorter than this need no telling.
const PATIENCE: Duration = Duration::from_secs(1);
const FRAME: Duration = Duration::from_millis(100);

/// Waits for `work`; says what it waits for if that takes longer than a second.
pub(crate) async fn attended<T>(quiet: bool, what: &str, work: impl Future<Output = T>) -> T {
    let mut work = pin!(work);
    if quiet {
        return work.await;
    }
    if let Ok(done) = timeout(PATIENCE, &mut work).await {
        return done;
    }
    if !io::stderr().is_terminal() {
        let _ = writeln!(io::stderr(), "{what} ...");
        return work.await;
    }
    let spinner = ProgressBar::new_spinner().with_message(what.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed:.dim}") {
        spinner.set_style(style.tick_chars("-\\|/ "));
    }
    spinner.enable_steady_tick(FRAME);
    let _clear = Clear(&spinner);
    work.await
}

/// Takes the spinner off the screen, also when the wait is given up.
struct Clear<'a>(&'a ProgressBar);

impl Drop for Clear<'_> {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
