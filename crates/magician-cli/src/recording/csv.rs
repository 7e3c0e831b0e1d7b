//! A row for each reading.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use magician::Event;

use super::sink::{Beginning, Reading, Sink};
use crate::failure::Failure;
use crate::serving::create;

/// Rows have no place for what happens between readings; where the line broke there are none.
pub(super) struct Csv(BufWriter<File>);

impl Csv {
    pub(super) fn open(path: &Path, beginning: &Beginning) -> Result<Self, Failure> {
        let mut file = BufWriter::new(create(path)?);
        let step = if beginning.counts_steps { ",step" } else { "" };
        writeln!(file, "t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms{step}")?;
        Ok(Self(file))
    }
}

impl Sink for Csv {
    fn write(&mut self, reading: &Reading) -> Result<(), Failure> {
        let pose = &reading.pose;
        write!(
            self.0,
            "{:.3},{},{},{},{}",
            reading.t, pose.x, pose.y, pose.z, pose.r
        )?;
        for angle in pose.joint_angle {
            write!(self.0, ",{angle}")?;
        }
        write!(self.0, ",{},{},", reading.index, reading.left_space)?;
        for (nth, code) in reading.alarms.codes().enumerate() {
            let space = if nth > 0 { " " } else { "" };
            write!(self.0, "{space}{code:#04x}")?;
        }
        if let Some(step) = reading.step {
            write!(self.0, ",{step}")?;
        }
        Ok(writeln!(self.0)?)
    }

    fn note(&mut self, _: f64, _: &Event, _: &str) -> Result<(), Failure> {
        Ok(())
    }

    fn flush(&mut self) -> Result<(), Failure> {
        Ok(self.0.flush()?)
    }

    fn finish(&mut self) -> Result<Option<usize>, Failure> {
        self.flush().map(|()| None)
    }
}
