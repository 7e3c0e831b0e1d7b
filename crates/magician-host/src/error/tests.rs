use std::collections::BTreeSet;

use super::*;
use crate::ToolBias;
use crate::build;
use crate::preflight::Preflight;
use crate::remedy::Action;

#[test]
fn an_alarm_names_cause_and_cure_and_what_clears_it() {
    let error = Error::alarm([0x00, 0x12].into_iter().collect(), false);
    let message = error.to_string();
    assert!(message.contains("0x12 PlanInvLimit"), "{message}");
    assert!(
        !message.contains("0x00"),
        "0x00 does not hold the queue: {message}"
    );
    assert_eq!(
        error.remedies(),
        [Remedy::new(Action::ClearAlarms, "releases the queue")]
    );
    assert!(error.alarms().is_some_and(|alarms| alarms.contains(0x12)));
}

#[test]
fn a_terminal_obeys_nothing_that_a_message_quotes() {
    let error = Error::invalid("no arm `\x1b[2J\u{202e}`").with_command("Get\x07");
    let message = r"Get\u{7}: no arm `\u{1b}[2J\u{202e}`";
    assert_eq!(error.to_string(), message);
    assert_eq!(format!("{error:?}"), format!("{message} (invalid-value)"));
}

#[test]
fn a_limit_has_both_values() {
    let limits = magician_motion::ArmModel::MAGICIAN.limits;
    let joints = magician_motion::JointAngles::new(0.0, 91.3, 45.0, 0.0);
    let error = Error::from(limits.check(&joints).unwrap_err());
    assert_eq!(error.kind(), ErrorKind::Unreachable);
    assert_eq!((error.value(), error.limit()), (Some(91.3), Some(90.0)));
    assert_eq!(error.unit(), Some("deg"));
    assert!(error.to_string().contains("91.3") && error.to_string().contains("90.0"));
}

#[test]
fn the_sentence_stands_apart_from_the_command_and_its_place() {
    let error = Error::invalid("x is NaN")
        .with_command("SetPTPCmd")
        .at_step(2);
    assert_eq!(error.message(), "x is NaN");
    assert_eq!(error.to_string(), "SetPTPCmd: x is NaN");
    let whole = "command 3: SetPTPCmd: x is NaN (invalid-value)";
    assert_eq!(format!("{error:?}"), whole);
    let start = Preflight::at(magician_motion::JointAngles::HOME, ToolBias::NONE);
    let program = [
        build::line_by(0.0, 1.0, 0.0, 0.0),
        build::line_to(f32::NAN, 0.0, 0.0, 0.0),
    ];
    let error = start.clone().program(&program).unwrap_err();
    assert_eq!(
        (error.step(), error.command()),
        (Some(1), Some("SetPTPCmd"))
    );
}

#[test]
fn codes_have_names_of_their_own() {
    let names: BTreeSet<_> = ErrorCode::ALL.iter().map(|code| code.name()).collect();
    assert_eq!(names.len(), ErrorCode::ALL.len());
    for name in names {
        let plain = |letter: char| letter.is_ascii_lowercase() || letter == '-';
        assert!(name.chars().all(plain), "{name}");
    }
}
