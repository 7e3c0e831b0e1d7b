//! A line stopped at any instant resumes where the pen stood: neither gap nor double stroke.

use std::time::Duration;

use magician::commands::CpCmd;
use magician::sim::world::{Drawing, Stroke};
use magician::{Arm, VirtualArm, build};
use magician_program::{Action, Origin, Plan, Program, Surface, Tool, Travel};
use magician_protocol::CpMode;

use super::interrupted::{place, run_until};

const PAPER: f64 = -60.0;
const TRAVEL_HEIGHT: f32 = -45.0;
/// Longest gap, mm.
const MAX_GAP: f64 = 0.2;
/// Radius of the bend, mm.
const BEND_RADIUS: f64 = 8.0;
/// Angle of each piece of the bend, degrees.
const PIECE_ANGLE: f64 = 3.0;
/// Longest double stroke, mm: the distance of one 20 ms period in the bend, 0.42 mm, because each
/// of its pieces takes one period. A segment that is replanned to rest within a period is slower
/// after the last pose than the pen was, which is up to this distance ahead of where the line
/// resumes.
const MAX_OVERLAP: f64 = BEND_RADIUS * PIECE_ANGLE.to_radians();

/// Number of instants at which each line is stopped.
const STOP_INSTANTS: u32 = 17;

type Point = [f64; 2];

/// Form of a line.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Path,
    PathBy,
    Line,
    LineBy,
}

/// Long lines, a corner, a bend of short ones, and a long one.
fn corners() -> Vec<Point> {
    let mut points = vec![[205.0, -30.0], [235.0, -30.0], [235.0, -12.0]];
    let bend = (1..=60).map(|nth| {
        let turned = f64::from(nth) * PIECE_ANGLE.to_radians();
        [
            235.0 + BEND_RADIUS * (1.0 - turned.cos()),
            -12.0 + BEND_RADIUS * turned.sin(),
        ]
    });
    points.extend(bend);
    points.push([251.0, -30.0]);
    points
}

fn plan(kind: Kind) -> Plan {
    let mut plan = Plan::new("a line");
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface::level(PAPER));
    let paper = PAPER as f32;
    let corners = corners();
    let at = |[x, y]: Point, z: f32| [x as f32, y as f32, z, 0.0];
    let mut push = |action: Action| plan.push(action, Origin::NONE);
    push(build::path_speed(50.0, 100.0).into());
    let [first, last] = [corners[0], corners[corners.len() - 1]];
    let line = |to| Action::Move {
        to,
        by: Travel::Line,
    };
    push(line(at(first, TRAVEL_HEIGHT)));
    push(line(at(first, paper)));
    for pair in corners.windows(2) {
        let by = [0, 1].map(|axis| (pair[1][axis] - pair[0][axis]) as f32);
        let [x, y] = by;
        push(match kind {
            Kind::Path => {
                let [x, y] = pair[1].map(|at| at as f32);
                let to = [x, y, paper];
                Action::Path { to }
            }
            Kind::PathBy => Action::from(magician::Set::from(CpCmd {
                cp_mode: CpMode::Relative,
                x,
                y,
                z: 0.0,
                velocity_or_power: 0.0,
            })),
            Kind::Line => line(at(pair[1], paper)),
            Kind::LineBy => Action::Shift {
                by: [x, y, 0.0, 0.0],
                line: true,
            },
        });
    }
    push(line(at(last, TRAVEL_HEIGHT)));
    plan
}

/// Runs the program from a place on, to its end or a stop; returns the place to resume at.
async fn run(
    arm: &Arm,
    program: &Program,
    from: (u64, Option<[f64; 3]>),
    stop: Option<Duration>,
) -> Option<(u64, Option<[f64; 3]>)> {
    let (rest, resume_point, pose) = run_until(arm, program, from, stop).await?;
    let next = rest.resume_place(resume_point, &pose);
    assert!(next.is_some(), "{resume_point:?}");
    next
}

/// Distance along the line of the nearest point to `point`.
fn along(point: Point) -> f64 {
    let corners = corners();
    let (mut before, mut best) = (0.0, (f64::INFINITY, 0.0));
    for pair in corners.windows(2) {
        let way = [0, 1].map(|axis| pair[1][axis] - pair[0][axis]);
        let off = [0, 1].map(|axis| point[axis] - pair[0][axis]);
        let length = way[0].hypot(way[1]);
        let share = ((way[0] * off[0] + way[1] * off[1]) / (length * length)).clamp(0.0, 1.0);
        let away = (off[0] - share * way[0]).hypot(off[1] - share * way[1]);
        if away < best.0 {
            best = (away, before + share * length);
        }
        before += length;
    }
    best.1
}

/// Extent of strokes along the line.
fn span(strokes: &[Stroke]) -> Option<(f64, f64)> {
    let points = strokes.iter().flat_map(|stroke| &stroke.points);
    points.map(|point| along(*point)).fold(None, |span, at| {
        let (from, to) = span.unwrap_or((at, at));
        Some((at.min(from), at.max(to)))
    })
}

fn strokes(cell: &VirtualArm) -> Vec<Stroke> {
    cell.with(|arm| Drawing::strokes(&arm.drawing()).to_vec())
}

#[tokio::test(start_paused = true)]
async fn line_stopped_at_any_instant_has_neither_gap_nor_overlap() {
    for kind in [Kind::Path, Kind::PathBy, Kind::Line, Kind::LineBy] {
        let program = Program::new(plan(kind), Some(1));
        let (cell, arm) = place(&program).await;
        let began = cell.state().now;
        assert_eq!(run(&arm, &program, (0, None), None).await, None);
        let whole = cell.state().now - began;
        let (_, end) = span(&strokes(&cell)).expect("it is drawn");
        let mut on_paper = 0;
        for nth in 1..STOP_INSTANTS {
            // Stopped twice: a resumed run can be stopped too.
            let (cell, arm) = place(&program).await;
            let (mut from, mut stop) = (
                (0, None),
                Some(whole.mul_f64(f64::from(nth) / f64::from(STOP_INSTANTS))),
            );
            let mut drawn = 0.0;
            for again in 0.. {
                let before = strokes(&cell).len();
                let stopped = run(&arm, &program, from, stop).await;
                if let Some((from, to)) = span(&strokes(&cell)[before..]) {
                    let gap = from - drawn;
                    assert!(
                        (-MAX_OVERLAP..=MAX_GAP).contains(&gap),
                        "{kind:?} {nth} of {STOP_INSTANTS}, {again}: {drawn} {from} {to}"
                    );
                    drawn = to;
                }
                let Some(next) = stopped.filter(|(steps, _)| program.check_step(*steps).is_ok())
                else {
                    break;
                };
                on_paper += u32::from(next.1.is_some() && again == 0);
                arm.lift(15.0).await.expect("it goes up");
                (from, stop) = (
                    next,
                    (again == 0 && nth % 4 == 0).then_some(whole.mul_f64(0.3)),
                );
            }
            assert!(
                (drawn - end).abs() <= MAX_GAP,
                "{kind:?} {nth}: {drawn} of {end}"
            );
        }
        assert!(on_paper > 5, "{kind:?} {on_paper}");
    }
}
