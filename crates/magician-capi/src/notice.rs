//! What a caller learns beyond a number: the log, and the last fault of its thread.
//!
//! A program that loops over a call that fails fills no disk: a fault of a function is told once, and again after another
//! one, or after the function has done its work.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::c_int;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tracing::Level;

use crate::code::{Code, Fault, Outcome};
use crate::log;

thread_local! {
    /// The sentence of the thread's last fault.
    static LAST: RefCell<String> = const { RefCell::new(String::new()) };
    /// What the call under way has sent and got, for the log.
    static NOTES: RefCell<String> = const { RefCell::new(String::new()) };
    /// Whether somebody wants to know.
    static NOTED: Cell<bool> = const { Cell::new(false) };
}

/// What was told last of a function.
static TOLD: Mutex<BTreeMap<&'static str, String>> = Mutex::new(BTreeMap::new());
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
pub(crate) fn ended(function: &'static str, outcome: &Outcome, took: Duration) -> c_int {
    let code = match outcome {
        Ok(()) => {
            succeeded(function);
            Code::NoError as c_int
        }
        Err(released) if released.code == Code::NoError => Code::NoError as c_int,
        Err(fault) => self::fault(function, fault),
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

/// A function did its work: its next fault is told.
pub(crate) fn succeeded(function: &'static str) {
    if COUNT.load(Ordering::Relaxed) > 0 {
        let mut told = told();
        told.remove(function);
        COUNT.store(told.len(), Ordering::Relaxed);
    }
}

/// Tells of a fault: to the log, and as the thread's last; what C gets.
pub(crate) fn fault(function: &'static str, fault: &Fault) -> c_int {
    remember(function, &fault.message);
    // A full queue is how programs pace themselves.
    if fault.code != Code::BufferFull && is_new(function, &fault.message) {
        tracing::warn!("{function}: {fault}");
    }
    fault.code as c_int
}

/// Tells of what is no fault to C.
pub(crate) fn warn(function: &'static str, message: &str) {
    remember(function, message);
    tracing::warn!("{function}: {message}");
}

/// Tells of a fault to those who ask for it, with no lock that another thread may hold.
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

/// Looks at the sentence of the thread's last fault.
pub(crate) fn last<T>(look: impl FnOnce(&str) -> T) -> T {
    LAST.with_borrow(|last| look(last))
}

fn remember(function: &str, message: &str) {
    let text = format!("{function}: {message}").replace('\0', "");
    LAST.with_borrow_mut(|last| *last = text);
}

fn is_new(function: &'static str, message: &str) -> bool {
    let mut told = told();
    let before = told.insert(function, message.to_owned());
    COUNT.store(told.len(), Ordering::Relaxed);
    before.is_none_or(|before| before != message)
}

fn told() -> MutexGuard<'static, BTreeMap<&'static str, String>> {
    TOLD.lock().unwrap_or_else(PoisonError::into_inner)
}
