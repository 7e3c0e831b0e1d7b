//! What the answers rested on, told at the end.

use std::fmt::Write as _;

use magician::serve::Handle;
use magician_sim::fidelity::{Basis, Confidence, Fidelity};
use serde_json::json;

/// Where the numbers lead that stand in the third column.
const LEGEND: &str = "\
in the repository: model N is docs/MODEL.md section N, errata are docs/ERRATA.md, letters and the whole list docs/FIDELITY.md
";

/// What there is to say of each arm: lines, or with `json` an object for each.
pub(super) async fn report(arms: &[Handle], numbered: bool, json: bool) -> String {
    let mut report = String::new();
    for (number, arm) in (1..).zip(arms) {
        let fidelity = arm.with(|runner| runner.controller().fidelity().clone());
        // An arm that is not served any more has been told of already.
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

/// Facts, then choices; of each kind what was used most first.
fn lines(fidelity: &Fidelity, number: Option<u32>) -> String {
    let arm = number.map_or_else(String::new, |number| format!("arm {number}: "));
    let mut text = String::new();
    let is_choice = |(basis, _): &(Basis, u64)| basis.confidence() == Confidence::Choice;
    let (choices, facts): (Vec<_>, Vec<_>) = fidelity.iter().partition(is_choice);
    for (title, mut bases) in [("facts", facts), ("choices", choices)] {
        let count = bases.len();
        let _ = writeln!(text, "{arm}the answers rested on {count} {title}");
        bases.sort_by_key(|(_, uses)| std::cmp::Reverse(*uses));
        for (basis, uses) in bases {
            let (letter, authority) = (basis.confidence().letter(), basis.authority());
            let says = basis.says();
            let _ = writeln!(text, "{uses:>9}  {letter:<2} {authority:<10} {says}");
        }
    }
    text
}

fn object(fidelity: &Fidelity, number: Option<u32>) -> String {
    let bases: Vec<_> = fidelity
        .iter()
        .map(|(basis, uses)| {
            json!({
                "basis": basis.name(),
                "confidence": basis.confidence().letter(),
                "section": basis.section(),
                "page": basis.authority().link().map(|link| format!("docs/{link}")),
                "uses": uses,
                "says": basis.says(),
            })
        })
        .collect();
    let mut object = json!({ "fidelity": bases });
    if let Some(number) = number {
        object["arm"] = json!(number);
    }
    format!("{object}\n")
}
