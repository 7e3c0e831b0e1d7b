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

use super::screen::EventKinds;
use super::{FRAME_INTERVAL, Keyboard, PictureThread, Screen, SuspendRequests, Theme, WaitResult};
use crate::failure::Failure;

/// Message from the terminal's thread.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TerminalEvent {
    /// An event of the keyboard or the window.
    Event(Event),
    /// Sign of life, sent with every frame, 20 times a second.
    Beat,
    /// The terminal is gone.
    Gone,
}

/// Terminal while a program has it.
pub(crate) struct FullScreen<M> {
    picture_thread: PictureThread,
    next: Arc<Mutex<Option<M>>>,
    events: UnboundedReceiver<TerminalEvent>,
    suspends: SuspendRequests,
}

impl<M: Send + 'static> FullScreen<M> {
    /// Takes the terminal. `draw` draws each model passed to [`show`](Self::show).
    pub(crate) fn open(draw: fn(&mut Frame<'_>, &M, Theme)) -> io::Result<Self> {
        let next = Arc::new(Mutex::new(None));
        let (events_out, events) = unbounded_channel();
        let taken = Arc::clone(&next);
        let picture_thread = PictureThread::begin(move |stop| {
            let mut work = DrawThread {
                next: taken,
                events_out,
                shown: None,
            };
            work.run(draw, stop)
        })?;
        let suspends = SuspendRequests::listen()?;
        Ok(Self {
            picture_thread,
            next,
            events,
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
    pub(crate) async fn next(&mut self) -> TerminalEvent {
        tokio::select! {
            biased;
            () = self.suspends.next() => TerminalEvent::Event(Event::FocusLost),
            event = self.events.recv() => event.unwrap_or(TerminalEvent::Gone),
        }
    }

    /// Restores the terminal.
    pub(crate) fn close(self) -> Result<(), Failure> {
        self.picture_thread.finish()
    }
}

/// State of the terminal's thread.
struct DrawThread<M> {
    next: Arc<Mutex<Option<M>>>,
    events_out: UnboundedSender<TerminalEvent>,
    shown: Option<M>,
}

impl<M> DrawThread<M> {
    fn run(&mut self, draw: fn(&mut Frame<'_>, &M, Theme), stop: &AtomicBool) -> io::Result<()> {
        let theme = Theme::for_stderr();
        let keyboard = Keyboard::find()?;
        let mut screen = Screen::take(EventKinds::All)?;
        let mut stale = false;
        while !stop.load(Ordering::Relaxed) {
            let begun = Instant::now();
            // `|` instead of `||`, since both calls have effects.
            stale |= screen.follow_size()? | self.take();
            if let Some(model) = self.shown.as_ref().filter(|_| stale) {
                screen.terminal.draw(|frame| draw(frame, model, theme))?;
                stale = false;
            }
            self.send(TerminalEvent::Beat);
            // Keys are read for the rest of the frame's time.
            while let Some(left) = FRAME_INTERVAL.checked_sub(begun.elapsed()) {
                match keyboard.wait(left)? {
                    WaitResult::Timeout => continue,
                    WaitResult::Gone => {
                        self.send(TerminalEvent::Gone);
                        return Ok(());
                    }
                    WaitResult::Event(event) if is_redraw_key(&event) => {
                        screen.clear()?;
                        stale = true;
                    }
                    WaitResult::Event(event) => self.send(TerminalEvent::Event(event)),
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

    fn send(&self, event: TerminalEvent) {
        // The receiver is dropped just before this thread is asked to stop.
        let _ = self.events_out.send(event);
    }
}

/// True for Ctrl-L, which redraws the screen in all terminal programs.
fn is_redraw_key(event: &Event) -> bool {
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
