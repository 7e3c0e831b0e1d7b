//! Picture and keys of a program that controls the arm: frames go in, events come out.
//!
//! The work with the arm and the terminal run on two threads. The terminal's thread sends a beat in
//! every frame: a held key must not keep an arm jogging if the keyboard can no longer be read (a
//! dead man's switch).

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

/// Message from the terminal's thread.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Told {
    /// An event of the keyboard or the window.
    Event(Event),
    /// Sign of life, sent with every frame, 20 times a second.
    Beat,
    /// The terminal is gone.
    Gone,
}

/// Terminal while a program has it.
pub(crate) struct Stage<M> {
    shown: Shown,
    next: Arc<Mutex<Option<M>>>,
    told: UnboundedReceiver<Told>,
    suspends: Suspends,
}

impl<M: Send + 'static> Stage<M> {
    /// Takes the terminal. `draw` draws each model passed to [`show`](Self::show).
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

    /// Shows this model from the next frame on.
    pub(crate) fn show(&self, model: M) {
        *self.next.lock().unwrap_or_else(PoisonError::into_inner) = Some(model);
    }

    /// Waits for the next message. A request to suspend the program counts as losing the focus,
    /// since a stopped process cannot stop the arm. After the terminal is gone, or if it cannot be
    /// drawn on, every call returns `Gone`.
    pub(crate) async fn next(&mut self) -> Told {
        tokio::select! {
            biased;
            () = self.suspends.next() => Told::Event(Event::FocusLost),
            told = self.told.recv() => told.unwrap_or(Told::Gone),
        }
    }

    /// Restores the terminal.
    pub(crate) fn close(self) -> Result<(), Failure> {
        self.shown.finish()
    }
}

/// State of the terminal's thread.
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
            // `|` instead of `||`, since both calls have effects.
            stale |= screen.follow_size()? | self.take();
            if let Some(model) = self.shown.as_ref().filter(|_| stale) {
                screen.terminal.draw(|frame| draw(frame, model, theme))?;
                stale = false;
            }
            self.tell(Told::Beat);
            // Keys are read for the rest of the frame's time.
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
        // The receiver is dropped just before this thread is asked to stop.
        let _ = self.tell.send(told);
    }
}

/// True for Ctrl-L, which redraws the screen in all terminal programs.
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
