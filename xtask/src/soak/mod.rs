//! Soak tests of the driver's guarantees: seeded simulations in virtual time, for as long as
//! wanted.
//!
//! Every soak is deterministic: runs with the same name, number of cases and seed send and receive
//! the same bytes at the same instants, and print the same digest of these. The tests of this crate
//! run each soak briefly.

mod command_log;
mod drawing;
mod heap;
mod hostile;
mod lines;
mod networks;
mod poses;
mod program;
mod resync;
mod shell;
mod streamed;
mod submitted;

use std::error::Error;
use std::time::Instant;

use crate::bench::figure::{Figure, Report};

/// Size and seed of a run.
#[derive(Clone, Copy, Debug)]
struct Scope {
    /// Number of cases: commands, faults or calls, depending on the soak.
    cases: u64,
    seed: u64,
}

/// Results of a soak: figures, and the digest of the traffic if there is any.
struct SoakResult {
    figures: Vec<Figure>,
    digest: Option<u64>,
}

/// Soak of one guarantee.
struct Soak {
    name: &'static str,
    description: &'static str,
    /// Cases that take about a minute in a release build.
    cases: u64,
    run: fn(Scope) -> Result<SoakResult, Box<dyn Error>>,
}

const SOAKS: [Soak; 14] = [
    Soak {
        name: "r1",
        description: "R1: queued commands one by one over a serial line that spoils and loses bytes",
        cases: 1_000_000,
        run: submitted::over_corrupted_line,
    },
    Soak {
        name: "r1-stream",
        description: "R1: a program streamed over such a line, one command in flight",
        cases: 1_000_000,
        run: streamed::over_corrupted_line,
    },
    Soak {
        name: "r1-poses",
        description: "R1: moves that the line altered, by the pose they end in; ten times the faults",
        cases: 1_000_000,
        run: poses::moves,
    },
    Soak {
        name: "r2",
        description: "R2: and the plug is pulled and the controller restarts now and then",
        cases: 1_000_000,
        run: submitted::with_resets,
    },
    Soak {
        name: "r2-stream",
        description: "R2: the same for a program that is streamed and resumed",
        cases: 1_000_000,
        run: streamed::with_resets,
    },
    Soak {
        name: "r2-handle",
        description: "R2: the plug of a handle is pulled, and put in again",
        cases: 20_000,
        run: shell::plugs,
    },
    Soak {
        name: "r3",
        description: "R3: queued commands over datagrams that are lost, doubled and out of order",
        cases: 1_000_000,
        run: submitted::datagrams,
    },
    Soak {
        name: "r4",
        description: "R4: what one spoilt, lost or added byte costs",
        cases: 30_000_000,
        run: resync::faults,
    },
    Soak {
        name: "r5",
        description: "R5: calls of a handle on lines that stall, fall silent, die and go",
        cases: 1_000_000,
        run: shell::deadlines,
    },
    Soak {
        name: "r6-host",
        description: "R6: steps of the host against a hostile arm",
        cases: 100_000_000,
        run: hostile::sessions,
    },
    Soak {
        name: "r7",
        description: "R7: memory of a session through so many seconds of that",
        cases: 86_400,
        run: hostile::memory,
    },
    Soak {
        name: "drawing",
        description: "programs that are drawn over lines of every kind of trouble",
        cases: 5_000,
        run: drawing::drawings,
    },
    Soak {
        name: "lines",
        description: "so many drawings over each kind of line, compared by length and holes: a table",
        cases: 12,
        run: lines::lines,
    },
    Soak {
        name: "networks",
        description: "so many drawings over each network that loses and doubles datagrams, compared in the same way",
        cases: 20,
        run: networks::networks,
    },
];

fn help() -> String {
    let lines = SOAKS.map(|soak| {
        format!(
            "    {:<14}{} ({} cases)\n",
            soak.name, soak.description, soak.cases
        )
    });
    lines.concat()
}

