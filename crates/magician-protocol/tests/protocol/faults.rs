//! Cost of a damaged byte: the checksum rejects every false frame that it can detect, and the
//! deframer resynchronises at once.

use crate::material::frames;
use magician_protocol::{Deframer, Description, Event, Frame, Request};

/// Offset and bytes of each frame in `bytes`, which end with a silence.
fn deframe(bytes: &[u8]) -> Vec<(usize, Vec<u8>)> {
    let mut deframer = Deframer::new();
    let mut input = bytes;
    let mut found = Vec::new();
    loop {
        while let Some(event) = deframer.next(&mut input) {
            if let Event::Frame { offset, frame } = event {
                found.push((offset as usize, frame.bytes().to_vec()));
            }
        }
        if !deframer.pending() {
            return found;
        }
        deframer.expire();
    }
}

fn sums_to_zero(frame: &[u8]) -> bool {
    frame[3..]
        .iter()
        .fold(0u8, |sum, byte| sum.wrapping_add(*byte))
        == 0
}

#[test]
fn single_byte_fault_is_rejected_unless_len_is_damaged() {
    let (mut faults, mut silent, mut errors, mut decoded) = (0, 0, 0, 0);
    for recorded in frames() {
        let mut bytes = recorded.bytes.clone();
        for at in 0..bytes.len() {
            let good = bytes[at];
            for bad in (0..=u8::MAX).filter(|bad| *bad != good) {
                bytes[at] = bad;
                faults += 1;
                let found = deframe(&bytes);
                if found.is_empty() {
                    silent += 1;
                }
                for (offset, frame) in found {
                    // The checksum covers id, Ctrl and parameters, so only a damaged Len can pass.
                    assert!(sums_to_zero(&frame), "{}", recorded.id);
                    assert!(offset != 0 || at == 2, "{} at {at}", recorded.id);
                    let frame = Frame::new(&frame).unwrap();
                    match (Request::decode(&frame), Description::guess(&frame)) {
                        (Err(_), Err(_)) => errors += 1,
                        _ => decoded += 1,
                    }
                }
            }
            bytes[at] = good;
        }
    }
    println!(
        "{faults} faults: {silent} rejected, {errors} typed errors, {decoded} decoded by a false Len whose sum is right"
    );
    assert!(faults > 600_000);
    assert!(decoded * 1000 < faults, "{decoded} of {faults}");
}

/// Fault of a single byte.
#[derive(Clone, Copy)]
enum Fault {
    Replaced(u8),
    Inserted(u8),
    Dropped,
}

/// Part of a long clean stream: offsets of its frames, and its bytes.
struct Stretch {
    frames: Vec<(usize, Vec<u8>)>,
    bytes: Vec<u8>,
}

impl Stretch {
    /// Collects frames from `first` on, until a frame with any false Len ends within their bytes.
    fn new(all: &[Vec<u8>], first: usize) -> Self {
        let (mut frames, mut bytes) = (Vec::new(), Vec::new());
        for frame in all.iter().cycle().skip(first) {
            if bytes.len() > 520 {
                break;
            }
            frames.push((bytes.len(), frame.clone()));
            bytes.extend(frame);
        }
        Self { frames, bytes }
    }

    /// Number of frames lost to a fault, and true if a false frame passed by chance.
    fn cost(&self, at: usize, fault: Fault) -> (usize, bool) {
        let mut bytes = self.bytes.clone();
        match fault {
            Fault::Replaced(bad) => bytes[at] = bad,
            Fault::Inserted(bad) => bytes.insert(at, bad),
            Fault::Dropped => drop(bytes.remove(at)),
        }
        let found = deframe(&bytes);
        // A 0xAA inserted next to a header is indistinguishable from the header's own byte.
        let same = |(offset, frame): &(usize, Vec<u8>), (at, bytes): &(usize, Vec<u8>)| {
            offset.abs_diff(*at) <= 1 && frame == bytes
        };
        let kept = |original: &&_| found.iter().any(|frame| same(frame, original));
        let lost = self.frames.len() - self.frames.iter().filter(kept).count();
        let is_true = |frame: &_| self.frames.iter().any(|original| same(frame, original));
        let all_true = found.iter().all(is_true);
        (lost, !all_true)
    }
}

#[derive(Default)]
struct FaultCount {
    faults: usize,
    lost: usize,
    false_frames: usize,
}

impl FaultCount {
    fn add(&mut self, (lost, chance): (usize, bool)) {
        // The damaged frame, and one good frame if a false checksum matches by chance.
        assert!(lost <= 1 + usize::from(chance), "{lost} frames lost");
        self.faults += 1;
        self.lost += lost;
        self.false_frames += usize::from(chance);
    }

    fn report_and_check(&self, name: &str) {
        let Self {
            faults,
            lost,
            false_frames,
        } = self;
        let mean = *lost as f64 / *faults as f64;
        println!(
            "{name}: {faults} faults, {mean:.4} frames lost each, {false_frames} false frames"
        );
        assert!(false_frames * 200 < *faults, "{name}");
    }
}

/// Bytes with a meaning to the deframer, and their neighbours.
const FAULT_BYTES: [u8; 12] = [
    0x00, 0x01, 0x02, 0x0A, 0x55, 0x7F, 0x80, 0xA9, 0xAA, 0xAB, 0xFA, 0xFF,
];

#[test]
fn a_fault_costs_one_frame() {
    let all: Vec<_> = frames()
        .into_iter()
        .map(|recorded| recorded.bytes)
        .collect();
    let [mut replaced, mut inserted, mut dropped] = [(); 3].map(|()| FaultCount::default());
    for (first, frame) in all.iter().enumerate() {
        let stretch = Stretch::new(&all, first);
        for (at, good) in frame.iter().enumerate() {
            dropped.add(stretch.cost(at, Fault::Dropped));
            for bad in FAULT_BYTES {
                inserted.add(stretch.cost(at, Fault::Inserted(bad)));
                if bad != *good {
                    replaced.add(stretch.cost(at, Fault::Replaced(bad)));
                }
            }
        }
    }
    replaced.report_and_check("replaced");
    inserted.report_and_check("inserted");
    dropped.report_and_check("dropped");
    let lost = replaced.lost + inserted.lost + dropped.lost;
    assert!(lost <= replaced.faults + inserted.faults + dropped.faults);
}

#[test]
fn any_length_byte_costs_one_frame() {
    let all: Vec<_> = frames()
        .into_iter()
        .map(|recorded| recorded.bytes)
        .collect();
    let mut tally = FaultCount::default();
    for (first, frame) in all.iter().enumerate() {
        let stretch = Stretch::new(&all, first);
        for bad in (0..=u8::MAX).filter(|bad| *bad != frame[2]) {
            tally.add(stretch.cost(2, Fault::Replaced(bad)));
        }
    }
    tally.report_and_check("false Len");
}
