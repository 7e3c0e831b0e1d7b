//! Pens that are lifted by a servo.

use magician_formats::formats::Dialect;
use magician_formats::{Action, Diagnostic, Plan, Surface};

use super::try_with;

fn servo(text: &str, dialect: Dialect) -> Result<(Plan, Vec<Diagnostic>), Diagnostic> {
    try_with(text, |options| {
        options.dialect = dialect;
        options.surface = Some(Surface::level(-50.0));
        options.lift = 10.0;
    })
}

/// Returns the heights of all motions without repetitions.
fn heights(text: &str, dialect: Dialect) -> Vec<f32> {
    let (plan, _) =
        servo(text, dialect).unwrap_or_else(|diagnostic| panic!("{text}: {diagnostic}"));
    assert!(!plan.burns(), "{text}");
    let mut heights: Vec<f32> = plan
        .steps
        .iter()
        .filter_map(|step| step.action.target())
        .map(|[_, _, z]| z)
        .collect();
    heights.dedup();
    heights
}

#[test]
fn angle_during_feed_is_pen_down() {
    let drawn =
        |down: &str, up: &str| format!("{up}\nG0 X220 Y0\n{down}\nG1 X240 F600\n{up}\nG0 X200\n");
    for (down, up) in [
        ("M3 S90", "M3 S40"),
        ("M3 S40", "M3 S90"),
        ("M3 S40", "M5"),
        ("M5", "M3 S700"),
        ("M3 S2000", "M3 S1000"),
    ] {
        let text = drawn(down, up);
        assert_eq!(
            heights(&text, Dialect::Servo),
            [-40.0, -50.0, -40.0],
            "{text}"
        );
    }
    // Without a dialect only M280 and M300 are taken for a servo.
    for (down, up) in [
        ("M280 P0 S40", "M280 P0 S90"),
        ("M300 S50", "M300 S30"),
        ("M300 S30", "M300 S50"),
    ] {
        for dialect in [Dialect::Detect, Dialect::Servo] {
            assert_eq!(
                heights(&drawn(down, up), dialect),
                [-40.0, -50.0, -40.0],
                "{down}"
            );
        }
    }
    let (plan, _) = servo(&drawn("M3 S90", "M3 S40"), Dialect::Detect).expect("a laser's");
    assert!(plan.burns());
    // M280 moves the probe of a printer or the flap of a laser.
    for head in ["G1 Z0.2\n", "; Laser\n", "G1 E1\n"] {
        let (plan, _) = servo(
            &format!("{head}{}", drawn("M280 P0 S10", "M280 P0 S90")),
            Dialect::Detect,
        )
        .expect("no servo's");
        assert!(
            !plan
                .steps
                .iter()
                .any(|step| step.action.target().is_some_and(|[_, _, z]| z == -50.0))
        );
    }
}

#[test]
fn z_is_ignored_and_intermediate_angles_are_pen_up() {
    let text = "M3 S10\nG0 X220 Y0 Z5\nM3 S50\nM3 S90\nG1 X240 F600 Z-3\nM3 S10\nM5\n";
    assert_eq!(heights(text, Dialect::Servo), [-40.0, -50.0, -40.0]);
    let (_, notes) = servo(text, Dialect::Servo).expect("a servo's");
    assert!(
        notes
            .iter()
            .any(|note| note.message.starts_with("Z is left out"))
    );
}

#[test]
fn indistinguishable_servo_angles_are_refused() {
    let both = "M3 S90\nG1 X220 Y0 F600\nM3 S40\nG1 X240\n";
    let refused = servo(both, Dialect::Servo).expect_err("which is down?");
    assert!(
        refused
            .to_string()
            .starts_with("line 3, column 1: X and Y are fed with the servo at S90 and at S40"),
        "{refused}"
    );
    let down = |plan: &Plan| {
        plan.steps
            .iter()
            .any(|step| matches!(step.action, Action::Path { to: [_, _, z] } if z == -50.0))
    };
    // With a single angle the pen is down throughout.
    let (plan, _) = servo("M3 S90\nG1 X220 Y0 F600\nG1 X240\n", Dialect::Servo).expect("one angle");
    assert!(down(&plan));
    let unknown = try_with("M280 P0 S9\nG1 X220 Y0\n", |_| {}).expect_err("no surface");
    assert!(unknown.message.contains("the surface height is unknown"));
}
