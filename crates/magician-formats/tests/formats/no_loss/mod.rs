//! Files from users, of which nothing may be lost: content is drawn or played, reported by a note,
//! or refused.

mod bounds;
mod encodings;
mod lettering;
mod mutations;
mod paint;
mod studio;
mod words;

use std::path::Path;

use magician_formats::{Artwork, Content, Diagnostic, Format, Parsed, Plan, ReadOptions, read};

/// Returns a file of `tests/data`, whose README lists the sources.
pub(crate) fn data(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Reads a file of `tests/data` in the format that its name suggests.
pub(crate) fn content(name: &str, options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    let bytes = data(name);
    let format = Format::of(name, &bytes).unwrap_or_else(|| panic!("{name} is of no format"));
    read(format, &bytes, options)
}

pub(crate) fn artwork(name: &str, options: &ReadOptions) -> (Artwork, Vec<Diagnostic>) {
    match content(name, options) {
        Ok(Parsed {
            content: Content::Artwork(artwork),
            notes,
        }) => (artwork, notes),
        other => panic!("{name}: {other:?}"),
    }
}

pub(crate) fn plan(name: &str) -> (Plan, Vec<Diagnostic>) {
    match content(name, &ReadOptions::default()) {
        Ok(Parsed {
            content: Content::Plan(plan),
            notes,
        }) => (plan, notes),
        other => panic!("{name}: {other:?}"),
    }
}

/// Length of all strokes, mm.
pub(crate) fn length(artwork: &Artwork) -> f64 {
    let lengths = artwork.strokes.iter().map(|stroke| {
        let pairs = stroke.points.iter().zip(stroke.points.iter().skip(1));
        pairs
            .map(|(from, to)| (to[0] - from[0]).hypot(to[1] - from[1]))
            .sum::<f64>()
    });
    lengths.sum()
}

/// Returns all notes as one text, one per line.
pub(crate) fn note_text(notes: &[Diagnostic]) -> String {
    let told = notes.iter().map(ToString::to_string);
    told.collect::<Vec<_>>().join("\n")
}

#[track_caller]
pub(crate) fn near(one: f64, other: f64, within: f64) {
    assert!(
        (one - other).abs() <= within,
        "{one} is not {other} within {within}"
    );
}

/// Encodes text as little-endian UTF-16 with a byte order mark.
fn utf16(text: &str) -> Vec<u8> {
    let units = std::iter::once(0xFEFF).chain(text.encode_utf16());
    units.flat_map(u16::to_le_bytes).collect()
}
