//! History and recordings in detail, without an engine, with exact times.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use magician_station::api::ArmEvent;
use magician_station::{
    ArmEntry, ArmOrder, ArmReport, RecordOrder, RecordReport, RecordingFile, RecordingStore,
    StationConfig,
};
use serde_json::json;

use crate::bare::{ARM, BareStation};

/// Store that writes nothing: the test looks at the orders.
struct NullStore;

impl RecordingStore for NullStore {
    fn begin(&self, _: &str, _: f64, _: u32) -> io::Result<Box<dyn RecordingFile>> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn read(&self, _: &str) -> io::Result<(Box<dyn io::Read + Send>, u64)> {
        Err(io::ErrorKind::NotFound.into())
    }
}

fn recording() -> BareStation {
    with_ring(0, true)
}

fn with_ring(ring: u32, save_on_alarm: bool) -> BareStation {
    let mut config = StationConfig::new(vec![ArmEntry::simulated("arm")], "0");
    config.recordings = Arc::new(NullStore);
    (config.ring, config.save_on_alarm) = (ring, save_on_alarm);
    BareStation::with(config)
}

impl BareStation {
    /// Reports this many readings at this interval.
    fn read_on(&mut self, count: usize, pause: Duration) {
        for _ in 0..count {
            self.now += pause;
            self.read(200.0, Duration::ZERO);
        }
    }

    /// Returns the new rates of reading, as ordered.
    fn rates(&mut self) -> Vec<Option<u32>> {
        let next = || self.station.poll_order();
        let orders = std::iter::from_fn(next);
        orders
            .filter_map(|(_, order)| match order {
                ArmOrder::Watch { rate, .. } => Some(rate),
                _ => None,
            })
            .collect()
    }

    fn moves_on(&mut self, seconds: u64) {
        for at in 0..seconds * 50 {
            self.now += Duration::from_millis(20);
            self.reading(at as f32, |reading| reading.moving = true);
        }
    }

    fn alarm(&mut self) {
        self.report(ArmReport::Event {
            event: ArmEvent::AlarmRaised,
            fields: vec![("code", json!(0x12))],
        });
    }

    /// Lets time pass without readings. Returns the orders of files.
    fn pass(&mut self, seconds: u64) -> Vec<RecordOrder> {
        let until = self.now + Duration::from_secs(seconds);
        while let Some(due) = self.station.poll_timeout().filter(|due| *due <= until) {
            self.now = self.now.max(due);
            self.station.handle_timeout(self.now);
        }
        self.now = until;
        let saves = |order: &RecordOrder| matches!(order, RecordOrder::Save { .. });
        self.orders().into_iter().filter(saves).collect()
    }

    fn orders(&mut self) -> Vec<RecordOrder> {
        let next = || self.station.poll_record().map(|(_, order)| order);
        std::iter::from_fn(next).collect()
    }

