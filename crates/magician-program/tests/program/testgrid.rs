//! Test grids: every cell is burnt with the power and speed in its name.

use std::time::Duration;

use magician_host::preflight::Preflight;
use magician_host::{JointAngles, Set, ToolBias};
use magician_program::rehearse::{RehearseOptions, rehearse};
use magician_program::{
    Content, Format, Plan, Prepared, ReadOptions, SetupDefaults, SetupOptions, Surface, TestGrid,
    check, read,
};
use serde_json::{Value, json};

fn grid(file: &Value) -> TestGrid {
    let read = read(
        Format::TestGrid,
        file.to_string().as_bytes(),
        &ReadOptions::default(),
    );
    match read.unwrap().content {
        Content::TestGrid(grid) => grid,
        other => panic!("{other:?}"),
    }
}

fn prepared(file: &Value, options: &Value) -> Prepared {
    let options = SetupOptions::from_fields(options.as_object().unwrap()).unwrap();
    let mut defaults = SetupDefaults::default();
    defaults.surface = Some(Surface::level(-60.0));
    let setup = options.setup(&defaults);
    setup
        .plan(Format::TestGrid, Content::TestGrid(grid(file)))
        .unwrap()
}

/// The arm's period, s.
const PERIOD: f64 = 0.02;

/// Cell of this name in a plan: powers above 0, speeds, and bounds of the burn.
fn cell_figures(plan: &Plan, name: &str) -> (Vec<f32>, Vec<f32>, [[f64; 2]; 2]) {
    let (mut powers, mut speeds, mut bounds) = (vec![], vec![], [[f64::MAX; 2], [f64::MIN; 2]]);
    let mut at = [0.0; 2];
    for step in plan
        .steps
        .iter()
        .filter(|step| plan.name_of(&step.origin) == Some(name))
    {
        match step.action.command().expect("it has one") {
            Set::CpLeCmd(segment) => {
                let to = [segment.x, segment.y].map(f64::from);
                if segment.velocity_or_power > 0.0 {
                    powers.push(segment.velocity_or_power);
                    for [x, y] in [at, to] {
                        bounds[0] = [bounds[0][0].min(x), bounds[0][1].min(y)];
                        bounds[1] = [bounds[1][0].max(x), bounds[1][1].max(y)];
                    }
                }
                at = to;
            }
            Set::CpParams(speed) => speeds.push(speed.junction_vel),
            Set::PtpCmd(to) => at = [to.x, to.y].map(f64::from),
            _ => {}
        }
    }
    powers.dedup();
    (powers, speeds, bounds)
}

#[test]
fn each_cell_has_the_power_and_the_speed_it_names_in_the_plan_and_at_the_arm() {
    let file = json!({"format": "magician-testgrid", "power": "20:60:3", "speed": "5:30:2", "spacing": 0.5});
    let cells = grid(&file).cells();
    assert_eq!(cells.len(), 6);
    let plan = prepared(&file, &json!({})).plan;
    let report = check(&plan, &Preflight::at(JointAngles::HOME, ToolBias::LASER));
    assert!(report.is_good(), "{:?}", report.refused_steps.first());
    let mut watched = RehearseOptions::default();
    watched.watch = Some(Duration::from_secs_f64(PERIOD));
    let done = rehearse(&plan, &watched).unwrap();
    assert!(done.is_good(), "{:?}", done.log);
    for cell in cells {
        let name = format!("{} % at {} mm/s", cell.power, cell.speed);
        let (powers, speeds, [[left, low], [right, high]]) = cell_figures(&plan, &name);
        assert_eq!(
            (powers, speeds),
            (vec![cell.power as f32], vec![cell.speed as f32]),
            "{name}"
        );
        assert!(
            (right - left - 8.0).abs() < 0.01 && (high - low - 7.5).abs() < 0.01,
            "{name}"
        );
        // Burn left by the laser there.
        let within = |[x, y]: &[f64; 2]| {
            (left - 0.1..=right + 0.1).contains(x) && (low - 0.1..=high + 0.1).contains(y)
        };
        let left_there = done
            .drawing
            .strokes()
            .iter()
            .filter(|stroke| stroke.points.iter().all(within));
        let left_there: Vec<_> = left_there.collect();
        assert_eq!(left_there.len(), 16, "{name}: lines of 0.5 mm");
        assert!(
            left_there
                .iter()
                .all(|stroke| (stroke.power - cell.power).abs() < 1e-6),
            "{name}"
        );
        // Speeds between readings, a period of 20 ms apart.
        let looks = done.way.windows(2).filter(|pair| {
            pair.iter().all(|[x, y, z]| within(&[*x, *y]) && *z < -59.9)
                && (pair[1][1] - pair[0][1]).abs() < 1e-6
        });
        let passed: Vec<f64> = looks
            .map(|pair| (pair[1][0] - pair[0][0]).abs() / PERIOD)
            .collect();
        // A line of 8 mm takes the nearest whole number of periods.
        let speed = 8.0 / (PERIOD * (8.0 / (cell.speed * PERIOD)).round());
        let fastest = passed.iter().copied().fold(0.0, f64::max);
        assert!(
            (fastest / speed - 1.0).abs() < 0.01,
            "{name}: {fastest} and not {speed}"
        );
        // The other readings of 16 lines of 8 mm are less than a period apart.
        let even = passed
            .iter()
            .filter(|passed| (**passed / speed - 1.0).abs() < 0.01);
        let length = even.sum::<f64>() * PERIOD;
        assert!(length > 0.9 * 16.0 * 8.0, "{name}: {length} mm");
    }
    // Everything else is labels at the lowest power.
    let powers = done.drawing.strokes().iter().map(|stroke| stroke.power);
    assert!(powers.filter(|power| (*power - 20.0).abs() < 1e-6).count() > 2 * 16);
}

