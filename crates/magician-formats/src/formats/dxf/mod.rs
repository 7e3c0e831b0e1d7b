//! Reader of DXF drawings (AutoCAD DXF Reference), in text and binary form.
//!
//! Drawn, as seen from above, are LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE, POLYLINE, SPLINE, HELIX,
//! POINT, 3DFACE, meshes, LEADER, MULTILEADER, HATCH, texts (TEXT, MTEXT, attributes) in the chosen
//! font, DIMENSION and tables by the block stored with them, and inserted blocks within their clip
//! boundary (XCLIP). Solid hatches, SOLID, TRACE and arrows are areas; other hatches have the lines
//! of their pattern. Lines that meet are joined.
//!
//! Layers that are off, frozen or not plotted are left out, and so are all other entities, with a
//! note.

mod binary;
mod canvas;
mod color;
mod curve;
mod drawing;
mod entity;
mod hatch;
mod join;
mod leader;
mod mesh;
mod mtext;
mod pairs;
mod spline;
#[cfg(test)]
mod tests;
mod text;
mod xclip;

use canvas::Canvas;
use drawing::Drawing;

use super::{Chords, Content, Parsed, ReadOptions};
use crate::encoding::{Fallback, decode};
use crate::{Diagnostic, Origin};

pub(super) fn read(
    bytes: &[u8],
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed, Diagnostic> {
    match binary::to_text(bytes)? {
        // The text of a binary file does not exist for the user, so places in it mean nothing.
        Some(text) => read_text(&text, options, chords)
            .map(without_places)
            .map_err(|diagnostic| Diagnostic {
                origin: Origin::NONE,
                ..diagnostic
            }),
        None => {
            let decoded = decode(bytes, Fallback::Western)?;
            let mut parsed = read_text(&decoded.text, options, chords)?;
            parsed.notes.extend(decoded.note);
            Ok(parsed)
        }
    }
}

fn read_text(text: &str, options: &ReadOptions, chords: &Chords) -> Result<Parsed, Diagnostic> {
    let pairs = pairs::pairs(text)?;
    let records = pairs::records(&pairs);
    let drawing = Drawing::new(&records)?;
    let mut canvas = Canvas::new(&drawing, options, chords);
    canvas.draw()?;
    if canvas.is_empty() && canvas.has_sheet {
        canvas = Canvas::of_sheet(&drawing, options, chords);
        canvas.draw()?;
    }
    let (artwork, notes) = canvas.finish();
    Ok(Parsed {
        content: Content::Artwork(artwork),
        notes,
    })
}

fn without_places(mut reading: Parsed) -> Parsed {
    let forget = |origin: &mut Origin| {
        let name = origin.name;
        *origin = Origin {
            name,
            ..Origin::NONE
        };
    };
    for note in &mut reading.notes {
        forget(&mut note.origin);
    }
    if let Content::Artwork(artwork) = &mut reading.content {
        for stroke in &mut artwork.strokes {
            forget(&mut stroke.origin);
        }
        for filled in &mut artwork.areas {
            forget(&mut filled.origin);
        }
    }
    reading
}