    /// Returns number of readings in the history, and the age of the first, s.
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
fn history_is_limited_to_ten_minutes_and_30_000_readings() {
    let mut bare = recording();
    bare.read_on(700, Duration::from_secs(1));
    assert_eq!(bare.ring(), (601, 600.0));
    // One reading per 10 ms is more than any subscription asks for.
    bare.read_on(40_000, Duration::from_millis(10));
    let (count, age) = bare.ring();
    assert_eq!(count, 30_000);
    assert!((age - 299.99).abs() < 1e-6, "{age}");
}

#[test]
fn recording_drops_readings_above_its_rate() {
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
fn lost_recording_is_not_reported_as_complete() {
    let mut bare = recording();
    bare.send("record.start", &json!({}));
    bare.orders();
    let lost = RecordReport::Lost("the disk is full".to_owned());
    bare.station.recorded(bare.now, ARM, lost);
    bare.received();
    bare.send("record.stop", &json!({}));
    let answer = bare.received().pop().unwrap();
    let why = answer["error"]["message"].as_str().unwrap();
    assert!(why.contains("the disk is full"), "{answer}");
    assert_eq!(bare.orders(), []);
}

#[test]
fn read_rate_is_5_at_rest_and_50_in_motion() {
    let mut bare = with_ring(50, true);
    assert_eq!(bare.rates(), [Some(5)]);
    bare.read_on(20, Duration::from_millis(200));
    assert_eq!(bare.rates(), []);
    bare.moves_on(1);
    assert_eq!(bare.rates(), [Some(50)]);
    // Two seconds after the last motion the arm counts as resting.
    bare.read_on(99, Duration::from_millis(20));
    assert_eq!(bare.rates(), []);
    bare.read_on(2, Duration::from_millis(20));
    assert_eq!(bare.rates(), [Some(5)]);
}

#[test]
fn queued_commands_count_as_motion() {
    let mut bare = with_ring(50, true);
    bare.read_on(2, Duration::from_millis(200));
    assert_eq!(bare.rates(), [Some(5)]);
    bare.reading(0.0, |reading| reading.left_space = 31);
    assert_eq!(bare.rates(), [Some(50)]);
}

#[test]
fn motion_command_raises_the_read_rate_in_advance() {
    let mut bare = with_ring(50, true);
    bare.read_on(1, Duration::from_millis(200));
    assert_eq!(bare.rates(), [Some(5)]);
    bare.send("lease.take", &json!({}));
    bare.send("arm.home", &json!({}));
    assert_eq!(bare.rates(), [Some(50)]);
}

#[test]
fn subscription_rate_is_kept_and_history_rate_is_the_limit() {
    let mut bare = with_ring(10, true);
    assert_eq!(bare.rates(), [Some(5)]);
    bare.subscribe("json");
    assert_eq!(bare.rates(), [Some(50)]);
    let mut bare = with_ring(10, true);
    bare.moves_on(1);
    assert_eq!(bare.rates(), [Some(5), Some(10)]);
    let mut bare = with_ring(0, true);
    bare.moves_on(1);
    assert_eq!(bare.rates(), []);
}

#[test]
fn alarm_saves_the_history_plus_5_s() {
    let mut bare = with_ring(50, true);
    bare.moves_on(30);
    bare.alarm();
    assert_eq!(bare.pass(4), []);
    bare.moves_on(1);
    let saves = bare.pass(0);
    let [
        RecordOrder::Save {
            request,
            name,
            samples,
            notes,
            ..
        },
    ] = &saves[..]
    else {
        panic!("{saves:?}");
    };
    assert_eq!(samples.len(), 31 * 50);
    assert_eq!(
        (notes[0].text.as_str(), notes[0].warning),
        ("alarm-raised code 18", true)
    );
    bare.subscribe("json");
    bare.received();
    let outcome = Ok(12_345);
    let request = *request;
    bare.station
        .recorded(bare.now, ARM, RecordReport::Done { request, outcome });
    let told = bare.received();
    let told = told
        .iter()
        .find(|one| one["params"]["event"] == json!("recording-saved"));
    let told = &told.expect("it is told")["params"];
    assert_eq!(
        (&told["name"], &told["bytes"]),
        (&json!(name), &json!(12_345))
    );
}

#[test]
fn alarms_are_saved_once_a_minute_without_duplicates() {
    let mut bare = with_ring(50, true);
    bare.moves_on(30);
    let mut begun = Vec::new();
    let mut written = 0;
    for _ in 0..100 {
        bare.moves_on(2);
        bare.alarm();
        for save in bare.pass(0) {
            let RecordOrder::Save { samples, .. } = save else {
                unreachable!()
            };
            written += samples.len();
            begun.push(bare.now);
        }
    }
    assert_eq!(begun.len(), 4, "in 200 s");
    assert!(
        begun
            .windows(2)
            .all(|pair| pair[1] - pair[0] >= Duration::from_secs(60))
    );
    let all = (30 + 200) * 50;
    assert!(written <= all, "{written} of {all}");
}

#[test]
fn early_or_disabled_alarm_saves_nothing() {
    // No earlier readings explain an alarm that is active from the start.
    let mut bare = with_ring(50, true);
    bare.read_on(1, Duration::from_millis(20));
    bare.alarm();
    bare.moves_on(20);
    assert_eq!(bare.pass(60), []);
    for mut bare in [with_ring(50, false), with_ring(0, true)] {
        bare.moves_on(30);
        bare.alarm();
        assert_eq!(bare.pass(60), []);
    }
}

#[test]
fn events_are_saved_with_the_history() {
    let mut bare = with_ring(50, true);
    bare.line(false);
    bare.line(true);
    bare.moves_on(20);
    bare.report(ArmReport::Event {
        event: ArmEvent::Reset,
        fields: Vec::new(),
    });
    bare.moves_on(1);
    bare.send("record.save_last", &json!({"seconds": 10}));
    let Some(RecordOrder::Save { notes, from, .. }) = bare.orders().pop() else {
        panic!("it is saved");
    };
    let notes: Vec<_> = notes
        .iter()
        .map(|note| (note.text.as_str(), note.t >= from))
        .collect();
    assert_eq!(notes, [("reset", true)]);
}
