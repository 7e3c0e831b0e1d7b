//! Drawings stopped at any instant: the pen goes up, and the next run resumes without a gap or a
//! stray line.

use std::time::Duration;

use magician::commands::Pose;
use magician::sim::ExternalEvent;
use magician::sim::world::{Drawing, Stroke};
use magician::{Arm, build};
use magician_program::resume::ResumePoint;
use magician_program::{Ending, Format, Program, ReadOptions, Setup, Surface, read};
use tokio::time::sleep;

use super::interrupted::{place, run_until};

const PAPER: f64 = -60.0;
const LIFT: f64 = 10.0;
/// Error of 32-bit coordinates and of flattened curves, mm.
const LINE_TOLERANCE: f64 = 0.05;

fn program() -> Program {
    let bytes = include_bytes!("../../samples/house.svg");
    let reading = read(Format::Svg, bytes, &ReadOptions::default()).expect("a drawing");
    let mut setup = Setup::default();
    setup.surface = Some(Surface::level(PAPER));
    let made = setup.plan(Format::Svg, reading.content).expect("it fits");
    Program::new(made.plan, Some(1))
}

fn xyz(pose: &Pose) -> [f64; 3] {
    [pose.x, pose.y, pose.z].map(f64::from)
}

/// Runs the program from a step on, to its end or a stop; returns where the arm stands and where to
/// resume.
async fn run(
    arm: &Arm,
    program: &Program,
    from: u64,
    stop: Option<Duration>,
) -> Option<([f64; 3], u64)> {
    let (_, resume_point, pose) = run_until(arm, program, (from, None), stop).await?;
    let (ResumePoint::After(steps) | ResumePoint::Again(steps)) = resume_point else {
        panic!("{resume_point:?}");
    };
    Some((xyz(&pose), steps))
}

type Point = [f64; 2];

/// Drawn lines.
fn lines(drawing: &Drawing) -> Vec<[Point; 2]> {
    let pairs = |stroke: &Stroke| {
        let pairs = stroke.points.windows(2).map(|pair| [pair[0], pair[1]]);
        pairs.collect::<Vec<_>>()
    };
    drawing.strokes().iter().flat_map(pairs).collect()
}

fn between([from, to]: &[Point; 2], share: f64) -> Point {
    [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
}

fn distance(line: &[Point; 2], [x, y]: Point) -> f64 {
    let [from, to] = line;
    let way = [to[0] - from[0], to[1] - from[1]];
    let square = way[0] * way[0] + way[1] * way[1];
    let along = (x - from[0]) * way[0] + (y - from[1]) * way[1];
    let share = if square > 0.0 { along / square } else { 0.0 };
    let [near_x, near_y] = between(line, share.clamp(0.0, 1.0));
    (x - near_x).hypot(y - near_y)
}

/// Largest distance of any point of one drawing from the other, mm.
fn largest_distance(one: &[[Point; 2]], other: &[[Point; 2]]) -> f64 {
    let points = one.iter().flat_map(|line| {
        let count = (distance(&[line[0], line[0]], line[1]) / 0.5)
            .ceil()
            .max(1.0);
        (0..=count as u32).map(move |nth| between(line, f64::from(nth) / count))
    });
    let away = |point| {
        let near = other.iter().map(|line| distance(line, point));
        near.fold(f64::INFINITY, f64::min)
    };
    points.map(away).fold(0.0, f64::max)
}

/// Instants as shares of the whole, the same in every run of the tests.
fn stop_shares() -> impl Iterator<Item = f64> {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    std::iter::repeat_with(move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    })
}

