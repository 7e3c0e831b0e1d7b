//! `--tui`: shows the virtual arm as a picture on stderr's terminal while it is served, with keys
//! to act on it.
//!
//! The picture runs on its own thread. The serving task only answers requests for a view of the
//! arm, at most twenty a second, so that a slow terminal does not slow the arm.

mod app;
mod arm_view;
mod feed;
mod keys;
mod view;

use std::future::pending;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use ratatui::crossterm::event::Event;
use tokio::sync::oneshot;

use crate::failure::Failure;
use crate::interrupt::Signal;
use crate::terminal::{
    self, EventKinds, FRAME_INTERVAL, Keyboard, PictureThread, Screen, Theme, WaitResult,
};

use app::App;
use keys::Action;

use app::End;
pub(super) use app::Subject;
pub(super) use feed::Feed;

#[cfg(test)]
pub(in crate::verbs) use view::tests::examples;

/// Fails unless there is a terminal for the picture and one for the keys.
pub(super) fn check() -> Result<(), Failure> {
    let without = "without --tui the log goes to stderr";
    terminal::check("--tui", without)
}

/// Picture while it is shown, if one was asked for.
pub(super) struct Dashboard {
    picture_thread: Option<PictureThread>,
    end: Option<oneshot::Receiver<End>>,
}

impl Dashboard {
    /// Shows the arms once they are served; nothing without subjects.
    pub(super) fn begin(subjects: Vec<Subject>) -> io::Result<Self> {
        if subjects.is_empty() {
            let (picture_thread, end) = (None, None);
            return Ok(Self {
                picture_thread,
                end,
            });
        }
        let (say, end) = oneshot::channel();
        let picture_thread = PictureThread::begin(move |stop| {
            let end = show(subjects, stop)?;
            // The receiver is gone if the server ended first.
            let _ = say.send(end);
            Ok(())
        })?;
        Ok(Self {
            picture_thread: Some(picture_thread),
            end: Some(end),
        })
    }

    /// Waits until the user ends the picture or the terminal is gone.
    pub(super) async fn ended(&mut self) -> Signal {
        let Some(end) = self.end.take() else {
            return pending().await;
        };
        let end = async {
            match end.await {
                Ok(End::Interrupt) => Signal::Interrupt,
                // Without an answer the picture has failed; `finish` reports the reason.
                Ok(End::Quit | End::Gone | End::Served) | Err(_) => Signal::Terminate,
            }
        };
        tokio::select! {
            signal = end => signal,
            () = terminal::wait_for_hangup() => Signal::HangUp,
        }
    }

    /// Ends the picture and restores the terminal.
    pub(super) fn finish(self) -> Result<(), Failure> {
        self.picture_thread.map_or(Ok(()), PictureThread::finish)
    }
}

/// Draws and handles keys until the picture ends.
fn show(subjects: Vec<Subject>, stop: &AtomicBool) -> io::Result<End> {
    let mut app = App::new(subjects);
    // Waits until everything is served, so that earlier errors are printed on the regular screen.
    if app.refresh().is_err() {
        return Ok(End::Served);
    }
    let theme = Theme::for_stderr();
    let keyboard = Keyboard::find()?;
    let mut screen = Screen::take(EventKinds::Presses)?;
    let mut stale = true;
    loop {
        let begun = Instant::now();
        stale |= screen.follow_size()?;
        if stale {
            screen
                .terminal
                .draw(|frame| view::draw(frame, &app, theme))?;
        }
        stale = false;
        while let Some(left) = FRAME_INTERVAL.checked_sub(begun.elapsed()) {
            let key = match keyboard.wait(left)? {
                WaitResult::Event(Event::Key(key)) => key,
                WaitResult::Event(_) | WaitResult::Timeout => continue,
                WaitResult::Gone => return Ok(End::Gone),
            };
            let action = keys::action(&app.mode, app.is_unlocked(), key);
            stale |= action != Action::Nothing;
            if action == Action::Redraw {
                screen.clear()?;
            }
            match app.act(action) {
                Ok(None) => {}
                Ok(Some(end)) => return Ok(end),
                Err(_) => return Ok(End::Served),
            }
            // This key may have changed the meaning of the next one.
            if app.refresh().is_err() {
                return Ok(End::Served);
            }
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(End::Served);
        }
        match app.refresh() {
            Ok(new) => stale |= new,
            Err(_) => return Ok(End::Served),
        }
    }
}
