//! What of an arm's readings is kept, and what is written: exact, in the test's own time.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use magician_station::{
    ArmEntry, RecordOrder, RecordReport, RecordingFile, RecordingStore, StationConfig,
};
use serde_json::json;

use crate::bare::{ARM, BareStation};

/// A place for recordings that writes nothing: the test sees what it would be told.
struct Nowhere;

impl RecordingStore for Nowhere {
    fn begin(&self, _: &str, _: f64, _: u32) -> io::Result<Box<dyn RecordingFile>> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn read(&self, _: &str) -> io::Result<(Box<dyn io::Read + Send>, u64)> {
        Err(io::ErrorKind::NotFound.into())
    }
}

fn recording() -> BareStation {
    let mut config = StationConfig::new(vec![ArmEntry::simulated("arm")], "0");
    config.recordings = Arc::new(Nowhere);
    BareStation::with(config)
}

impl BareStation {
    /// So many readings, at this distance.
    fn read_on(&mut self, count: usize, pause: Duration) {
        for _ in 0..count {
            self.now += pause;
            self.read(200.0, Duration::ZERO);
        }
    }

    fn orders(&mut self) -> Vec<RecordOrder> {
        let next = || self.station.poll_record().map(|(_, order)| order);
        std::iter::from_fn(next).collect()
    }

    /// How many readings the ring has, and how old its first one is, s.
    fn ring(&mut self) -> (usize, f64) {
        self.send("record.save_last", &json!({"seconds": 600}));
        let Some(RecordOrder::Save { samples, .. }) = self.orders().pop() else {
            panic!("it is saved");
        };
        let (first, last) = (samples.first().unwrap(), samples.last().unwrap());
        (samples.len(), last.t - first.t)
    }
}

#[test]
fn the_ring_has_ten_minutes_and_at_most_thirty_thousand_readings() {
    let mut bare = recording();
    bare.read_on(700, Duration::from_secs(1));
    assert_eq!(bare.ring(), (601, 600.0));
    // A reading each 10 ms is more than any subscription asks for.
    bare.read_on(40_000, Duration::from_millis(10));
    let (count, age) = bare.ring();
    assert_eq!(count, 30_000);
    assert!((age - 299.99).abs() < 1e-6, "{age}");
}

#[test]
fn readings_between_the_times_of_a_recording_are_left_out() {
    let mut bare = recording();
    bare.send("record.start", &json!({"rate": 5}));
    bare.orders();
    bare.read_on(200, Duration::from_millis(20));
    let written = bare.orders().len();
    assert!(
        (20..=21).contains(&written),
        "{written} in 4 s at 5 a second"
    );
}

#[test]
fn a_recording_that_was_lost_is_not_stopped_as_if_it_were_whole() {
    let mut bare = recording();
    bare.send("record.start", &json!({}));
    bare.orders();
    let lost = RecordReport::Lost("the disk is full".to_owned());
    bare.station.recorded(bare.now, ARM, lost);
    bare.heard();
    bare.send("record.stop", &json!({}));
    let answer = bare.heard().pop().unwrap();
    let why = answer["error"]["message"].as_str().unwrap();
    assert!(why.contains("the disk is full"), "{answer}");
    assert_eq!(bare.orders(), []);
}
