//! Depths of placed programs: a pen draws all depths on the surface, and never goes through it.

use magician_program::{
    Action, Depths, Format, Frame, Plan, ReadOptions, Setup, Surface, Tool, read,
};

const SURFACE: f32 = -40.0;

fn placed_with_notes(text: &str, say: impl FnOnce(&mut Setup)) -> (Plan, Vec<String>) {
    let mut setup = Setup::default();
    setup.tool = Some(Tool::Pen);
    setup.default_surface = Some(Surface::level(f64::from(SURFACE)));
    setup.placement.frame = Frame::Own;
    say(&mut setup);
    let mut options = ReadOptions::default();
    setup.set_gcode_options(&mut options.gcode, None);
    let reading = read(Format::Gcode, text.as_bytes(), &options).expect("it is read");
    let made = setup.plan(Format::Gcode, reading.content);
    let made = made.expect("it has a size");
    let notes = made.notes.into_iter().map(|note| note.message.into());
    (made.plan, notes.collect())
}

fn placed(text: &str, pen_z: Option<f64>) -> Plan {
    placed_with_notes(text, |setup| setup.placement.pen_z = pen_z).0
}

/// Length of motion on the surface, mm.
fn drawn(plan: &Plan) -> f64 {
    let (mut at, mut drawn) = (None::<[f32; 3]>, 0.0);
    for step in &plan.steps {
        let Some(to) = step.action.target() else {
            continue;
        };
        let from = at.replace(to);
        if let Some(from) = from.filter(|from| from[2] <= SURFACE && to[2] <= SURFACE) {
            drawn += f64::from((to[0] - from[0]).hypot(to[1] - from[1]));
        }
    }
    drawn
}

fn depth_notes(notes: &[String]) -> String {
    let of_depths = notes.iter().filter(|note| note.contains("all depths"));
    of_depths.cloned().collect()
}

fn lowest(plan: &Plan) -> f32 {
    let heights = plan.steps.iter().filter_map(|step| step.action.target());
    heights.map(|[_, _, z]| z).fold(f32::MAX, f32::min)
}

#[test]
fn only_lines_at_the_surface_are_drawn() {
    for text in [
        "G19\nG1 Y0 Z20 F200\nG2 Y20 Z0 J0 K-20\n",
        "G0 X0 Y0 Z0\nG1 X5 Y5 Z-5 F9\nX10 Y10 Z0\n",
    ] {
        assert_eq!(lowest(&placed(text, None)), SURFACE, "{text}");
    }
}

#[test]
fn hole_is_a_dot_at_any_depth() {
    let line = "G0 X0 Y0 Z5\nG1 Z-0.1 F100\nX20\nG0 Z5\n";
    for hole in [
        "G0 X30\nG1 Z-3\nG0 Z5\n",
        "G81 X30 Z-3 R1\n",
        "G91 G81 X10 Z-4 R-4\n",
        "G20\nG83 X1.5 Z-0.2 R0.1 Q0.01\n",
    ] {
        let plan = placed(&format!("{line}{hole}"), None);
        assert!((lowest(&plan) - SURFACE).abs() < 1e-3, "{hole}");
        let dots = plan.steps.windows(2).filter(|two| {
            matches!(two[1].action, Action::Path { .. })
                && two[0].action.target().map(|[x, y, _]| [x, y])
                    == two[1].action.target().map(|[x, y, _]| [x, y])
        });
        assert_eq!(dots.count(), 2, "{hole}: {:?}", plan.steps);
        let plan = placed(&format!("{line}{hole}"), Some(-0.1));
        assert!((lowest(&plan) - SURFACE).abs() < 1e-3, "{hole}");
        let (plan, notes) = placed_with_notes(&format!("{line}{hole}"), |setup| {
            setup.depths = Depths::Keep;
        });
        assert!(lowest(&plan) < SURFACE - 2.0, "{hole}");
        assert!(
            notes.iter().any(|note| note.contains("below the surface")),
            "{notes:?}"
        );
    }
}

