//! Drawings over bad lines: the result is identical, or the run stops and reports its place.

use std::error::Error;
use std::path::Path;

use magician::faults::Faults;
use magician::pair::Digest;
use magician::sim::world::Drawing;
use magician_program::Plan;

use super::{Scope, SoakResult};
use crate::bench::figure::Figure;

#[path = "../../../crates/magician-program/tests/program/lossy/datagrams.rs"]
pub(super) mod datagrams;
#[path = "../../../crates/magician-program/tests/program/lossy/ink.rs"]
mod ink;
#[path = "../../../crates/magician-program/tests/program/lossy/programs.rs"]
pub(super) mod programs;
#[path = "../../../crates/magician-program/tests/program/lossy/rig.rs"]
pub(super) mod rig;
#[path = "../../../crates/magician-program/tests/program/lossy/sheet.rs"]
pub(super) mod sheet;
#[path = "../../../crates/magician-program/tests/program/lossy/troubles.rs"]
mod troubles;
#[path = "../../../crates/magician-program/tests/program/lossy/verdict.rs"]
pub(super) mod verdict;

use ink::{CORNER_ACCURACY, Ink};
use rig::{FaultSetup, draw, on_virtual_clock};
use verdict::{Verdict, drawn, judge};

const SAMPLES: &str = "../crates/magician-program/samples";
/// One round in this many draws over a network, the others over a line.
const NETWORK_INTERVAL: u64 = 5;
/// Largest number of failed drawings that are printed.
const MAX_PRINTED: u64 = 10;

/// Plan, and its drawing without faults.
struct Program {
    name: &'static str,
    plan: Plan,
    expected: Drawing,
}

#[derive(Default)]
struct Tally {
    commands: u64,
    requests: u64,
    resent: u64,
    same_strokes: u64,
    same_lines: u64,
    completed: u64,
    stopped: u64,
    interrupted: u64,
    interruptions: u64,
    doubled: u64,
    wrong: u64,
    digest: Digest,
}

/// Reads the plan of a sample.
pub(super) fn sample(name: &str) -> Result<Plan, Box<dyn Error>> {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join(SAMPLES);
    Ok(programs::plan(&samples, name)?)
}

/// Runs `scope.cases` drawings, each with its own program, faults and seed.
pub(super) fn drawings(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join(SAMPLES);
    let mut all = Vec::new();
    for name in programs::PROGRAMS {
        let plan = programs::plan(&samples, name)?;
        let expected = drawn(&plan, None);
        all.push(Program {
            name,
            plan,
            expected,
        });
    }
    let mut tally = Tally::default();
    for nth in 0..scope.cases {
        let seed = scope.seed.wrapping_mul(1_000_003).wrapping_add(nth);
        let program = all
            .get((nth % all.len() as u64) as usize)
            .ok_or("no programs")?;
        let round = nth / all.len() as u64;
        let wrong = match round % NETWORK_INTERVAL {
            0 => tally.over_a_network(program, round / NETWORK_INTERVAL, seed)?,
            _ => tally.over_a_line(program, round, seed)?,
        };
        let Some(wrong) = wrong else { continue };
        tally.wrong += 1;
        if tally.wrong <= MAX_PRINTED {
            println!("  {}: {wrong}", program.name);
        }
    }
    Ok(SoakResult {
        figures: tally.figures(scope.cases),
        digest: Some(tally.digest.0),
    })
}

