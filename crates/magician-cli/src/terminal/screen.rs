//! Takes the terminal of stderr for a picture, and restores it however the program ends.

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

/// True while the terminal is taken. Global, since a panic on any thread must restore it.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// True while the terminal reports more than key presses, which must be undone as well.
static REPORTS_EXTRA: AtomicBool = AtomicBool::new(false);

/// Output of others to stderr while the picture is shown.
static LOG: Mutex<Vec<u8>> = Mutex::new(Vec::new());
/// Largest part of that output that is kept, bytes.
const MAX_LOG_SIZE: usize = 1 << 16;

/// Size assumed for a terminal that does not report one, in columns and rows.
const DEFAULT_SIZE: (u16, u16) = (80, 24);

/// Kinds of terminal events to receive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EventKinds {
    /// Key presses.
    Presses,
    /// Also key releases where the terminal reports them, changes of the window's focus, and pasted
    /// text, which then does not arrive as keys.
    All,
}

/// Flags of the kitty keyboard protocol for key releases. Letters report releases only if all keys
/// are sent as escape sequences, and characters typed with Shift only if alternate keys are
/// reported too. Terminals without the protocol ignore the request and report no releases.
const RELEASE_FLAGS: KeyboardEnhancementFlags = KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES
    .union(KeyboardEnhancementFlags::REPORT_EVENT_TYPES)
    .union(KeyboardEnhancementFlags::REPORT_ALTERNATE_KEYS)
    .union(KeyboardEnhancementFlags::REPORT_ALL_KEYS_AS_ESCAPE_CODES);

/// Screen, taken until it is dropped.
pub(crate) struct Screen {
    pub(crate) terminal: Terminal<CrosstermBackend<FrameBuffer>>,
    area: Rect,
}

/// Fails unless there is a terminal for the picture of `what` and one for the keys; `without` is
/// the hint then.
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
    pub(crate) fn take(listen: EventKinds) -> io::Result<Self> {
        // Before raw mode, so that no panic can leave the terminal in it.
        install_panic_hook();
        enable_raw_mode()?;
        TAKEN.store(true, Ordering::SeqCst);
        let area = size();
        let terminal = blank(area).inspect_err(|_| restore())?;
        // From here on dropping `screen` restores the terminal.
        let mut screen = Self { terminal, area };
        execute!(io::stderr(), EnterAlternateScreen)?;
        screen.clear()?;
        if listen == EventKinds::All {
            REPORTS_EXTRA.store(true, Ordering::SeqCst);
            // Windows consoles report all of this without a request and reject one, so errors are
            // ignored.
            let _ = execute!(io::stderr(), EnableFocusChange, EnableBracketedPaste);
            let _ = execute!(io::stderr(), PushKeyboardEnhancementFlags(RELEASE_FLAGS));
        }
        Ok(screen)
    }

    /// Adapts to the terminal's size. Returns true if it changed.
    pub(crate) fn follow_size(&mut self) -> io::Result<bool> {
        let area = size();
        let changed = area != self.area;
        if changed {
            self.area = area;
            self.clear()?;
        }
        Ok(changed)
    }

    /// Clears the screen, whatever has been written to it.
    pub(crate) fn clear(&mut self) -> io::Result<()> {
        self.terminal = blank(self.area)?;
        execute!(io::stderr(), Clear(ClearType::All), Hide)
    }
}

/// Creates an empty terminal. The library's own clear and resize query the cursor's position over
/// stdout, which must carry nothing but results.
fn blank(area: Rect) -> io::Result<Terminal<CrosstermBackend<FrameBuffer>>> {
    let viewport = Viewport::Fixed(area);
    let backend = CrosstermBackend::new(FrameBuffer::default());
    Terminal::with_options(backend, TerminalOptions { viewport })
}

impl Drop for Screen {
    fn drop(&mut self) {
        restore();
    }
}

fn size() -> Rect {
    let reported = terminal_size::terminal_size_of(io::stderr());
    let (width, height) = reported.map_or(DEFAULT_SIZE, |(width, height)| (width.0, height.0));
    Rect::new(0, 0, width, height)
}

/// Restores the terminal if it is taken. Errors are ignored: the terminal may be gone.
pub(crate) fn restore() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        let _ = disable_raw_mode();
        let mut stderr = io::stderr().lock();
        if REPORTS_EXTRA.swap(false, Ordering::SeqCst) {
            let _ = queue!(stderr, PopKeyboardEnhancementFlags);
            let _ = queue!(stderr, DisableFocusChange, DisableBracketedPaste);
        }
        let _ =
            queue!(stderr, ResetColor, LeaveAlternateScreen, Show).and_then(|()| stderr.flush());
        // Lines that were logged beside the picture appear after it.
        let _ = stderr.write_all(&std::mem::take(&mut *log()));
    }
}

/// Restores only the terminal's mode, for a terminal that may not accept output any more.
pub(crate) fn restore_mode() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        let _ = disable_raw_mode();
    }
}

/// Installs a panic hook that restores the terminal before the message is printed.
fn install_panic_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            restore();
            previous(info);
        }));
    });
}

/// Collects a frame and writes it in one piece, or drops it if the terminal has been restored.
#[derive(Default)]
pub(crate) struct FrameBuffer {
    bytes: Vec<u8>,
}

impl Write for FrameBuffer {
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

/// Returns and removes what others wrote to stderr since the last call, by lines.
pub(crate) fn take_log() -> Vec<String> {
    let bytes = std::mem::take(&mut *log());
    let text = String::from_utf8_lossy(&bytes);
    text.lines().map(plain).collect()
}

/// Removes colour sequences from a line.
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

/// Log writer for use beside a picture: collects lines for the picture's log, and writes to stderr
/// otherwise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogWriter;

impl Write for LogWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if !TAKEN.load(Ordering::SeqCst) {
            // Errors are hidden: the log library panics on them, and a closed terminal accepts
            // nothing.
            let _ = io::stderr().write_all(bytes);
            return Ok(bytes.len());
        }
        let mut log = log();
        if log.len() + bytes.len() <= MAX_LOG_SIZE {
            log.extend_from_slice(bytes);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
