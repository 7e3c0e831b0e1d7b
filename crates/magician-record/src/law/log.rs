//! Readings, parsed from the files that a recording writes.

use magician_protocol::commands;
use magician_protocol::{Direction, Frame, Layout, Readable};
use serde::Deserialize;
use thiserror::Error;

use crate::replay::{Replay, values_of};

/// A pose, and the time at which the host asked for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Seconds on the host's clock.
    pub t: f64,
    /// x, y, z in mm; r and J1 to J4 in deg.
    pub values: [f64; 8],
}

/// Readings of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Samples in order of time.
    pub samples: Vec<Sample>,
    /// True if the last line was cut off and is left out.
    pub cut: bool,
}

/// Reason why a file is not a log of readings.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file has no readings.
    #[error("it has no readings")]
    Empty,
    /// The file is of another kind.
    #[error(
        "it is neither a trace nor readings: it has no line of column names with t, x, y and z, and no JSON objects with them"
    )]
    Foreign,
    /// A line is invalid.
    #[error("line {line}: {what}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// Reason.
        what: String,
    },
    /// A recording cannot be read.
    #[error("the recording cannot be read: {0}")]
    Recording(String),
}

/// Names of the columns of a table, and of the fields of an object.
const NAMES: [&str; 9] = ["t", "x", "y", "z", "r", "j1", "j2", "j3", "j4"];

impl Samples {
    /// Parses a table (CSV), JSON lines, or a recording (MCAP) without frames.
    ///
    /// ```
    /// use magician_record::law::Samples;
    ///
    /// let log = Samples::read(b"t,x,y,z\n0.00,200,0,50\n0.05,200.1,0,50\n")?;
    /// assert_eq!((log.samples.len(), log.samples[1].values[0]), (2, 200.1));
    /// # Ok::<(), magician_record::law::LogError>(())
    /// ```
    ///
    /// # Errors
    /// [`LogError`] if the file is of another kind, damaged, or has no readings.
    pub fn read(bytes: &[u8]) -> Result<Self, LogError> {
        if crate::mcap::is_recording(bytes) {
            return Self::recording(bytes);
        }
        let blank = bytes.iter().all(u8::is_ascii_whitespace);
        if blank {
            return Err(LogError::Empty);
        }
        let text = std::str::from_utf8(bytes).map_err(|_| LogError::Foreign)?;
        let log = if text.trim_start().starts_with('{') {
            Self::objects(text)
        } else {
            Self::table(text)
        }?;
        log.checked()
    }

    /// Extracts the poses of a session, with the times of their requests.
    #[must_use]
    pub fn of_session(session: &Replay<'_>) -> Self {
        let row = <commands::Pose as Readable>::ROW;
        let first = session.packets().first().map_or(0, |packet| packet.time);
        let mut asked = None;
        let mut samples = Vec::new();
        for packet in session.packets() {
            let Some(frame) = Frame::new(packet.bytes).filter(|frame| frame.id() == row.id) else {
                continue;
            };
            match packet.direction {
                Some(Direction::Request) => asked = Some(packet.time),
                Some(Direction::Reply) => {
                    let at = asked.take().unwrap_or(packet.time);
                    if let Ok(pose) = commands::Pose::decode(frame.params()) {
                        let t = at.saturating_sub(first) as f64 / 1e6;
                        let values = values_of(&pose);
                        samples.push(Sample { t, values });
                    }
                }
                None => {}
            }
        }
        samples.retain(|sample| sample.values.iter().all(|value| value.is_finite()));
        Self {
            samples,
            cut: false,
        }
    }

