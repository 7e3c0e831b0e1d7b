//! A table of the Magician's alarms on the virtual arm, held to be true before it is written.

mod table;
mod trial;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use magician_protocol::Alarm;

use table::{Arises, Claim, Goes, claims};

const INTRODUCTION: &str = "\
# The Magician's alarms on the virtual arm

How each arises here, whether what is queued behind it waits, and how it goes. `cargo xtask alarms` writes this page,
after it has done to a virtual arm what stands in each row and found it true; a test does the same.

Of every alarm, however it arose:

* It can be injected: by a scenario, or by `Controller::inject(ExternalEvent::Alarm(code))`. An injected one has no cause
  that lasts, so the first ClearAllAlarmsState (id 20 or 21) drops it.
* A motion under way goes on to its end.
* Where the queue waits, it waits for ClearAllAlarmsState, even if the alarm has dropped by itself before. Homing runs
  all the same when it is next, and clears nothing. Immediate commands are carried out.
* None goes by waiting. A reset drops all and raises 0x00.
";

const SIBLINGS: &str = "
The other alarms that have a name belong to the arm's siblings and are raised by injection only; they behave as
those above:
";

/// Writes `docs/ALARMS.md`.
pub(crate) fn write(docs: &Path) -> Result<(), Box<dyn Error>> {
    if let [first, ..] = &untrue()[..] {
        return Err(first.as_str().into());
    }
    fs::write(docs.join("ALARMS.md"), page())?;
    Ok(())
}

/// The page.
fn page() -> String {
    let mut page = INTRODUCTION.to_owned();
    page += "\n| alarm | how it arises here | queue | how it goes |\n|---|---|---|---|\n";
    let claims = claims();
    for claim in &claims {
        row(&mut page, claim);
    }
    page += SIBLINGS;
    let others: Vec<String> = (others(&claims).iter())
        .map(|alarm| format!("`{:#04x}` {}", alarm.code, alarm.name))
        .collect();
    let _ = writeln!(page, "{}.", others.join(", "));
    page
}

/// The alarms that nothing is claimed of but that they can be injected.
fn others(claims: &[Claim]) -> Vec<&'static Alarm> {
    let listed = |code| claims.iter().any(|claim| claim.code == code);
    let others = Alarm::TABLE.iter().filter(|alarm| !listed(alarm.code));
    others.collect()
}

/// Tries everything that the page says; what is not so.
fn untrue() -> Vec<String> {
    let claims = claims();
    let claimed = claims
        .iter()
        .map(|claim| (claim.code, trial::try_claim(claim)));
    let others = others(&claims);
    let injected = (others.iter()).map(|alarm| (alarm.code, trial::try_injected(alarm.code, true)));
    (claimed.chain(injected))
        .filter_map(|(code, verdict)| Some(format!("alarm {code:#04x}: {}", verdict.err()?)))
        .collect()
}

fn row(page: &mut String, claim: &Claim) {
    let name = Alarm::with_code(claim.code).map_or("", |alarm| alarm.name);
    let arises = match &claim.arises {
        Arises::When { says, .. } => says.clone(),
        Arises::Injected(why) => format!("by injection only: {why}"),
        Arises::Never { says, .. } => format!("cannot arise: {says}"),
    };
    let queue = if claim.holds { "waits" } else { "goes on" };
    let goes = match &claim.goes {
        Goes::Cleared => "ClearAllAlarmsState".to_owned(),
        Goes::UntilHomed { .. } => {
            "ClearAllAlarmsState; the next LostStepCmd raises it again until the arm has been homed"
                .to_owned()
        }
        Goes::Inside { says, .. } => format!(
            "by itself once the joint is back inside ({says}), and not before; then ClearAllAlarmsState frees the queue"
        ),
    };
    let code = claim.code;
    let _ = writeln!(
        page,
        "| `{code:#04x}` {name} | {arises} | {queue} | {goes} |"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_claim_is_true() {
        assert_eq!(untrue(), [""; 0]);
    }

    /// Those of the siblings that something raises here are listed too.
    #[test]
    fn every_alarm_of_the_magician_is_listed_once_and_in_order() {
        let claimed: Vec<u8> = claims().iter().map(|claim| claim.code).collect();
        let listed: Vec<u8> = (Alarm::TABLE.iter())
            .filter(|alarm| alarm.magician || alarm.code == Alarm::PlanSpeedInputParam)
            .map(|alarm| alarm.code)
            .collect();
        assert_eq!(claimed, listed);
    }

    /// What drops by itself in the protocol's own list of alarms does so here if it arises here.
    #[test]
    fn the_list_of_alarms_agrees() {
        for claim in claims() {
            let alarm = Alarm::with_code(claim.code).expect("listed");
            assert_eq!(claim.holds, Alarm::blocks(claim.code), "{}", alarm.name);
            let drops = matches!(claim.goes, Goes::Inside { .. });
            let arises = matches!(claim.arises, Arises::When { .. });
            assert_eq!(drops, alarm.clears_itself && arises, "{}", alarm.name);
        }
    }

    #[test]
    fn the_page_is_current() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/ALARMS.md");
        let written = fs::read_to_string(path).expect("docs/ALARMS.md");
        assert!(written == page(), "cargo xtask alarms writes it anew");
    }
}
