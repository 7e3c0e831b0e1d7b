//! What a caller learns beyond a number: the log, and the last fault of its thread.
//!
//! A program that loops over a call that fails fills no disk: a fault of a function is told once an arm, and again after
//! another one, or after the function has done its work there.

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
    /// The sentence of the thread's last fault.
    static LAST: RefCell<String> = const { RefCell::new(String::new()) };
    /// What the call under way has sent and got, for the log.
    static NOTES: RefCell<String> = const { RefCell::new(String::new()) };
    /// Whether a sink is registered.
    static NOTED: Cell<bool> = const { Cell::new(false) };
}

/// A function, and the id of the arm that it was about; 0 if about none.
type About = (&'static str, c_int);

/// What was told last of a function.
static TOLD: Mutex<BTreeMap<About, String>> = Mutex::new(BTreeMap::new());
/// Most that are remembered: a program may make up ids.
const MOST_TOLD: usize = 1024;
/// How many there are: nothing is looked up as long as nothing fails.
static COUNT: AtomicUsize = AtomicUsize::new(0);

/// Begins to listen, once in the life of the library.
pub(crate) fn listen() {
    log::begin();
}

/// A call begins.
pub(crate) fn begin() {
    let noted = tracing::enabled!(Level::DEBUG);
    NOTED.set(noted);
    if noted {
        NOTES.with_borrow_mut(String::clear);
    }
}

/// Adds to what is logged of the call under way.
pub(crate) fn note(text: impl FnOnce() -> String) {
    if NOTED.get() {
        let text = text();
        NOTES.with_borrow_mut(|notes| {
            if !text.is_empty() {
                notes.push(' ');
                notes.push_str(&text);
            }
        });
    }
}

/// A call has ended; what C gets.
pub(crate) fn ended(about: About, outcome: &Outcome, took: Duration) -> c_int {
    let (function, _) = about;
    let code = match outcome {
        Ok(()) => {
            succeeded_at(about);
            Code::NoError as c_int
        }
        Err(released) if released.code == Code::NoError => Code::NoError as c_int,
        Err(fault) => fault_at(about, fault),
    };
    if NOTED.replace(false) {
        NOTES.with_borrow(|notes| {
            let milliseconds = took.as_secs_f64() * 1e3;
            let why = outcome.as_ref().err().map(|fault| format!(": {fault}"));
            let why = why.unwrap_or_default();
            tracing::debug!("{function}{notes} -> {code} ({milliseconds:.2} ms){why}");
        });
    }
    code
}

/// Does what a function does that is about no arm, and logs it.
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

/// A function that is about no arm did its work: its next fault is told.
pub(crate) fn succeeded(function: &'static str) {
    succeeded_at((function, 0));
}

fn succeeded_at(about: About) {
    if COUNT.load(Ordering::Relaxed) > 0 {
        let mut told = told();
        told.remove(&about);
        COUNT.store(told.len(), Ordering::Relaxed);
    }
}

/// Tells of a fault of a function that is about no arm: to the log, and as the thread's last; what C gets.
pub(crate) fn fault(function: &'static str, fault: &Fault) -> c_int {
    fault_at((function, 0), fault)
}

fn fault_at(about: About, fault: &Fault) -> c_int {
    let (function, _) = about;
    remember(function, &fault.message);
    // A full queue is how programs pace themselves.
    if fault.code != Code::BufferFull && is_new(about, &fault.message) {
        tracing::warn!("{}", named(function, &fault.message));
    }
    fault.code as c_int
}

/// Tells of what is no fault to C.
pub(crate) fn warn(function: &'static str, message: &str) {
    remember(function, message);
    tracing::warn!("{}", named(function, message));
}

/// Reports an error to its listeners, without a lock that another thread may hold.
pub(crate) fn quietly(function: &'static str, fault: &Fault) -> c_int {
    remember(function, &fault.message);
    fault.code as c_int
}

/// Tells something of a function, once in the life of the library.
pub(crate) fn once(function: &'static str, message: &str) {
    static SAID: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
    if said.insert(function) {
        tracing::warn!("{function}: {message}");
    }
}

/// The sentence of the thread's last fault; empty if there was none, or if the thread is about to end.
pub(crate) fn sentence() -> String {
    LAST.try_with(|last| last.borrow().clone())
        .unwrap_or_default()
}

/// Makes it the sentence of the thread's last fault.
pub(crate) fn recall(sentence: String) {
    let _ = LAST.try_with(|last| last.replace(sentence));
}

/// The message with the function's name before it, which the driver may have put there: most commands bear it. It may
/// quote what a program or an arm said; programs print it.
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
    recall(named(function, message).replace('\0', ""));
}

fn is_new(about: About, message: &str) -> bool {
    let mut told = told();
    if told.len() >= MOST_TOLD {
        told.clear();
    }
    let before = told.insert(about, message.to_owned());
    COUNT.store(told.len(), Ordering::Relaxed);
    before.is_none_or(|before| before != message)
}

fn told() -> MutexGuard<'static, BTreeMap<About, String>> {
    TOLD.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_is_named_once() {
        assert_eq!(named("GetPose", "GetPose: gone"), "GetPose: gone");
        assert_eq!(
            named("GetPose", "GetPoseL: gone"),
            "GetPose: GetPoseL: gone"
        );
        assert_eq!(named("GetPose", "gone"), "GetPose: gone");
    }

    #[test]
    fn what_an_arm_said_is_quoted_harmlessly() {
        let quoted = named("GetPose", "the arm \x1b]0;x\x07 is gone");
        assert_eq!(quoted, r"GetPose: the arm \u{1b}]0;x\u{7} is gone");
    }
}
