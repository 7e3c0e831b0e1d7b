//! A command that the arm may or may not have taken.
//!
//! Stock wrappers send a command again for as long as they get anything but 0. If the arm had taken the first one, it
//! would move twice. So while it is in doubt, every further command that may not be repeated is refused: the arm's
//! position is unknown, and later commands were made for another one.
//!
//! `SetQueuedCmdClear` ends it, once the arm has confirmed that: what was in doubt waits no more. Neither
//! `SetQueuedCmdStopExec` nor `SetQueuedCmdForceStopExec` does; both leave what waits in the queue, and the next
//! `SetQueuedCmdStartExec` would run it and its copy. A new `ConnectDobot` begins without doubt.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use magician::Error;

use super::registry::lock;
use crate::code::{Code, Fault, Outcome};

/// Whether there is a doubt, and which.
#[derive(Debug, Default)]
pub(super) struct Doubt {
    exists: AtomicBool,
    about: Mutex<Option<String>>,
}

impl Doubt {
    /// Nothing goes out while there is a doubt.
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

    pub(super) fn arise(&self, error: &Error) {
        lock(&self.about).get_or_insert_with(|| error.to_string());
        self.exists.store(true, Ordering::SeqCst);
    }

    pub(super) fn lift(&self) {
        *lock(&self.about) = None;
        self.exists.store(false, Ordering::SeqCst);
    }
}
