//! Refused programs, and the limits that accepted ones keep.

use magician::blocking::Arm;
use magician::preflight::Preflight;
use magician::{ErrorKind, JointAngles, Options, ToolBias, VirtualArm};
use magician_program::{Format, Lines, ReadOptions, check, read};
use magician_protocol::Set;
use proptest::prelude::*;

use super::{diagnostic, try_read, try_with};

#[test]
fn errors_have_origin_and_reason() {
    for (text, message) in [
        ("G1 X", "line 1, column 4: X has no number"),
        ("G1 Xnan", "line 1, column 4: X has no number"),
        ("\nG1 X1 Yinf", "line 2, column 7: Y has no number"),
        (
            "G1 X1e999",
            "line 1, column 4: 1e999 may be one number or a number and a word E",
        ),
        (
            "G91\nM72",
            "line 2, column 1: M72 restores earlier settings, which is not supported",
        ),
        ("G0 X1 X2", "line 1, column 7: X appears twice on one line"),
        ("G0 G1 X2", "line 1, column 4: two motions on one line"),
        (
            "G80\nX2",
            "line 2, column 1: the line has coordinates but no motion: G80 has ended the last one",
        ),
        ("G1 @5", "line 1, column 4: '@' is not valid in G-code"),
        ("G1.55 X2", "line 1, column 1: unknown code G1.55"),
        ("G-1", "line 1, column 1: unknown code G-1"),
        (
            "G1 X250 F0",
            "line 1, column 9: the speed is F0, it must be above 0",
        ),
        (
            "G1 X9000000 Y0",
            "line 1, column 4: X would be at 9000000 mm",
        ),
        (
            "G4 P-1",
            "line 1, column 1: the pause is -1 ms, which is out of range",
        ),
        (
            "G4 S9000000",
            "line 1, column 1: the pause is 9000000000 ms, which is out of range",
        ),
        (
            "G93 G1 X2 F1",
            "line 1, column 1: G93 is not supported: F must be a speed in mm or inches a minute (G94)",
        ),
        (
            "G5.2 X1 Y1 P1 L3",
            "line 1, column 1: G5.2 may move the arm, which is not supported",
        ),
        (
            "G84 X1 Y1 Z1 R1",
            "line 1, column 1: G84 may move the arm, which is not supported",
        ),
        (
            "G33 Z1 K1",
            "line 1, column 1: G33 may move the arm, which is not supported",
        ),
        (
            "G999 X5",
            "line 1, column 1: G999 may move the arm, which is not supported",
        ),
        (
            "G10 L3 P1 X5",
            "line 1, column 1: G10 changes the coordinate system, which is not supported",
        ),
        (
            "G10 L2 P10 X5",
            "line 1, column 8: unknown coordinate system P10; P is 0 to 9",
        ),
        (
            "G10 L20 P1.5 X5",
            "line 1, column 9: unknown coordinate system P1.5; P is 0 to 9",
        ),
        (
            "G10 L2 P1 X5 R45",
            "line 1, column 14: rotated coordinate systems (R45) are not supported",
        ),
        (
            "G68 X0 Y0 R45",
            "line 1, column 1: G68 changes the coordinate system, which is not supported",
        ),
        (
            "G91\nG1 X2",
            "line 2, column 4: X is relative to the arm's position, which is unknown",
        ),
        (
            "G0 X220",
            "line 1, column 1: the program moves, but never gives X and Y",
        ),
    ] {
        assert_eq!(diagnostic(text), message, "{text}");
    }
    let forty = format!("G1 X{}", "9".repeat(40));
    assert_eq!(
        diagnostic(&forty),
        "line 1, column 4: X is 1e40, which is too large"
    );
}

#[test]
fn origin_of_an_error_is_the_faulty_word() {
    let text = "G21\n(größer) G1 X220 Y1e999 Z1";
    let diagnostic = try_read(text).expect_err("it is wrong");
    let range = Lines::new(text).range(&diagnostic.origin).expect("a place");
    assert_eq!(&text[range], "Y1e999");
}

