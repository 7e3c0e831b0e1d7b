//! HPGL plots (`.plt`): pen lines in fortieths of a millimetre.
//!
//! | instructions | what becomes of them |
//! |---|---|
//! | PU, PD, PA, PR | strokes |
//! | CI, AA, AR, EA, ER, EW | arcs within the tolerance, outlines |
//! | BZ, BR | curves within the tolerance |
//! | RA, RR, WG | outlines, with a note: nothing is filled |
//! | PM, EP, FP | polygons, as outlines |
//! | IP, SC | scaling to user units; without IP it is the plotter's own and refused |
//! | SP | SP0 is no pen; all others draw alike |
//! | IN, DF, LT, VS, PW, WU ... | as it is here anyway |
//! | LB | text, left out with a note |
//! | PE, RO, AT, RT | refused |
//!
//! Any of space, comma and nothing may stand between numbers, and a semicolon or nothing behind an instruction.

mod curves;
mod figures;
mod lexer;
mod plotter;
mod polygon;
mod scale;

use super::gcode::{Notes, text_of};
use super::{Content, ReadOptions, Reading};
use crate::{Lines, Problem};

use lexer::Instructions;
use plotter::Plotter;

/// No curve is followed more closely than this, mm.
const FINEST: f64 = 1e-4;

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Reading, Problem> {
    let text = text_of(bytes);
    let lines = Lines::new(&text);
    let tolerance = options.tolerance;
    let tolerance = if tolerance > FINEST {
        tolerance
    } else {
        FINEST
    };
    let mut plotter = Plotter::new(&options.title, tolerance, &lines);
    for instruction in Instructions::new(&text) {
        let done = instruction.and_then(|instruction| plotter.take(&instruction));
        done.map_err(|flaw| {
            let origin = lines.origin(flaw.range.clone());
            flaw.into_problem(origin)
        })?;
    }
    let (artwork, notes) = plotter.finish();
    Ok(Reading {
        content: Content::Artwork(artwork),
        notes,
    })
}
