//! Frames: position, height, and the laser off.

use std::time::Duration;

use magician_host::commands::PtpCmd;
use magician_host::preflight::Preflight;
use magician_host::{JointAngles, Set, ToolBias};
use magician_program::rehearse::{RehearseOptions, rehearse};
use magician_program::{
    Content, Format, Plan, Prepared, SetupDefaults, SetupOptions, Surface, check, read,
};
use serde_json::{Value, json};

const HOUSE: &[u8] = include_bytes!("../../samples/house.svg");
const GRADIENT: &[u8] = include_bytes!("../../samples/engrave_gradient.png");
const SURFACE: f64 = -60.0;

fn prepared(format: Format, bytes: &[u8], options: &Value) -> Prepared {
    let options = SetupOptions::from_fields(options.as_object().unwrap()).unwrap();
    let mut defaults = SetupDefaults::default();
    defaults.surface = Some(Surface::level(SURFACE));
    let setup = options.setup(&defaults);
    let content = read(format, bytes, &options.reading(&setup))
        .unwrap()
        .content;
    setup.plan(format, content).unwrap()
}

fn bounds_of(format: Format, bytes: &[u8], options: &Value) -> [[f64; 3]; 2] {
    let plan = prepared(format, bytes, options).plan;
    let report = check(&plan, &Preflight::at(JointAngles::HOME, ToolBias::PEN));
    assert!(report.is_good(), "{:?}", report.refused_steps);
    report.bounds.unwrap()
}

/// Path of the tool around the frame.
fn round(plan: &Plan) -> Vec<[f64; 3]> {
    let commands = plan.commands();
    let points = commands.filter_map(|command| match command {
        Set::CpCmd(cp) => Some([cp.x, cp.y, cp.z]),
        Set::CpLeCmd(cp) => Some([cp.x, cp.y, cp.z]),
        Set::PtpCmd(ptp) => Some([ptp.x, ptp.y, ptp.z]),
        _ => None,
    });
    let points: Vec<_> = points.map(|point| point.map(f64::from)).collect();
    let height = points.iter().map(|[_, _, z]| *z).reduce(f64::min).unwrap();
    points
        .into_iter()
        .filter(|[_, _, z]| *z == height)
        .collect()
}

fn box_of(points: &[[f64; 3]]) -> [[f64; 3]; 2] {
    let edge = |pick: fn(f64, f64) -> f64| {
        [0, 1, 2].map(|axis| points.iter().map(|point| point[axis]).reduce(pick).unwrap())
    };
    [edge(f64::min), edge(f64::max)]
}

fn assert_dark(plan: &Plan) {
    for command in plan.commands() {
        match command {
            Set::CpLeCmd(segment) => assert!(segment.velocity_or_power == 0.0, "{segment:?}"),
            Set::SetEndEffectorLaser(laser) => assert!(!laser.on.is_on()),
            Set::PtpCmd(PtpCmd { .. }) | Set::CpCmd(_) | Set::CpParams(_) => {}
            Set::PtpCoordinateParams(_) | Set::PtpJointParams(_) | Set::EndEffectorParams(_) => {}
            other => panic!("{other:?}"),
        }
    }
    let done = rehearse(plan, &RehearseOptions::default()).unwrap();
    assert!(done.is_good(), "{:?}", done.log);
    assert!(done.drawing.strokes().is_empty(), "something was marked");
}

#[test]
fn box_frame_bounds_the_marks_at_tool_height() {
    for (format, bytes, with) in [
        (Format::Svg, HOUSE, json!({"work": "engrave", "rotate": 20})),
        (
            Format::Image,
            GRADIENT,
            json!({"work": "engrave", "width": 40}),
        ),
        (
            Format::Image,
            GRADIENT,
            json!({"work": "draw", "width": 40, "lift": 6}),
        ),
        (
            Format::Svg,
            HOUSE,
            json!({"work": "draw", "lift": 6, "scale": 0.5}),
        ),
    ] {
        let [least, most] = bounds_of(format, bytes, &with);
        let mut framed = with.clone();
        framed["frame"] = json!("box");
        let prepared = prepared(format, bytes, &framed);
        assert_dark(&prepared.plan);
        let [from, to] = box_of(&round(&prepared.plan));
        for axis in [0, 1] {
            assert!(
                (from[axis] - least[axis]).abs() < 0.02,
                "{with}: {from:?} {least:?}"
            );
            assert!(
                (to[axis] - most[axis]).abs() < 0.02,
                "{with}: {to:?} {most:?}"
            );
        }
        let height = if with["work"] == "draw" {
            SURFACE + 6.0
        } else {
            SURFACE
        };
        assert!(
            (from[2] - height).abs() < 1e-3 && (to[2] - height).abs() < 1e-3,
            "{with}"
        );
    }
}

#[test]
fn framing_an_image_twice_gives_the_same_frame() {
    let options = json!({"work": "engrave", "width": 40, "frame": "outline"});
    let plan = || prepared(Format::Image, GRADIENT, &options).plan;
    assert_eq!(plan(), plan());
    let mut twice = plan();
    twice.steps.extend(plan().steps);
    assert_dark(&twice);
}