#[tokio::test(start_paused = true)]
async fn stop_at_any_instant_lifts_the_pen_and_resuming_leaves_no_trace() {
    let program = program();
    let (cell, arm) = place(&program).await;
    let began = cell.state().now;
    assert_eq!(run(&arm, &program, 0, None).await, None);
    let whole = cell.state().now - began;
    let right = lines(&cell.with(|arm| arm.drawing()));
    let ending = Ending {
        lift: LIFT,
        ..Ending::default()
    };
    let mut on_paper = 0;
    for share in stop_shares().take(20) {
        let (cell, arm) = place(&program).await;
        let stop = whole.mul_f64(share);
        let stopped = run(&arm, &program, 0, Some(stop)).await;
        let (stood, steps) = stopped.expect("it was stopped");
        let since = cell.state().now;
        let drawn = lines(&cell.with(|arm| arm.drawing()));
        // The ink up to the arm's position is part of the drawing.
        assert!(
            largest_distance(&drawn, &right) < LINE_TOLERANCE,
            "{stop:?}"
        );
        let lift = ending.after_stop(program.plan()).expect("a pen");
        let lifted = arm.lift(lift).await.expect("it goes up");
        let took = cell.state().now - since;
        assert!(took < Duration::from_secs(2), "{stop:?}: {took:?}");
        let up = xyz(&lifted.pose);
        let off = [
            up[0] - stood[0],
            up[1] - stood[1],
            up[2] - stood[2] - lifted.by,
        ];
        assert!(off.iter().all(|off| off.abs() < 0.01), "{stood:?} {up:?}");
        if stood[2] < PAPER + 0.5 {
            on_paper += 1;
            assert!((up[2] - PAPER - LIFT).abs() < 0.5, "{up:?}");
        }
        if lifted.by < LIFT {
            let check = arm.preflight().await.expect("read");
            let [x, y, z] = up.map(|at| at as f32);
            let higher = build::line_to(x, y, z + 0.2, lifted.pose.r);
            assert!(check.clone().check(&higher).is_err(), "{lifted:?}");
        }
        assert_eq!(lines(&cell.with(|arm| arm.drawing())), drawn, "{stop:?}");
        assert_eq!(run(&arm, &program, steps, None).await, None);
        let done = lines(&cell.with(|arm| arm.drawing()));
        assert!(
            largest_distance(&right, &done) < LINE_TOLERANCE,
            "a gap after {stop:?}"
        );
        assert!(
            largest_distance(&done, &right) < LINE_TOLERANCE,
            "a stray line after {stop:?}"
        );
    }
    assert!((5..20).contains(&on_paper), "{on_paper}");
}

#[tokio::test(start_paused = true)]
async fn a_second_stop_ends_the_lift_where_it_is() {
    let program = program();
    let (_, arm) = place(&program).await;
    let stopped = run(&arm, &program, 0, Some(Duration::from_secs(8))).await;
    let (stood, _) = stopped.expect("it was stopped");
    tokio::select! {
        lifted = arm.lift(60.0) => panic!("{lifted:?}"),
        () = sleep(Duration::from_millis(400)) => {}
    }
    arm.stop().await.expect("it stands");
    let pose: Pose = arm.get().await.expect("a pose");
    let up = f64::from(pose.z) - stood[2];
    assert!((0.5..59.0).contains(&up), "{up}");
    sleep(Duration::from_secs(5)).await;
    assert_eq!(arm.get::<Pose>().await.expect("a pose"), pose);
    // A stop before the lift begins moves nothing.
    let stops = arm.stopper();
    let lift = arm.lift(10.0);
    stops.request_stop().expect("it is there");
    drop(lift);
    sleep(Duration::from_secs(5)).await;
    assert_eq!(arm.get::<Pose>().await.expect("a pose"), pose);
}

#[tokio::test(start_paused = true)]
async fn arm_in_alarm_is_not_moved() {
    let program = program();
    let (cell, arm) = place(&program).await;
    let stopped = run(&arm, &program, 0, Some(Duration::from_secs(8))).await;
    stopped.expect("it was stopped");
    cell.with(|arm| arm.inject(ExternalEvent::Alarm(0x10)));
    let before: Pose = arm.get().await.expect("a pose");
    for error in [
        arm.lift(10.0).await.map(drop),
        arm.park([200.0, 0.0, 60.0]).await.map(drop),
    ] {
        let error = error.expect_err("it is held");
        assert_eq!(error.kind(), magician::ErrorKind::Alarm);
    }
    assert_eq!(arm.get::<Pose>().await.expect("a pose"), before);
}

#[tokio::test(start_paused = true)]
async fn finished_drawing_is_parked_from_above() {
    let program = program();
    let (cell, arm) = place(&program).await;
    assert_eq!(run(&arm, &program, 0, None).await, None);
    let drawn = lines(&cell.with(|arm| arm.drawing()));
    let ending = Ending {
        park: Some([200.0, -80.0, -20.0]),
        ..Ending::default()
    };
    let at = xyz(&arm.get::<Pose>().await.expect("a pose"));
    // The drawing has lifted the pen as its last step.
    assert_eq!(ending.after_done(program.plan(), at), None);
    assert_eq!(
        Ending {
            lift: 15.0,
            ..ending
        }
        .after_done(program.plan(), at),
        Some(5.0)
    );
    let pose = arm.park([200.0, -80.0, -20.0]).await.expect("within reach");
    assert_eq!(xyz(&pose), [200.0, -80.0, -20.0]);
    assert_eq!(lines(&cell.with(|arm| arm.drawing())), drawn);
    let start = arm.preflight_for(&program.kinds()).await.expect("read");
    let rest = program.remaining(0, start).expect("within reach");
    assert!(ending.check(&rest).is_ok());
    let far = Ending {
        park: Some([400.0, 0.0, 0.0]),
        ..ending
    };
    let error = far.check(&rest).expect_err("too far");
    assert_eq!(error.kind(), magician::ErrorKind::Unreachable);
    assert!(error.value() > error.limit());
}
