//! Chinese and Japanese characters with stroke order, from the data of KanjiVG, hanzi-writer and
//! Make Me a Hanzi.

use magician_host::message;
use std::collections::HashMap;

use kurbo::{Affine, BezPath};
use serde::Deserialize;

use crate::Diagnostic;
use crate::curves::flatten;
use crate::formats::Format;
use crate::lettering::svg_font;
use crate::lettering::{Glyph, Glyphs};

/// Height of a Latin capital beside these characters, as a share of the square. A choice that suits
/// the line spacing of Latin text.
const CAP_HEIGHT_SHARE: f64 = 0.75;
/// Depth of the square below the baseline, as a share of the square. A choice, as above.
const BASELINE_DEPTH_SHARE: f64 = 0.12;
/// Side of the square in KanjiVG, where y grows downwards.
const KANJIVG_SQUARE: f64 = 109.0;
/// Side of the square in hanzi-writer, whose baseline is at y = 0.
const HANZI_WRITER_SQUARE: f64 = 1024.0;

pub(super) struct StrokeOrder {
    square: f64,
    strokes: HashMap<char, Vec<BezPath>>,
}

impl StrokeOrder {
    fn new(square: f64, strokes: HashMap<char, Vec<BezPath>>) -> Result<Self, Diagnostic> {
        if strokes.is_empty() {
            Err(Diagnostic::of_file(message!("the file has no character")))
        } else {
            Ok(Self { square, strokes })
        }
    }
}

impl Glyphs for StrokeOrder {
    fn cap_height(&self) -> f64 {
        CAP_HEIGHT_SHARE * self.square
    }

    fn glyph(&self, character: char, tolerance: f64) -> Option<Glyph> {
        let strokes = self.strokes.get(&character)?.iter();
        Some(Glyph {
            advance: self.square,
            lines: strokes
                .flat_map(|stroke| flatten(stroke, tolerance, false))
                .collect(),
        })
    }

    fn has_stroke_order(&self) -> bool {
        true
    }
}

/// Reads KanjiVG: all characters in one file, or one character as a drawing. The id of an element
/// contains the code point of its character.
pub(super) fn kanjivg(text: &str) -> Result<StrokeOrder, Diagnostic> {
    // A drawing declares the namespace prefix only in its document type, which the parser ignores.
    let text = text.replace("kvg:", "kvg-");
    let document = super::document(&text)?;
    let to = Affine::new([
        1.0,
        0.0,
        0.0,
        -1.0,
        0.0,
        KANJIVG_SQUARE * (1.0 - BASELINE_DEPTH_SHARE),
    ]);
    let mut strokes = HashMap::new();
    for node in document.descendants() {
        let id = node.attribute("id").unwrap_or_default();
        let code = id
            .strip_prefix("kvg-kanji_")
            .or_else(|| id.strip_prefix("kvg-StrokePaths_"));
        // Variants have a suffix after the code point and are skipped.
        let Some(character) = code
            .and_then(|code| u32::from_str_radix(code, 16).ok())
            .and_then(char::from_u32)
        else {
            continue;
        };
        let paths = node.descendants().filter_map(|node| node.attribute("d"));
        let paths = paths.map(|path| Ok(to * svg_font::path(path, character, KANJIVG_SQUARE)?));
        let paths: Vec<_> = paths.collect::<Result<_, Diagnostic>>()?;
        strokes.entry(character).or_insert(paths);
    }
    StrokeOrder::new(KANJIVG_SQUARE, strokes)
}

/// A character of hanzi-writer or Make Me a Hanzi: the centre line of each stroke.
#[derive(Deserialize)]
struct Character {
    character: Option<String>,
    medians: Vec<Vec<[f64; 2]>>,
}

/// Reads JSON of hanzi-writer (all characters by name, or one character named like the file) or
/// Make Me a Hanzi (one line per character).
pub(super) fn medians(text: &str, name: &str) -> Result<StrokeOrder, Diagnostic> {
    let all: Result<HashMap<String, Character>, _> = serde_json::from_str(text);
    let all: Vec<(String, Character)> = match all {
        Ok(all) => all.into_iter().collect(),
        Err(_) => {
            let stream = serde_json::Deserializer::from_str(text).into_iter::<Character>();
            let named = stream.map(|character| {
                let character = character?;
                let own = character.character.clone();
                Ok((
                    own.unwrap_or_else(|| Format::title(name).to_owned()),
                    character,
                ))
            });
            let named: Result<_, serde_json::Error> = named.collect();
            named.map_err(|error| Diagnostic::of_file(error.to_string()))?
        }
    };
    let mut strokes = HashMap::new();
    for (name, character) in all {
        let mut letters = name.chars();
        let (Some(letter), None) = (letters.next(), letters.next()) else {
            let message = message!(
                "'{name}' is not one character: a file of one is named for it, such as 中.json",
                name
            );
            return Err(Diagnostic::of_file(message));
        };
        let paths = character.medians.iter().map(|median| {
            let mut points = median.iter().map(|[x, y]| (*x, *y));
            let mut path = BezPath::new();
            if let Some(first) = points.next() {
                path.move_to(first);
            }
            points.for_each(|point| path.line_to(point));
            svg_font::within(path, letter, HANZI_WRITER_SQUARE)
        });
        strokes.insert(letter, paths.collect::<Result<_, Diagnostic>>()?);
    }
    StrokeOrder::new(HANZI_WRITER_SQUARE, strokes)
}
