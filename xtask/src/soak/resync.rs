//! R4: number of frames that a decoder loses after a fault.

use std::error::Error;

use magician::faults::Dice;
use magician::pair::Digest;
use magician_protocol::{Ctrl, Deframer, Event, FrameBuf};

use super::{Scope, SoakResult};
use crate::bench::figure::Figure;

/// Good frames before and after the fault.
const FRAMES_BEFORE: usize = 3;
const FRAMES_AFTER: usize = 6;

#[derive(Default)]
struct Tally {
    faults: u64,
    /// Frames that were not decoded, including the damaged one.
    lost: u64,
    /// Largest number of good frames lost behind a damaged frame, in cases without an invented
    /// frame.
    worst: usize,
    /// Frames that were decoded but not sent: the checksum matches, so nothing can detect them.
    invented: u64,
}

fn reply(dice: &mut Dice) -> Vec<u8> {
    let (id, length) = match dice.below(4) {
        0 => (10, 32),
        1 => (246, 8),
        2 => (84, 17),
        _ => (dice.byte(), dice.below(60)),
    };
    let params: Vec<u8> = (0..length)
        .map(|_| match dice.below(3) {
            0 => 0,
            _ => dice.byte(),
        })
        .collect();
    FrameBuf::new(id, Ctrl(dice.below(4) as u8), &params)
        .map(|frame| frame.bytes().to_vec())
        .unwrap_or_default()
}

fn frames(bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut deframer = Deframer::new();
    let mut input = bytes;
    let mut found = Vec::new();
    let mut take = |deframer: &mut Deframer, input: &mut &[u8]| {
        while let Some(event) = deframer.next(input) {
            if let Event::Frame { frame, .. } = event {
                found.push(FrameBuf::from(frame).bytes().to_vec());
            }
        }
    };
    take(&mut deframer, &mut input);
    // End of the silence after the last byte.
    deframer.expire();
    take(&mut deframer, &mut &[][..]);
    found
}

/// Replaces, drops or inserts one byte of one frame, with good frames before and after it.
fn fault_once(dice: &mut Dice, kind: u64, tally: &mut Tally, digest: &mut Digest) {
    let sent: Vec<Vec<u8>> = (0..FRAMES_BEFORE + 1 + FRAMES_AFTER)
        .map(|_| reply(dice))
        .collect();
    let mut hit = sent[FRAMES_BEFORE].clone();
    let at = dice.below(hit.len() as u64) as usize;
    match kind {
        0 => hit[at] = hit[at].wrapping_add(1 + dice.below(255) as u8),
        1 => drop(hit.remove(at)),
        _ => hit.insert(at, dice.byte()),
    }
    let mut bytes = sent[..FRAMES_BEFORE].concat();
    bytes.extend(&hit);
    bytes.extend(sent[FRAMES_BEFORE + 1..].concat());
    digest.add(0, &bytes);
    let found = frames(&bytes);
    // In order: which of the sent frames were decoded.
    let mut rest = found.as_slice();
    let lost: Vec<bool> = (sent.iter())
        .map(|frame| match rest.iter().position(|other| other == frame) {
            Some(at) => {
                rest = &rest[at + 1..];
                false
            }
            None => true,
        })
        .collect();
    let kept = lost.iter().filter(|gone| !**gone).count();
    tally.faults += 1;
    tally.lost += (lost.len() - kept) as u64;
    tally.invented += (found.len() - kept) as u64;
    if found.len() > kept {
        return;
    }
    let behind = lost[FRAMES_BEFORE + 1..]
        .iter()
        .filter(|gone| **gone)
        .count();
    tally.worst = tally.worst.max(behind);
}

pub(super) fn faults(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let mut dice = Dice::new(scope.seed);
    let mut digest = Digest::default();
    let (mut figures, mut all) = (Vec::new(), 0.0);
    for (kind, name) in ["replaced", "lost", "added"].into_iter().enumerate() {
        let mut tally = Tally::default();
        for _ in 0..scope.cases / 3 {
            fault_once(&mut dice, kind as u64, &mut tally, &mut digest);
        }
        let lost = tally.lost as f64 / tally.faults.max(1) as f64;
        let name = format!("frames lost per byte {name}");
        all += lost / 3.0;
        figures.push(
            Figure::new(name, lost, "").with("wrong ones with a right sum", tally.invented as f64),
        );
        let name = "clean frames lost behind it";
        figures.push(Figure::new(name, tally.worst as f64, "at most").at_most(1.0));
    }
    figures.push(Figure::new("frames lost per byte fault", all, "").at_most(1.0));
    Ok(SoakResult {
        figures,
        digest: Some(digest.0),
    })
}
