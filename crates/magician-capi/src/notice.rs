//! What a caller learns beyond a number: the log, and the last fault of its thread.

use std::cell::RefCell;
use std::ffi::CString;

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Tells of a fault: to the log, and as the thread's last.
pub(crate) fn fault(function: &str, message: &str) {
    tracing::warn!("{function}: {message}");
    let text = format!("{function}: {message}").replace('\0', "");
    LAST.with(|last| *last.borrow_mut() = CString::new(text).unwrap_or_default());
}
