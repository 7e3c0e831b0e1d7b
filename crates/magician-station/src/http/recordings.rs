//! Recordings as MCAP files, and their download.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Read, Write};
use std::path::PathBuf;

use axum::body::Body;
use axum::http::header::{CONTENT_LENGTH, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use magician_protocol::Direction;
use magician_record::mcap::Readings;
use magician_record::{Reading, WriteReadings};

use crate::engine::run_blocking;
use crate::recording::{RecordingFile, RecordingStore, Sample};

/// Places in the arm's queue.
const QUEUE_CAPACITY: u32 = 32;
/// Bytes read from a file at once.
const CHUNK_SIZE: usize = 64 * 1024;

/// Folder of recordings in MCAP, each readable by its owner alone.
#[derive(Clone, Debug)]
pub struct RecordingFolder {
    folder: PathBuf,
}

impl RecordingFolder {
    /// Uses this folder, which is created for the first recording.
    #[must_use]
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
    }
}

/// True if a recording may have this name; the station's names are `ARM-YYYYMMDD-HHMMSS.mcap`.
/// Excludes separators, so that no name leads out of the folder.
fn is_name(name: &str) -> bool {
    let sign =
        |sign: char| sign.is_ascii_lowercase() || sign.is_ascii_digit() || "_-".contains(sign);
    // Room for the longest name of an arm and the time.
    let stem = name.strip_suffix(".mcap").filter(|stem| stem.len() <= 64);
    stem.is_some_and(|stem| !stem.is_empty() && stem.chars().all(sign))
}

impl RecordingStore for RecordingFolder {
    fn begin(&self, name: &str, epoch: f64, rate: u32) -> io::Result<Box<dyn RecordingFile>> {
        fs::create_dir_all(&self.folder)?;
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let file = BufWriter::new(options.open(self.folder.join(name))?);
        let nanos = (epoch * 1e9) as u64;
        let readings = Readings::new(file, nanos, f64::from(rate))?;
        Ok(Box::new(Mcap { readings, epoch }))
    }

    fn read(&self, name: &str) -> io::Result<(Box<dyn Read + Send>, u64)> {
        if !is_name(name) {
            return Err(io::ErrorKind::NotFound.into());
        }
        let file = File::open(self.folder.join(name))?;
        let length = file.metadata()?.len();
        // A recording in progress is sent up to its present length.
        Ok((Box::new(file.take(length)), length))
    }
}

struct Mcap {
    readings: Readings<BufWriter<File>>,
    epoch: f64,
}

impl RecordingFile for Mcap {
    fn write(&mut self, sample: &Sample) -> io::Result<()> {
        self.readings.write(&Reading {
            // Readings of the history may be slightly older than the start of the recording.
            t: (sample.t - self.epoch).max(0.0),
            step: None,
            pose: sample.pose,
            rail: sample.rail.map(f64::from),
            index: sample.current_index,
            left_space: sample.left_space,
            // An arm that reports more free places has a larger queue.
            capacity: QUEUE_CAPACITY.max(sample.left_space),
            alarms: sample.alarms,
        })
    }

    fn passed(&mut self, t: f64, line: &str, direction: Direction, bytes: &[u8]) -> io::Result<()> {
        self.readings
            .passed((t - self.epoch).max(0.0), line, direction, bytes)
    }

    fn note(&mut self, t: f64, warning: bool, text: &str) -> io::Result<()> {
        self.readings.note((t - self.epoch).max(0.0), warning, text)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.readings.flush()
    }

    fn finish(self: Box<Self>) -> io::Result<u64> {
        let mut file = self.readings.into_file()?;
        file.flush()?;
        Ok(file.get_ref().metadata()?.len())
    }
}

/// Streams a recording to the client.
pub(super) fn answer(file: Box<dyn Read + Send>, length: u64) -> Response {
    let pieces = stream::unfold(Some(file), |file| async move {
        let mut file = file?;
        let read = run_blocking(move || {
            let mut piece = vec![0; CHUNK_SIZE];
            let count = file.read(&mut piece);
            count.map(|count| {
                piece.truncate(count);
                (piece, file)
            })
        });
        match read.await {
            Ok(Ok((piece, _))) if piece.is_empty() => None,
            Ok(Ok((piece, file))) => Some((Ok(piece), Some(file))),
            Ok(Err(error)) => Some((Err(error), None)),
            Err(error) => Some((Err(io::Error::other(error.message)), None)),
        }
    });
    let headers = [
        (CONTENT_TYPE, "application/octet-stream".to_owned()),
        (CONTENT_LENGTH, length.to_string()),
    ];
    (headers, Body::from_stream(pieces)).into_response()
}

#[cfg(test)]
mod tests {
    use magician_protocol::AlarmSet;
    use magician_protocol::commands::Pose;

    use super::*;

    #[test]
    fn killed_program_leaves_flushed_readings() {
        let folder = tempfile::tempdir().unwrap();
        let store = RecordingFolder::at(folder.path().join("recordings"));
        let mut file = store.begin("arm-20261123-120000.mcap", 1000.0, 20).unwrap();
        let pose = Pose {
            x: 200.0,
            y: 0.0,
            z: 0.0,
            r: 0.0,
            joint_angle: [0.0; 4],
        };
        let sample = |at: u32| Sample {
            t: 1000.0 + f64::from(at) / 20.0,
            pose: Pose {
                y: at as f32,
                ..pose
            },
            rail: None,
            current_index: 0,
            left_space: 32,
            alarms: AlarmSet::default(),
        };
        (0..20).for_each(|at| file.write(&sample(at)).unwrap());
        file.flush().unwrap();
        // Like a killed process: nothing is completed.
        std::mem::forget(file);
        let (mut written, length) = store.read("arm-20261123-120000.mcap").unwrap();
        let mut bytes = Vec::new();
        written.read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes.len() as u64, length);
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("0.019"), "the last reading");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let path = folder.path().join("recordings/arm-20261123-120000.mcap");
            let mode = path.metadata().unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600, "its user's alone");
        }
        // A recording is never overwritten, and no name leads out of the folder.
        assert!(store.begin("arm-20261123-120000.mcap", 0.0, 1).is_err());
        std::fs::write(folder.path().join("secret.mcap"), "secret").unwrap();
        for name in ["../secret.mcap", "", ".mcap", "x", "A.mcap", "a/b.mcap"] {
            assert!(store.read(name).is_err(), "{name}");
        }
    }
}
