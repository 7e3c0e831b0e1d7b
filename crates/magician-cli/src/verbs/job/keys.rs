//! Keys at a terminal while a job runs.
//!
//! The terminal is not in raw mode: Ctrl-C and Ctrl-Z remain signals. Only line buffering and echo
//! are switched off.

use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use ratatui::crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use tokio::sync::mpsc;

use super::input::UserOrder;
use crate::terminal::{FRAME_INTERVAL, Keyboard, WaitResult};

/// Listener for keys. Dropping it restores the terminal.
pub(super) struct Keys {
    over: Arc<AtomicBool>,
    reads: Option<JoinHandle<()>>,
}

impl Keys {
    /// Begins to listen if this program has a terminal. In the background it waits until it is in
    /// the foreground.
    pub(super) fn listen(to: mpsc::UnboundedSender<UserOrder>) -> Option<Self> {
        if !io::stdin().is_terminal() || !io::stderr().is_terminal() {
            return None;
        }
        let over = Arc::new(AtomicBool::new(false));
        let stopping = Arc::clone(&over);
        let mode = Some(())
            .filter(|()| is_in_foreground())
            .and_then(|()| TerminalMode::take());
        let read = thread::Builder::new().name("keys".to_owned());
        let reads = read.spawn(move || listen(&stopping, &to, mode)).ok()?;
        Some(Self {
            over,
            reads: Some(reads),
        })
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        self.over.store(true, Ordering::SeqCst);
        // Returns soon, since the thread checks the flag regularly. A panic in it has been printed
        // already.
        let _ = self.reads.take().map(JoinHandle::join);
    }
}

fn listen(
    over: &AtomicBool,
    to: &mpsc::UnboundedSender<UserOrder>,
    mut mode: Option<TerminalMode>,
) {
    let Ok(keyboard) = Keyboard::find() else {
        return;
    };
    while !over.load(Ordering::SeqCst) {
        // The system stops a background process that reads a terminal (SIGTTIN).
        if !is_in_foreground() {
            thread::sleep(FRAME_INTERVAL);
            continue;
        }
        if mode.is_none() {
            mode = TerminalMode::take();
            if mode.is_none() {
                return;
            }
        }
        let typed = match keyboard.wait(FRAME_INTERVAL) {
            Ok(WaitResult::Event(event)) => order_of(&event),
            Ok(WaitResult::Timeout) => None,
            Ok(WaitResult::Gone) | Err(_) => return,
        };
        if typed.is_some_and(|typed| to.send(typed).is_err()) {
            return;
        }
    }
}

/// Returns the order that a key stands for; `None` if it has no meaning.
pub(super) fn order_of(event: &Event) -> Option<UserOrder> {
    let Event::Key(KeyEvent {
        code,
        modifiers,
        kind,
        ..
    }) = event
    else {
        return None;
    };
    // Shift is part of the character. Repeated keys are ignored except for the speed: a held key
    // would pause and resume in turn.
    let plain = modifiers.difference(KeyModifiers::SHIFT).is_empty();
    match (code, kind) {
        (_, KeyEventKind::Release) => None,
        _ if !plain => None,
        (KeyCode::Char('+'), _) => Some(UserOrder::Faster),
        (KeyCode::Char('-'), _) => Some(UserOrder::Slower),
        (_, KeyEventKind::Repeat) => None,
        (KeyCode::Char('p' | 'P'), _) => Some(UserOrder::Toggle),
        (KeyCode::Char(' ' | 's' | 'S'), _) => Some(UserOrder::Stop),
        _ => None,
    }
}

#[cfg(unix)]
use unix::TerminalMode;
#[cfg(unix)]
pub(super) use unix::is_in_foreground;

#[cfg(unix)]
mod unix {
    use std::io;

    use rustix::process::getpgrp;
    use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcgetpgrp, tcsetattr};

    /// True if this process is in the foreground. A process without a controlling terminal may
    /// always read.
    pub(in super::super) fn is_in_foreground() -> bool {
        tcgetpgrp(io::stdin()).map_or(true, |group| group == getpgrp())
    }

    /// Mode of the terminal while keys are read. crossterm's raw mode would turn Ctrl-C into a key.
    pub(super) struct TerminalMode(Termios);

    impl TerminalMode {
        pub(super) fn take() -> Option<Self> {
            let before = tcgetattr(io::stdin()).ok()?;
            let mut keys = before.clone();
            keys.local_modes &= !(LocalModes::ICANON | LocalModes::ECHO);
            tcsetattr(io::stdin(), OptionalActions::Now, &keys).ok()?;
            Some(Self(before))
        }
    }

    impl Drop for TerminalMode {
        fn drop(&mut self) {
            // In the background the terminal belongs to another process.
            if is_in_foreground() {
                let _ = tcsetattr(io::stdin(), OptionalActions::Now, &self.0);
            }
        }
    }
}

/// Windows consoles deliver key events in any mode and do not echo them.
#[cfg(not(unix))]
struct TerminalMode;

#[cfg(not(unix))]
impl TerminalMode {
    const fn take() -> Option<Self> {
        Some(Self)
    }
}

#[cfg(not(unix))]
pub(super) const fn is_in_foreground() -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(code: KeyCode, modifiers: KeyModifiers, kind: KeyEventKind) -> Option<UserOrder> {
        order_of(&Event::Key(KeyEvent::new_with_kind(code, modifiers, kind)))
    }

    #[test]
    fn shift_keeps_the_meaning_of_a_key_and_releases_have_none() {
        let [none, shift] = [KeyModifiers::NONE, KeyModifiers::SHIFT];
        let press = |code, modifiers| key(code, modifiers, KeyEventKind::Press);
        for (sign, typed) in [
            ('p', UserOrder::Toggle),
            ('P', UserOrder::Toggle),
            (' ', UserOrder::Stop),
            ('s', UserOrder::Stop),
            ('S', UserOrder::Stop),
            ('+', UserOrder::Faster),
            ('-', UserOrder::Slower),
        ] {
            let code = KeyCode::Char(sign);
            assert_eq!(press(code, none), Some(typed.clone()), "{sign}");
            assert_eq!(press(code, shift), Some(typed), "{sign}");
            assert_eq!(press(code, KeyModifiers::ALT), None, "{sign}");
            assert_eq!(key(code, none, KeyEventKind::Release), None, "{sign}");
        }
    }

    #[test]
    fn held_key_changes_speed_but_does_not_toggle() {
        let held = |sign| {
            key(
                KeyCode::Char(sign),
                KeyModifiers::NONE,
                KeyEventKind::Repeat,
            )
        };
        assert_eq!(held('+'), Some(UserOrder::Faster));
        assert_eq!(held('p'), None);
        assert_eq!(held(' '), None);
    }

    /// Escape sequences of these keys contain letters that have a meaning alone.
    #[test]
    fn other_keys_are_ignored() {
        for code in [
            KeyCode::F(1),
            KeyCode::F(4),
            KeyCode::Up,
            KeyCode::Esc,
            KeyCode::Char('x'),
        ] {
            assert_eq!(key(code, KeyModifiers::NONE, KeyEventKind::Press), None);
        }
    }
}
