//! Poses during a run, as a file: one row each.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use magician::commands::Pose;
use serde::Serialize;

use crate::failure::Failure;
use crate::serving::create;

/// What is known of the arm at an instant.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Sample {
    /// Seconds of the arm's clock since the run began.
    pub(super) t: f64,
    /// Steps that are finished.
    pub(super) step: u64,
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) z: f32,
    pub(super) r: f32,
    pub(super) j1: f32,
    pub(super) j2: f32,
    pub(super) j3: f32,
    pub(super) j4: f32,
}

/// What keeps samples.
pub(super) trait Recorder {
    /// Keeps one.
    fn keep(&mut self, sample: &Sample) -> Result<(), Failure>;
    /// No more come.
    fn end(&mut self) -> Result<(), Failure>;
}

impl Sample {
    pub(super) fn new(t: f64, step: u64, pose: &Pose) -> Self {
        let [j1, j2, j3, j4] = pose.joint_angle;
        let Pose { x, y, z, r, .. } = *pose;
        Self {
            t,
            step,
            x,
            y,
            z,
            r,
            j1,
            j2,
            j3,
            j4,
        }
    }
}

/// Opens a file for samples; the end of its name says what it is.
pub(super) fn open(path: &Path) -> Result<Box<dyn Recorder>, Failure> {
    let end = path.extension().map(|end| end.to_ascii_lowercase());
    match end.as_deref().and_then(|end| end.to_str()) {
        Some("csv") => Ok(Box::new(Csv::open(path)?)),
        Some("jsonl" | "ndjson" | "json") => Ok(Box::new(Objects(BufWriter::new(create(path)?)))),
        _ => Err(Failure::usage(format!(
            "{}: a recording is a .csv or .jsonl file",
            path.display()
        ))),
    }
}

struct Csv(BufWriter<File>);

impl Csv {
    fn open(path: &Path) -> Result<Self, Failure> {
        let mut file = BufWriter::new(create(path)?);
        writeln!(file, "t,step,x,y,z,r,j1,j2,j3,j4")?;
        Ok(Self(file))
    }
}

impl Recorder for Csv {
    fn keep(&mut self, sample: &Sample) -> Result<(), Failure> {
        let Sample {
            t,
            step,
            x,
            y,
            z,
            r,
            j1,
            j2,
            j3,
            j4,
        } = sample;
        Ok(writeln!(
            self.0,
            "{t:.3},{step},{x},{y},{z},{r},{j1},{j2},{j3},{j4}"
        )?)
    }

    fn end(&mut self) -> Result<(), Failure> {
        Ok(self.0.flush()?)
    }
}

struct Objects(BufWriter<File>);

impl Recorder for Objects {
    fn keep(&mut self, sample: &Sample) -> Result<(), Failure> {
        serde_json::to_writer(&mut self.0, sample)?;
        Ok(writeln!(self.0)?)
    }

    fn end(&mut self) -> Result<(), Failure> {
        Ok(self.0.flush()?)
    }
}
