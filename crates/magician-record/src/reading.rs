use std::io;

use magician_protocol::AlarmSet;
use magician_protocol::commands::Pose;

/// What a host has read of an arm at an instant. Numbers are as the arm gave them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Seconds since the recording began.
    pub t: f64,
    /// Finished steps of a program, where they are counted. MCAP has no place for them.
    pub step: Option<u64>,
    /// Where the tool is, mm and deg, and the joint angles, deg.
    pub pose: Pose,
    /// Where the carriage is on its rail, mm, if there is one. Only MCAP has a place for it.
    pub rail: Option<f64>,
    /// The index of the queued command that finished last.
    pub index: u64,
    /// Free places in the command queue.
    pub left_space: u32,
    /// Its places in all.
    pub capacity: u32,
    /// The alarms that stand.
    pub alarms: AlarmSet,
}

/// A file that readings are written to, whatever its format.
pub trait WriteReadings {
    /// Writes a reading.
    ///
    /// # Errors
    /// What the writer reports.
    fn write(&mut self, reading: &Reading) -> io::Result<()>;

    /// Writes down what happened so many seconds after the beginning, in words; as a warning, or as a mere fact. A format
    /// of rows has no place for it.
    ///
    /// # Errors
    /// What the writer reports.
    fn note(&mut self, t: f64, warning: bool, words: &str) -> io::Result<()>;

    /// Hands on all that was written, so that it is in the file whatever happens to this program.
    ///
    /// # Errors
    /// What the writer reports.
    fn flush(&mut self) -> io::Result<()>;

    /// Completes the file.
    ///
    /// # Errors
    /// What the writer reports.
    fn finish(self: Box<Self>) -> io::Result<()>;
}
