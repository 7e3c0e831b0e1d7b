//! Accepted programs stay within limits, others are refused before the first byte is sent, and no
//! input makes a reader panic. The targets in `fuzz` test the readers for longer.

use std::cell::Cell;
use std::path::Path;

use magician::sim::Event;
use magician::{ErrorKind, Options, Set, VirtualArm, blocking::Arm};
use magician_program::rehearse::{RehearseOptions, rehearse, stage, start_of};
use magician_program::{
    Content, Diagnostic, Format, Lines, Plan, ReadOptions, Setup, Surface, check, read,
};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(0x0D2A3),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Outcome of a text that is read, checked and run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FileOutcome {
    /// Refused by the reader, or because it cannot be placed.
    Unread,
    /// Refused by the check.
    Refused,
    /// Run to its end without an alarm.
    Done,
}

fn placed_plan(format: Format, text: &str, fit: bool) -> Result<Plan, Diagnostic> {
    let content = read(format, text.as_bytes(), &ReadOptions::default())?.content;
    let mut setup = Setup::default();
    setup.assumed_surface = Some(Surface::level(-60.0));
    setup.placement.fit = fit;
    Ok(setup.plan(format, content)?.fitting()?.plan)
}

/// Reads, checks and runs a text. Asserts that an accepted text runs without an alarm, and that
/// nothing of a refused text is sent.
fn run_text(format: Format, text: &str, fit: bool) -> Result<FileOutcome, TestCaseError> {
    let plan = match placed_plan(format, text, fit) {
        Ok(plan) => plan,
        Err(diagnostic) => {
            prop_assert!(!diagnostic.message.is_empty());
            return Ok(FileOutcome::Unread);
        }
    };
    let options = RehearseOptions::default();
    let Ok(arm) = stage(&plan, &options) else {
        return Ok(FileOutcome::Refused);
    };
    let report = check(&plan, &start_of(&arm));
    if report.is_good() {
        let done = rehearse(&plan, &options).expect("commands fit into frames");
        prop_assert!(done.is_good(), "{:?} {:?}", done.alarms, done.log);
        prop_assert_eq!(Some(done.time), report.time);
        return Ok(FileOutcome::Done);
    }
    let cell = VirtualArm::from(arm);
    let arm = Arm::simulated(cell.clone(), Options::default()).expect("it answers");
    let before = cell.state();
    cell.with(|arm| while arm.poll_event().is_some() {});
    let commands: Vec<Set> = plan.commands().collect();
    let error = arm.run(&commands).expect_err("the check failed");
    prop_assert!(
        matches!(
            error.kind(),
            ErrorKind::Unreachable | ErrorKind::InvalidInput
        ),
        "{}",
        error
    );
    let events = cell.with(|arm| std::iter::from_fn(|| arm.poll_event()).collect::<Vec<_>>());
    let taken = |event: &&Event| matches!(event, Event::Accepted { .. } | Event::Started { .. });
    prop_assert!(!events.iter().any(|event| taken(&event)), "{:?}", events);
    let after = cell.state();
    prop_assert_eq!(
        (after.pose, after.queue.current_index),
        (before.pose, before.queue.current_index)
    );
    Ok(FileOutcome::Refused)
}

/// Runs a property and prints how many texts had which result.
fn count_outcomes<S: Strategy>(
    cases: u32,
    strategy: S,
    run: impl Fn(S::Value) -> Result<FileOutcome, TestCaseError>,
) -> [u32; 3] {
    let counts: [Cell<u32>; 3] = Default::default();
    let mut runner = proptest::test_runner::TestRunner::new(config(cases));
    let outcome = runner.run(&strategy, |value| {
        let count = &counts[run(value)? as usize];
        count.set(count.get() + 1);
        Ok(())
    });
    if let Err(error) = outcome {
        panic!("{error}");
    }
    let counts = counts.map(|count| count.get());
    println!(
        "not read {}, refused {}, done {}",
        counts[0], counts[1], counts[2]
    );
    counts
}

fn one_of(words: &'static [&'static str]) -> impl Strategy<Value = String> + Clone {
    proptest::sample::select(words).prop_map(str::to_owned)
}

