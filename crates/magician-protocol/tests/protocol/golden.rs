//! Frames written by hand from the document, for ids without a recorded frame.
//!
//! Do not change this test or its data to make it pass.

use std::collections::BTreeSet;

use crate::material::{check, frames, golden};
use magician_protocol::{Direction, Source, TABLE};

#[test]
fn frames_read_as_written_and_write_back() {
    for frame in golden() {
        check(&frame);
    }
}

#[test]
fn golden_frames_cover_the_ids_that_the_vectors_leave_out() {
    let covered: BTreeSet<u8> = golden().iter().map(|f| f.number("cmd_id")).collect();
    let hard = [
        0, 11, 21, 60, 86, 87, 88, 89, 92, 101, 120, 132, 135, 140, 151, 155, 156, 157, 171, 243,
        244,
    ];
    let beyond = TABLE.iter().filter(|row| row.source != Source::Document);
    for id in hard.into_iter().chain(beyond.map(|row| row.id)) {
        assert!(covered.contains(&id), "id {id} has no golden frame");
    }
}

#[test]
fn every_row_has_a_recorded_frame() {
    let covered: BTreeSet<u8> = frames().iter().map(|f| f.number("cmd_id")).collect();
    let missing: Vec<u8> = TABLE
        .iter()
        .map(|row| row.id)
        .filter(|id| !covered.contains(id))
        .collect();
    assert_eq!(missing, Vec::<u8>::new());
}

#[test]
fn both_directions_are_covered() {
    let count = |direction| frames().iter().filter(|f| f.direction == direction).count();
    assert!(count(Direction::Request) > 100);
    assert!(count(Direction::Reply) > 60);
}
