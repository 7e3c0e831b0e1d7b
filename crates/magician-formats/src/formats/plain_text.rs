//! Reader of plain text: lays out its characters in a font.

use std::ops::Range;

use magician_host::{Setting, SettingValue, message};

use super::{Chords, Content, Fills, Parsed, ReadOptions};
use crate::artwork::Style;
use crate::encoding::{Fallback, decode};
use crate::fill::{Area, FillRule};
use crate::lettering::{Glyphs, LaidText, lacks, lay_out};
use crate::{Artwork, Diagnostic, DiagnosticCode, FilledArea, Lines, Origin, Stroke};

/// Largest number of characters. A choice: far more than a sheet can hold.
const MAX_CHARACTERS: usize = 100_000;
/// Largest height of a capital, mm.
const MAX_CAPITAL_HEIGHT: f64 = 10_000.0;
/// Largest number of missing characters to name. The rest is counted.
const MAX_NAMED_CHARACTERS: usize = 20;

pub(super) fn read(
    bytes: &[u8],
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed, Diagnostic> {
    let decoded = decode(bytes, Fallback::Western)?;
    let text = decoded.text.trim_end_matches(['\n', '\r']);
    let lines = Lines::new(text);
    if text.trim().is_empty() {
        return Err(Diagnostic::of_file(message!("there is no text")));
    }
    let count = text.chars().count();
    if count > MAX_CHARACTERS {
        let message = message!(
            "the text has {count} characters, limit {limit}",
            count,
            limit = MAX_CHARACTERS
        );
        return Err(Diagnostic::of_file(message));
    }
    let size = options.text.size;
    if !(size > 0.0 && size <= MAX_CAPITAL_HEIGHT) {
        let message = message!(
            "a capital is {size} mm high, limit {limit}",
            size,
            limit = MAX_CAPITAL_HEIGHT
        );
        return Err(Diagnostic::of_file(message)
            .remedy((Setting::Size, SettingValue::Any("MM")), "sets it"));
    }
    let font = options.text.font.load()?;
    let LaidText {
        lines: penned,
        missing,
        substituted,
    } = lay_out(text, &font, &options.text, chords.for_curve())?;
    let mut notes = notes(&missing, &lines, options)?;
    notes.extend(substitution(&substituted, &lines, options));
    notes.extend(decoded.note);
    let mut artwork = Artwork {
        title: options.title.clone(),
        in_order: font.has_stroke_order(),
        ..Artwork::default()
    };
    let filled = options.fills == Fills::Areas && font.is_outlined();
    // Characters that the font lacks come from a single-line font, so they have nothing to fill.
    let single = |range: &Range<usize>| substituted.iter().any(|(_, other)| other == range);
    for letter in penned.chunk_by(|one, next| one.range == next.range) {
        let Some(range) = letter.first().map(|line| line.range.clone()) else {
            continue;
        };
        let origin = lines.origin(range.clone());
        let points = letter.iter().map(|line| line.points.clone());
        if filled && !single(&range) {
            let area = Area {
                rings: points.collect(),
                rule: FillRule::NonZero,
            };
            artwork.areas.push(FilledArea {
                area,
                origin,
                style: Style::default(),
            });
        } else {
            let strokes = points.map(|points| Stroke::new(points, origin));
            artwork.strokes.extend(strokes);
        }
    }
    Ok(Parsed {
        content: Content::Artwork(artwork),
        notes,
    })
}

/// Returns a note about characters taken from another font.
fn substitution(
    substituted: &[(char, Range<usize>)],
    lines: &Lines<'_>,
    options: &ReadOptions,
) -> Option<Diagnostic> {
    let (_, first) = substituted.first()?;
    let named = substituted.iter().take(MAX_NAMED_CHARACTERS);
    let named: Vec<String> = named
        .map(|(character, _)| format!("'{character}'"))
        .collect();
    let more = if substituted.len() > MAX_NAMED_CHARACTERS {
        ", .."
    } else {
        ""
    };
    let message = message!(
        "written in sans, because the font {font} does not have them: {characters}",
        font = options.text.font.to_string(),
        characters = named.join(", ") + more
    );
    let note = Diagnostic::new(lines.origin(first.clone()), message);
    Some(note.coded(DiagnosticCode::Assumed))
}

/// Returns notes about characters that no font has, or the error for the first one in strict mode.
fn notes(
    missing: &[(char, Range<usize>)],
    lines: &Lines<'_>,
    options: &ReadOptions,
) -> Result<Vec<Diagnostic>, Diagnostic> {
    let font = options.text.font.to_string();
    let about = |(character, range): &(char, Range<usize>)| {
        let origin = lines.origin(range.clone());
        lacks(*character, &font, options.strict_text, origin)
    };
    if let Some(first) = missing.first().filter(|_| options.strict_text) {
        return Err(about(first));
    }
    let named = missing.iter().take(MAX_NAMED_CHARACTERS);
    let mut notes: Vec<Diagnostic> = named
        .map(|one| about(one).coded(DiagnosticCode::LeftOut))
        .collect();
    let more = missing.len().saturating_sub(MAX_NAMED_CHARACTERS);
    if more > 0 {
        let message = message!("{more} more characters are left out", more);
        notes.push(Diagnostic::new(Origin::NONE, message).coded(DiagnosticCode::LeftOut));
    }
    Ok(notes)
}
