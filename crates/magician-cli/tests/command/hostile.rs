//! Text from outside is displayed and never obeyed by the terminal.

use std::path::Path;

use crate::magician::{Run, run, run_with};
use magician_protocol::is_deceptive;

/// Sets the window's title, clears the screen, hides text, and reverses the writing direction.
const NAME: &str = "a\x1b]0;mine\x07b\u{9b}2Jc\x1b[8m\u{202e}d";
const VISIBLE: &str = r"a\u{1b}]0;mine\u{7}b\u{9b}2Jc\u{1b}[8m\u{202e}d";

/// Asserts that the output consists only of lines of text.
fn is_harmless(run: &Run) {
    for text in [&run.out, &run.err] {
        let harmful = text
            .chars()
            .find(|sign| is_deceptive(*sign) && *sign != '\n');
        assert_eq!(harmful, None, "{text:?}");
    }
}

fn in_a_shell(options: &[&str]) -> Run {
    let lines = format!("set DeviceName 'device_name={NAME}'\ninfo\nget DeviceName\n");
    let arguments = [&["--port", "sim"], options, &["shell"]].concat();
    run_with(&arguments, lines.as_bytes())
}

#[test]
fn the_name_of_an_arm_is_shown_with_its_control_characters_escaped() {
    let said = in_a_shell(&[]);
    assert_eq!(said.status, 0, "{said:?}");
    is_harmless(&said);
    assert_eq!(said.out.matches(VISIBLE).count(), 2, "{said:?}");
}

#[test]
fn in_json_the_name_of_an_arm_is_the_name_itself() {
    let said = in_a_shell(&["--json"]);
    is_harmless(&said);
    let objects = said.objects();
    assert_eq!(objects[1]["device_name"], NAME);
    assert_eq!(objects[2]["device_name"], NAME);
}

#[test]
fn a_frame_is_decoded_without_obeying_its_text() {
    let mut frame = vec![0xAA, 0xAA, 2 + NAME.len() as u8 + 1, 0x01, 0x01];
    frame.extend(NAME.bytes().chain([0]));
    let sum = frame[3..]
        .iter()
        .fold(0u8, |sum, byte| sum.wrapping_add(*byte));
    frame.push(sum.wrapping_neg());
    let hex: String = frame.iter().map(|byte| format!("{byte:02X}")).collect();
    let said = run(&["decode", "--from", "host", &hex]);
    assert_eq!(said.status, 0, "{said:?}");
    is_harmless(&said);
    assert!(said.out.contains(VISIBLE), "{said:?}");
    let object = run(&["decode", "--json", "--from", "host", &hex]);
    is_harmless(&object);
    assert_eq!(object.object()["params"]["device_name"], NAME);
}

#[test]
fn no_file_writes_to_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let title = serde_json::to_string(NAME).unwrap();
    let files = [
        at(
            "title.plan.json",
            &format!(
                r#"{{"format":"magician-plan","version":1,"title":{title},"steps":[{{{title}:1}}]}}"#
            ),
        ),
        at(
            "word.gcode",
            &format!("G21 ({NAME})\nG1 X{NAME} F100\nM999 {NAME}\n"),
        ),
        at(
            "layer.dxf",
            &format!(
                "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n{NAME}\n10\n0\n20\n0\n11\nnot {NAME}\n21\n9\n0\nENDSEC\n0\nEOF\n"
            ),
        ),
        at("name.hpgl", &format!("IN;PU0,0;XX{NAME};PD9;\n")),
        at("settings.toml", &format!("[{title}]\nport = 1\n")),
    ];
    for file in &files {
        let shown = |options: &[&str]| {
            let file = file.to_str().unwrap();
            let said = run(&[&["--port", "sim", "run", file, "--check"], options].concat());
            is_harmless(&said);
        };
        shown(&[]);
        shown(&["--json"]);
    }
    let missing = run(&["--port", NAME, "pose"]);
    is_harmless(&missing);
    is_harmless(&run(&["run", "--port", "sim", NAME]));
    preview(
        &at("drawn.gcode", "G21\nG1 X200 Y0 Z0 F1000\nG1 X210\n"),
        folder.path(),
    );
}

/// A title in a picture is displayed in the same way.
fn preview(file: &Path, folder: &Path) {
    let (plan, svg) = (folder.join("drawn.plan.json"), folder.join("drawn.svg"));
    let (file, plan_path) = (file.to_str().unwrap(), plan.to_str().unwrap());
    let converted = run(&["--port", "sim", "convert", file, plan_path]);
    assert_eq!(converted.status, 0, "{converted:?}");
    let text = std::fs::read_to_string(&plan).unwrap();
    let mut object: serde_json::Value = serde_json::from_str(&text).unwrap();
    object["title"] = NAME.into();
    std::fs::write(&plan, object.to_string()).unwrap();
    let said = run(&[
        "--port",
        "sim",
        "run",
        plan_path,
        "--preview",
        svg.to_str().unwrap(),
    ]);
    assert_eq!(said.status, 0, "{said:?}");
    is_harmless(&said);
    let svg = std::fs::read_to_string(svg).unwrap();
    assert!(
        !svg.contains(|sign| is_deceptive(sign) && sign != '\n'),
        "{svg}"
    );
    assert!(svg.contains(r"a\u{1b}]0;mine"), "{svg}");
}
