//! Plans on the virtual arm.

use magician::{Options, VirtualArm, blocking::Arm, build};
use magician_program::rehearse::{RehearseOptions, rehearse, stage, start_of, start_of_stage};
use magician_program::{
    Action, Format, Grip, Origin, Plan, Preparation, PrepareRequest, StartPosition, Surface, Tool,
    Travel, check,
};

const PAPER: f32 = -60.0;

fn travel(plan: &mut Plan, x: f32, y: f32, z: f32) {
    let (to, by) = ([x, y, z, 0.0], Travel::Line);
    plan.push(Action::Move { to, by }, Origin::NONE);
}

fn stroke(plan: &mut Plan, points: &[[f32; 2]]) {
    let (Some([x, y]), Some([to_x, to_y])) = (points.first(), points.last()) else {
        return;
    };
    travel(plan, *x, *y, PAPER + 10.0);
    travel(plan, *x, *y, PAPER);
    for [x, y] in &points[1..] {
        plan.push(
            Action::Path {
                to: [*x, *y, PAPER],
            },
            Origin::NONE,
        );
    }
    travel(plan, *to_x, *to_y, PAPER + 10.0);
}

/// A circle with many corners, and a line.
fn drawing() -> Plan {
    let mut plan = Plan::new("circle");
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface::level(PAPER.into()));
    plan.push(build::path_speed(40.0, 80.0), Origin::NONE);
    let circle: Vec<[f32; 2]> = (0..=300)
        .map(|nth| {
            let angle = nth as f32 / 300.0 * std::f32::consts::TAU;
            [220.0 + 30.0 * angle.cos(), 30.0 * angle.sin()]
        })
        .collect();
    stroke(&mut plan, &circle);
    stroke(&mut plan, &[[200.0, 80.0], [240.0, 100.0]]);
    plan
}

#[test]
fn rehearsal_takes_the_checked_time() {
    let plan = drawing();
    let options = RehearseOptions::default();
    let done = rehearse(&plan, &options).unwrap();
    assert!(done.is_good(), "{:?} {:?}", done.alarms, done.log);
    assert_eq!(done.steps, plan.steps.len());
    let report = check(&plan, &start_of(&stage(&plan, &options).unwrap()));
    assert_eq!(report.time, Some(done.time));
    assert_eq!(done.drawing.strokes().len(), 2);
}

#[test]
fn driver_leaves_the_same_drawing() {
    let plan = drawing();
    let options = RehearseOptions::default();
    let cell = VirtualArm::from(stage(&plan, &options).unwrap());
    let arm = Arm::simulated(cell.clone(), Options::default()).unwrap();
    arm.start(plan.commands().collect::<Vec<_>>())
        .wait(|_| {})
        .unwrap();
    let done = rehearse(&plan, &options).unwrap();
    assert_eq!(cell.with(|arm| arm.drawing()), done.drawing);
    assert_eq!(cell.state().pose, done.pose);
}

#[test]
fn rehearsal_is_deterministic() {
    let [one, two] = [(); 2].map(|()| rehearse(&drawing(), &RehearseOptions::default()).unwrap());
    assert_eq!(one.drawing, two.drawing);
    assert_eq!((one.time, one.pose), (two.time, two.pose));
}

#[test]
fn unreachable_target_raises_an_alarm() {
    let mut plan = drawing();
    travel(&mut plan, 500.0, 0.0, 0.0);
    let done = rehearse(&plan, &RehearseOptions::default()).unwrap();
    assert!(!done.is_good());
    assert!(!done.alarms.is_empty() && !done.log.is_empty());
}

#[test]
fn endless_wait_ends_the_rehearsal() {
    let mut plan = Plan::new("waits");
    plan.push(build::wait_for_level(1, true), Origin::NONE);
    travel(&mut plan, 220.0, 0.0, 0.0);
    let done = rehearse(&plan, &RehearseOptions::default()).unwrap();
    assert_eq!(done.steps, 0);
    assert!(!done.is_good());
}

