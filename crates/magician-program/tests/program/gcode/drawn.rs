//! Marks of pen and laser on a virtual arm.

use std::f64::consts::TAU;

use magician::blocking::Arm;
use magician::sim::world::Drawing;
use magician::sim::{Controller, Profile, Scenario, World};
use magician::{Options, ToolBias, VirtualArm};
use magician_protocol::commands::EndEffectorParams;

use super::{LASER_SAMPLE, PEN_SAMPLE, try_read};

/// Largest difference between the marks and the drawing, mm.
const TOLERANCE: f64 = 0.05;

/// Runs a program on a virtual arm with this tool mounted and set.
fn run(text: &str, tool: &str, bias: ToolBias) -> Drawing {
    let world = format!("[tool]\nkind = \"{tool}\"\n[table]\nheight = 0\n");
    let world = World::from_scenario(&Scenario::from_toml(&world).expect("a world"));
    let mut profile = Profile::default();
    // Above the table, which is higher than the home point.
    profile.power_up.joints = [0.0, 20.0, 30.0, 0.0];
    let cell = VirtualArm::from(Controller::in_world(profile, world));
    let arm = Arm::simulated(cell.clone(), Options::default()).expect("an arm");
    let bias = EndEffectorParams {
        x_bias: bias.x as f32,
        y_bias: bias.y as f32,
        z_bias: bias.z as f32,
    };
    arm.set(&bias).expect("it takes its tool");
    let (plan, _) = try_read(text).expect("it is all right");
    let commands: Vec<_> = plan.commands().collect();
    arm.run(&commands).expect("it can be done");
    cell.with(|arm| arm.drawing())
}

/// Distance of a point from a polyline.
fn distance_to_line(point: [f64; 2], line: &[[f64; 2]]) -> f64 {
    let sides = line.iter().zip(line.iter().skip(1));
    let distances = sides.map(|(a, b)| {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let [px, py] = [point[0] - a[0], point[1] - a[1]];
        let square = dx * dx + dy * dy;
        let share = if square > 0.0 {
            ((px * dx + py * dy) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (px - share * dx).hypot(py - share * dy)
    });
    distances.fold(f64::INFINITY, f64::min)
}

/// Largest distance of a point of either line from the other.
fn largest_distance(one: &[[f64; 2]], other: &[[f64; 2]]) -> f64 {
    let finely = |line: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let sides = line.windows(2);
        let points = sides.flat_map(|side| {
            let [a, b] = [side[0], side[1]];
            (0..=50).map(move |nth| {
                let share = f64::from(nth) / 50.0;
                [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]
            })
        });
        points.collect()
    };
    let one_way = |from: &[[f64; 2]], to: &[[f64; 2]]| {
        let distances = finely(from)
            .into_iter()
            .map(|point| distance_to_line(point, to));
        distances.fold(0.0, f64::max)
    };
    f64::max(one_way(one, other), one_way(other, one))
}

/// Points of a circle between two angles, given as shares of a turn.
fn round(centre: [f64; 2], radius: f64, from: f64, to: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..=500).map(move |nth| {
        let (sin, cos) = (TAU * (from + (to - from) * f64::from(nth) / 500.0)).sin_cos();
        [centre[0] + radius * cos, centre[1] + radius * sin]
    })
}

#[test]
fn pen_sample_leaves_its_outline() {
    let drawing = run(PEN_SAMPLE, "pen", ToolBias::PEN);
    let [stroke] = drawing.strokes() else {
        panic!("{} strokes", drawing.strokes().len())
    };
    let mut outline = vec![[220.0, -20.0], [260.0, -20.0], [260.0, 20.0]];
    outline.extend(round([240.0, 20.0], 20.0, 0.0, -0.75));
    outline.push([220.0, 40.0]);
    outline.extend(round([220.0, 10.0], 30.0, 0.25, 0.75));
    let apart = largest_distance(&stroke.points, &outline);
    println!("the pen sample: {apart:.4} mm");
    assert!(apart < TOLERANCE, "{apart}");
    assert!((stroke.points[0][0] - 220.0).hypot(stroke.points[0][1] + 20.0) < TOLERANCE);
}

#[test]
fn laser_sample_leaves_its_pattern() {
    let drawing = run(LASER_SAMPLE, "laser", ToolBias::LASER);
    // Content of the file, read without a G-code reader.
    let (mut expected, mut at) = (Vec::new(), [0.0, 0.0]);
    for line in LASER_SAMPLE.lines().filter(|line| line.contains(" X")) {
        let word = |letter| {
            let mut words = line.split(' ').filter_map(|word| word.strip_prefix(letter));
            words
                .next()
                .map(|number: &str| number.parse::<f64>().expect("a number"))
        };
        let to = [word('X').expect("X"), word('Y').unwrap_or(at[1])];
        if word('S') == Some(255.0) {
            expected.push([at, to]);
        }
        at = to;
    }
    assert_eq!(expected.len(), 50);
    assert_eq!(drawing.strokes().len(), expected.len());
    for (stroke, line) in drawing.strokes().iter().zip(&expected) {
        assert!((stroke.power - 100.0).abs() < 1e-9);
        let apart = largest_distance(&stroke.points, line);
        assert!(apart < TOLERANCE, "{line:?}: {:?}, {apart}", stroke.points);
    }
}

#[test]
fn arcs_of_a_laser_are_as_round_as_those_of_a_pen() {
    let program = "G0 X250 Y0 Z0\nM3 S100\nG1 F600\nG2 I-20 J0\nM5\n";
    let drawing = run(program, "laser", ToolBias::LASER);
    let burnt: Vec<_> = drawing
        .strokes()
        .iter()
        .flat_map(|stroke| stroke.points.clone())
        .collect();
    let circle: Vec<_> = round([230.0, 0.0], 20.0, 0.0, -1.0).collect();
    let apart = largest_distance(&burnt, &circle);
    println!("a circle of the laser: {apart:.4} mm");
    assert!(apart < TOLERANCE + 0.01, "{apart}");
}
