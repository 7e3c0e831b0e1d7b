//! Recordings of arms, and the history.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::{Tap, Tracer};
use magician_protocol::Direction;
use magician_station::{FrameRing, RecordingFile, RecordingStore, Role, Sample};
use serde_json::{Value, json};

use crate::bench::LocalStation;

/// Recordings in memory, on a disk that may become full.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tapes {
    tapes: Arc<Mutex<BTreeMap<String, MemoryRecordings>>>,
    /// True if the disk is full.
    full: Arc<Mutex<bool>>,
}

#[derive(Clone, Debug, Default)]
struct MemoryRecordings {
    epoch: f64,
    rate: u32,
    samples: Vec<Sample>,
    notes: Vec<String>,
    passed: Vec<(f64, Direction, Vec<u8>)>,
    flushed: usize,
    whole: bool,
}

struct Writer {
    tapes: Tapes,
    name: String,
}

impl Tapes {
    fn room(&self) -> io::Result<()> {
        if *self.full.lock().unwrap() {
            return Err(io::ErrorKind::StorageFull.into());
        }
        Ok(())
    }

    fn tape(&self, name: &str) -> MemoryRecordings {
        self.tapes.lock().unwrap()[name].clone()
    }

    fn fill(&self, full: bool) {
        *self.full.lock().unwrap() = full;
    }
}

impl RecordingStore for Tapes {
    fn begin(&self, name: &str, epoch: f64, rate: u32) -> io::Result<Box<dyn RecordingFile>> {
        self.room()?;
        let tape = MemoryRecordings {
            epoch,
            rate,
            ..MemoryRecordings::default()
        };
        let before = self.tapes.lock().unwrap().insert(name.to_owned(), tape);
        assert!(before.is_none(), "{name} is there already");
        Ok(Box::new(Writer {
            tapes: self.clone(),
            name: name.to_owned(),
        }))
    }

    fn read(&self, _: &str) -> io::Result<(Box<dyn Read + Send>, u64)> {
        Ok((Box::new(Cursor::new(Vec::new())), 0))
    }
}

impl Writer {
    fn change(&self, change: impl FnOnce(&mut MemoryRecordings)) -> io::Result<()> {
        self.tapes.room()?;
        let mut tapes = self.tapes.tapes.lock().unwrap();
        change(tapes.get_mut(&self.name).unwrap());
        Ok(())
    }
}

impl RecordingFile for Writer {
    fn write(&mut self, sample: &Sample) -> io::Result<()> {
        self.change(|tape| tape.samples.push(*sample))
    }

    fn passed(&mut self, t: f64, _: &str, from: Direction, bytes: &[u8]) -> io::Result<()> {
        self.change(|tape| tape.passed.push((t, from, bytes.to_vec())))
    }

    fn note(&mut self, _: f64, _: bool, text: &str) -> io::Result<()> {
        self.change(|tape| tape.notes.push(text.to_owned()))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.change(|tape| tape.flushed = tape.samples.len())
    }

    fn finish(self: Box<Self>) -> io::Result<u64> {
        self.change(|tape| tape.whole = true)?;
        Ok(self.tapes.tape(&self.name).samples.len() as u64 * 100)
    }
}

/// Returns the number of frames that the station has sent to the arm.
async fn asked(bench: &LocalStation) -> u64 {
    bench.drivers[0].stats().await.unwrap().0.sent
}

