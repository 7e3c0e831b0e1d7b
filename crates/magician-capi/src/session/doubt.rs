//! Commands in doubt: the arm may or may not have accepted them.
//!
//! Stock wrappers retry a call until it returns 0. If the arm had accepted the first command, it
//! would move twice. While a command is in doubt, every further command that must not be repeated
//! is therefore refused: the position of the arm is unknown, and later commands assume another one.
//!
//! A confirmed `SetQueuedCmdClear` ends the doubt, because it removes the command from the queue.
//! `SetQueuedCmdStopExec` and `SetQueuedCmdForceStopExec` do not: both keep the queue, and the next
//! `SetQueuedCmdStartExec` would execute the command and its copy. A new `ConnectDobot` starts
//! without doubt.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use magician::Error;

use super::registry::lock;
use crate::code::{Code, Fault, Outcome};

/// The command in doubt, if there is one.
#[derive(Debug, Default)]
pub(super) struct Doubt {
    exists: AtomicBool,
    about: Mutex<Option<String>>,
}

impl Doubt {
    /// Fails while a command is in doubt.
    pub(super) fn check(&self) -> Outcome {
        if !self.exists.load(Ordering::SeqCst) {
            return Ok(());
        }
        let Some(about) = lock(&self.about).clone() else {
            return Ok(());
        };
        let message = format!(
            "not sent, because of an earlier command: {about}. Call SetQueuedCmdClear or \
                reconnect to send commands again; check where the arm is, and home it if needed"
        );
        Err(Fault::new(Code::Timeout, message))
    }

    pub(super) fn raise(&self, error: &Error) {
        lock(&self.about).get_or_insert_with(|| error.to_string());
        self.exists.store(true, Ordering::SeqCst);
    }

    pub(super) fn clear(&self) {
        *lock(&self.about) = None;
        self.exists.store(false, Ordering::SeqCst);
    }
}
