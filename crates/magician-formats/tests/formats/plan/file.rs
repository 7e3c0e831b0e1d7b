//! Plan files: written, read back, and refused with a position and a reason.

use magician::build;
use magician_formats::{
    Action, Content, Format, Origin, Plan, ReadOptions, Surface, Tool, Travel, read,
};
use proptest::prelude::*;

use super::strategies::{cases, plan};

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn written_plan_reads_back(plan in plan()) {
        let text = plan.to_json();
        let back = Plan::from_json(text.as_bytes());
        prop_assert!(back.is_ok(), "{:?}\n{text}", back);
        let back = back.unwrap();
        // Compared as text, because NaN then equals itself and -0 differs from 0.
        prop_assert_eq!(format!("{back:?}"), format!("{plan:?}"), "{}", text);
        prop_assert_eq!(back.to_json(), text);
    }

    #[test]
    fn reader_survives_arbitrary_bytes(bytes in any::<Vec<u8>>()) {
        let _ = Plan::from_json(&bytes);
    }

    #[test]
    fn reader_survives_damaged_files(plan in plan(), damage in prop::collection::vec((any::<usize>(), any::<u8>()), 1..4)) {
        let mut bytes = plan.to_json().into_bytes();
        for (at, byte) in damage {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        let _ = Plan::from_json(&bytes);
    }

    #[test]
    fn reader_survives_fragments(parts in prop::collection::vec(
        prop::sample::select(vec![
            "{", "}", "[", "]", ",", ":", "\"steps\"", "\"format\"", "\"magician-plan\"", "\"version\"", "1", "\"move\"", "\"by\"",
            "\"command\"", "\"values\"", "\"PTPCmd\"", "\"at\"", "\"name\"", "\"names\"", "-1e999", "\"inf\"", "null", "\n", "\"\\ud800\"",
        ]), 0..20))
    {
        let head = r#"{"format":"magician-plan","version":1,"steps":[{"#;
        let _ = Plan::from_json(format!("{head}{}", parts.concat()).as_bytes());
        let _ = Plan::from_json(parts.concat().as_bytes());
    }
}

#[test]
fn plan_file_has_the_documented_form() {
    let mut plan = Plan::new("house \"1\"");
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface {
        height: -60.5,
        slope: [0.01, 0.0],
    });
    let outline = plan.name("outline");
    let place = Origin {
        line: 3,
        column: 5,
        length: 20,
        name: 0,
    }
    .named(outline);
    plan.push(build::line_speed(100.0, 50.0), Origin::NONE);
    plan.push(
        Action::Move {
            to: [220.0, 0.1, -40.0, 0.0],
            by: Travel::Line,
        },
        place,
    );
    plan.push(
        Action::Path {
            to: [230.0, 1e-9, 1e20],
        },
        place,
    );
    plan.push(
        Action::Burn {
            to: [230.0, 0.0, -60.0],
            power: 40.0,
        },
        Origin::NONE,
    );
    plan.push(Action::Wait(500), Origin::NONE);
    plan.push(
        Action::Arc {
            via: [1.0; 4],
            to: [2.0; 4],
        },
        Origin { name: 0, ..place },
    );
    plan.push(
        build::with_outputs(
            build::jump_to(220.0, 0.0, 20.0, 0.0),
            &[build::Output {
                percent: 50,
                address: 17,
                high: true,
            }],
        )
        .unwrap(),
        Origin::NONE,
    );
    let text = r#"{"format":"magician-plan","version":1,"title":"house \"1\"","tool":"pen","surface":{"height":-60.5,"slope":[0.01,0]},"steps":[
{"command":"PTPCoordinateParams","values":{"xyz_velocity":100,"r_velocity":50,"xyz_acceleration":50,"r_acceleration":25}},
{"move":[220,0.1,-40,0],"by":"line","at":[3,5,20],"name":"outline"},
{"path":[230,1e-9,1e20],"at":[3,5,20],"name":"outline"},
{"burn":[230,0,-60],"power":40},
{"wait":0.5},
{"arc":[2,2,2,2],"via":[1,1,1,1],"at":[3,5,20]},
{"command":"PTPPOCmd","values":{"ptp_mode":0,"x":220,"y":0,"z":20,"r":0,"po":[{"ratio":50,"address":17,"level":1}]}}
]}
"#;
    assert_eq!(plan.to_json(), text);
    assert_eq!(Plan::from_json(text.as_bytes()).unwrap(), plan);
}

#[test]
fn hand_written_plan_files_are_accepted() {
    let text = "\u{FEFF}{ \"version\": 1, \"format\": \"magician-plan\",\n \"$schema\": \"plan.schema.json\", \"steps\": [ {\"move\": [2.2e2, 0, 5, 0]},\r\n\
        {\"command\":\"set-ptp-common-params\",\"values\":{\"velocityratio\":50,\"acceleration-ratio\":\"20\"}},\n\
        {\"command\":\"IODO\",\"values\":{\"address\":3,\"level\":true}}, {\"command\":\"HOMECmd\"} ] }\n";
    let plan = Plan::from_json(text.as_bytes()).unwrap();
    let commands: Vec<_> = plan.commands().collect();
    let expected = [
        build::move_to(220.0, 0.0, 5.0, 0.0),
        build::speed(50.0, 20.0),
        build::output(3, true),
        build::home(),
    ];
    assert_eq!(commands, expected);
    let options = ReadOptions::default();
    let reading = read(Format::Plan, text.as_bytes(), &options).unwrap();
    assert_eq!(reading.content, Content::Plan(plan));
}

