//! Outcome of a case.

use std::fmt::Write;

use magician_protocol::{Direction, FrameBuf, describe};

/// Outcome of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The arm met all expectations.
    Passed,
    /// The arm deviated.
    Failed(Box<Mismatch>),
    /// The case was not run, for this reason.
    Skipped(String),
}

/// Deviation of an arm from a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// Line of the step in its file; 0 if the initial state could not be reached.
    pub line: usize,
    /// Step as written.
    pub step: String,
    /// Last frame or bytes sent.
    pub sent: Vec<u8>,
    /// Expectation, in words or bytes.
    pub expected: String,
    /// Actual result, in words.
    pub got: String,
    /// Actual bytes.
    pub received: Vec<u8>,
}

/// Returns bytes as hex text.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len() * 3);
    for byte in bytes {
        let space = if text.is_empty() { "" } else { " " };
        // Writing to a string cannot fail.
        let _ = write!(text, "{space}{byte:02X}");
    }
    text
}

/// Describes a frame from the arm: command and fields.
#[must_use]
pub fn in_words(frame: &FrameBuf, direction: Direction) -> String {
    let frame = frame.frame();
    let known = describe(&frame, direction);
    let Ok(description) = known else {
        return format!(
            "id {}, Ctrl {:#04x}, {} parameter bytes",
            frame.id(),
            frame.ctrl().0,
            frame.params().len()
        );
    };
    let mut text = description.name.to_owned();
    if description.queued {
        text += " (queued)";
    }
    for (field, value) in description.values().into_iter().flatten() {
        let _ = write!(text, " {}={value}", field.name);
    }
    text
}
