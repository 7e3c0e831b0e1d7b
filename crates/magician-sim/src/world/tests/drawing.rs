//! Traces of pen and laser.

use super::{Arm, SECOND, TimedPath, joint_state};
use crate::Micros;
use crate::world::{Drawing, Stroke, StrokeKind};

fn pen() -> Arm {
    let text = "[tool]\nkind = \"pen\"\n[table]\nheight = -60\n";
    Arm::new(text, [200.0, 0.0, -40.0, 0.0])
}

fn laser() -> Arm {
    Arm::new("[tool]\nkind = \"laser\"\n", [200.0, 0.0, -20.0, 0.0])
}

/// Points of the stroke, rounded to a micrometre.
fn corners(stroke: &Stroke) -> Vec<[f64; 2]> {
    let round = |value: f64| (value * 1e3).round() / 1e3 + 0.0;
    stroke.points.iter().map(|point| point.map(round)).collect()
}

#[test]
fn a_square_is_one_stroke_of_four_sides() {
    let mut arm = pen();
    for [x, y, z] in [
        [200.0, 0.0, -60.0],
        [240.0, 0.0, -60.0],
        [240.0, 40.0, -60.0],
        [200.0, 40.0, -60.0],
        [200.0, 0.0, -60.0],
        [200.0, 0.0, -40.0],
    ] {
        arm.go([x, y, z, 0.0], SECOND);
    }
    let drawing = arm.world.drawing().unwrap();
    let [stroke] = drawing.strokes() else {
        panic!("{drawing:?}")
    };
    assert_eq!((stroke.kind, stroke.power), (StrokeKind::Ink, 100.0));
    let square = [
        [200.0, 0.0],
        [240.0, 0.0],
        [240.0, 40.0],
        [200.0, 40.0],
        [200.0, 0.0],
    ];
    assert_eq!(corners(stroke), square);
}

#[test]
fn the_pen_lifts_between_strokes() {
    let mut arm = pen();
    for [x, z] in [
        [200.0, -60.0],
        [220.0, -60.0],
        [220.0, -50.0],
        [230.0, -50.0],
        [230.0, -60.0],
        [250.0, -60.0],
    ] {
        arm.go([x, 0.0, z, 0.0], SECOND);
    }
    let drawing = arm.world.drawing().unwrap();
    let strokes: Vec<_> = drawing.strokes().iter().map(corners).collect();
    assert_eq!(
        strokes,
        [
            vec![[200.0, 0.0], [220.0, 0.0]],
            vec![[230.0, 0.0], [250.0, 0.0]]
        ]
    );
}

#[test]
fn the_pen_writes_only_where_it_is_down() {
    let mut arm = pen();
    arm.go([200.0, 0.0, -55.0, 0.0], SECOND);
    // From -55 to -65: it reaches the paper half way, counting 0.02 mm above it.
    arm.go([240.0, 0.0, -65.0, 0.0], SECOND);
    let drawing = arm.world.drawing().unwrap();
    let [stroke] = drawing.strokes() else {
        panic!("{drawing:?}")
    };
    let points = corners(stroke);
    assert!(
        (points[0][0] - 219.92).abs() < 0.01 && points.last() == Some(&[240.0, 0.0]),
        "{points:?}"
    );
}

#[test]
fn the_pen_writes_only_on_the_paper() {
    let text = "[tool]\nkind = \"pen\"\n[table]\nheight = -60\nx = [210, 230]\n";
    let mut arm = Arm::new(text, [200.0, 0.0, -60.0, 0.0]);
    arm.go([240.0, 0.0, -60.0, 0.0], SECOND);
    let drawing = arm.world.drawing().unwrap();
    let [stroke] = drawing.strokes() else {
        panic!("{drawing:?}")
    };
    assert_eq!(corners(stroke), [[210.0, 0.0], [230.0, 0.0]]);
}

#[test]
fn a_touch_of_the_paper_is_a_dot() {
    let mut arm = pen();
    arm.go([200.0, 0.0, -60.0, 0.0], SECOND);
    arm.go([200.0, 0.0, -40.0, 0.0], SECOND);
    let drawing = arm.world.drawing().unwrap();
    assert_eq!(corners(&drawing.strokes()[0]), [[200.0, 0.0]]);
    assert_eq!(drawing.strokes().len(), 1);
}

/// A path on a circle of 20 mm radius, at `turns` turns per second.
fn circle(arm: &Arm, turns: f64) -> impl Fn(Micros) -> crate::world::JointState + use<> {
    let geometry = arm.geometry;
    move |at| {
        let angle = at as f64 / 1e6 * turns * std::f64::consts::TAU;
        let pose = [200.0 + 20.0 * angle.cos(), 20.0 * angle.sin(), -60.0, 0.0];
        joint_state(&geometry, &pose.into())
    }
}

#[test]
fn a_circle_is_as_round_as_promised() {
    for turns in [1.0, 4.0] {
        let mut arm = pen();
        let at = circle(&arm, turns);
        let path = TimedPath::new(0, SECOND, &at);
        arm.world.begin(&path);
        arm.world.end(&path);
        let drawing = arm.world.drawing().unwrap();
        let [stroke] = drawing.strokes() else {
            panic!("{drawing:?}")
        };
        let sagitta = |pair: &[[f64; 2]]| {
            let middle = [
                f64::midpoint(pair[0][0], pair[1][0]) - 200.0,
                f64::midpoint(pair[0][1], pair[1][1]),
            ];
            20.0 - (middle[0].powi(2) + middle[1].powi(2)).sqrt()
        };
        let worst = stroke.points.windows(2).map(sagitta).fold(0.0, f64::max);
        assert!(worst <= 0.02, "{worst}");
        // A chord with a sagitta of 0.02 mm spans 5.1 degrees, so a turn needs 71 points.
        let points = stroke.points.len() as f64;
        assert!((71.0 * turns..300.0 * turns).contains(&points), "{points}");
    }
}

