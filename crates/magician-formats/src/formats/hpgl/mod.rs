//! HPGL plots (`.plt`): pen lines in fortieths of a millimetre.
//!
//! | instructions | what becomes of them |
//! |---|---|
//! | PU, PD, PA, PR | strokes |
//! | PE | strokes: the same, encoded |
//! | CI, AA, AR, AT, RT, EA, ER, EW | arcs within the tolerance, outlines |
//! | BZ, BR | curves within the tolerance |
//! | RA, RR, WG, FP | areas; the lines of the file's own hatch (FT3, FT4) |
//! | XT, YT, TL | tick marks |
//! | PM, EP | polygons |
//! | IP, IR, SC, PS | scaling to user units; where the file does not say where P1 and P2 are, as on a sheet of A4, with a note |
//! | RO | the coordinate system is turned |
//! | IW | what lies outside of it is cut off |
//! | SP | SP0 is no pen; the others are the layers of the drawing |
//! | LB, BL, PB, SI, SR, DI, DR, DV, SL, LO, CP, ES, DT, SM | text, in the lettering that is asked for |
//! | IN, DF, LT, VS, PW, WU ... | as it is here anyway |
//!
//! Any of space, comma and nothing may stand between numbers, and a semicolon or nothing behind an instruction. What the plotter
//! itself is told (`ESC .`), and what a printer is told around a plot (`ESC E`, `ESC %0A`, `@PJL`), is passed over.
//!
//! Instructions are those of the HP-GL/2 and HP RTL reference guide and of the HP 7475A.

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
use crate::encoding::{Otherwise, characters, with_line_feeds};
use crate::{Diagnostic, Lines};

use lexer::Instructions;
use plotter::Plotter;

pub(super) fn read(
    bytes: &[u8],
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed, Diagnostic> {
    // Encoded polylines mean bytes.
    let text = characters(bytes, Otherwise::Bytes)?.text;
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
