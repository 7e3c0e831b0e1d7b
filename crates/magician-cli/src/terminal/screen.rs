//! The terminal of stderr while a picture has it, and giving it back.

use std::io::{self, IsTerminal, Write};
use std::panic;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::{Hide, Show};
use ratatui::crossterm::event::{
    DisableBracketedPaste, DisableFocusChange, EnableBracketedPaste, EnableFocusChange,
    KeyboardEnhancementFlags, PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
};
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

/// Whether more than presses of keys was asked for, which has to be given back as well.
static LISTENS: AtomicBool = AtomicBool::new(false);

/// What others wanted to write on stderr meanwhile.
static LOG: Mutex<Vec<u8>> = Mutex::new(Vec::new());
/// As much of it is kept.
const LOG_KEPT: usize = 1 << 16;

/// What a terminal that does not tell its size is taken for.
const USUAL_SIZE: (u16, u16) = (80, 24);

/// What is to be heard of the keyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Listen {
    /// Presses.
    Presses,
    /// Also releases, where the terminal tells them, whether the window has the focus, and what is pasted, which then is no
    /// row of keys.
    Everything,
}

/// What is asked of a terminal that is to tell of releases: keys of letters are among them only if all keys come as sequences,
/// and the signs that Shift makes only if both come. Terminals that do not know it ignore it, and tell no release.
const RELEASES: KeyboardEnhancementFlags = KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES
    .union(KeyboardEnhancementFlags::REPORT_EVENT_TYPES)
    .union(KeyboardEnhancementFlags::REPORT_ALTERNATE_KEYS)
    .union(KeyboardEnhancementFlags::REPORT_ALL_KEYS_AS_ESCAPE_CODES);

/// The screen, taken until it is dropped.
pub(crate) struct Screen {
    pub(crate) terminal: Terminal<CrosstermBackend<Frames>>,
    area: Rect,
}

/// Whether there is a terminal for the picture of `what` and one for the keys; `without` says what to do if not.
pub(crate) fn check(what: &str, without: &str) -> Result<(), Failure> {
    if !io::stderr().is_terminal() {
        let message = format!("{what} draws on stderr, which is not a terminal");
        return Err(Failure::usage(message).hint(without));
    }
    if std::env::var_os("TERM").is_some_and(|term| term == "dumb") {
        let message = format!("{what} needs a terminal with cursor control; TERM is `dumb`");
        return Err(Failure::usage(message).hint(without));
    }
    if Keyboard::find().is_err() {
        let message = format!(
            "{what} needs a keyboard: stdin is not a terminal, and this program has no \
                controlling terminal"
        );
        return Err(Failure::usage(message).hint(without));
    }
    Ok(())
}

impl Screen {
    pub(crate) fn take(listen: Listen) -> io::Result<Self> {
        give_back_in_a_panic();
        enable_raw_mode()?;
        TAKEN.store(true, Ordering::SeqCst);
        let area = size();
        let terminal = blank(area).inspect_err(|_| restore())?;
        // From here on dropping it gives the terminal back.
        let mut screen = Self { terminal, area };
        execute!(io::stderr(), EnterAlternateScreen)?;
        screen.clear()?;
        if listen == Listen::Everything {
            LISTENS.store(true, Ordering::SeqCst);
            // Consoles of Windows tell all this unasked, and cannot be asked.
            let _ = execute!(io::stderr(), EnableFocusChange, EnableBracketedPaste);
            let _ = execute!(io::stderr(), PushKeyboardEnhancementFlags(RELEASES));
        }
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

    /// Takes everything off the screen, whatever wrote it.
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
        restore();
    }
}

fn size() -> Rect {
    let told = terminal_size::terminal_size_of(io::stderr());
    let (width, height) = told.map_or(USUAL_SIZE, |(width, height)| (width.0, height.0));
    Rect::new(0, 0, width, height)
}

/// Gives the terminal back as it was, if it is taken. A terminal that is gone cannot be helped.
pub(crate) fn restore() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        let _ = disable_raw_mode();
        let mut stderr = io::stderr().lock();
        if LISTENS.swap(false, Ordering::SeqCst) {
            let _ = queue!(stderr, PopKeyboardEnhancementFlags);
            let _ = queue!(stderr, DisableFocusChange, DisableBracketedPaste);
        }
        let _ =
            queue!(stderr, ResetColor, LeaveAlternateScreen, Show).and_then(|()| stderr.flush());
        let _ = stderr.write_all(&std::mem::take(&mut *log()));
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
            restore();
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
        let done = if TAKEN.load(Ordering::SeqCst) {
            io::stderr().lock().write_all(&self.bytes)
        } else {
            Ok(())
        };
        self.bytes.clear();
        done
    }
}

/// What others wanted to write on stderr since the last look, line by line; nothing of it is written later.
pub(crate) fn take_log() -> Vec<String> {
    let bytes = std::mem::take(&mut *log());
    let text = String::from_utf8_lossy(&bytes);
    text.lines().map(plain).collect()
}

/// A line without its colours.
fn plain(line: &str) -> String {
    let mut pieces = line.split("\x1b[");
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        text.push_str(piece.split_once('m').map_or(piece, |(_, rest)| rest));
    }
    text
}

fn log() -> MutexGuard<'static, Vec<u8>> {
    LOG.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where a log goes that would go to stderr: while a picture is there, to the picture's log, or else to stderr afterwards.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogWriter;

impl Write for LogWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if !TAKEN.load(Ordering::SeqCst) {
            // The log panics over what cannot be written, and a terminal that was closed takes nothing.
            let _ = io::stderr().write_all(bytes);
            return Ok(bytes.len());
        }
        let mut log = log();
        if log.len() + bytes.len() <= LOG_KEPT {
            log.extend_from_slice(bytes);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