/// Typical lines, with positions around the reach.
fn line() -> impl Strategy<Value = String> {
    let place = prop_oneof![
        12 => (180.0..290.0, -80.0..80.0, -60.0..60.0),
        1 => (-400.0..400.0, -400.0..400.0, -200.0..250.0),
    ];
    prop_oneof![
        4 => (0..2, place.clone()).prop_map(|(g, (x, y, z))| format!("G{g} X{x:.3} Y{y:.3} Z{z:.3}")),
        4 => (0..2, place.clone()).prop_map(|(g, (x, y, _))| format!("G{g}X{x:.2}Y{y:.2}")),
        2 => place.clone().prop_map(|(x, y, _)| format!("X{x:.1} Y{y:.1} S100")),
        3 => (2..4, -25.0..25.0, -25.0..25.0).prop_map(|(g, i, j)| format!("G{g} I{i:.3} J{j:.3}")),
        3 => (2..4, place, 30.0..120.0, any::<bool>())
            .prop_map(|(g, (x, y, _), r, long)| format!("G{g} X{x:.3} Y{y:.3} R{}{r:.2}", if long { "-" } else { "" })),
        1 => (-15.0..15.0, -15.0..15.0).prop_map(|(x, y)| format!("G91\nG1 X{x:.2} Y{y:.2}\nG90")),
        1 => (1_u32..30_000).prop_map(|f| format!("F{f}")),
        1 => (0_u32..400).prop_map(|p| format!("G4 P{p}")),
        1 => prop::sample::select(vec!["M3 S200", "M5", "S0", "M4 S1", "M106 S9", "M107"]).prop_map(str::to_owned),
        1 => prop::sample::select(vec!["G92 X250 Y0", "G92.1", "G20\nG91\nG0 X0.1\nG21\nG90", "G80", "G28", "M0", "G55", "G54", "G10 L20 P2 X230 Z5", "G10 L2 P1 X5", "G52 Y3"])
            .prop_map(str::to_owned),
    ]
}

fn program() -> impl Strategy<Value = String> {
    let start = prop::sample::select(vec!["G0 X230 Y10 Z0\n", "", "M3 S0\nG0 X230 Y10 Z0\n"]);
    (start, prop::collection::vec(line(), 1..10))
        .prop_map(|(start, lines)| format!("{start}{}\n", lines.join("\n")))
}

/// Checks that an accepted program stays within limits, and a refused one sends nothing. Returns
/// true if it was accepted.
fn accepted_or_refused(text: &str) -> bool {
    let start = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    let pose = start.arm().expect("it is known").pose;
    let Ok((plan, _)) = try_with(text, |options| {
        options.start = Some([pose.x, pose.y, pose.z])
    }) else {
        return false;
    };
    let report = check(&plan, &start);
    let cell = VirtualArm::default().tool(ToolBias::NONE);
    let arm = Arm::simulated(cell.clone(), Options::default()).expect("an arm");
    let before = cell.state();
    let commands: Vec<Set> = plan.commands().collect();
    let ran = arm.run(&commands);
    if report.is_good() {
        // An alarm on the way would have been an error.
        ran.expect("the arm can do it");
        return true;
    }
    // The error is about reach, not about the laser, which may follow from a step left out.
    let first = report.refused_steps.first().expect("a complaint");
    assert_eq!(first.error.kind(), ErrorKind::Unreachable, "{first:?}");
    let kind = ran.expect_err("the check failed").kind();
    assert!(
        matches!(kind, ErrorKind::Unreachable | ErrorKind::InvalidInput),
        "{kind:?}"
    );
    assert_eq!(cell.state().pose, before.pose);
    assert_eq!(cell.state().queue, before.queue);
    false
}

#[test]
fn laser_is_off_on_the_way_to_the_beginning() {
    // A circle from an unknown position before the first position.
    assert!(accepted_or_refused(
        "M4 S1\nG2 I0.000 J0.423\nG1X180.00Y0.00\n"
    ));
}

#[test]
fn generated_programs_include_accepted_and_refused_ones() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..60 {
        let text = program()
            .new_tree(&mut runner)
            .expect("a program")
            .current();
        if accepted_or_refused(&text) {
            accepted += 1;
        } else {
            refused += 1;
        }
    }
    assert!(
        accepted > 5 && refused > 5,
        "{accepted} accepted, {refused} refused"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn program_stays_within_limits_or_is_refused(text in program()) {
        accepted_or_refused(&text);
    }
}

proptest! {
    #[test]
    fn parser_survives_arbitrary_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = read(Format::Gcode, &bytes, &ReadOptions::default());
    }

    #[test]
    fn parser_survives_malformed_words(
        text in "([GMXYZIJKRSFPEN%;()*/.# \n+-]{0,3}[0-9]{0,5}(\\.[0-9]{0,2})?){0,60}"
    ) {
        if let Ok((plan, _)) = try_read(&text) {
            for command in plan.commands() {
                prop_assert!(!format!("{command:?}").contains("inf"), "{command:?}");
                prop_assert!(!format!("{command:?}").contains("NaN"), "{command:?}");
            }
        }
    }
}
