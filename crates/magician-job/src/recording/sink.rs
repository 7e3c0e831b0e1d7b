//! The files that a recording can be.

use std::path::Path;
use std::time::SystemTime;

use magician::Event;
use magician_program::{Surface, Tool};
use magician_record::Reading;
use serde::Serialize;

use super::{RecordError, program, readings};

/// What is known before the first reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beginning {
    /// When it began.
    pub(super) began: SystemTime,
    /// Readings a second.
    pub(super) rate: f64,
    /// How far a program may be from the motion, mm.
    pub(super) tolerance: f64,
    /// The tool that poses are counted for at first.
    pub(super) tool: Tool,
    pub(super) counts_steps: bool,
    /// Whether rows have a line of units.
    pub(super) units: bool,
    /// Where a pen draws.
    pub(super) paper: Option<Surface>,
}

/// Where readings go.
pub(super) trait Sink: Send {
    /// A reading, and the tool that its pose is counted for.
    fn write(&mut self, reading: &Reading, tool: Tool) -> Result<(), RecordError>;
    /// Something has happened.
    fn note(&mut self, t: f64, event: &Event) -> Result<(), RecordError>;
    /// What was written is to outlive this program from now on.
    fn flush(&mut self) -> Result<(), RecordError>;
    /// No more come; steps of the program, if it is one.
    fn finish(&mut self) -> Result<Option<usize>, RecordError>;
}

/// What a recording can be, by the end of its file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Format {
    /// Readings, for Foxglove.
    Mcap,
    /// Readings as rows.
    Csv,
    /// Readings as JSON lines.
    Jsonl,
    /// A program of ours that repeats the motion.
    Plan,
    /// The same for DobotStudio.
    Playback,
}

impl Format {
    const ENDS: [(&str, Self); 8] = [
        (".mcap", Self::Mcap),
        (".csv", Self::Csv),
        (".jsonl", Self::Jsonl),
        (".ndjson", Self::Jsonl),
        (".plan.json", Self::Plan),
        (".plan", Self::Plan),
        (".playback", Self::Playback),
        // What `run --record` has taken for lines of objects.
        (".json", Self::Jsonl),
    ];

    /// What a file is to be.
    ///
    /// # Errors
    /// [`RecordError::Format`] for any other name.
    pub fn of(path: &Path) -> Result<Self, RecordError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let name = name.to_ascii_lowercase();
        let mut known = Self::ENDS.into_iter();
        let found = known.find(|(end, _)| name.ends_with(end));
        let format = found.map(|(_, format)| format);
        format.ok_or_else(|| RecordError::Format(path.to_owned()))
    }

    /// Whether it is a program that repeats the motion.
    #[must_use]
    pub fn is_program(self) -> bool {
        matches!(self, Self::Plan | Self::Playback)
    }

    pub(super) fn open(
        self,
        path: &Path,
        beginning: &Beginning,
    ) -> Result<Box<dyn Sink>, RecordError> {
        Ok(match self {
            Self::Mcap | Self::Csv | Self::Jsonl => {
                Box::new(readings::Readings::open(path, self, beginning)?)
            }
            Self::Plan | Self::Playback => Box::new(program::Program::open(path, self, beginning)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_a_name_says_what_it_is() {
        for (name, format) in [
            ("a.mcap", Format::Mcap),
            ("A.CSV", Format::Csv),
            ("a.b.jsonl", Format::Jsonl),
            ("a.plan.json", Format::Plan),
            ("a.playback", Format::Playback),
        ] {
            assert_eq!(Format::of(Path::new(name)).ok(), Some(format), "{name}");
        }
        for name in ["a", "a.txt", "csv", ".."] {
            assert!(Format::of(Path::new(name)).is_err(), "{name}");
        }
    }
}