/// Numbers as people and programs write them, and rarely an odd one, such as NaN or an overflow.
fn number(range: std::ops::Range<f64>) -> impl Strategy<Value = String> + Clone {
    let in_range = range.prop_map(|value| format!("{value:.3}"));
    let odd = one_of(&[
        "0",
        "-0",
        "1e3",
        "99999",
        "1e30",
        "-1e300",
        "1e400",
        "nan",
        "inf",
        "-",
        ".",
        "",
        "--1",
        "1.2.3",
        "1e",
        "+7",
        "0x10",
        "184467440737095516160",
        "0.0000000000001",
    ]);
    prop_oneof![400 => in_range, 1 => odd]
}

fn word(
    letter: &'static str,
    range: std::ops::Range<f64>,
) -> impl Strategy<Value = String> + Clone {
    number(range).prop_map(move |number| format!("{letter}{number}"))
}

/// Line of G-code, mostly within reach.
fn g_line() -> impl Strategy<Value = String> + Clone {
    let place = (
        proptest::option::of(word("X", 180.0..290.0)),
        proptest::option::of(word("Y", -90.0..90.0)),
        proptest::option::weighted(0.3, word("Z", -20.0..40.0)),
        proptest::option::weighted(0.2, word("F", 10.0..6000.0)),
    );
    let place =
        place.prop_map(|(x, y, z, f)| [x, y, z, f].map(Option::unwrap_or_default).join(" "));
    // A radius large enough to reach most positions.
    let round = prop_oneof![
        1 => (word("I", -20.0..20.0), word("J", -20.0..20.0)).prop_map(|(i, j)| format!("{i} {j}")),
        8 => word("R", 110.0..400.0),
    ];
    prop_oneof![
        12 => (one_of(&["G0", "G1", "G01", "g1"]), place.clone()).prop_map(|(g, at)| format!("{g} {at}")),
        1 => (one_of(&["G2", "G3"]), place, round).prop_map(|(g, at, round)| format!("{g} {at} {round}")),
        1 => (word("P", 0.0..900.0)).prop_map(|p| format!("G4 {p}")),
        1 => (word("S", 0.0..255.0)).prop_map(|s| format!("M3 {s}")),
        1 => one_of(&["G21", "G90", "M5", "M2", "(a comment)", "; another", "%", "N10"]),
    ]
}

fn g_code() -> impl Strategy<Value = String> {
    // Some programs have one line that leads far away, such as a change of units or to relative
    // coordinates.
    let far_line = proptest::option::weighted(
        0.3,
        one_of(&[
            "G1 X400 Y0",
            "G1 Z-300",
            "G0 X0 Y0",
            "G20",
            "G91",
            "G92 X0 Y0",
            "G92 X1e9",
            "G28",
            "T1",
            "G64",
            "M3 S1e9",
        ]),
    );
    (far_line, vec(g_line(), 1..30)).prop_map(|(far_line, lines)| {
        format!(
            "G21 G90\nG0 X220 Y0 Z10\n{}\n{}\n",
            far_line.unwrap_or_default(),
            lines.join("\n")
        )
    })
}

#[test]
fn g_code_stays_within_limits_or_is_refused() {
    let [_, refused, done] =
        count_outcomes(400, g_code(), |text| run_text(Format::Gcode, &text, false));
    assert!(refused >= 30 && done >= 100, "{refused} {done}");
}

/// Number in a drawing, sometimes huge or NaN.
fn length() -> impl Strategy<Value = String> + Clone {
    number(-20.0..120.0)
}

fn path_data() -> impl Strategy<Value = String> + Clone {
    let step = prop_oneof![
        (one_of(&["L", "l", "M", "m"]), length(), length())
            .prop_map(|(c, x, y)| format!("{c}{x} {y}")),
        (one_of(&["C", "c"]), vec(length(), 6)).prop_map(|(c, n)| format!("{c}{}", n.join(" "))),
        (one_of(&["Q", "t", "S"]), vec(length(), 4))
            .prop_map(|(c, n)| format!("{c}{}", n.join(" "))),
        (length(), length(), length(), length())
            .prop_map(|(rx, ry, x, y)| format!("A{rx} {ry} 30 1 0 {x} {y}")),
        one_of(&["Z", "h5", "v-9", "H1e9", "T", "zz"]),
    ];
    vec(step, 1..12).prop_map(|steps| format!("M10 10 {}", steps.join(" ")))
}

