//! Report at the end: facts and assumptions on which the virtual arm's answers were based.

use std::fmt::Write as _;

use magician::serve::Handle;
use magician_sim::fidelity::{Assumption, Confidence, Fidelity};
use serde_json::json;

/// Explanation of the sources in the third column.
const LEGEND: &str = "\
in the repository: model N is section N of docs/reference/MODEL.md, errata are in docs/reference/ERRATA.md, letters \
    and the whole list in docs/reference/FIDELITY.md
";

/// Returns the report on each arm: as lines, or with `json` as one object each.
pub(super) async fn report(arms: &[Handle], numbered: bool, json: bool) -> String {
    let mut report = String::new();
    for (number, arm) in (1..).zip(arms) {
        let fidelity = arm.with(|runner| runner.controller().fidelity().clone());
        // The end of an arm that is no longer served has been reported already.
        let Ok(fidelity) = fidelity.await else {
            continue;
        };
        let number = numbered.then_some(number);
        report += &if json {
            object(&fidelity, number)
        } else {
            lines(&fidelity, number)
        };
    }
    if !json && !report.is_empty() {
        report += LEGEND;
    }
    report
}

/// Returns facts, then choices, each sorted by use.
fn lines(fidelity: &Fidelity, number: Option<u32>) -> String {
    let arm = number.map_or_else(String::new, |number| format!("arm {number}: "));
    let mut text = String::new();
    let is_choice =
        |(assumption, _): &(Assumption, u64)| assumption.confidence() == Confidence::Choice;
    let (choices, facts): (Vec<_>, Vec<_>) = fidelity.iter().partition(is_choice);
    for (title, mut assumptions) in [("facts", facts), ("choices", choices)] {
        let count = assumptions.len();
        let _ = writeln!(text, "{arm}the replies relied on {count} {title}");
        assumptions.sort_by_key(|(_, uses)| std::cmp::Reverse(*uses));
        for (assumption, uses) in assumptions {
            let (letter, authority) = (assumption.confidence().letter(), assumption.authority());
            let says = assumption.says();
            let _ = writeln!(text, "{uses:>9}  {letter:<2} {authority:<10} {says}");
        }
    }
    text
}

fn object(fidelity: &Fidelity, number: Option<u32>) -> String {
    let assumptions: Vec<_> = fidelity
        .iter()
        .map(|(assumption, uses)| {
            json!({
                "basis": assumption.name(),
                "confidence": assumption.confidence().letter(),
                "section": assumption.section(),
                "page": assumption.authority().link().map(|link| format!("docs/reference/{link}")),
                "uses": uses,
                "says": assumption.says(),
            })
        })
        .collect();
    let mut object = json!({ "fidelity": assumptions });
    if let Some(number) = number {
        object["arm"] = json!(number);
    }
    format!("{object}\n")
}
