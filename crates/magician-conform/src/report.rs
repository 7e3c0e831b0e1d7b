//! What came of a case.

use std::fmt::Write;

use magician_protocol::{Direction, FrameBuf, describe};

/// What came of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The arm did all of it.
    Passed,
    /// The arm did something else.
    Failed(Box<Mismatch>),
    /// It was not done, and why.
    Skipped(String),
}

/// Where an arm did something else than a case says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// Line of the step in its file, 0 when the arm could not be brought to where the case begins.
    pub line: usize,
    /// The step, as it is written.
    pub step: String,
    /// The frame or bytes sent last.
    pub sent: Vec<u8>,
    /// What was expected, in words or bytes.
    pub expected: String,
    /// What came instead, in words.
    pub got: String,
    /// What came instead, as it came.
    pub received: Vec<u8>,
}

/// Bytes as people write them.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len() * 3);
    for byte in bytes {
        let space = if text.is_empty() { "" } else { " " };
        // A string takes whatever is written.
        let _ = write!(text, "{space}{byte:02X}");
    }
    text
}

/// A frame from the arm in words: command and fields.
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
