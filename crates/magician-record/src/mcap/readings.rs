//! What a host sees of an arm, as a recording.

use std::io::{self, Write};

use magician_motion::{JointAngles, Pose};
use magician_protocol::AlarmSet;

use super::SECOND;
use super::file::{File, Topic};
use super::message::{Alarms, Joints, Log, PoseInFrame, QueueFromOutside};
use magician_sim::Micros;

/// What a host has read of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Where the tool is, mm and deg.
    pub pose: Pose,
    /// The joint angles, deg.
    pub joints: JointAngles,
    /// Where the carriage is on its rail, mm, if there is one.
    pub rail: Option<f64>,
    /// Places of the command queue in all.
    pub capacity: u32,
    /// Commands in it.
    pub waiting: u32,
    /// The index of the command that finished last.
    pub current_index: u64,
    /// The alarms that stand.
    pub alarms: AlarmSet,
}

/// Writes readings of a host in the topics of a [`Recorder`](super::Recorder), with the same schemas. What was not read is
/// absent; queue and alarms are written when they change, and every second.
///
/// ```
/// use magician_motion::{Geometry, JointAngles};
/// use magician_record::mcap::{Reading, Readings};
///
/// let joints = JointAngles::HOME;
/// let pose = Geometry::default().forward(&joints);
/// let alarms = Default::default();
/// let reading = Reading { pose, joints, rail: None, capacity: 32, waiting: 0, current_index: 0, alarms };
/// let mut readings = Readings::new(Vec::new(), 0, 20.0)?;
/// readings.write(0, &reading)?;
/// readings.write(50_000, &reading)?;
/// let file = readings.finish()?;
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

    /// Writes a reading of an instant.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write(&mut self, now: Micros, reading: &Reading) -> io::Result<()> {
        let all = now >= self.again;
        let last = self.last.replace(*reading).filter(|_| !all);
        let file = &mut self.file;
        file.write(Topic::Pose, now, |t| PoseInFrame::new(t, &reading.pose))?;
        file.write(Topic::Joints, now, |t| {
            Joints::new(t, &reading.joints, reading.rail)
        })?;
        let queue = |of: &Reading| (of.capacity, of.waiting, of.current_index);
        if last.is_none_or(|last| queue(&last) != queue(reading)) {
            let (capacity, waiting, current_index) = queue(reading);
            file.write(Topic::Queue, now, |timestamp| QueueFromOutside {
                timestamp,
                capacity,
                waiting,
                current_index,
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

    /// Writes down what happened at an instant, in words; as a warning, or as a mere fact.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn note(&mut self, now: Micros, warning: bool, words: &str) -> io::Result<()> {
        self.file
            .write(Topic::Events, now, |t| Log::noticed(t, warning, words))
    }

    /// Hands on all that was written, so that it is in the file whatever happens to this program.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }

    /// Writes summary and index; the file is whole.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn finish(self) -> io::Result<W> {
        self.file.finish()
    }
}
