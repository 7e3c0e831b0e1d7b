//! DXF drawings (AutoCAD DXF Reference; text, and binary as text).
//!
//! Drawn are LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE, POLYLINE, SPLINE, POINT, the outlines of SOLID, TRACE and 3DFACE, and what
//! blocks hold, seen from above; lines that meet become one. Layers that are off, frozen or not plotted are left out, and so is the rest, with a note.

mod binary;
mod canvas;
mod color;
mod curve;
mod drawing;
mod entity;
mod join;
mod pairs;
mod spline;
#[cfg(test)]
mod tests;

use canvas::Canvas;
use drawing::Drawing;

use super::{Content, Parsed, ReadOptions};
use crate::artwork::Layer;
use crate::{Artwork, Diagnostic, Origin};

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    if bytes.starts_with(b"AC10") {
        return Err(Diagnostic::of_file("this is a DWG file, not a DXF file")
            .help("save it as DXF in the program that made it"));
    }
    match binary::to_text(bytes)? {
        // Positions in a text that does not exist are left out.
        Some(text) => read_text(&text, options)
            .map(without_places)
            .map_err(|diagnostic| Diagnostic {
                origin: Origin::NONE,
                ..diagnostic
            }),
        None => read_text(&String::from_utf8_lossy(bytes), options),
    }
}

fn read_text(text: &str, options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    let pairs = pairs::pairs(text)?;
    let records = pairs::records(&pairs);
    let drawing = Drawing::new(&records)?;
    let mut canvas = Canvas::new(&drawing, options.tolerance);
    canvas.draw()?;
    let (strokes, names, colors, notes) = canvas.finish();
    let layers = names.iter().map(|name| Layer {
        name: Some(name.clone()),
        inkscape: false,
    });
    let artwork = Artwork {
        title: options.title.clone(),
        strokes: join::joined(strokes),
        layers: layers.collect(),
        colors,
        names,
        ..Artwork::default()
    };
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
    }
    reading
}
