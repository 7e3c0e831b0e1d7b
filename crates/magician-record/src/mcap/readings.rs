//! What a host sees of an arm, as a recording.

use std::io::{self, Write};

use magician_motion::{JointAngles, Pose};

use super::file::{File, Topic};
use super::message::{Alarms, Joints, Log, PoseInFrame, QueueFromOutside};
use super::{Micros, SECOND};
use crate::{Reading, WriteReadings};

/// Writes readings of a host in the topics of a recording, with the same schemas. What was not read is absent; queue and
/// alarms are written when they change, and every second.
///
/// ```
/// use magician_protocol::commands::Pose;
/// use magician_record::mcap::Readings;
/// use magician_record::{Reading, WriteReadings};
///
/// let pose = Pose { x: 200.0, y: 0.0, z: 0.0, r: 0.0, joint_angle: [0.0, 45.0, 45.0, 0.0] };
/// let alarms = Default::default();
/// let first = Reading { t: 0.0, step: None, pose, rail: None, index: 0, left_space: 32, capacity: 32, alarms };
/// let mut readings = Readings::new(Vec::new(), 0, 20.0)?;
/// readings.write(&first)?;
/// readings.write(&Reading { t: 0.05, ..first })?;
/// let file = readings.into_file()?;
///
/// let topics: Vec<_> = mcap::MessageStream::new(&file)?
///     .map(|message| message.map(|message| message.channel.topic.clone()))
///     .collect::<Result<_, _>>()?;
/// assert_eq!(topics, ["/pose", "/joints", "/queue", "/alarms", "/pose", "/joints"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Readings<W: Write> {
    file: File<W>,
    last: Option<Reading>,
    /// When everything is written again.
    again: Micros,
}

impl<W: Write> Readings<W> {
    /// Begins a recording of so many readings a second, on a clock that showed 0 at `epoch`, in nanoseconds since 1970.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn new(out: W, epoch: u64, rate: f64) -> io::Result<Self> {
        Ok(Self {
            file: File::begin(out, "host", epoch, &rate.to_string())?,
            last: None,
            again: 0,
        })
    }

    /// Writes summary and index, and gives back what was written to; the file is whole.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn into_file(self) -> io::Result<W> {
        self.file.finish()
    }
}

fn micros(seconds: f64) -> Micros {
    (seconds * 1e6) as Micros
}

impl<W: Write> WriteReadings for Readings<W> {
    fn write(&mut self, reading: &Reading) -> io::Result<()> {
        let now = micros(reading.t);
        let all = now >= self.again;
        let last = self.last.replace(*reading).filter(|_| !all);
        let file = &mut self.file;
        let place = [
            reading.pose.x,
            reading.pose.y,
            reading.pose.z,
            reading.pose.r,
        ];
        let pose = Pose::from(place.map(f64::from));
        let joints = JointAngles::from(reading.pose.joint_angle.map(f64::from));
        file.write(Topic::Pose, now, |t| PoseInFrame::new(t, &pose))?;
        file.write(Topic::Joints, now, |t| {
            Joints::new(t, &joints, reading.rail)
        })?;
        let queue = |of: &Reading| (of.capacity, of.left_space, of.index);
        if last.is_none_or(|last| queue(&last) != queue(reading)) {
            file.write(Topic::Queue, now, |timestamp| QueueFromOutside {
                timestamp,
                capacity: reading.capacity,
                waiting: reading.capacity.saturating_sub(reading.left_space),
                current_index: reading.index,
            })?;
        }
        if last.is_none_or(|last| last.alarms != reading.alarms) {
            file.write(Topic::Alarms, now, |t| Alarms::new(t, &reading.alarms))?;
        }
        if all {
            self.again = now.saturating_add(SECOND);
        }
        Ok(())
    }

    fn note(&mut self, t: f64, warning: bool, words: &str) -> io::Result<()> {
        self.file.write(Topic::Events, micros(t), |t| {
            Log::noticed(t, warning, words)
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.into_file().map(drop)
    }
}
