//! Samples of G-code with a pen and with a laser, step by step.

use magician::build;
use magician_formats::Action;
use magician_formats::formats::GcodeOptions;

use super::{
    LASER_SAMPLE, PEN_SAMPLE, actions, arc, burn, notes, path, travel, try_read, try_with,
};

#[test]
fn pen_sample_step_by_step() {
    // The arc about (240, 20) with a radius of 20 runs clockwise from 0 to 90 degrees: three
    // quarters of a circle, with its middle at 225 degrees.
    let root = 20.0 * 0.5_f64.sqrt();
    let middle = [(240.0 - root) as f32, (20.0 - root) as f32, 0.0];
    let expected = [
        build::line_speed(200.0, 200.0).into(),
        // The pen is lifted first, at the arm's position.
        travel(200.0, 0.0, 10.0),
        travel(220.0, -20.0, 10.0),
        build::path_speed(25.0, 100.0).into(),
        path(220.0, -20.0, 0.0),
        path(260.0, -20.0, 0.0),
        path(260.0, 20.0, 0.0),
        build::arc_speed(25.0, 100.0).into(),
        build::line_speed(25.0, 100.0).into(),
        arc(middle, [240.0, 40.0, 0.0]),
        path(220.0, 40.0, 0.0),
        // The arc about (220, 10) with a radius of 30 runs counter-clockwise from 90 to -90
        // degrees.
        arc([190.0, 10.0, 0.0], [220.0, -20.0, 0.0]),
        build::line_speed(200.0, 200.0).into(),
        travel(220.0, -20.0, 10.0),
        Action::Wait(200),
        travel(200.0, 0.0, 10.0),
    ];
    let from = |options: &mut GcodeOptions| options.start = Some([200.0, 0.0, -8.0]);
    let (plan, notes) = try_with(PEN_SAMPLE, from).expect("it is all right");
    let actions: Vec<_> = plan.steps.into_iter().map(|step| step.action).collect();
    assert_eq!(actions, expected);
    assert_eq!(notes, []);
}

#[test]
fn laser_sample_step_by_step() {
    let all = actions(LASER_SAMPLE);
    let mut expected: Vec<Action> = vec![
        build::line_speed(200.0, 200.0).into(),
        travel(220.0, 0.0, 0.0),
        build::path_speed((1000.0 / 60.0) as f32, 100.0).into(),
    ];
    for row in 0..10_u8 {
        let y = f32::from(row) / 2.0;
        let right = row % 2 == 0;
        if row > 0 {
            expected.push(burn(if right { 220.0 } else { 240.0 }, y, 0.0, 0.0));
        }
        for column in 1..=10_u8 {
            let way = 2.0 * f32::from(column);
            let x = if right { 220.0 + way } else { 240.0 - way };
            expected.push(burn(x, y, 0.0, 0.0));
        }
    }
    // Each burn has the power of its line (S255 is 100 %), and travels do not burn.
    let s = LASER_SAMPLE
        .lines()
        .filter(|line| line.starts_with('G') && line.contains('X'));
    let powers = s.map(|line| if line.ends_with("S255") { 100.0 } else { 0.0 });
    let mut burns = expected.iter_mut();
    for power in powers.skip(1) {
        if let Some(Action::Burn { power: to, .. }) =
            burns.find(|a| matches!(a, Action::Burn { .. }))
        {
            *to = power;
        }
    }
    expected.push(Action::Laser(false));
    expected.push(travel(220.0, 0.0, 0.0));
    assert_eq!(all, expected);
    assert_eq!(
        notes(LASER_SAMPLE),
        [
            "line 1, column 1: full power is S255, as $30 says",
            "line 6, column 1: the program has no Z: 0 is used"
        ]
    );
}

#[test]
fn each_step_has_its_line() {
    let (plan, _) = try_read(PEN_SAMPLE).expect("it is all right");
    let lines: Vec<_> = PEN_SAMPLE.lines().collect();
    for step in &plan.steps {
        let at = step.origin;
        let line = lines[at.line as usize - 1];
        assert_eq!((at.column, at.length as usize), (1, line.len()), "{line}");
    }
    assert_eq!(plan.steps.last().map(|step| step.origin.line), Some(14));
}
