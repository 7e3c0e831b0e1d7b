//! Readings as comma-separated values: a row for each.

use std::io::{self, Write};

use crate::{Reading, WriteReadings};

/// Writes readings as rows under a line of names. Rows have no place for what happens between readings.
///
/// ```
/// use magician_protocol::commands::Pose;
/// use magician_record::csv::Csv;
/// use magician_record::{Reading, WriteReadings};
///
/// let pose = Pose { x: 200.0, y: -1.5, z: 0.0, r: 0.0, joint_angle: [0.0, 45.0, 45.0, 0.0] };
/// let alarms = Default::default();
/// let reading = Reading { t: 0.05, step: None, pose, rail: None, index: 3, left_space: 31, capacity: 32, alarms };
/// let mut file = Vec::new();
/// let mut csv = Csv::new(&mut file, false)?;
/// csv.write(&reading)?;
/// drop(csv);
/// assert_eq!(
///     String::from_utf8(file)?,
///     "t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms\n0.050,200,-1.5,0,0,0,45,45,0,3,31,\n"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Csv<W: Write>(W);

impl<W: Write> Csv<W> {
    /// Begins a file; whether its rows end with steps of a program.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn new(mut out: W, counts_steps: bool) -> io::Result<Self> {
        let step = if counts_steps { ",step" } else { "" };
        writeln!(out, "t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms{step}")?;
        Ok(Self(out))
    }
}

impl<W: Write> WriteReadings for Csv<W> {
    fn write(&mut self, reading: &Reading) -> io::Result<()> {
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
        writeln!(self.0)
    }

    fn note(&mut self, _: f64, _: bool, _: &str) -> io::Result<()> {
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.0.flush()
    }
}
