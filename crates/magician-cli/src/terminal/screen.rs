//! The terminal of stderr while a picture has it, and giving it back.

use std::io::{self, IsTerminal, Write};
use std::panic;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::{Hide, Show};
use ratatui::crossterm::style::ResetColor;
use ratatui::crossterm::terminal::{
    Clear, ClearType, EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use ratatui::crossterm::{execute, queue};
use ratatui::layout::Rect;
use ratatui::{Terminal, TerminalOptions, Viewport};

use super::Keyboard;
use crate::failure::Failure;

/// Whether the terminal is ours: there is one, and a panic anywhere has to give it back.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// What a terminal that does not tell its size is taken for.
const USUAL_SIZE: (u16, u16) = (80, 24);

/// The screen, taken until it is dropped.
pub(crate) struct Screen {
    pub(crate) terminal: Terminal<CrosstermBackend<Frames>>,
    area: Rect,
}

/// Whether there is a terminal for the picture of `what` and one for the keys; `without` says what to do if not.
pub(crate) fn check(what: &str, without: &str) -> Result<(), Failure> {
    if !io::stderr().is_terminal() {
        let message = format!("{what} draws on stderr, which is no terminal");
        return Err(Failure::usage(message).hint(without));
    }
    if std::env::var_os("TERM").is_some_and(|term| term == "dumb") {
        let message =
            format!("{what} needs a terminal that can place its cursor; TERM says `dumb`");
        return Err(Failure::usage(message).hint(without));
    }
    if Keyboard::find().is_err() {
        let message =
            format!("{what} has no keyboard: stdin is no terminal, and none controls this program");
        return Err(Failure::usage(message).hint(without));
    }
    Ok(())
}

impl Screen {
    pub(crate) fn take() -> io::Result<Self> {
        give_back_in_a_panic();
        enable_raw_mode()?;
        TAKEN.store(true, Ordering::SeqCst);
        let area = size();
        let terminal = blank(area).inspect_err(|_| give_back())?;
        // From here on dropping it gives the terminal back.
        let mut screen = Self { terminal, area };
        execute!(io::stderr(), EnterAlternateScreen)?;
        screen.clear()?;
        Ok(screen)
    }

    /// Follows the terminal's size; whether it has changed.
    pub(crate) fn follow_size(&mut self) -> io::Result<bool> {
        let area = size();
        let changed = area != self.area;
        if changed {
            self.area = area;
            self.clear()?;
        }
        Ok(changed)
    }

    /// Takes everything off the screen, whoever put it there.
    pub(crate) fn clear(&mut self) -> io::Result<()> {
        self.terminal = blank(self.area)?;
        execute!(io::stderr(), Clear(ClearType::All), Hide)
    }
}

/// A terminal on which nothing has been drawn. The library's own ways to clear and resize one ask for the cursor's place,
/// on stdout, which has one line to say and no more.
fn blank(area: Rect) -> io::Result<Terminal<CrosstermBackend<Frames>>> {
    let viewport = Viewport::Fixed(area);
    let backend = CrosstermBackend::new(Frames::default());
    Terminal::with_options(backend, TerminalOptions { viewport })
}

impl Drop for Screen {
    fn drop(&mut self) {
        give_back();
    }
}

fn size() -> Rect {
    let told = terminal_size::terminal_size_of(io::stderr());
    let (width, height) = told.map_or(USUAL_SIZE, |(width, height)| (width.0, height.0));
    Rect::new(0, 0, width, height)
}

/// Gives the terminal back as it was, if it is taken. A terminal that is gone cannot be helped.
pub(crate) fn give_back() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        let _ = disable_raw_mode();
        let mut stderr = io::stderr().lock();
        let _ =
            queue!(stderr, ResetColor, LeaveAlternateScreen, Show).and_then(|()| stderr.flush());
    }
}

/// The same where the terminal may not take what is written: its mode only.
pub(crate) fn give_back_mode() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        let _ = disable_raw_mode();
    }
}

/// What a panic has to say belongs on the screen as it was.
fn give_back_in_a_panic() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let said = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            give_back();
            said(info);
        }));
    });
}

/// Collects a frame and writes it at once; not at all when the terminal has been given back.
#[derive(Default)]
pub(crate) struct Frames {
    bytes: Vec<u8>,
}

impl Write for Frames {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let done = match TAKEN.load(Ordering::SeqCst) {
            true => io::stderr().lock().write_all(&self.bytes),
            false => Ok(()),
        };
        self.bytes.clear();
        done
    }
}
