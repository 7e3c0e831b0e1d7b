//! How deep a placed program goes: what it draws is on the surface, and no hole goes through it.

use magician_program::{Action, Format, Frame, Plan, ReadOptions, Setup, Surface, Tool, read};

const SURFACE: f32 = -40.0;

fn placed(text: &str, pen_z: Option<f64>) -> Plan {
    let mut setup = Setup::default();
    setup.tool = Some(Tool::Pen);
    setup.default_surface = Some(Surface::level(f64::from(SURFACE)));
    setup.placement.frame = Frame::Own;
    setup.placement.pen_z = pen_z;
    let mut options = ReadOptions::default();
    setup.prepare(&mut options.gcode, None);
    let reading = read(Format::Gcode, text.as_bytes(), &options).expect("it is read");
    let made = setup.plan(Format::Gcode, reading.content);
    made.expect("it has a size").plan
}

fn lowest(plan: &Plan) -> f32 {
    let heights = plan.steps.iter().filter_map(|step| step.action.target());
    heights.map(|[_, _, z]| z).fold(f32::MAX, f32::min)
}

#[test]
fn lines_that_only_come_down_to_the_surface_are_what_is_drawn() {
    for text in [
        "G19\nG1 Y0 Z20 F200\nG2 Y20 Z0 J0 K-20\n",
        "G0 X0 Y0 Z0\nG1 X5 Y5 Z-5 F9\nX10 Y10 Z0\n",
    ] {
        assert_eq!(lowest(&placed(text, None)), SURFACE, "{text}");
    }
}

#[test]
fn a_hole_is_a_dot_however_deep_it_is() {
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
        // Where the person has said at which Z it touches, what is deeper is meant.
        let plan = placed(&format!("{line}{hole}"), Some(-0.1));
        assert!(lowest(&plan) < SURFACE - 2.0, "{hole}");
    }
}
