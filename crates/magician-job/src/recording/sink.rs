//! File formats of a recording.

use std::path::Path;
use std::time::SystemTime;

use magician::Event;
use magician_program::{Surface, Tool};
use magician_record::Reading;
use serde::Serialize;

use super::{RecordError, program, readings};

/// Parameters known before the first reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct RecordingStart {
    /// Start time.
    pub(super) began: SystemTime,
    /// Rate of readings, Hz.
    pub(super) rate: f64,
    /// Largest distance between a program and the motion, mm.
    pub(super) tolerance: f64,
    /// Tool to which the first poses refer.
    pub(super) tool: Tool,
    pub(super) counts_steps: bool,
    /// True if a CSV file gets a line of units.
    pub(super) units: bool,
    /// Paper plane.
    pub(super) paper: Option<Surface>,
}

/// Receiver of readings.
pub(super) trait Sink: Send {
    /// Writes a reading; its pose refers to `tool`.
    fn write(&mut self, reading: &Reading, tool: Tool) -> Result<(), RecordError>;
    /// Writes an event at time `t`, s.
    fn note(&mut self, t: f64, event: &Event) -> Result<(), RecordError>;
    /// Makes all data written up to now survive a crash of this program.
    fn flush(&mut self) -> Result<(), RecordError>;
    /// Completes the file; returns the number of steps if it is a program.
    fn finish(&mut self) -> Result<Option<usize>, RecordError>;
}

/// Format of a recording, chosen by the extension of its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Format {
    /// Readings, for Foxglove.
    Mcap,
    /// Readings as CSV.
    Csv,
    /// Readings as JSON lines.
    Jsonl,
    /// Plan that repeats the motion.
    Plan,
    /// DobotStudio playback that repeats the motion.
    Playback,
}

impl Format {
    const EXTENSIONS: [(&str, Self); 8] = [
        (".mcap", Self::Mcap),
        (".csv", Self::Csv),
        (".jsonl", Self::Jsonl),
        (".ndjson", Self::Jsonl),
        (".plan.json", Self::Plan),
        (".plan", Self::Plan),
        (".playback", Self::Playback),
        // `run --record` has always written JSON lines under this extension.
        (".json", Self::Jsonl),
    ];

    /// Format for a file name.
    ///
    /// # Errors
    /// [`RecordError::Format`] for an unknown extension.
    pub fn of(path: &Path) -> Result<Self, RecordError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let name = name.to_ascii_lowercase();
        let mut known = Self::EXTENSIONS.into_iter();
        let found = known.find(|(end, _)| name.ends_with(end));
        let format = found.map(|(_, format)| format);
        format.ok_or_else(|| RecordError::Format(path.to_owned()))
    }

    /// True for a program that repeats the motion.
    #[must_use]
    pub fn is_program(self) -> bool {
        matches!(self, Self::Plan | Self::Playback)
    }

    pub(super) fn open(
        self,
        path: &Path,
        start: &RecordingStart,
    ) -> Result<Box<dyn Sink>, RecordError> {
        Ok(match self {
            Self::Mcap | Self::Csv | Self::Jsonl => {
                Box::new(readings::Readings::open(path, self, start)?)
            }
            Self::Plan | Self::Playback => Box::new(program::Program::open(path, self, start)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_extension_selects_the_format() {
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