impl Tally {
    /// Draws over a faulty line. Returns a description of what is wrong, or `None`.
    fn over_a_line(
        &mut self,
        program: &Program,
        round: u64,
        seed: u64,
    ) -> Result<Option<String>, Box<dyn Error>> {
        let Program { plan, expected, .. } = program;
        let trouble = FaultSetup {
            faults: faults(&troubles::SERIAL_FAULTS, round, seed)?,
            window: [4, 1, 2, 1, 8, 1, 3, 1, 6][(round % 9) as usize],
        };
        let outcome = on_virtual_clock(draw(plan, trouble))?;
        self.commands += plan.commands().count() as u64;
        self.requests += outcome.requests[0];
        self.resent += outcome.requests[1];
        self.interrupted += u64::from(!outcome.between.is_empty());
        self.interruptions += outcome.between.len() as u64;
        self.digest
            .add(outcome.requests[0], &trace(&outcome.drawing));
        Ok(match judge(plan, expected, trouble, &outcome) {
            Ok(verdict) => {
                self.count(verdict);
                None
            }
            Err(why) => Some(format!(
                "{}, window {}: {why}; {:?}",
                trouble.faults, trouble.window, outcome.end
            )),
        })
    }

    fn over_a_network(
        &mut self,
        program: &Program,
        round: u64,
        seed: u64,
    ) -> Result<Option<String>, Box<dyn Error>> {
        let faults = faults(&troubles::NETWORK_FAULTS, round, seed)?;
        let run = datagrams::draw(&program.plan, faults)?;
        self.commands += program.plan.commands().count() as u64;
        self.requests += run.requests;
        self.interrupted += u64::from(run.resumed > 0);
        self.interruptions += run.resumed as u64;
        self.doubled += u64::from(run.told);
        self.digest.add(run.requests, &trace(&run.drawing));
        let (ink, all) = (Ink::of(&run.drawing), Ink::of(&program.expected));
        let begins =
            (ink.distance_from_beginning_of(&all)).is_some_and(|off| off <= CORNER_ACCURACY);
        let ends = (ink.length() - all.length()).abs() <= CORNER_ACCURACY;
        let verdict = match run.stopped {
            None if ink.equals(&all) => Verdict::Same,
            None if begins && ends => Verdict::Equal,
            Some(_) if begins => Verdict::Stopped,
            stopped => {
                let found = format!(
                    "{faults}, datagrams: {:.3} of {:.3} mm",
                    ink.length(),
                    all.length()
                );
                return Ok(Some(format!("{found}; {stopped:?}")));
            }
        };
        self.count(verdict);
        Ok(None)
    }

    fn count(&mut self, verdict: Verdict) {
        let count = match verdict {
            Verdict::Same => &mut self.same_strokes,
            Verdict::Equal => &mut self.same_lines,
            Verdict::Completed => &mut self.completed,
            Verdict::Stopped => &mut self.stopped,
        };
        *count += 1;
    }

    fn figures(&self, cases: u64) -> Vec<Figure> {
        let count = |name: &str, value: u64| Figure::new(name, value as f64, "");
        // The checksum misses some alterations. Goal R1 (docs/evidence/MEASUREMENTS.md) allows 3 in
        // a million commands.
        let altered = 3.0 * (self.commands as f64 / 1e6).max(1.0);
        vec![
            count("drawings", cases).with("commands", self.commands as f64),
            count("requests", self.requests).with("sent again", self.resent as f64),
            count("the same strokes", self.same_strokes),
            count("the same lines", self.same_lines),
            count("stopped, gone on with, whole", self.completed),
            count("stopped, with the steps in doubt", self.stopped)
                .with("commands doubled and told of", self.doubled as f64),
            count("interrupted on the way", self.interrupted)
                .with("times", self.interruptions as f64),
            count("another drawing", self.wrong).at_most(altered),
        ]
    }
}

fn faults(troubles: &[&str], round: u64, seed: u64) -> Result<Faults, Box<dyn Error>> {
    let nth = (round % troubles.len() as u64) as usize;
    let text = troubles.get(nth).ok_or("no troubles")?;
    Ok(format!("{text},seed={seed}").parse()?)
}

/// Returns the bytes of a drawing.
fn trace(drawing: &Drawing) -> Vec<u8> {
    let points = drawing.strokes().iter().flat_map(|stroke| &stroke.points);
    points
        .flatten()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}
