//! An object on a line for each reading, and for each event.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use magician::Event;
use serde::Serialize;

use super::sink::{Reading, Sink};
use crate::failure::Failure;
use crate::serving::create;

pub(super) struct Jsonl(BufWriter<File>);

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

impl Jsonl {
    pub(super) fn open(path: &Path) -> Result<Self, Failure> {
        Ok(Self(BufWriter::new(create(path)?)))
    }

    fn line(&mut self, value: &impl Serialize) -> Result<(), Failure> {
        serde_json::to_writer(&mut self.0, value)?;
        Ok(writeln!(self.0)?)
    }
}

/// Milliseconds are as exact as it is known.
fn rounded(t: f64) -> f64 {
    (t * 1000.0).round() / 1000.0
}

impl Sink for Jsonl {
    fn write(&mut self, reading: &Reading) -> Result<(), Failure> {
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

    fn note(&mut self, t: f64, _: &Event, text: &str) -> Result<(), Failure> {
        let (t, event) = (rounded(t), text);
        self.line(&Happened { t, event })
    }

    fn flush(&mut self) -> Result<(), Failure> {
        Ok(self.0.flush()?)
    }

    fn finish(&mut self) -> Result<Option<usize>, Failure> {
        self.flush().map(|()| None)
    }
}
