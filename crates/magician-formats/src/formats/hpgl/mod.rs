//! Reader of HPGL plots (`.plt`): pen strokes in units of 1/40 mm.
//!
//! | instructions | result |
//! |---|---|
//! | PU, PD, PA, PR | strokes |
//! | PE | the same, encoded |
//! | CI, AA, AR, AT, RT, EA, ER, EW | arcs within the tolerance, outlines |
//! | BZ, BR | curves within the tolerance |
//! | RA, RR, WG, FP | areas; lines of the file's own hatch (FT3, FT4) |
//! | XT, YT, TL | tick marks |
//! | PM, EP | polygons |
//! | IP, IR, SC, PS | scaling to user units; A4 with a note if the file does not define P1 and P2 |
//! | RO | rotation of the coordinate system |
//! | IW | clip window |
//! | SP | SP0 means no pen; other pens are the layers of the drawing |
//! | LB, BL, PB, SI, SR, DI, DR, DV, SL, LO, CP, ES, DT, SM | text, in the chosen font |
//! | IN, DF, LT, VS, PW, WU ... | no effect beyond defaults |
//!
//! Numbers are separated by a blank, a comma or nothing, instructions by a semicolon or nothing.
//! Escape sequences for the plotter (`ESC .`), and for a printer around the plot (`ESC E`, `ESC
//! %0A`, `@PJL`), are skipped.
//!
//! Instructions follow the HP-GL/2 and HP RTL reference guide and the manual of the HP 7475A.

mod areas;
mod curves;
mod encoded;
mod figures;
mod frame;
mod lexer;
mod plotter;
mod polygon;
mod scale;
mod text;

use super::notes::Notes;
use super::{Chords, Content, Parsed, ReadOptions};
use crate::encoding::{Fallback, decode_characters, with_line_feeds};
use crate::{Diagnostic, Lines};

use lexer::Instructions;
use plotter::Plotter;

pub(super) fn read(
    bytes: &[u8],
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed, Diagnostic> {
    // Encoded polylines consist of bytes.
    let text = decode_characters(bytes, Fallback::Bytes)?.text;
    let latin = std::str::from_utf8(bytes).is_err();
    let divided = with_line_feeds(text.as_ref().into());
    let lines = Lines::new(&divided);
    let mut plotter = Plotter::new(options, chords, &lines, latin);
    for instruction in Instructions::new(&text) {
        let done = instruction.and_then(|instruction| plotter.take(&instruction));
        done.map_err(|error| {
            let origin = lines.origin(error.range.clone());
            error.into_diagnostic(origin)
        })?;
    }
    let (artwork, notes) = plotter.finish();
    Ok(Parsed {
        content: Content::Artwork(artwork),
        notes,
    })
}
