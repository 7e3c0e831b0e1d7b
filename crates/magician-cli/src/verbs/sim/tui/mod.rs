//! `--tui`: the arm as a picture on stderr's terminal, with keys, while it is served.
//!
//! The picture has a thread of its own, so that neither a slow terminal nor a key keeps a client waiting: the serving
//! task does nothing for it but take a look at the arm, at most twenty times a second.

mod app;
mod feed;
mod keyboard;
mod keys;
mod look;
mod screen;
mod theme;
mod view;

use std::future::pending;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use magician::ErrorKind;
use ratatui::crossterm::event::Event;
use tokio::sync::oneshot;

use crate::failure::{Failure, Kind};
use crate::interrupt::Signal;

use app::App;
use keyboard::{Keyboard, Waited};
use keys::Action;
use screen::Screen;
use theme::Theme;

use app::End;
pub(super) use app::Subject;
pub(super) use feed::Feed;
pub(super) use screen::check;

/// No two frames are nearer than this.
const FRAME: Duration = Duration::from_millis(50);
/// How long a terminal has to take the last frame before it is left as it is.
const PATIENCE: Duration = Duration::from_secs(1);

/// The picture while it is shown, if one was asked for.
pub(super) struct Dashboard {
    shown: Option<Shown>,
    end: Option<oneshot::Receiver<End>>,
}

struct Shown {
    thread: JoinHandle<io::Result<()>>,
    stop: Arc<AtomicBool>,
    /// Closed when the thread is done.
    alive: mpsc::Receiver<()>,
}

impl Dashboard {
    /// Shows the arms from when they are served; without arms there is nothing to show.
    pub(super) fn begin(subjects: Vec<Subject>) -> io::Result<Self> {
        if subjects.is_empty() {
            let (shown, end) = (None, None);
            return Ok(Self { shown, end });
        }
        let stop = Arc::new(AtomicBool::new(false));
        let (say, end) = oneshot::channel();
        let (holds, alive) = mpsc::channel();
        let told = Arc::clone(&stop);
        let work = move || {
            // Dropped when this is done, also by a panic.
            let _alive: mpsc::Sender<()> = holds;
            let end = show(subjects, &told)?;
            // Nobody listens if the server ended first.
            let _ = say.send(end);
            Ok(())
        };
        let thread = thread::Builder::new().name("picture".into()).spawn(work)?;
        Ok(Self {
            shown: Some(Shown {
                thread,
                stop,
                alive,
            }),
            end: Some(end),
        })
    }

    /// Waits until the user wants an end, or the terminal is gone.
    pub(super) async fn ended(&mut self) -> Signal {
        let Some(end) = self.end.take() else {
            return pending().await;
        };
        let end = async {
            match end.await {
                Ok(End::Interrupt) => Signal::Interrupt,
                // Without an answer the picture could not go on, and `finish` says why.
                Ok(End::Quit | End::Gone | End::Served) | Err(_) => Signal::Terminate,
            }
        };
        tokio::select! {
            signal = end => signal,
            () = hung_up() => Signal::Terminate,
        }
    }

    /// Ends the picture and gives the terminal back.
    pub(super) fn finish(self) -> Result<(), Failure> {
        let Some(Shown {
            thread,
            stop,
            alive,
        }) = self.shown
        else {
            return Ok(());
        };
        stop.store(true, Ordering::Relaxed);
        if alive.recv_timeout(PATIENCE) == Err(mpsc::RecvTimeoutError::Timeout) {
            // The terminal takes nothing more: what would be written to it now would wait too.
            screen::give_back_mode();
            return Ok(());
        }
        match thread.join() {
            Ok(Ok(())) => Ok(()),
            Ok(Err(error)) => {
                let message = format!("the terminal cannot be drawn on: {error}");
                Err(Failure::new(Kind::Driver(ErrorKind::Closed), message))
            }
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

/// Waits until the terminal that controls this program is gone.
async fn hung_up() {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut signal) = signal(SignalKind::hangup()) {
            signal.recv().await;
            return;
        }
    }
    pending().await
}

/// Draws and obeys until there is an end.
fn show(subjects: Vec<Subject>, stop: &AtomicBool) -> io::Result<End> {
    let mut app = App::new(subjects);
    // Answered when everything is served: what goes wrong before is told on the screen as it is.
    if app.look().is_err() {
        return Ok(End::Served);
    }
    let theme = Theme::for_stderr();
    let keyboard = Keyboard::find()?;
    let mut screen = Screen::take()?;
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
        while let Some(left) = FRAME.checked_sub(begun.elapsed()) {
            let key = match keyboard.wait(left)? {
                Waited::Came(Event::Key(key)) => key,
                Waited::Came(_) | Waited::Nothing => continue,
                Waited::Gone => return Ok(End::Gone),
            };
            let action = keys::action(&app.mode, app.unlocked(), key);
            stale |= action != Action::Nothing;
            if action == Action::Redraw {
                screen.clear()?;
            }
            match app.act(action) {
                Ok(None) => {}
                Ok(Some(end)) => return Ok(end),
                Err(_) => return Ok(End::Served),
            }
            // What the next key means may depend on what this one did.
            if app.look().is_err() {
                return Ok(End::Served);
            }
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(End::Served);
        }
        match app.look() {
            Ok(new) => stale |= new,
            Err(_) => return Ok(End::Served),
        }
    }
}
