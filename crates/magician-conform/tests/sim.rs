//! Every case on the virtual arm, and proof that a wrong arm does not pass.

use std::time::Duration;

use magician_conform::{Case, Examination, Outcome, SimBench, Suite, hex};
use magician_sim::Profile;

fn suite() -> Suite {
    Suite::built_in().unwrap_or_else(|error| panic!("{error}"))
}

/// The outcomes of cases on virtual arms with this profile.
fn examine<'c>(profile: Profile, cases: &[&'c Case]) -> Vec<(&'c Case, Outcome)> {
    let bench = SimBench::new(profile);
    let mut examination =
        Examination::new(bench, Duration::from_secs(1)).expect("the beginnings are read");
    let runtime = tokio::runtime::Builder::new_current_thread()
        .build()
        .expect("a runtime");
    runtime.block_on(async {
        examination.begin().await.expect("a virtual arm answers");
        let mut outcomes = Vec::new();
        for case in cases {
            let outcome = examination.examine(case).await.expect("no line to lose");
            outcomes.push((*case, outcome));
        }
        examination.end().await.expect("a virtual arm answers");
        outcomes
    })
}

fn told(case: &Case, outcome: &Outcome) -> String {
    match outcome {
        Outcome::Failed(m) => format!(
            "{} ({}.toml:{})\n    {}\n    sent     {}\n    expected {}\n    got      {} [{}]",
            case.id,
            case.chapter(),
            m.line,
            m.step,
            hex(&m.sent),
            m.expected,
            m.got,
            hex(&m.received)
        ),
        other => format!("{}: {other:?}", case.id),
    }
}

#[test]
fn the_virtual_arm_passes_every_case() {
    let suite = suite();
    let cases: Vec<_> = suite.cases().iter().collect();
    let outcomes = examine(Profile::default(), &cases);
    let bad: Vec<_> = outcomes
        .iter()
        .filter(|(_, outcome)| *outcome != Outcome::Passed)
        .map(|(case, outcome)| (case.pending, told(case, outcome)))
        .collect();
    let list = |pending| {
        let told: Vec<_> = bad
            .iter()
            .filter(|(is, _)| *is == pending)
            .map(|(_, text)| text.as_str())
            .collect();
        told.join("\n")
    };
    let ripe = outcomes
        .iter()
        .filter(|(case, outcome)| case.pending && *outcome == Outcome::Passed);
    println!("pending and red:\n{}", list(true));
    println!(
        "pending and green: {:?}",
        ripe.map(|(case, _)| case.id.as_str()).collect::<Vec<_>>()
    );
    println!("{} cases", cases.len());
    assert!(list(false).is_empty(), "\n{}", list(false));
}
