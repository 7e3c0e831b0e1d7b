//! Readings as JSON lines: one object for each reading and each event.

use std::io::{self, Write};

use serde::Serialize;

use crate::{Reading, WriteReadings};

/// Writes one line with an object for each reading and each event.
///
/// ```
/// use magician_protocol::commands::Pose;
/// use magician_record::jsonl::JsonLines;
/// use magician_record::{Reading, WriteReadings};
///
/// let pose = Pose { x: 200.0, y: -1.5, z: 0.0, r: 0.0, joint_angle: [0.0, 45.0, 45.0, 0.0] };
/// let alarms = Default::default();
/// let reading = Reading { t: 0.0501, step: None, pose, rail: None, index: 3, left_space: 31, capacity: 32, alarms };
/// let mut file = Vec::new();
/// let mut lines = JsonLines::new(&mut file);
/// lines.write(&reading)?;
/// lines.note(0.06, true, "the cable was pulled")?;
/// drop(lines);
/// assert_eq!(
///     String::from_utf8(file)?,
///     "{\"t\":0.05,\"x\":200.0,\"y\":-1.5,\"z\":0.0,\"r\":0.0,\"j1\":0.0,\"j2\":45.0,\"j3\":45.0,\"j4\":0.0,\
///      \"index\":3,\"left_space\":31,\"alarms\":[]}\n\
///      {\"t\":0.06,\"event\":\"the cable was pulled\"}\n"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct JsonLines<W: Write>(W);

#[derive(Serialize)]
struct Row {
    t: f64,
    x: f32,
    y: f32,
    z: f32,
    r: f32,
    j1: f32,
    j2: f32,
    j3: f32,
    j4: f32,
    index: u64,
    left_space: u32,
    alarms: Vec<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<u64>,
}

#[derive(Serialize)]
struct Happened<'a> {
    t: f64,
    event: &'a str,
}

impl<W: Write> JsonLines<W> {
    /// Creates the writer.
    pub fn new(out: W) -> Self {
        Self(out)
    }

    fn line(&mut self, value: &impl Serialize) -> io::Result<()> {
        serde_json::to_writer(&mut self.0, value)?;
        writeln!(self.0)
    }
}

/// Rounds to milliseconds, the accuracy of the host's timestamps.
fn rounded(t: f64) -> f64 {
    (t * 1000.0).round() / 1000.0
}

impl<W: Write> WriteReadings for JsonLines<W> {
    fn write(&mut self, reading: &Reading) -> io::Result<()> {
        let pose = &reading.pose;
        let [j1, j2, j3, j4] = pose.joint_angle;
        self.line(&Row {
            t: rounded(reading.t),
            x: pose.x,
            y: pose.y,
            z: pose.z,
            r: pose.r,
            j1,
            j2,
            j3,
            j4,
            index: reading.index,
            left_space: reading.left_space,
            alarms: reading.alarms.codes().collect(),
            step: reading.step,
        })
    }

    fn note(&mut self, t: f64, _: bool, words: &str) -> io::Result<()> {
        let (t, event) = (rounded(t), words);
        self.line(&Happened { t, event })
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.0.flush()
    }
}