#[test]
fn a_tilted_paper_gets_its_whole_drawing() {
    let mut plan = Plan::new("tilted");
    plan.tool = Some(Tool::Pen);
    let surface = Surface {
        height: -70.0,
        slope: [0.0, 0.1],
    };
    plan.surface = Some(surface);
    let at = |x: f32, y: f32| [x, y, surface.at([x.into(), y.into()]) as f32];
    let [x, y, z] = at(220.0, -60.0);
    travel(&mut plan, x, y, z + 20.0);
    travel(&mut plan, x, y, z);
    plan.push(
        Action::Path {
            to: at(220.0, 60.0),
        },
        Origin::NONE,
    );
    let done = rehearse(&plan, &RehearseOptions::default()).unwrap();
    assert!(done.is_good(), "{:?} {:?}", done.alarms, done.log);
    let [[_, low], [_, high]] = done.drawing.bounds().unwrap();
    assert!((high - low - 120.0).abs() < 0.01, "{low} {high}");
}

#[test]
fn a_table_at_no_height_is_refused() {
    for height in [f64::NAN, f64::INFINITY, 1e9] {
        let options = RehearseOptions::default().table(height);
        assert!(rehearse(&drawing(), &options).is_err());
    }
}

#[test]
fn needed_tool_follows_from_the_steps() {
    use magician_program::rehearse::tool_of;
    let with = |action: Action| {
        let mut plan = Plan::new("");
        plan.push(action, Origin::NONE);
        tool_of(&plan, &RehearseOptions::default())
    };
    assert_eq!(with(Action::Laser(true)), Tool::Laser);
    assert_eq!(with(Action::Gripper(Grip::Close)), Tool::Gripper);
    assert_eq!(with(Action::Suction(true)), Tool::Suction);
    assert_eq!(with(Action::Wait(1)), Tool::Pen);
    let told = RehearseOptions::default().tool(Tool::None);
    assert_eq!(tool_of(&drawing(), &told), Tool::None);
}

#[test]
fn a_pen_begins_above_its_paper() {
    let mut plan = Plan::new("high");
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface::level(20.0));
    travel(&mut plan, 220.0, 0.0, 30.0);
    travel(&mut plan, 220.0, 0.0, 20.0);
    let to = [240.0, 0.0, 20.0];
    plan.push(Action::Path { to }, Origin::NONE);
    let done = rehearse(&plan, &RehearseOptions::default()).unwrap();
    assert!(done.is_good(), "{:?}", done.log);
    let [low, high] = done.drawing.bounds().unwrap();
    for (found, wanted) in [low, high].concat().iter().zip([220.0, 0.0, 240.0, 0.0]) {
        assert!((found - wanted).abs() < 1e-6, "{low:?} {high:?}");
    }
}

#[test]
fn a_watched_way_goes_from_the_start_to_the_end() {
    let options = RehearseOptions::default();
    assert!(rehearse(&drawing(), &options).unwrap().way.is_empty());
    let options = options.watch(std::time::Duration::from_millis(10));
    let done = rehearse(&drawing(), &options).unwrap();
    let end = [done.pose.x, done.pose.y, done.pose.z];
    assert_eq!(done.way.last(), Some(&end));
    let steps = done.way.windows(2).map(|pair| {
        let squares = (0..3).map(|axis| (pair[1][axis] - pair[0][axis]).powi(2));
        squares.sum::<f64>().sqrt()
    });
    assert!(steps.fold(0.0, f64::max) < 3.0);
}

#[test]
fn start_of_a_stage_is_known_without_building_it() {
    for (name, surface) in [
        ("house.svg", -60.0),
        ("house.svg", 5.0),
        ("pen_outline.gcode", -60.0),
    ] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("samples")
            .join(name);
        let mut file = PrepareRequest::new(
            Format::of(name, b"").unwrap(),
            &std::fs::read(path).unwrap(),
        );
        file.defaults.surface = Some(Surface::level(surface));
        file.start = StartPosition::Staged;
        let Ok(Preparation::Done(laid)) = file.prepare() else {
            panic!("{name} is not laid");
        };
        let (plan, options) = (laid.program.plan(), RehearseOptions::default());
        let arm = start_of(&stage(plan, &options).unwrap());
        let known = start_of_stage(plan, &options).unwrap();
        assert_eq!(known.arm(), arm.arm(), "{name}");
    }
}