#[test]
fn unreachable_box_becomes_the_hull_with_a_note() {
    // A square standing on its corner: it is within reach, the corners of its box are not.
    let line = r#"<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="200mm" viewBox="0 0 200 200"><path d="M 0 80 L 80 0 L 160 80 L 80 160 Z" fill="none" stroke="black"/></svg>"#;
    let options = |frame: &str| json!({"work": "draw", "at": [245, 0], "frame": frame});
    let boxed = prepared(Format::Svg, line.as_bytes(), &options("box"));
    let notes: Vec<_> = boxed
        .notes
        .iter()
        .map(|note| note.message.as_str())
        .collect();
    assert!(
        notes.iter().any(|note| note.contains("convex hull")),
        "{notes:?}"
    );
    assert_eq!(
        boxed.plan,
        prepared(Format::Svg, line.as_bytes(), &options("hull")).plan
    );
    assert_dark(&boxed.plan);
}

#[test]
fn outline_surrounds_each_part_but_no_holes() {
    let ring = r#"<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="60mm" viewBox="0 0 90 60"><circle cx="20" cy="30" r="18" fill="none" stroke="black"/><rect x="67" y="20" width="20" height="20"/></svg>"#;
    let options = json!({"work": "engrave", "frame": "outline"});
    let plan = prepared(Format::Svg, ring.as_bytes(), &options).plan;
    assert_dark(&plan);
    let darkens = plan
        .commands()
        .filter(|command| matches!(command, Set::SetEndEffectorLaser(_)));
    assert_eq!(darkens.count(), 2, "two contours");
    let length: f64 = {
        let points = round(&plan);
        let ways = points
            .windows(2)
            .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]));
        ways.filter(|way| *way < 25.0).sum()
    };
    let edges = std::f64::consts::TAU * 18.0 + 80.0;
    assert!(
        (length / edges - 1.0).abs() < 0.1,
        "{length:.1} mm, and not {edges:.1}"
    );
}

#[test]
fn outline_has_equal_distance_on_every_side() {
    let square = r#"<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="0 0 20 20"><path d="M0 0H20V20H0Z" fill="none" stroke="black"/></svg>"#;
    let options = json!({"work": "engrave", "at": [250, 0], "frame": "outline"});
    let plan = prepared(Format::Svg, square.as_bytes(), &options).plan;
    let points = round(&plan);
    for (axis, middle) in [(0, 250.0), (1, 0.0)] {
        let at = |nth: usize| points[nth][axis];
        let (least, most) = (0..points.len()).fold((f64::MAX, f64::MIN), |(least, most), nth| {
            (least.min(at(nth)), most.max(at(nth)))
        });
        assert!(
            ((least + most) / 2.0 - middle).abs() < 0.02 && (19.9..=20.6).contains(&(most - least)),
            "axis {axis}: from {least} to {most}"
        );
    }
}

#[test]
fn only_a_laser_lights_a_frame_up_to_the_limit() {
    let options = json!({"work": "engrave", "width": 40, "frame": "hull", "frame_power": 2});
    let plan = prepared(Format::Image, GRADIENT, &options).plan;
    let powers = plan.commands().filter_map(|command| match command {
        Set::CpLeCmd(segment) => Some(segment.velocity_or_power),
        _ => None,
    });
    assert!(powers.into_iter().all(|power| power == 2.0) && plan.burns());
    let options = json!({"work": "draw", "frame": "hull", "frame_power": 2});
    let options = SetupOptions::from_fields(options.as_object().unwrap()).unwrap();
    let mut defaults = SetupDefaults::default();
    defaults.surface = Some(Surface::level(SURFACE));
    let setup = options.setup(&defaults);
    let content = read(Format::Svg, HOUSE, &options.reading(&setup))
        .unwrap()
        .content;
    let refused = setup.plan(Format::Svg, content).unwrap_err();
    assert!(refused.message.contains("another tool"), "{refused}");
}

#[test]
fn plan_without_marks_has_no_frame() {
    let options = SetupOptions::from_fields(json!({"frame": "box"}).as_object().unwrap()).unwrap();
    let setup = options.setup(&SetupDefaults::default());
    let mut plan = Plan::new("carries");
    let to = [200.0, 0.0, 20.0, 0.0];
    let by = magician_program::Travel::Joints;
    plan.push(
        magician_program::Action::Move { to, by },
        magician_program::Origin::NONE,
    );
    let refused = setup.plan(Format::Plan, Content::Plan(plan)).unwrap_err();
    assert!(
        refused.message.contains("draws and burns nothing"),
        "{refused}"
    );
}

#[test]
fn tool_is_never_below_the_frame() {
    let options = json!({"work": "draw", "frame": "box", "lift": 8});
    let plan = prepared(Format::Svg, HOUSE, &options).plan;
    let mut watched = RehearseOptions::default();
    watched.watch = Some(Duration::from_millis(10));
    let done = rehearse(&plan, &watched).unwrap();
    assert!(done.way.iter().all(|[_, _, z]| *z >= SURFACE + 8.0 - 0.01));
}
