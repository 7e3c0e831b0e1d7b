//! Drawings over networks that lose and duplicate datagrams, compared like those over lines.

use std::error::Error;
use std::time::Duration;

use magician::faults::Faults;

use super::drawing::sheet::{Passage, Row};
use super::drawing::verdict::drawn;
use super::drawing::{datagrams, sample};
use super::{Scope, SoakResult};
use crate::bench::figure::Figure;

/// Share of datagrams lost in each direction; one of 100 of the others is duplicated.
const LOSS_RATES: [&str; 4] = ["0", "0.003", "0.01", "0.02"];
/// Drawing of 80 commands.
const DRAWING: &str = "house.svg";

/// Runs `scope.cases` drawings over each network.
pub(super) fn networks(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let plan = sample(DRAWING)?;
    let expected = drawn(&plan, None);
    let faultless_time = datagrams::draw(&plan, Faults::NONE)?.lasted;
    let mut figures = Vec::new();
    let (mut wrong, mut lost, mut slowest) = (0, 0, 0.0_f64);
    println!("{}", Row::TABLE_HEAD);
    for share in LOSS_RATES {
        let mut row = Row::new(format!("UDP, {share} lost, 0.01 doubled, each way"));
        let mut doubled = 0;
        for nth in 0..scope.cases {
            let seed = scope.seed.wrapping_mul(1_000_003).wrapping_add(nth);
            let text = format!("drop-chunk={share},duplicate-chunk=0.01,seed={seed}");
            let run = datagrams::draw(&plan, text.parse()?)?;
            doubled += run.told;
            let passage = Passage {
                right: &expected,
                drawn: &run.drawing,
                done: run.stopped.is_none() && run.resumed == 0,
                took: Duration::from_micros(run.lasted),
                usual: Duration::from_micros(faultless_time),
            };
            if let Some(wrong) = row.add(&passage) {
                println!("  {text}: {wrong}");
            } else if !passage.done {
                println!("  {text}: {:?}", run.stopped);
            }
        }
        println!("{}", row.line());
        wrong += row.wrong;
        lost += row.runs - row.done;
        slowest = slowest.max(row.slowest);
        figures.push(
            Figure::new(row.name.clone(), row.done as f64, "done")
                .with("of", row.runs as f64)
                .with("wrong", row.wrong as f64)
                .with("commands doubled", f64::from(doubled)),
        );
    }
    figures.push(Figure::new("done and wrong", wrong as f64, "").at_most(0.0));
    figures.push(Figure::new("not done", lost as f64, ""));
    figures.push(Figure::new("slowest", slowest, "times a good network's").at_most(2.0));
    Ok(SoakResult {
        figures,
        digest: None,
    })
}