#[test]
fn errors_state_origin_and_expected_form() {
    let head = r#"{"format":"magician-plan","version":1,"steps":["#;
    let step = |step: &str| format!("{head}\n{{\"home\":true}},\n  {step}\n]}}");
    let cases = [
        (
            step(r#"{"path":[1,2]}"#),
            (3, 11, 5),
            "'path' takes 3 numbers, x, y, z, and these are 2",
        ),
        (
            step(r#"{"path":[1,"two",3]}"#),
            (3, 14, 5),
            "'path' takes a number, not \"two\"",
        ),
        (
            step(r#"{"path":[1,1e39,3]}"#),
            (3, 14, 4),
            "'path' takes a number, not 1e39",
        ),
        (
            step(r#"{"move":[1,2,3,4],"by":"foot"}"#),
            (3, 26, 6),
            "expected \"joints\", \"line\" or \"jump\"",
        ),
        (
            step(r#"{"shift":[1,2,3,4],"by":"jump"}"#),
            (3, 27, 6),
            "expected \"joints\" or \"line\"",
        ),
        (
            step(r#"{"wait":-1}"#),
            (3, 11, 2),
            "'wait' takes seconds, 0 to 4294967.295 in whole ms, not -1",
        ),
        (
            step(r#"{"wait":0.0005}"#),
            (3, 11, 6),
            "'wait' takes seconds, 0 to 4294967.295 in whole ms, not 0.0005",
        ),
        (
            step(r#"{"suction":1}"#),
            (3, 14, 1),
            "expected true or false",
        ),
        (
            step(r#"{"at":[1,1,1]}"#),
            (3, 3, 14),
            "this step has no action",
        ),
        (
            step(r#"{"home":true,"wait":1}"#),
            (3, 3, 22),
            "'home' and 'wait' in one step",
        ),
        (
            step(r#"{"home":true,"home":true}"#),
            (3, 23, 4),
            "'home' appears twice",
        ),
        (
            step(r#"{"home":true,"fast":true}"#),
            (3, 17, 4),
            "unknown member 'fast'",
        ),
        (
            step(r#"{"burn":[1,2,3]}"#),
            (3, 11, 7),
            "'burn' needs 'power' beside it",
        ),
        (
            step(r#"{"command":"Dance"}"#),
            (3, 14, 7),
            "unknown command \"Dance\" to set",
        ),
        (
            step(r#"{"command":"DeviceName"}"#),
            (3, 14, 12),
            "'DeviceName' cannot be queued, so it cannot be a step",
        ),
        (
            step(r#"{"command":"IODO","values":{"address":3,"level":[5,[1]]}}"#),
            (3, 54, 3),
            "expected a number, a string or a list of them",
        ),
        (
            step(r#"{"command":"IODO","values":{"address":3,"level":500}}"#),
            (3, 51, 3),
            "IODO: 'level=500': expected 0 or 1 (flag)",
        ),
        (
            step(r#"{"command":"IODO","values":{"address":3}}"#),
            (3, 30, 13),
            "IODO: 'level' is missing: 0 or 1 (flag)",
        ),
        (
            step(r#"{"command":"IODO","values":{"pin":3}}"#),
            (3, 37, 1),
            "IODO: no field 'pin'",
        ),
        (
            step(r#"{"path":[1,2,3}"#),
            (3, 17, 1),
            "this is not JSON: expected `,` or `]`",
        ),
        (
            step(r#"{"größe":[1],"#),
            (4, 1, 1),
            "this is not JSON: key must be a string",
        ),
        (
            String::from(r#"{"format":"magician-plan","version":3,"steps":[{"new":1}]}"#),
            (1, 37, 1),
            "this is a plan of version 3; only versions 1 and 2 are known here",
        ),
        (
            String::from(r#"{"format":"recipe","version":1}"#),
            (1, 11, 8),
            "this is \"recipe\", not \"magician-plan\"",
        ),
        (
            String::from(r#"{"format":"magician-plan","version":1,"tool":"spoon","steps":[]}"#),
            (1, 46, 7),
            "unknown tool \"spoon\"",
        ),
        (
            String::from(r#"{"format":"magician-plan","version":1}"#),
            (0, 0, 0),
            "there are no steps",
        ),
        (String::from("[]"), (1, 1, 2), "expected an object, {..}"),
    ];
    for (text, (line, column, length), message) in cases {
        let diagnostic = Plan::from_json(text.as_bytes()).expect_err(&text);
        assert_eq!(diagnostic.message, message, "{text}");
        let origin = diagnostic.origin;
        assert_eq!(
            (origin.line, origin.column, origin.length),
            (line, column, length),
            "{diagnostic}"
        );
    }
    let diagnostic = Plan::from_json(b"{\"format\":\n\"magic\xFFian\"").unwrap_err();
    assert_eq!(
        diagnostic.to_string(),
        "line 2, column 7: this is not UTF-8 text"
    );
}

#[test]
fn deep_nesting_is_refused() {
    let deep = "[".repeat(200_000);
    for text in [
        deep.clone(),
        format!(r#"{{"format":"magician-plan","version":1,"steps":{deep}"#),
        format!(
            r#"{{"format":"magician-plan","version":1,"steps":[{{"move":{deep}{}}}]}}"#,
            "]".repeat(200_000)
        ),
        format!(
            r#"{{"format":"magician-plan","version":1,"steps":[{{"command":"IODO","values":{{"level":{deep}{}}}}}]}}"#,
            "]".repeat(200_000)
        ),
    ] {
        assert!(Plan::from_json(text.as_bytes()).is_err());
    }
}
