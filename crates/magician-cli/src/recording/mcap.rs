//! The topics and schemas of a virtual arm's recording.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;
use std::time::SystemTime;

use magician::Event;
use magician_motion::{JointAngles, Pose};
use magician_record::mcap::{self, Readings};

use super::sink::{Beginning, Reading, Sink};
use crate::failure::Failure;
use crate::serving::create;

/// The file, until it is complete.
pub(super) struct Mcap(Option<Readings<BufWriter<File>>>);

impl Mcap {
    pub(super) fn open(path: &Path, beginning: &Beginning) -> Result<Self, Failure> {
        let since_1970 = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
        let epoch = u64::try_from(since_1970.as_nanos()).unwrap_or_default();
        let file = BufWriter::new(create(path)?);
        Ok(Self(Some(Readings::new(file, epoch, beginning.rate)?)))
    }

    fn open_file(&mut self) -> io::Result<&mut Readings<BufWriter<File>>> {
        self.0
            .as_mut()
            .ok_or_else(|| io::ErrorKind::BrokenPipe.into())
    }
}

fn micros(seconds: f64) -> u64 {
    (seconds * 1e6) as u64
}

impl Sink for Mcap {
    fn write(&mut self, reading: &Reading) -> Result<(), Failure> {
        let pose = &reading.pose;
        let place = [pose.x, pose.y, pose.z, pose.r].map(f64::from);
        let seen = mcap::Reading {
            pose: Pose::from(place),
            joints: JointAngles::from(pose.joint_angle.map(f64::from)),
            rail: None,
            capacity: reading.places,
            waiting: reading.places.saturating_sub(reading.left_space),
            current_index: reading.index,
            alarms: reading.alarms,
        };
        Ok(self.open_file()?.write(micros(reading.t), &seen)?)
    }

    fn note(&mut self, t: f64, event: &Event, text: &str) -> Result<(), Failure> {
        let warning = matches!(
            event,
            Event::AlarmRaised { .. }
                | Event::LinkLost { .. }
                | Event::Reset { .. }
                | Event::Missed { .. }
        );
        Ok(self.open_file()?.note(micros(t), warning, text)?)
    }

    fn flush(&mut self) -> Result<(), Failure> {
        Ok(self.open_file()?.flush()?)
    }

    fn finish(&mut self) -> Result<Option<usize>, Failure> {
        if let Some(readings) = self.0.take() {
            readings.finish()?;
        }
        Ok(None)
    }
}
