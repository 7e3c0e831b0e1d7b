//! Tests of DXF: with entities given as a string of codes and values, and with files.

mod blocks;
mod entities;
mod files;
mod hatches;
mod texts;

use std::fmt::Write;
use std::sync::LazyLock;

use super::*;
use crate::{Artwork, Format, Stroke, read};

/// A sample of the repository. It is not part of the published crate.
static PLATE: LazyLock<String> = LazyLock::new(|| {
    let crates = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    std::fs::read_to_string(format!("{crates}/magician-program/samples/plate.dxf")).unwrap()
});

const TOLERANCE: f64 = 0.01;

fn options() -> ReadOptions {
    ReadOptions {
        tolerance: TOLERANCE,
        ..ReadOptions::default()
    }
}

fn drawn(bytes: &[u8]) -> (Artwork, Vec<Diagnostic>) {
    let reading = read(Format::Dxf, bytes, &options()).unwrap();
    match reading.content {
        Content::Artwork(artwork) => (artwork, reading.notes),
        other => panic!("{other:?}"),
    }
}

/// Builds a file from codes and values, one word each.
fn file(words: &str) -> String {
    let mut text = words
        .split_whitespace()
        .fold(String::new(), |mut text, word| {
            writeln!(text, "{word}").unwrap();
            text
        });
    text.push_str("0\nEOF\n");
    text
}

/// Returns the lines of entities in mm, and the notes.
fn entities(words: &str) -> (Vec<Stroke>, Vec<String>) {
    let head = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES";
    let (artwork, notes) = drawn(file(&format!("{head} {words} 0 ENDSEC")).as_bytes());
    let notes = notes.iter().map(ToString::to_string);
    (artwork.strokes, notes.collect())
}

/// Returns the points of an entity's only line. Panics if there are other lines, or notes.
fn entity(words: &str) -> Vec<[f64; 2]> {
    let (strokes, notes) = entities(words);
    assert_eq!(notes, [""; 0]);
    let [stroke] = strokes.as_slice() else {
        panic!("{strokes:?}")
    };
    stroke.points.clone()
}

fn near(one: [f64; 2], other: [f64; 2]) -> bool {
    libm::hypot(one[0] - other[0], one[1] - other[1]) < 1e-9
}