fn shape() -> impl Strategy<Value = String> + Clone {
    let four = || (length(), length(), length(), length());
    let plain = prop_oneof![
        four().prop_map(|(a, b, c, d)| format!(
            "<line x1=\"{a}\" y1=\"{b}\" x2=\"{c}\" y2=\"{d}\"/>"
        )),
        four().prop_map(|(a, b, c, d)| format!(
            "<rect x=\"{a}\" y=\"{b}\" width=\"{c}\" height=\"{d}\"/>"
        )),
        four().prop_map(|(a, b, c, d)| format!(
            "<ellipse cx=\"{a}\" cy=\"{b}\" rx=\"{c}\" ry=\"{d}\"/>"
        )),
        path_data().prop_map(|data| format!("<path d=\"{data}\"/>")),
        vec(length(), 2..12)
            .prop_map(|points| format!("<polyline points=\"{}\"/>", points.join(" "))),
        one_of(&[
            "<text x=\"9\" y=\"20\">Ag</text>",
            "<use href=\"#none\"/>",
            "<image href=\"x\"/>",
            "<g/>"
        ]),
    ];
    let transformed = (
        one_of(&["rotate", "translate", "scale", "skewX", "matrix"]),
        number(-1.0..3.0),
        plain.clone(),
    );
    prop_oneof![
        6 => plain,
        1 => transformed.prop_map(|(how, by, shape)| format!("<g transform=\"{how}({by})\">{shape}</g>")),
    ]
}

fn svg() -> impl Strategy<Value = (String, bool)> {
    let size = prop_oneof![
        8 => Just("width=\"100mm\" height=\"80mm\" viewBox=\"0 0 100 80\"".to_owned()),
        1 => one_of(&[
            "", "width=\"1e9mm\" height=\"5\"", "viewBox=\"0 0 1e-9 1e-9\"", "width=\"0\" height=\"0\"",
            "width=\"100%\" viewBox=\"-1e20 0 2e20 10\"", "width=\"nan\" height=\"-4\"",
        ]),
    ];
    (size, vec(shape(), 0..8), any::<bool>()).prop_map(|(size, shapes, fit)| {
        let shapes = shapes.concat();
        let style = "fill=\"none\" stroke=\"black\"";
        (
            format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" {size}><g {style}>{shapes}</g></svg>"
            ),
            fit,
        )
    })
}

#[test]
fn svg_stays_within_limits_or_is_refused() {
    let [unread, refused, done] =
        count_outcomes(45, svg(), |(text, fit)| run_text(Format::Svg, &text, fit));
    assert!(unread >= 5 && done >= 20, "{unread} {refused} {done}");
    // Everything that can be placed can be drawn.
    assert_eq!(refused, 0);
}

#[test]
fn large_files_run_or_are_refused() {
    let lines = (0..3000).map(|nth| {
        let (column, row) = (nth % 60, nth / 60);
        let (x, y) = (f64::from(column) * 1.2, f64::from(row) * 1.2);
        format!("<path d=\"M{x} {y}l1 0l0 1\"/>")
    });
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"80mm\" height=\"70mm\" viewBox=\"0 0 80 70\">\
         <g fill=\"none\" stroke=\"black\">{}</g></svg>",
        lines.collect::<String>()
    );
    assert_eq!(
        run_text(Format::Svg, &svg, false).unwrap(),
        FileOutcome::Done
    );
    let rows = (0..5000).map(|nth| {
        let y = f64::from(nth % 50) * 0.5;
        format!("G1 X{} Y{y}\n", if nth % 2 == 0 { 220 } else { 250 })
    });
    let program = format!(
        "G21 G90\nG0 X220 Y0 Z5\nG1 Z0 F3000\n{}",
        rows.collect::<String>()
    );
    assert_eq!(
        run_text(Format::Gcode, &program, false).unwrap(),
        FileOutcome::Done
    );
    let far = format!("{program}G1 X900\n");
    assert_eq!(
        run_text(Format::Gcode, &far, false).unwrap(),
        FileOutcome::Refused
    );
}

