//! Readings of a host, and the interface of the formats that store them.

use std::io;

use magician_protocol::AlarmSet;
use magician_protocol::commands::Pose;

/// State of an arm as read by a host at an instant. Numbers are as the arm sent them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Seconds since the start of the recording.
    pub t: f64,
    /// Number of finished steps of a program, if counted. Not stored in MCAP.
    pub step: Option<u64>,
    /// Pose of the tool, mm and deg, and joint angles, deg.
    pub pose: Pose,
    /// Position of the rail's carriage, mm; `None` without a rail. Stored in MCAP only.
    pub rail: Option<f64>,
    /// Index of the queued command that finished last.
    pub index: u64,
    /// Number of free places in the command queue.
    pub left_space: u32,
    /// Number of places in the command queue.
    pub capacity: u32,
    /// Standing alarms.
    pub alarms: AlarmSet,
}

/// A file of readings in some format.
pub trait WriteReadings {
    /// Writes a reading.
    ///
    /// # Errors
    /// Errors of the writer.
    fn write(&mut self, reading: &Reading) -> io::Result<()>;

    /// Writes an event, `t` seconds after the start, as a warning or as information. Formats of
    /// rows drop it.
    ///
    /// # Errors
    /// Errors of the writer.
    fn note(&mut self, t: f64, warning: bool, words: &str) -> io::Result<()>;

    /// Flushes everything written, so that it survives a crash of this program.
    ///
    /// # Errors
    /// Errors of the writer.
    fn flush(&mut self) -> io::Result<()>;

    /// Completes the file.
    ///
    /// # Errors
    /// Errors of the writer.
    fn finish(self: Box<Self>) -> io::Result<()>;
}