#[test]
fn cells_lie_a_quarter_apart_and_labels_beside_them() {
    let bare = grid(&json!({"format": "magician-testgrid", "labels": false}));
    assert_eq!((bare.size, bare.corner), ([48.0, 48.0], [0.0; 2]));
    let corners: Vec<_> = bare.cells().iter().map(|cell| cell.corner).collect();
    assert_eq!(
        (corners[0], corners[1], corners[5]),
        ([0.0; 2], [10.0, 0.0], [0.0, 10.0])
    );
    let labelled = grid(&json!({"format": "magician-testgrid"}));
    let [left, top] = labelled.corner;
    let points = || labelled.labels.iter().flatten();
    assert!(
        points().all(|[x, y]| *x <= left || *y <= top),
        "labels lie beside the cells"
    );
    assert!(
        points()
            .all(|[x, y]| (0.0..=labelled.size[0]).contains(x)
                && (0.0..=labelled.size[1]).contains(y))
    );
    assert!(points().count() > 100);
}

#[test]
fn labels_are_burnt_with_the_weakest_power_at_the_highest_speed() {
    let file = json!({"format": "magician-testgrid", "power": "80:30:2", "speed": "10:25:2"});
    let plan = prepared(&file, &json!({})).plan;
    let labels = plan
        .steps
        .iter()
        .take_while(|step| step.origin.name_index().is_none());
    let mut burns = 0;
    for step in labels {
        match step.action.command().expect("it has one") {
            Set::CpLeCmd(segment) => {
                assert_eq!(segment.velocity_or_power, 30.0);
                burns += 1;
            }
            Set::CpParams(speed) => assert_eq!(speed.junction_vel, 25.0),
            _ => {}
        }
    }
    assert!(burns > 20);
}

#[test]
fn a_grid_is_placed_as_drawings_are() {
    let file = json!({"format": "magician-testgrid", "power": "20:60:2", "speed": "5:10:2"});
    let made = prepared(&file, &json!({"at": [230, 20], "rotate": 90}));
    let report = check(
        &made.plan,
        &Preflight::at(JointAngles::HOME, ToolBias::LASER),
    );
    assert!(report.is_good());
    let [least, most] = report.bounds.unwrap();
    let middle = [0, 1].map(|axis| f64::midpoint(least[axis], most[axis]));
    assert!(
        (middle[0] - 230.0).abs() < 0.1 && (middle[1] - 20.0).abs() < 0.1,
        "{middle:?}"
    );
    // Scaled down, its lines keep their distance.
    let fitted = prepared(
        &json!({"format": "magician-testgrid", "cell": 40, "power": "20:60:5"}),
        &json!({"fit": true}),
    );
    let scale = fitted.placed.unwrap().scale;
    assert!(scale < 1.0);
    let (powers, _, [[_, low], [_, high]]) = cell_figures(&fitted.plan, "20 % at 5 mm/s");
    assert_eq!(powers, [20.0]);
    assert!((high - low - (40.0 * scale - 0.2)).abs() < 0.3);
    let report = check(
        &fitted.plan,
        &Preflight::at(JointAngles::HOME, ToolBias::LASER),
    );
    assert!(report.is_good(), "{:?}", report.refused_steps.first());
}

#[test]
fn invalid_or_contradicting_grid_options_are_refused() {
    for (file, what) in [
        (
            r#"{"format": "magician-testgrid", "power": "10:120:3"}"#,
            "at most 100",
        ),
        (
            r#"{"format": "magician-testgrid", "power": "0:20:3"}"#,
            "above 0",
        ),
        (
            r#"{"format": "magician-testgrid", "speed": "5:900:3"}"#,
            "at most 500",
        ),
        (r#"{"format": "magician-testgrid", "cell": 0.5}"#, "cell is"),
        (
            r#"{"format": "magician-testgrid", "spacing": 9}"#,
            "spacing is",
        ),
        (r#"{"format": "magician-testgrid", "colour": 9}"#, "colour"),
        (r#"{"format": "magician-plan"}"#, "magician-plan"),
        ("{", "EOF"),
    ] {
        let refused = read(Format::TestGrid, file.as_bytes(), &ReadOptions::default()).unwrap_err();
        assert!(refused.message.contains(what), "{file}: {refused}");
    }
    for options in [json!({"power": 50}), json!({"speed": 10})] {
        let options = SetupOptions::from_fields(options.as_object().unwrap()).unwrap();
        let mut defaults = SetupDefaults::default();
        defaults.surface = Some(Surface::level(-60.0));
        let file = json!({"format": "magician-testgrid"});
        let refused = options
            .setup(&defaults)
            .plan(Format::TestGrid, Content::TestGrid(grid(&file)));
        assert!(
            refused
                .unwrap_err()
                .message
                .contains("of its own in each cell")
        );
    }
}
