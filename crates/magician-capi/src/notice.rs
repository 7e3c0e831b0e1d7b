//! Reports to the caller beyond a return code: the log, and the last fault of the calling thread.
//!
//! A program may repeat a failing call in a loop, and must not fill the disk with its log. A fault
//! is therefore logged once per function and arm, and again only after a different fault or a
//! success of the same function.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::c_int;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use magician::protocol::visible_lines;
use tracing::Level;

use crate::code::{Code, Fault, Outcome};
use crate::log;

thread_local! {
    /// Sentence of the last fault on this thread.
    static LAST_FAULT: RefCell<String> = const { RefCell::new(String::new()) };
    /// Arguments and results of the current call, for the log.
    static NOTES: RefCell<String> = const { RefCell::new(String::new()) };
    /// True if the current call is logged, so that notes are collected.
    static IS_LOGGED: Cell<bool> = const { Cell::new(false) };
}

/// Function, and id of the arm. The id is 0 if no arm is concerned.
type About = (&'static str, c_int);

/// Last logged fault of each function.
static LOGGED: Mutex<BTreeMap<About, String>> = Mutex::new(BTreeMap::new());
/// Most entries of [`LOGGED`], because a program may use arbitrary ids.
const MAX_LOGGED: usize = 1024;
/// Number of entries, so that successful calls take no lock as long as nothing has failed.
static LOGGED_COUNT: AtomicUsize = AtomicUsize::new(0);

/// Installs the log.
pub(crate) fn install_log() {
    log::install();
}

/// Starts the log entry of a call.
pub(crate) fn begin() {
    let noted = tracing::enabled!(Level::DEBUG);
    IS_LOGGED.set(noted);
    if noted {
        NOTES.with_borrow_mut(String::clear);
    }
}

/// Adds text to the log entry of the current call.
pub(crate) fn note(text: impl FnOnce() -> String) {
    if IS_LOGGED.get() {
        let text = text();
        NOTES.with_borrow_mut(|notes| {
            if !text.is_empty() {
                notes.push(' ');
                notes.push_str(&text);
            }
        });
    }
}

/// Finishes a call: logs it, and returns the code for C.
pub(crate) fn finish(about: About, outcome: &Outcome, took: Duration) -> c_int {
    let (function, _) = about;
    let code = match outcome {
        Ok(()) => {
            succeeded_at(about);
            Code::NoError as c_int
        }
        // `DisconnectDobot` ended the call: C gets 0 and unchanged results.
        Err(released) if released.code == Code::NoError => Code::NoError as c_int,
        Err(fault) => fault_at(about, fault),
    };
    if IS_LOGGED.replace(false) {
        NOTES.with_borrow(|notes| {
            let milliseconds = took.as_secs_f64() * 1e3;
            let why = outcome.as_ref().err().map(|fault| format!(": {fault}"));
            let why = why.unwrap_or_default();
            tracing::debug!("{function}{notes} -> {code} ({milliseconds:.2} ms){why}");
        });
    }
    code
}

/// Runs and logs a function that concerns no arm.
pub(crate) fn host(
    function: &'static str,
    arguments: impl FnOnce() -> String,
    act: impl FnOnce() -> c_int,
) -> c_int {
    let begun = Instant::now();
    let result = act();
    if tracing::enabled!(Level::DEBUG) {
        let milliseconds = begun.elapsed().as_secs_f64() * 1e3;
        let arguments = arguments();
        tracing::debug!("{function} {arguments} -> {result} ({milliseconds:.2} ms)");
    }
    result
}

/// Records the success of a function that concerns no arm: its next fault is logged again.
pub(crate) fn succeeded(function: &'static str) {
    succeeded_at((function, 0));
}

fn succeeded_at(about: About) {
    if LOGGED_COUNT.load(Ordering::Relaxed) > 0 {
        let mut logged = logged();
        logged.remove(&about);
        LOGGED_COUNT.store(logged.len(), Ordering::Relaxed);
    }
}

/// Reports a fault of a function that concerns no arm, to the log and as the thread's last fault.
/// Returns the code for C.
pub(crate) fn fault(function: &'static str, fault: &Fault) -> c_int {
    fault_at((function, 0), fault)
}

fn fault_at(about: About, fault: &Fault) -> c_int {
    let (function, _) = about;
    remember(function, &fault.message);
    // Not logged: programs fill the queue until it is full, and so pace themselves.
    if fault.code != Code::BufferFull && is_new(about, &fault.message) {
        tracing::warn!("{}", named(function, &fault.message));
    }
    fault.code as c_int
}

/// Logs a warning and stores it as the thread's last fault, although the call succeeds.
pub(crate) fn warn(function: &'static str, message: &str) {
    remember(function, message);
    tracing::warn!("{}", named(function, message));
}

/// Stores a fault as the thread's last one without logging it: in a forked child another thread may
/// have held the locks of the log.
pub(crate) fn remember_unlogged(function: &'static str, fault: &Fault) -> c_int {
    remember(function, &fault.message);
    fault.code as c_int
}

/// Logs a warning about a function, once in the life of the library.
pub(crate) fn warn_once(function: &'static str, message: &str) {
    static WARNED: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut warned = WARNED.lock().unwrap_or_else(PoisonError::into_inner);
    if warned.insert(function) {
        tracing::warn!("{function}: {message}");
    }
}

/// Sentence of the thread's last fault. Empty if there was no fault, or while the thread ends.
pub(crate) fn sentence() -> String {
    LAST_FAULT
        .try_with(|last| last.borrow().clone())
        .unwrap_or_default()
}

/// Sets the sentence of the thread's last fault.
pub(crate) fn set_sentence(sentence: String) {
    let _ = LAST_FAULT.try_with(|last| last.replace(sentence));
}

/// Puts the name of the function before the message, unless the driver has already done so. Control
/// characters are escaped, because the message may quote text of a program or an arm and will be
/// printed.
fn named(function: &str, message: &str) -> String {
    let message = visible_lines(message);
    match message.to_string() {
        message
            if message
                .strip_prefix(function)
                .is_some_and(|rest| rest.starts_with(": ")) =>
        {
            message
        }
        message => format!("{function}: {message}"),
    }
}

fn remember(function: &str, message: &str) {
    set_sentence(named(function, message).replace('\0', ""));
}

fn is_new(about: About, message: &str) -> bool {
    let mut logged = logged();
    if logged.len() >= MAX_LOGGED {
        logged.clear();
    }
    let before = logged.insert(about, message.to_owned());
    LOGGED_COUNT.store(logged.len(), Ordering::Relaxed);
    before.is_none_or(|before| before != message)
}

fn logged() -> MutexGuard<'static, BTreeMap<About, String>> {
    LOGGED.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn function_name_is_not_repeated() {
        assert_eq!(named("GetPose", "GetPose: gone"), "GetPose: gone");
        assert_eq!(
            named("GetPose", "GetPoseL: gone"),
            "GetPose: GetPoseL: gone"
        );
        assert_eq!(named("GetPose", "gone"), "GetPose: gone");
    }

    #[test]
    fn text_of_an_arm_is_escaped() {
        let quoted = named("GetPose", "the arm \x1b]0;x\x07 is gone");
        assert_eq!(quoted, r"GetPose: the arm \u{1b}]0;x\u{7} is gone");
    }
}
