//! What a caller learns beyond a number: the log, and the last fault of its thread.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ffi::CString;
use std::sync::{Mutex, PoisonError};

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Tells of a fault: to the log, and as the thread's last.
pub(crate) fn fault(function: &str, message: &str) {
    tracing::warn!("{function}: {message}");
    let text = format!("{function}: {message}").replace('\0', "");
    LAST.with(|last| *last.borrow_mut() = CString::new(text).unwrap_or_default());
}

/// The functions that [`once`] has told of.
static TOLD: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// Tells of something that is no fault, once a process and function.
pub(crate) fn once(function: &'static str, message: &str) {
    let mut told = TOLD.lock().unwrap_or_else(PoisonError::into_inner);
    if told.insert(function) {
        tracing::warn!("{function}: {message}");
    }
}