const TWO_DEPTHS: &str = "G0 Z5\nG0 X5 Y5\nG1 Z-0.2 F100\nG1 X35 Y5\nG1 X35 Y25\nG0 Z5\nG0 X0 Y0\nG1 Z-3 F100\n\
    G1 X40 Y0\nG1 X40 Y30\nG1 X0 Y30\nG1 X0 Y0\nG0 Z5\n";

#[test]
fn two_depths_are_drawn_on_the_surface_with_a_note() {
    for pen_z in [None, Some(-0.2)] {
        let (plan, notes) = placed_with_notes(TWO_DEPTHS, |setup| setup.placement.pen_z = pen_z);
        assert!((drawn(&plan) - 190.0).abs() < 0.01, "{}", drawn(&plan));
        assert_eq!(lowest(&plan), SURFACE);
        assert_eq!(
            depth_notes(&notes),
            "the pen draws all depths on the surface: 50 mm at Z-0.2, 140 mm at Z-3"
        );
    }
    // The touching Z may be that of the deepest lines.
    assert!((drawn(&placed(TWO_DEPTHS, Some(-3.0))) - 140.0).abs() < 0.01);
    let (plan, notes) = placed_with_notes(TWO_DEPTHS, |setup| setup.depths = Depths::Keep);
    assert!((lowest(&plan) - (SURFACE - 2.8)).abs() < 1e-3);
    assert!(depth_notes(&notes).is_empty(), "{notes:?}");
}

#[test]
fn size_of_two_depths_is_that_of_all_of_them() {
    let (plan, notes) = placed_with_notes(TWO_DEPTHS, |setup| setup.placement.scale = 0.5);
    assert!((drawn(&plan) - 95.0).abs() < 0.01);
    assert!(
        depth_notes(&notes).contains("25 mm at Z-0.2, 70 mm at Z-3"),
        "{notes:?}"
    );
}

#[test]
fn passes_of_one_contour_are_drawn_once() {
    let pass = |z: &str| format!("G1 Z{z} F100\nG1 X40 Y0\nG1 X40 Y30\nG1 X0 Y30\nG1 X0 Y0\n");
    let passes = ["-1", "-2", "-3"].map(pass).concat();
    let (plan, notes) = placed_with_notes(&format!("G0 Z5\nG0 X0 Y0\n{passes}G0 Z5\n"), |_| {});
    assert!((drawn(&plan) - 140.0).abs() < 0.01, "{:?}", plan.steps);
    assert_eq!(
        depth_notes(&notes),
        "the pen draws all depths on the surface: 140 mm at Z-1; 280 mm that is cut again deeper is drawn once"
    );
    // The last pass leaves tabs: its pieces repeat existing lines.
    let tabs = "G1 Z-3\nG1 X15 Y0\nG0 Z5\nG0 X25\nG1 Z-3\nG1 X40 Y0\nG1 X40 Y30\nG0 Z5\n";
    let (plan, _) = placed_with_notes(&format!("G0 Z5\nG0 X0 Y0\n{}{tabs}", pass("-1")), |_| {});
    assert!((drawn(&plan) - 140.0).abs() < 0.01, "{:?}", plan.steps);
}

#[test]
fn ramp_draws_from_where_it_enters_the_surface_and_once() {
    // Two turns of a ramp along one line, from 1 mm above to 3 mm below, then the line at full
    // depth.
    let text = "G0 Z5\nG0 X0 Y0\nG1 Z1 F100\nG1 X20 Z-1\nG1 X0 Z-3\nG1 X20\nG1 Y10\nG0 Z5\n";
    let plan = placed(text, None);
    // The first half of the line is in the air on the first turn, and drawn on the second.
    assert_eq!(lowest(&plan), SURFACE);
    assert!((drawn(&plan) - 40.0).abs() < 0.1, "{}", drawn(&plan));
}

