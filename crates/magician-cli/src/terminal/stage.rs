//! A picture for a program that works with the arm: frames go to it, keys come from it.
//!
//! The work with the arm and the terminal are on two threads. Beats tell the one that the other is well: a dead man's control
//! must not be kept up by a keyboard that cannot be read.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use ratatui::Frame;
use ratatui::crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use super::screen::Listen;
use super::{FRAME, Keyboard, Screen, Shown, Suspends, Theme, Waited};
use crate::failure::Failure;

/// What the terminal has to tell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Told {
    /// Something on the keyboard, or to do with the window.
    Event(Event),
    /// Nothing but that it is well; twenty times a second.
    Beat,
    /// The terminal is gone.
    Gone,
}

/// The terminal while a program has it.
pub(crate) struct Stage<M> {
    shown: Shown,
    next: Arc<Mutex<Option<M>>>,
    told: UnboundedReceiver<Told>,
    suspends: Suspends,
}

impl<M: Send + 'static> Stage<M> {
    /// Takes the terminal. `draw` makes a frame of what [`show`](Self::show) hands over.
    pub(crate) fn open(draw: fn(&mut Frame<'_>, &M, Theme)) -> io::Result<Self> {
        let next = Arc::new(Mutex::new(None));
        let (tell, told) = unbounded_channel();
        let taken = Arc::clone(&next);
        let shown = Shown::begin(move |stop| {
            let mut work = Work {
                next: taken,
                tell,
                shown: None,
            };
            work.go_on(draw, stop)
        })?;
        let suspends = Suspends::listen()?;
        Ok(Self {
            shown,
            next,
            told,
            suspends,
        })
    }

    /// What is to be seen from the next frame on.
    pub(crate) fn show(&self, model: M) {
        *self.next.lock().unwrap_or_else(PoisonError::into_inner) = Some(model);
    }

    /// The next thing that the terminal tells. A suspension counts as losing the focus: a stopped process cannot stop an
    /// arm.
    /// After it is gone, or cannot be drawn on, it is gone again and again.
    pub(crate) async fn next(&mut self) -> Told {
        tokio::select! {
            biased;
            () = self.suspends.next() => Told::Event(Event::FocusLost),
            told = self.told.recv() => told.unwrap_or(Told::Gone),
        }
    }

    /// Gives the terminal back.
    pub(crate) fn close(self) -> Result<(), Failure> {
        self.shown.finish()
    }
}

/// The terminal's thread.
struct Work<M> {
    next: Arc<Mutex<Option<M>>>,
    tell: UnboundedSender<Told>,
    shown: Option<M>,
}

impl<M> Work<M> {
    fn go_on(&mut self, draw: fn(&mut Frame<'_>, &M, Theme), stop: &AtomicBool) -> io::Result<()> {
        let theme = Theme::for_stderr();
        let keyboard = Keyboard::find()?;
        let mut screen = Screen::take(Listen::Everything)?;
        let mut stale = false;
        while !stop.load(Ordering::Relaxed) {
            let begun = Instant::now();
            stale |= screen.follow_size()? | self.take();
            if let Some(model) = self.shown.as_ref().filter(|_| stale) {
                screen.terminal.draw(|frame| draw(frame, model, theme))?;
                stale = false;
            }
            self.tell(Told::Beat);
            while let Some(left) = FRAME.checked_sub(begun.elapsed()) {
                match keyboard.wait(left)? {
                    Waited::Nothing => continue,
                    Waited::Gone => {
                        self.tell(Told::Gone);
                        return Ok(());
                    }
                    Waited::Came(event) if redraws(&event) => {
                        screen.clear()?;
                        stale = true;
                    }
                    Waited::Came(event) => self.tell(Told::Event(event)),
                }
            }
        }
        Ok(())
    }

    fn take(&mut self) -> bool {
        let mut next = self.next.lock().unwrap_or_else(PoisonError::into_inner);
        let new = next.take();
        let is_new = new.is_some();
        self.shown = new.or(self.shown.take());
        is_new
    }

    fn tell(&self, told: Told) {
        // The receiver is gone when the program is about to stop this.
        let _ = self.tell.send(told);
    }
}

/// Ctrl-L, at every terminal program's.
fn redraws(event: &Event) -> bool {
    matches!(
        event,
        Event::Key(KeyEvent {
            code: KeyCode::Char('l'),
            modifiers: KeyModifiers::CONTROL,
            kind: KeyEventKind::Press,
            ..
        })
    )
}