#[tokio::test(start_paused = true)]
async fn recording_sets_the_read_rate_and_contains_events() {
    let tapes = Tapes::default();
    let bench = LocalStation::recording(tapes.clone()).await;
    let mut anna = bench.join("Anna").await;
    let mut viewer = bench.join_as("Viewer", Role::Viewer).await;
    assert_eq!(viewer.code("record.start", json!({})).await, -32001);
    let name = anna.ok("record.start", json!({"rate": 10})).await["name"].clone();
    assert_eq!(name, json!("arm-19700112-134640.mcap"));
    let info = viewer.ok("server.info", json!({})).await;
    assert_eq!(info["recording"], json!(true));
    let refused = anna.call("record.start", json!({})).await.unwrap_err();
    assert_eq!(
        (&refused["code"], &refused["data"]["recording"]),
        (&json!(-32003), &name)
    );
    anna.lease().await;
    anna.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
    let name = name.as_str().unwrap().to_owned();
    for _ in 0..2 {
        anna.listen(Duration::from_secs(3)).await;
        anna.ok("session.list", json!({})).await;
    }
    // The disk lags behind by about a second at most.
    let tape = tapes.tape(&name);
    assert!(!tape.whole && tape.flushed > 50, "{}", tape.flushed);
    viewer.ok("arm.stop", json!({})).await;
    anna.listen(Duration::from_millis(500)).await;
    let over = anna.ok("record.stop", json!({})).await;
    let tape = tapes.tape(&name);
    let (first, last) = (tape.samples[0], tape.samples[tape.samples.len() - 1]);
    let rate = (tape.samples.len() - 1) as f64 / (last.t - first.t);
    let seconds = over["seconds"].as_f64().unwrap();
    // Readings since the last flush are written too.
    let since = tape.epoch + seconds - last.t;
    assert!(since < 0.2, "the last reading is {since} s old");
    assert!((9.0..=11.0).contains(&rate), "{rate}");
    assert!(tape.whole && tape.rate == 10 && tape.epoch == 1_000_000.0);
    assert!((last.pose.x - 220.0).abs() < 1e-3 && first.pose.x > 250.0);
    assert!(
        tape.notes.iter().any(|note| note.starts_with("stop by ")),
        "{:?}",
        tape.notes
    );
    assert!((6.0..12.0).contains(&seconds), "{over}");
    assert_eq!(over["bytes"], json!(tape.samples.len() * 100));
    // After the end the arm is no longer read.
    let info = viewer.ok("server.info", json!({})).await;
    assert_eq!(info["recording"], json!(false));
    let refused = anna.call("record.stop", json!({})).await.unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("invalid-input"));
    let before = asked(&bench).await;
    anna.listen(Duration::from_secs(60)).await;
    assert_eq!(asked(&bench).await, before);
}

#[tokio::test(start_paused = true)]
async fn history_of_ten_minutes_can_be_saved() {
    let tapes = Tapes::default();
    let bench = LocalStation::recording(tapes.clone()).await;
    let mut anna = bench.join("Anna").await;
    anna.listen(Duration::from_secs(1)).await;
    // The history itself requests no readings.
    let before = asked(&bench).await;
    anna.listen(Duration::from_secs(60)).await;
    assert_eq!(asked(&bench).await, before);
    let last = json!({"seconds": 10});
    let refused = anna.call("record.save_last", last.clone()).await;
    assert_eq!(refused.unwrap_err()["data"]["kind"], json!("invalid-input"));
    let watch = json!({"rate": 20});
    let id = anna.ok("arm.subscribe", watch).await["subscription"].clone();
    anna.listen(Duration::from_secs(700)).await;
    let saved = async |anna: &mut crate::bench::Tester, seconds: u64| {
        let saved = anna
            .ok("record.save_last", json!({"seconds": seconds}))
            .await;
        let name = saved["name"].as_str().unwrap().to_owned();
        (tapes.tape(&name), name)
    };
    let (tape, first) = saved(&mut anna, 10).await;
    assert!(
        (195..=205).contains(&tape.samples.len()),
        "{}",
        tape.samples.len()
    );
    assert!(tape.whole && tape.rate == 20, "{}", tape.rate);
    let (tape, second) = saved(&mut anna, 600).await;
    assert!(
        (11_900..=12_100).contains(&tape.samples.len()),
        "{}",
        tape.samples.len()
    );
    assert_ne!(first, second);
    // Without a subscriber the history ages.
    anna.ok("arm.unsubscribe", json!({"subscription": id}))
        .await;
    anna.listen(Duration::from_secs(30)).await;
    assert_eq!(anna.code("record.save_last", last).await, -32000);
    let (tape, _) = saved(&mut anna, 40).await;
    assert!(
        (150..=250).contains(&tape.samples.len()),
        "{}",
        tape.samples.len()
    );
}

#[tokio::test(start_paused = true)]
async fn full_disk_ends_the_recording_but_not_the_arm() {
    let tapes = Tapes::default();
    let bench = LocalStation::recording(tapes.clone()).await;
    let mut anna = bench.join("Anna").await;
    tapes.fill(true);
    let refused = anna.call("record.start", json!({})).await.unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unexpected"), "{refused}");
    tapes.fill(false);
    let name = anna.ok("record.start", json!({})).await["name"].clone();
    anna.ok("arm.subscribe", json!({"rate": 5})).await;
    anna.lease().await;
    tapes.fill(true);
    anna.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
    anna.listen(Duration::from_secs(3)).await;
    let events = anna.noticed("arm.event");
    let lost = |event: &&&Value| event["event"] == json!("recording-lost");
    let lost = events.iter().find(lost).expect("it is told");
    assert_eq!(lost["name"], name);
    anna.ok("arm.move", json!({"to": [220, 40, 50, 0]})).await;
    assert!((bench.arms[0].state().pose.y - 40.0).abs() < 1e-3);
    let info = anna.ok("server.info", json!({})).await;
    assert_eq!(info["recording"], json!(false));
    let refused = anna.call("record.stop", json!({})).await.unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unexpected"), "{refused}");
    // A new recording starts once there is room.
    tapes.fill(false);
    anna.ok("record.start", json!({})).await;
    // Recordings in progress are completed when the station ends.
    let name = anna.call("record.start", json!({})).await.unwrap_err();
    let name = name["data"]["recording"].as_str().unwrap().to_owned();
    bench.station.close_recordings().await;
    assert!(tapes.tape(&name).whole);
    // A station without a store refuses.
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let refused = anna.call("record.start", json!({})).await.unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unsupported"));
}