    fn table(text: &str) -> Result<Self, LogError> {
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.is_empty());
        let (_, names) = lines.next().ok_or(LogError::Empty)?;
        let names: Vec<&str> = names.split(',').map(str::trim).collect();
        let columns = NAMES.map(|name| names.iter().position(|own| own.eq_ignore_ascii_case(name)));
        if columns[..4].iter().any(Option::is_none) {
            return Err(LogError::Foreign);
        }
        let mut log = Self::default();
        let is_whole = text.ends_with('\n');
        let mut lines = lines.peekable();
        // A line with the units of the columns.
        lines.next_if(|(_, line)| {
            let mut cells = line.split(',').map(str::trim);
            cells.all(|cell| ["", "s", "mm", "deg"].contains(&cell))
        });
        while let Some((line, text)) = lines.next() {
            // A last line without a newline may be cut in the middle of a number.
            if lines.peek().is_none() && !is_whole {
                log.cut = true;
                break;
            }
            let cells: Vec<&str> = text.split(',').map(str::trim).collect();
            let mut numbers = [0.0; NAMES.len()];
            for ((number, column), name) in numbers.iter_mut().zip(columns).zip(NAMES) {
                let Some(column) = column else { continue };
                let cell = cells.get(column).copied().unwrap_or_default();
                *number = number_in(cell).ok_or_else(|| LogError::Line {
                    line,
                    what: format!("{name} is '{}', which is no number", cell.escape_debug()),
                })?;
            }
            log.push(line, numbers)?;
        }
        Ok(log)
    }

    fn objects(text: &str) -> Result<Self, LogError> {
        #[derive(Deserialize)]
        struct Row {
            t: Option<f64>,
            x: Option<f64>,
            y: Option<f64>,
            z: Option<f64>,
            #[serde(default)]
            r: f64,
            #[serde(default)]
            j1: f64,
            #[serde(default)]
            j2: f64,
            #[serde(default)]
            j3: f64,
            #[serde(default)]
            j4: f64,
            event: Option<serde_json::Value>,
        }
        let mut log = Self::default();
        let is_whole = text.ends_with('\n');
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.is_empty());
        let mut lines = lines.by_ref().peekable();
        while let Some((line, text)) = lines.next() {
            let wrong = |what: String| LogError::Line { line, what };
            let row: Row = match serde_json::from_str(text) {
                Ok(row) => row,
                Err(_) if lines.peek().is_none() && !is_whole => {
                    log.cut = true;
                    break;
                }
                Err(error) => return Err(wrong(error.to_string())),
            };
            if row.event.is_some() {
                continue;
            }
            let Row {
                t: Some(t),
                x: Some(x),
                y: Some(y),
                z: Some(z),
                ..
            } = row
            else {
                return Err(if log.samples.is_empty() {
                    LogError::Foreign
                } else {
                    wrong("t, x, y or z is missing".to_owned())
                });
            };
            log.push(line, [t, x, y, z, row.r, row.j1, row.j2, row.j3, row.j4])?;
        }
        Ok(log)
    }

    fn recording(bytes: &[u8]) -> Result<Self, LogError> {
        #[derive(Deserialize)]
        struct PoseInFrame {
            pose: Placed,
        }
        #[derive(Deserialize)]
        struct Placed {
            position: Position,
            orientation: Orientation,
        }
        #[derive(Deserialize)]
        struct Position {
            x: f64,
            y: f64,
            z: f64,
        }
        #[derive(Deserialize)]
        struct Orientation {
            z: f64,
            w: f64,
        }
        #[derive(Deserialize)]
        struct Joints {
            joints: Vec<Joint>,
        }
        #[derive(Deserialize)]
        struct Joint {
            position: f64,
        }
        let unreadable = |error: mcap::McapError| LogError::Recording(error.to_string());
        // A killed recorder leaves no end magic.
        let options = mcap::read::Options::IgnoreEndMagic.into();
        let messages = mcap::MessageStream::new_with_options(bytes, options).map_err(unreadable)?;
        let mut log = Self::default();
        let mut begin = None;
        // Records have no markers to synchronise on, so everything behind damaged bytes is lost.
        for (number, message) in (1..).zip(messages.map_while(Result::ok)) {
            let wrong = |error: serde_json::Error| LogError::Line {
                line: number,
                what: error.to_string(),
            };
            match message.channel.topic.as_str() {
                "/pose" => {
                    let read: PoseInFrame = serde_json::from_slice(&message.data).map_err(wrong)?;
                    let begin = *begin.get_or_insert(message.log_time);
                    let t = message.log_time.saturating_sub(begin) as f64 / 1e9;
                    let Placed {
                        position,
                        orientation,
                    } = read.pose;
                    let r = 2.0 * libm::atan2(orientation.z, orientation.w).to_degrees();
                    let [x, y, z] = [position.x, position.y, position.z].map(|m| m * 1000.0);
                    log.push(number, [t, x, y, z, r, 0.0, 0.0, 0.0, 0.0])?;
                }
                "/joints" => {
                    let read: Joints = serde_json::from_slice(&message.data).map_err(wrong)?;
                    if let Some(last) = log.samples.last_mut() {
                        let angles = last.values[4..].iter_mut().zip(&read.joints);
                        for (own, joint) in angles.filter(|(_, joint)| joint.position.is_finite()) {
                            *own = joint.position.to_degrees();
                        }
                    }
                }
                // Other topics hold no pose.
                _ => {}
            }
        }
        log.checked()
    }

    fn push(&mut self, line: usize, numbers: [f64; 9]) -> Result<(), LogError> {
        let [t, values @ ..] = numbers;
        let wrong = |what: String| LogError::Line { line, what };
        if let Some((name, value)) = NAMES.iter().zip(numbers).find(|(_, v)| !v.is_finite()) {
            return Err(wrong(format!("{name} is {value}")));
        }
        if self.samples.last().is_some_and(|last| t < last.t) {
            return Err(wrong(
                "its time is before that of the line before".to_owned(),
            ));
        }
        self.samples.push(Sample { t, values });
        Ok(())
    }

    fn checked(self) -> Result<Self, LogError> {
        if self.samples.is_empty() {
            Err(LogError::Empty)
        } else {
            Ok(self)
        }
    }
}

/// Parses a number of a table. NaN and infinity are accepted here and refused by the caller.
fn number_in(cell: &str) -> Option<f64> {
    cell.parse().ok()
}