#[test]
fn relief_is_drawn_flat_in_few_steps() {
    let mut text = "G0 Z2\nG0 X0 Y0\nG1 Z-1 F900\n".to_owned();
    for row in 0..10 {
        for nth in 0..200 {
            let x = if row % 2 == 0 { nth } else { 199 - nth };
            let z = -1.0 - 9.0 * f64::from((nth * 7 + row * 13) % 50) / 50.0;
            text += &format!("G1 X{} Y{row} Z{z:.3}\n", f64::from(x) * 0.2);
        }
    }
    let (plan, notes) = placed_with_notes(&format!("{text}G0 Z2\n"), |_| {});
    assert_eq!(lowest(&plan), SURFACE);
    assert!((drawn(&plan) - 407.0).abs() < 1.0, "{}", drawn(&plan));
    assert!(plan.steps.len() < 60, "{}", plan.steps.len());
    assert!(depth_notes(&notes).contains(" to Z-9.82"), "{notes:?}");
}

#[test]
fn zero_at_the_bed_has_its_first_depth_above_0() {
    let text = TWO_DEPTHS
        .replace("Z-0.2", "Z5.8")
        .replace("Z-3", "Z3")
        .replace("Z5\n", "Z11\n");
    let (plan, notes) = placed_with_notes(&text, |_| {});
    assert!(
        (drawn(&plan) - 190.0).abs() < 0.01,
        "{notes:?} {:?}",
        plan.steps
    );
    assert!(
        depth_notes(&notes).contains("50 mm at Z5.8, 140 mm at Z3"),
        "{notes:?}"
    );
}

#[test]
fn feed_moves_at_the_height_of_travel_draw_nothing() {
    for [up, down] in [["5", "0"], ["0", "-5"], ["-50", "-60"], ["3", "-1"]] {
        let stroke = |x: u8| format!("G1 X{x} Y0\nG1 Z{down}\nG1 Y20\nG1 Z{up}\n");
        let text = format!("G1 Z{up} F900\n{}{}{}", stroke(0), stroke(10), stroke(20));
        let plan = placed(&text, None);
        assert!(
            (drawn(&plan) - 60.0).abs() < 0.01,
            "{up} {down}: {:?}",
            plan.steps
        );
    }
}

#[test]
fn holes_of_several_depths_are_dots() {
    let text = "G0 Z5\nG0 X0 Y0\nG1 Z-1 F100\nG0 Z5\nG0 X10\nG1 Z-3\nG0 Z5\nG0 X20\nG1 Z-1\nG0 Z0\nG1 Z-2\nG0 Z5\n";
    let (plan, notes) = placed_with_notes(text, |_| {});
    let dots = plan.steps.iter().filter_map(|step| step.action.target());
    let dots: Vec<_> = dots.filter(|[_, _, z]| *z <= SURFACE).collect();
    assert_eq!(dots.len(), 3, "{:?} {notes:?}", plan.steps);
}

#[test]
fn program_of_nearly_only_travel_is_noted() {
    let mut text = "G0 Z2\nG0 X0 Y0\nG1 Z-9 F900\nG1 X2\n".to_owned();
    for nth in 0..100 {
        text += &format!("G1 X{} Y{} Z-{}\n", nth % 30, nth % 20, 1 + nth % 3);
    }
    let (plan, notes) = placed_with_notes(&text, |setup| setup.placement.pen_z = Some(-9.0));
    assert!(
        notes
            .iter()
            .any(|note| note.starts_with("nearly all of it is travel:")),
        "{notes:?}"
    );
    assert!(plan.steps.len() < 20, "{}", plan.steps.len());
}

#[test]
fn travel_in_a_groove_leaves_the_paper() {
    // A rapid move at a depth that was cut before.
    let text = "G0 Z5\nG0 X0 Y0\nG1 Z-1 F100\nG1 X20\nG0 X30 Y10\nG1 Z-3\nG1 X40\nG0 Z5\n";
    let plan = placed(text, None);
    assert!((drawn(&plan) - 30.0).abs() < 0.01, "{:?}", plan.steps);
}