/// Asserts that every reader reads or refuses the bytes, and that the reported position lies within
/// the text.
fn check_all_readers(bytes: &[u8]) -> Result<(), TestCaseError> {
    let text = std::str::from_utf8(bytes).ok();
    let formats = Format::ALL.into_iter().chain(Format::of("unknown", bytes));
    for format in formats {
        match read(format, bytes, &ReadOptions::default()) {
            Ok(reading) => {
                if let Content::Plan(plan) = &reading.content {
                    let start =
                        start_of(&stage(&Plan::default(), &RehearseOptions::default()).unwrap());
                    let _ = check(plan, &start);
                }
                for note in &reading.notes {
                    prop_assert!(!note.message.is_empty());
                }
            }
            Err(diagnostic) => {
                prop_assert!(!diagnostic.message.is_empty(), "{}", format);
                let known = diagnostic.origin.is_known();
                if let Some(text) = text.filter(|_| known && format != Format::Image) {
                    let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
                    prop_assert!(
                        Lines::new(text).range(&diagnostic.origin).is_some(),
                        "{}: {}",
                        format,
                        diagnostic
                    );
                }
            }
        }
    }
    Ok(())
}

/// The samples, and a plan file.
fn sample_files() -> Vec<Vec<u8>> {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let mut names: Vec<_> = (std::fs::read_dir(samples).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end != "md"))
        .collect();
    names.sort();
    let mut files: Vec<Vec<u8>> = names
        .iter()
        .map(|path| std::fs::read(path).unwrap())
        .collect();
    let drawing = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9mm\" height=\"9mm\"><path d=\"M0 0h9v9\" \
                   stroke=\"#000\" fill=\"none\"/></svg>";
    files.push(
        placed_plan(Format::Svg, drawing, false)
            .unwrap()
            .to_json()
            .into_bytes(),
    );
    files
}

/// Change to a file: replaces `removed` bytes at `at` by `inserted`.
#[derive(Clone, Debug)]
struct Change {
    at: prop::sample::Index,
    removed: usize,
    inserted: Vec<u8>,
}

fn change() -> impl Strategy<Value = Change> {
    let inserted = prop_oneof![
        vec(any::<u8>(), 0..4),
        one_of(&[
            "nan",
            "1e999",
            "-",
            "\"",
            "<",
            ">",
            "{",
            "]",
            "\n",
            "0",
            "\u{FEFF}",
            "\u{FFFD}",
            "999999999999999999999"
        ])
        .prop_map(String::into_bytes),
    ];
    (any::<prop::sample::Index>(), 0_usize..12, inserted).prop_map(|(at, removed, inserted)| {
        Change {
            at,
            removed,
            inserted,
        }
    })
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn no_bytes_make_a_reader_panic(bytes in vec(any::<u8>(), 0..200)) {
        check_all_readers(&bytes)?;
    }

    #[test]
    fn no_text_makes_a_reader_panic(text in "[ -~\\n]{0,120}") {
        check_all_readers(text.as_bytes())?;
    }
}

proptest! {
    #![proptest_config(config(120))]

    #[test]
    fn no_spoilt_file_makes_a_reader_panic(
        which in any::<prop::sample::Index>(),
        changes in vec(change(), 1..6),
        cut in proptest::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        thread_local! {
            static FILES: Vec<Vec<u8>> = sample_files();
        }
        let mut bytes = FILES.with(|files| files[which.index(files.len())].clone());
        for Change { at, removed, inserted } in changes {
            let at = at.index(bytes.len().max(1)).min(bytes.len());
            let end = (at + removed).min(bytes.len());
            bytes.splice(at..end, inserted);
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len().max(1)));
        }
        check_all_readers(&bytes)?;
    }
}