#[test]
fn a_picture_shows_the_motion_under_way() {
    let mut arm = pen();
    let at = circle(&arm, 1.0);
    let path = TimedPath::new(0, SECOND, &at);
    arm.world.begin(&path);
    assert!(arm.world.drawing().unwrap().is_empty());
    let half = arm.world.drawing_at(SECOND / 2, Some(&path));
    let last = half.strokes()[0].points.last().unwrap();
    assert!(
        (last[0] - 180.0).abs() < 1e-6 && last[1].abs() < 1e-6,
        "{last:?}"
    );
    // The query did not change anything: nothing is drawn twice.
    arm.world.end(&path);
    let drawing = arm.world.drawing().unwrap();
    assert_eq!(drawing.strokes().len(), 1);
    assert_eq!(arm.world.drawing_at(SECOND, None), *drawing);
}

#[test]
fn a_course_told_in_parts_is_one_stroke() {
    let mut arm = pen();
    let at = circle(&arm, 1.0);
    for (from, to) in [(0, 300_000), (300_000, 310_000), (310_000, SECOND)] {
        arm.world.begin(&TimedPath::new(from, SECOND, &at));
        arm.world.end(&TimedPath::new(from, to, &at));
    }
    assert_eq!(arm.world.drawing().unwrap().strokes().len(), 1);
}

fn burns(drawing: &Drawing) -> Vec<(f64, Vec<[f64; 2]>)> {
    let strokes = drawing.strokes().iter();
    strokes
        .inspect(|stroke| assert_eq!(stroke.kind, StrokeKind::Burn))
        .map(|stroke| (stroke.power, corners(stroke)))
        .collect()
}

#[test]
fn the_laser_burns_with_its_power() {
    let mut arm = laser();
    arm.go([210.0, 0.0, -20.0, 0.0], SECOND);
    for (power, x) in [
        (50.0, 220.0),
        (80.0, 230.0),
        (80.0, 240.0),
        (0.0, 250.0),
        (30.0, 260.0),
    ] {
        arm.laser(power);
        arm.go([x, 0.0, -20.0, 0.0], SECOND);
    }
    let expected = [
        (50.0, vec![[210.0, 0.0], [220.0, 0.0]]),
        (80.0, vec![[220.0, 0.0], [230.0, 0.0], [240.0, 0.0]]),
        (30.0, vec![[250.0, 0.0], [260.0, 0.0]]),
    ];
    assert_eq!(burns(arm.world.drawing().unwrap()), expected);
}

#[test]
fn power_that_changes_on_the_way_splits_the_stroke_there() {
    let mut arm = laser();
    let geometry = arm.geometry;
    let at = |at: Micros| {
        let pose = [200.0 + 40.0 * at as f64 / 1e6, 0.0, -20.0, 0.0];
        joint_state(&geometry, &pose.into())
    };
    let path = TimedPath::new(0, SECOND, &at);
    arm.world.begin(&path);
    for (now, laser) in [(250_000, 20.0), (500_000, 100.0), (750_000, 0.0)] {
        let tool = crate::world::ToolState {
            laser,
            ..Default::default()
        };
        arm.world.set_tool(now, tool, &at(now));
    }
    let half = arm.world.drawing_at(600_000, Some(&path));
    assert_eq!(
        burns(&half),
        [
            (20.0, vec![[210.0, 0.0], [220.0, 0.0]]),
            (100.0, vec![[220.0, 0.0], [224.0, 0.0]])
        ]
    );
    arm.world.end(&path);
    let expected = [
        (20.0, vec![[210.0, 0.0], [220.0, 0.0]]),
        (100.0, vec![[220.0, 0.0], [230.0, 0.0]]),
    ];
    assert_eq!(burns(arm.world.drawing().unwrap()), expected);
}

#[test]
fn a_laser_at_rest_burns_a_dot() {
    let mut arm = laser();
    arm.laser(60.0);
    arm.laser(0.0);
    assert!(arm.world.drawing().unwrap().is_empty(), "on for no time");
    arm.laser(60.0);
    arm.wait_until(SECOND);
    arm.laser(0.0);
    assert_eq!(
        burns(arm.world.drawing().unwrap()),
        [(60.0, vec![[200.0, 0.0]])]
    );
}

#[test]
fn other_tools_leave_nothing() {
    for tool in ["none", "suction", "gripper"] {
        let text = format!("[tool]\nkind = \"{tool}\"\n[table]\nheight = -60\n");
        let mut arm = Arm::new(&text, [200.0, 0.0, -60.0, 0.0]);
        arm.laser(100.0);
        arm.go([220.0, 0.0, -60.0, 0.0], SECOND);
        assert!(arm.world.drawing().unwrap().is_empty());
    }
}

#[test]
fn what_is_told_again_is_not_drawn_again() {
    let mut arm = pen();
    let at = circle(&arm, 0.5);
    for to in [400_000, 700_000, SECOND] {
        arm.world.end(&TimedPath::new(0, to, &at));
    }
    let [stroke] = arm.world.drawing().unwrap().strokes() else {
        panic!("one stroke")
    };
    let left = stroke.points.windows(2).all(|pair| pair[1][0] < pair[0][0]);
    assert!(left, "half a circle goes one way: {:?}", stroke.points);
}
