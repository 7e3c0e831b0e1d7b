//! Page of the Magician's alarms on the virtual arm, generated from the conformance cases that show
//! them.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use magician_conform::{AlarmCase, Case, Suite};
use magician_protocol::Alarm;

const INTRODUCTION: &str = "\
# The Magician's alarms on the virtual arm

How each alarm arises on the virtual arm, whether the queue waits, and how the alarm is cleared. A
row is a case of the conformance suite; `magician conform --only alarm --list -v` shows its steps.
`cargo xtask alarms` writes this page.

For every alarm (`alarm.injected-*`):

* A scenario or `Controller::inject(ExternalEvent::Alarm(code))` can inject it. Without a lasting
  cause, the first ClearAllAlarmsState (id 20 or 21) clears it.
* The running motion continues to its end.
* A waiting queue waits for ClearAllAlarmsState, even if the alarm has already cleared by itself.
  Homing still runs when it is next, and clears no alarm. Immediate commands are carried out.
* No alarm clears by waiting. A reset clears all alarms and raises 0x00.

| alarm | how it arises | queue | how it is cleared | case |
|---|---|---|---|---|
";

const SIBLINGS: &str = "
The other named alarms belong to the arm's siblings and are raised by injection only; they behave like
those above:
";

/// Writes `docs/reference/ALARMS.md`.
pub(crate) fn write(docs: &Path) -> Result<(), Box<dyn Error>> {
    fs::write(docs.join("reference/ALARMS.md"), page(&Suite::built_in()?))?;
    Ok(())
}

/// Returns the cases that show an alarm, sorted by code.
fn rows(suite: &Suite) -> Vec<(&AlarmCase, &Case)> {
    let cases = suite.cases().iter();
    let mut rows: Vec<_> = cases
        .filter_map(|case| Some((case.alarm.as_ref()?, case)))
        .collect();
    rows.sort_by_key(|(alarm, _)| alarm.code);
    rows
}

fn page(suite: &Suite) -> String {
    let mut page = INTRODUCTION.to_owned();
    let rows = rows(suite);
    for (AlarmCase { code, arises, goes }, case) in &rows {
        let name = Alarm::with_code(*code).map_or("", |alarm| alarm.name);
        let queue = if Alarm::blocks(*code) {
            "waits"
        } else {
            "continues"
        };
        let _ = writeln!(
            page,
            "| `{code:#04x}` {name} | {arises} | {queue} | {goes} | `{}` |",
            case.id
        );
    }
    page += SIBLINGS;
    let listed = |alarm: &&Alarm| !rows.iter().any(|(row, _)| row.code == alarm.code);
    let others: Vec<String> = (Alarm::TABLE.iter().filter(listed))
        .map(|alarm| format!("`{:#04x}` {}", alarm.code, alarm.name))
        .collect();
    let _ = writeln!(page, "{}.", others.join(", "));
    page
}

#[cfg(test)]
mod tests {
    use magician_sim::fidelity::Assumption;

    use super::*;

    fn suite() -> Suite {
        Suite::built_in().expect("its own cases")
    }

    /// Alarms of sibling products are listed too if something raises them here.
    #[test]
    fn every_alarm_of_the_magician_has_one_row() {
        let suite = suite();
        let shown: Vec<u8> = rows(&suite).iter().map(|(alarm, _)| alarm.code).collect();
        let wanted: Vec<u8> = (Alarm::TABLE.iter())
            .filter(|alarm| alarm.magician || alarm.code == Alarm::PlanSpeedInputParam)
            .map(|alarm| alarm.code)
            .collect();
        assert_eq!(shown, wanted);
    }

    /// General statements about alarms are tested with every alarm that has a name, or with its
    /// row.
    #[test]
    fn every_alarm_with_a_name_is_injected_in_a_case() {
        let suite = suite();
        for alarm in Alarm::TABLE {
            let id = format!("alarm.injected-{:#04x}", alarm.code);
            let found = suite.cases().iter().any(|case| case.id == id);
            assert!(found || alarm.code < 2, "{id}");
        }
    }

    /// Alarms that clear by themselves in the protocol's list do so here if they can arise here.
    #[test]
    fn the_list_of_alarms_agrees() {
        for (row, case) in rows(&suite()) {
            let alarm = Alarm::with_code(row.code).expect("listed");
            let drops = case.assumes.contains(&Assumption::LimitDrops);
            let arises = case.id.starts_with("alarm.raised-");
            assert_eq!(drops, alarm.clears_itself && arises, "{}", alarm.name);
        }
    }

    #[test]
    fn the_page_is_current() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference/ALARMS.md");
        let written = fs::read_to_string(path).expect("docs/reference/ALARMS.md");
        assert!(
            written == page(&suite()),
            "cargo xtask alarms writes it anew"
        );
    }
}