/// Tap that notes all traffic.
#[derive(Default)]
struct RecordingTap(Mutex<Vec<(Direction, Vec<u8>)>>);

impl Tap for RecordingTap {
    fn passed(&self, _: &str, direction: Direction, bytes: &[u8]) {
        let mut heard = self.0.lock().unwrap();
        heard.push((direction, bytes.to_vec()));
    }
}

/// Returns all bytes in one direction.
fn bytes_of<'a>(
    passed: impl IntoIterator<Item = &'a (Direction, Vec<u8>)>,
    of: Direction,
) -> Vec<u8> {
    let of = passed.into_iter().filter(|(direction, _)| *direction == of);
    of.flat_map(|(_, bytes)| bytes.clone()).collect()
}

#[tokio::test(start_paused = true)]
async fn line_traffic_is_complete_in_history_and_recording() {
    let tapes = Tapes::default();
    let (line, heard) = (FrameRing::new("usb"), Arc::new(RecordingTap::default()));
    let both = Arc::new(CombinedTap(Arc::clone(&line), Arc::clone(&heard)));
    let bench = LocalStation::ringing(tapes.clone(), line, Tracer::default().tap(both)).await;
    let mut anna = bench.join("Anna").await;
    anna.listen(Duration::from_secs(3)).await;
    let before = heard.0.lock().unwrap().len();
    let name = anna.ok("record.start", json!({"rate": 10})).await["name"].clone();
    anna.lease().await;
    anna.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
    anna.listen(Duration::from_secs(3)).await;
    anna.ok("record.stop", json!({})).await;
    let saved = anna.ok("record.save_last", json!({"seconds": 600})).await["name"].clone();
    // Later traffic consists of readings of the resting arm.
    let heard = heard.0.lock().unwrap().clone();
    for (name, before) in [(name, before), (saved, 0)] {
        let tape = tapes.tape(name.as_str().unwrap());
        assert!(tape.passed.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        let passed: Vec<_> = { tape.passed.iter() }
            .map(|(_, from, bytes)| (*from, bytes.clone()))
            .collect();
        for direction in [Direction::Request, Direction::Reply] {
            let (got, all) = (bytes_of(&passed, direction), bytes_of(&heard, direction));
            assert!(got.len() > 1000, "{}", got.len());
            let begun = all.windows(got.len()).position(|part| part == got);
            let begun = begun.unwrap_or_else(|| panic!("{direction:?}: something is missing"));
            // The file is created in the background while the arm is read.
            let wanted = bytes_of(&heard[..before], direction).len();
            assert!(begun.abs_diff(wanted) < 500, "{begun} for {wanted}");
            let left = all.len() - begun - got.len();
            assert!(left < 500, "{left} of {}", all.len());
        }
        let (first, last) = (tape.samples[0].t, tape.samples[tape.samples.len() - 1].t);
        assert!((tape.passed[0].0 - first).abs() < 1.0 && tape.passed[0].0 >= tape.epoch - 1e-6);
        assert!((tape.passed[tape.passed.len() - 1].0 - last).abs() < 1.0);
    }
}

#[tokio::test(start_paused = true)]
async fn arm_is_read_for_the_history_without_clients() {
    let line = FrameRing::new("usb");
    let trace = Tracer::default().tap(Arc::clone(&line) as _);
    let bench = LocalStation::ringing(Tapes::default(), line, trace).await;
    let before = asked(&bench).await;
    tokio::time::sleep(Duration::from_secs(60)).await;
    let asked = asked(&bench).await - before;
    // Four requests, five times a second.
    assert!((1100..=1300).contains(&asked), "{asked}");
}

/// Two taps.
struct CombinedTap(Arc<FrameRing>, Arc<RecordingTap>);

impl Tap for CombinedTap {
    fn passed(&self, line: &str, direction: Direction, bytes: &[u8]) {
        self.0.passed(line, direction, bytes);
        self.1.passed(line, direction, bytes);
    }
}
