//! Drawings over lines of each kind, compared with the correct drawing: a table with one row per
//! line.

use std::error::Error;

use magician::faults::Faults;
use magician::sim::world::Drawing;
use magician_program::Plan;

use super::drawing::programs::hard;
use super::drawing::rig::{FaultSetup, Outcome, draw_at, on_virtual_clock};
use super::drawing::sheet::{Passage, Row};
use super::drawing::verdict::drawn;
use super::{Scope, SoakResult};
use crate::bench::figure::Figure;

/// Points on the curve of the drawing: few, so that most of it is long strokes and corners; more;
/// and many.
const FEW_POINTS: u32 = 12;
const SOME_POINTS: u32 = 200;
const MANY_POINTS: u32 = 2_400;

/// Kind of line.
struct Line {
    name: &'static str,
    faults: &'static str,
    windows: &'static [usize],
    points: u32,
    /// Speed of the arm relative to the host's assumption.
    pace: f64,
    /// True if every drawing must be completed.
    completes: bool,
}

const LINES: [Line; 10] = [
    Line {
        name: "some 6 spoilt bytes, 40 commands, an arm 20 times as fast",
        faults: "replace=2e-3",
        windows: &[1, 2, 3, 4, 5, 6, 7, 8],
        points: FEW_POINTS,
        pace: 20.0,
        completes: true,
    },
    Line {
        name: "some 6 spoilt bytes, 40 commands",
        faults: "replace=2e-3",
        windows: &[1, 2, 3, 4, 5, 6, 7, 8],
        points: FEW_POINTS,
        pace: 1.0,
        completes: true,
    },
    Line {
        name: "some 6 spoilt bytes",
        faults: "replace=3e-4",
        windows: &[1, 2, 3, 4, 5, 6, 7, 8],
        points: SOME_POINTS,
        pace: 1.0,
        completes: true,
    },
    Line {
        name: "1 spoilt byte in 1,000, 1 lost in 10,000",
        faults: "replace=1e-3,drop=1e-4",
        windows: &[1, 2, 4, 8],
        points: SOME_POINTS,
        pace: 1.0,
        completes: false,
    },
    Line {
        name: "3 frames in 100 lost, stalls of 0.1 s",
        faults: "drop-chunk=0.03,stall=0.01",
        windows: &[1, 4],
        points: SOME_POINTS,
        pace: 1.0,
        completes: false,
    },
    Line {
        name: "held for 1 s",
        faults: "stall=0.005,stall-min-ms=1000,stall-ms=1000",
        windows: &[1, 4],
        points: SOME_POINTS,
        pace: 1.0,
        completes: true,
    },
    Line {
        name: "held for 3 s",
        faults: "stall=0.005,stall-min-ms=3000,stall-ms=3000",
        windows: &[1, 4],
        points: SOME_POINTS,
        pace: 1.0,
        completes: true,
    },
    Line {
        name: "held for 8 s",
        faults: "stall=0.002,stall-min-ms=8000,stall-ms=8000",
        windows: &[1, 4],
        points: SOME_POINTS,
        pace: 1.0,
        completes: true,
    },
    Line {
        name: "held for 20 s",
        faults: "stall=7e-4,stall-min-ms=20000,stall-ms=20000",
        windows: &[1, 4],
        points: SOME_POINTS,
        pace: 1.0,
        completes: true,
    },
    Line {
        name: "2,400 points, held for up to 8 s, 1 spoilt byte in 1,000",
        faults: "stall=5e-4,stall-ms=8000,replace=1e-3",
        windows: &[1],
        points: MANY_POINTS,
        pace: 1.0,
        completes: true,
    },
];

/// Runs this many drawings over each line with each window.
pub(super) fn lines(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let mut figures = Vec::new();
    let (mut wrong, mut lost) = (0, 0);
    println!("{}", Row::TABLE_HEAD);
    for points in [FEW_POINTS, SOME_POINTS, MANY_POINTS] {
        let plan = hard(points)?;
        let right = drawn(&plan, None);
        let good = FaultSetup {
            faults: Faults::NONE,
            window: 1,
        };
        let usual = draw_over(&plan, good, 1.0)?;
        let of_these = LINES.iter().filter(|line| line.points == points);
        for (line, window) in of_these.flat_map(|line| line.windows.iter().map(move |w| (line, *w)))
        {
            let row = drawings(scope, line, window, (&plan, &right, &usual))?;
            println!("{}", row.line());
            wrong += row.wrong;
            lost += if line.completes {
                row.runs - row.done
            } else {
                0
            };
            figures.push(
                Figure::new(row.name.clone(), row.done as f64, "done")
                    .with("of", row.runs as f64)
                    .with("wrong", row.wrong as f64),
            );
        }
    }
    figures.push(Figure::new("done and wrong", wrong as f64, "").at_most(0.0));
    figures.push(Figure::new("not done where it can be", lost as f64, ""));
    Ok(SoakResult {
        figures,
        digest: None,
    })
}

fn draw_over(plan: &Plan, trouble: FaultSetup, pace: f64) -> Result<Outcome, Box<dyn Error>> {
    Ok(on_virtual_clock(draw_at(plan, trouble, pace))?)
}

fn drawings(
    scope: Scope,
    line: &Line,
    window: usize,
    (plan, right, usual): (&Plan, &Drawing, &Outcome),
) -> Result<Row, Box<dyn Error>> {
    let mut row = Row::new(format!("serial, window {window}, {}", line.name));
    for nth in 0..scope.cases {
        let seed = scope.seed.wrapping_mul(1_000_003).wrapping_add(nth);
        let faults: Faults = format!("{},seed={seed}", line.faults).parse()?;
        let outcome = draw_over(plan, FaultSetup { faults, window }, line.pace)?;
        let passage = Passage {
            right,
            drawn: &outcome.drawing,
            done: outcome.end.is_ok() && outcome.between.is_empty(),
            took: outcome.took,
            usual: usual.took,
        };
        if let Some(wrong) = row.add(&passage) {
            println!("  window {window}, {faults}: {wrong}");
        } else if !passage.done && line.completes {
            println!(
                "  window {window}, {faults}: {:?} {:?}",
                outcome.why, outcome.end
            );
        }
    }
    Ok(row)
}