/// Runs the soaks that `words` name.
pub(crate) fn run(words: &[String]) -> Result<(), Box<dyn Error>> {
    let (mut json, mut names) = (false, Vec::new());
    let (mut cases, mut seed) = (None, 1);
    let mut rest = words.iter();
    while let Some(word) = rest.next() {
        let mut number = || -> Result<u64, Box<dyn Error>> {
            let text = rest
                .next()
                .ok_or_else(|| format!("{word} wants a number"))?;
            let wrong = |error| format!("{word} {text}: {error}");
            Ok(text.replace('_', "").parse().map_err(wrong)?)
        };
        match word.as_str() {
            "--json" => json = true,
            "--cases" => cases = Some(number()?),
            "--seed" => seed = number()?,
            name => names.push(name),
        }
    }
    if names.is_empty() {
        print!("{}", help());
        return Ok(());
    }
    let mut missed = Vec::new();
    for name in names {
        let soak = (SOAKS.iter().find(|soak| soak.name == name))
            .ok_or_else(|| format!("there is no soak `{name}`; there is\n{}", help()))?;
        let cases = cases.unwrap_or(soak.cases);
        missed.extend(report(soak, Scope { cases, seed }, json)?);
    }
    if missed.is_empty() {
        Ok(())
    } else {
        Err(format!("missed: {}", missed.join(", ")).into())
    }
}

/// Runs one soak and prints its results. Returns the names of figures that miss their goals.
fn report(soak: &Soak, scope: Scope, json: bool) -> Result<Vec<String>, Box<dyn Error>> {
    let Scope { cases, seed } = scope;
    let report = Report::new(json);
    report.title(&format!(
        "{} --cases {cases} --seed {seed}: {}",
        soak.name, soak.description
    ));
    let began = Instant::now();
    let result =
        (soak.run)(scope).map_err(|error| format!("{} --seed {seed}: {error}", soak.name))?;
    let wall_time = began.elapsed().as_secs_f64();
    let mut missed = Vec::new();
    for figure in &result.figures {
        report.print(figure);
        if figure.is_missed() {
            missed.push(format!("{} {}", soak.name, figure.name()));
        }
    }
    let speed =
        Figure::new("wall time", wall_time, "s").with("cases a second", cases as f64 / wall_time);
    report.print(&speed);
    if let Some(digest) = result.digest {
        if json {
            println!("{{\"name\":\"digest\",\"value\":\"{digest:016x}\"}}")
        } else {
            println!("  digest of all bytes, and when      {digest:016x}")
        }
    }
    Ok(missed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cases of each soak in a debug build.
    const SHORT_RUNS: [(&str, u64); 14] = [
        ("r1", 20_000),
        ("r1-stream", 10_000),
        ("r1-poses", 5_000),
        ("r2", 20_000),
        ("r2-stream", 10_000),
        ("r2-handle", 100),
        ("r3", 10_000),
        ("r5", 3_000),
        ("r4", 60_000),
        ("r6-host", 100_000),
        ("r7", 86_400),
        ("drawing", 25),
        ("lines", 1),
        ("networks", 2),
    ];

    fn run_soak(name: &str, cases: u64, seed: u64) -> SoakResult {
        let soak = SOAKS.iter().find(|soak| soak.name == name).unwrap();
        (soak.run)(Scope { cases, seed }).unwrap()
    }

    #[test]
    fn every_guarantee_holds_in_a_short_run() {
        for soak in &SOAKS {
            let (_, cases) = SHORT_RUNS
                .iter()
                .find(|(name, _)| *name == soak.name)
                .unwrap();
            let missed = report(
                soak,
                Scope {
                    cases: *cases,
                    seed: 1,
                },
                false,
            )
            .unwrap();
            assert!(missed.is_empty(), "{missed:?}");
        }
    }

    #[test]
    fn traffic_depends_on_the_seed_alone() {
        for (name, cases) in SHORT_RUNS {
            let digest = |seed| run_soak(name, cases / 10, seed).digest;
            let Some(first) = digest(7) else { continue };
            assert_eq!(digest(7), Some(first), "{name}");
            assert_ne!(digest(8), Some(first), "{name}");
        }
    }
}
