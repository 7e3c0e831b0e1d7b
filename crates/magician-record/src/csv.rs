//! Readings as comma-separated values, one row each.

use std::io::{self, Write};
use std::time::{Duration, SystemTime};

use crate::{Reading, WriteReadings};

/// Writes readings as rows below a header. Events between readings have no place in rows and are
/// dropped.
///
/// ```
/// use std::time::SystemTime;
///
/// use magician_protocol::commands::Pose;
/// use magician_record::csv::Csv;
/// use magician_record::{Reading, WriteReadings};
///
/// let pose = Pose { x: 200.0, y: -1.5, z: 0.0, r: 0.0, joint_angle: [0.0, 45.0, 45.0, 0.0] };
/// let alarms = Default::default();
/// let reading = Reading { t: 0.05, step: None, pose, rail: None, index: 3, left_space: 31, capacity: 32, alarms };
/// let mut file = Vec::new();
/// let mut csv = Csv::new(&mut file, SystemTime::UNIX_EPOCH, false, true)?;
/// csv.write(&reading)?;
/// drop(csv);
/// assert_eq!(
///     String::from_utf8(file)?,
///     "time,t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms\n\
///      ,s,mm,mm,mm,deg,deg,deg,deg,deg,,,\n\
///      1970-01-01T00:00:00.050Z,0.050,200,-1.5,0,0,0,45,45,0,3,31,\n"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Csv<W: Write> {
    out: W,
    began: SystemTime,
}

impl<W: Write> Csv<W> {
    /// Writes the header. `began` is the time of the first reading's clock 0.
    ///
    /// `counts_steps` adds a column for the steps of a program, `units` a second line with the
    /// units.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn new(mut out: W, began: SystemTime, counts_steps: bool, units: bool) -> io::Result<Self> {
        let (step, unit) = if counts_steps {
            (",step", ",")
        } else {
            ("", "")
        };
        let columns = "time,t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms";
        writeln!(out, "{columns}{step}")?;
        if units {
            writeln!(out, ",s,mm,mm,mm,deg,deg,deg,deg,deg,,,{unit}")?;
        }
        Ok(Self { out, began })
    }
}

impl<W: Write> WriteReadings for Csv<W> {
    fn write(&mut self, reading: &Reading) -> io::Result<()> {
        let pose = &reading.pose;
        let since = Duration::try_from_secs_f64(reading.t).unwrap_or_default();
        // A clock set to the end of time must not fail the recording: the cell stays empty.
        if let Some(time) = self.began.checked_add(since) {
            write!(self.out, "{}", humantime::format_rfc3339_millis(time))?;
        }
        write!(
            self.out,
            ",{:.3},{},{},{},{}",
            reading.t, pose.x, pose.y, pose.z, pose.r
        )?;
        for angle in pose.joint_angle {
            write!(self.out, ",{angle}")?;
        }
        write!(self.out, ",{},{},", reading.index, reading.left_space)?;
        for (nth, code) in reading.alarms.codes().enumerate() {
            let space = if nth > 0 { " " } else { "" };
            write!(self.out, "{space}{code:#04x}")?;
        }
        if let Some(step) = reading.step {
            write!(self.out, ",{step}")?;
        }
        writeln!(self.out)
    }

    fn note(&mut self, _: f64, _: bool, _: &str) -> io::Result<()> {
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.out.flush()
    }
}
