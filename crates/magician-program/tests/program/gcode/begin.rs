//! Beginnings of programs: nothing is drawn from where the arm happens to stand, and the tool is
//! low only where it should be.

use std::slice;
use std::time::Duration;

use magician::{Geometry, JointAngles, ToolBias};
use magician_motion::{ArmModel, Pose};
use magician_program::rehearse::{Rehearsal, RehearseOptions, rehearse};
use magician_program::{
    Action, Content, Diagnostic, Format, Frame, Missing, Plan, ReadOptions, Setup, Surface, Tool,
    Travel, read,
};
use proptest::prelude::*;

use super::{actions_with, diagnostic, notes, path, travel, try_read, try_with};

/// Position of the arm, mm.
const START: [f64; 3] = [262.0, 0.0, 35.0];
/// Surface of placed programs, mm.
const SURFACE: f64 = -50.0;

fn from_start(text: &str) -> Vec<Action> {
    let all = actions_with(text, |options| options.start = Some([200.0, 10.0, 30.0]));
    let moves = all.into_iter().filter(|action| action.target().is_some());
    moves.collect()
}

fn joints(x: f32, y: f32, z: f32) -> Action {
    let (to, by) = ([x, y, z, 0.0], Travel::Joints);
    Action::Move { to, by }
}

#[test]
fn initial_lift_goes_straight_up_from_the_start() {
    let program = "G21 G90\nG0 Z50\nG0 X230 Y40\nG1 Z20 F1500\nG1 X240\nM2\n";
    assert_eq!(
        from_start(program),
        [
            travel(200.0, 10.0, 50.0),
            travel(230.0, 40.0, 50.0),
            path(230.0, 40.0, 20.0),
            path(240.0, 40.0, 20.0),
        ]
    );
    // Axis by axis, each is one move.
    assert_eq!(
        from_start("G0 Y40\nG0 Z50\nG0 X230\n"),
        [
            travel(200.0, 40.0, 30.0),
            travel(200.0, 40.0, 50.0),
            travel(230.0, 40.0, 50.0)
        ]
    );
    // An unknown position is asked for; without an answer the tool comes from above.
    let (plan, notes) = try_read(program).expect("it is all right");
    assert!(
        notes
            .iter()
            .any(|note| note.missing == Some(Missing::Start))
    );
    let mut moves = plan.steps.iter().map(|step| &step.action);
    let first = moves.find(|action| action.target().is_some());
    assert_eq!(first, Some(&joints(230.0, 40.0, 50.0)));
}

#[test]
fn tool_is_lowered_at_the_first_program_position() {
    for low in [
        "G0 Z0\nG0 X230 Y40\n",
        "G1 Z0\nG0 X230\nG0 Y40\n",
        "G0 X230 Z0\nG0 Y40\n",
    ] {
        let all = from_start(low);
        let over = travel(230.0, 40.0, 30.0);
        assert_eq!(
            all[all.len() - 2..],
            [over, travel(230.0, 40.0, 0.0)],
            "{low}"
        );
        for action in &all[..all.len() - 1] {
            assert!(action.target().is_some_and(|[_, _, z]| z >= 30.0), "{low}");
        }
    }
    // A program that never states a position starts where the arm stands.
    assert_eq!(from_start("G0 Z10\n"), [travel(200.0, 10.0, 10.0)]);
    assert_eq!(
        from_start("G0 Z10\nG91\nG1 X5\n"),
        [travel(200.0, 10.0, 10.0), path(205.0, 10.0, 10.0)]
    );
}

#[test]
fn a_feed_move_from_an_unknown_place_draws_nothing() {
    let program = "G21 G90\nG1 X220 Y-60 Z0 F1500\nG1 X260\nG1 Y20\n";
    for start in [None, Some([200.0, 10.0, 30.0])] {
        let all = actions_with(program, |options| options.start = start);
        let moves: Vec<_> = all.into_iter().filter(|a| a.target().is_some()).collect();
        assert_eq!(
            moves,
            [
                joints(220.0, -60.0, 0.0),
                path(260.0, -60.0, 0.0),
                path(260.0, 20.0, 0.0)
            ]
        );
    }
    let told = notes(program);
    assert!(
        told[0].starts_with("line 2, column 1: the program begins with a feed move"),
        "{told:?}"
    );
    // Nor does a laser burn on that move.
    let lit = |action: &Action| matches!(action, Action::Burn { power, .. } if *power > 0.0);
    for first in ["G1 X220 Y0 Z0", "G1 X220\nG1 Y0"] {
        let burnt = from_start(&format!("M3 S255\n{first} F600\nG1 X230\n"));
        let lines = burnt.iter().filter(|action| lit(action));
        assert_eq!(lines.count(), 1, "{burnt:?}");
        assert!(burnt.last().is_some_and(lit), "{burnt:?}");
    }
}

#[test]
fn arc_begins_at_the_programmed_position() {
    let from = |text: &str| try_with(text, |options| options.start = Some([200.0, 10.0, 30.0]));
    for stray in [
        "G2 X230 Y20 I-20",
        "G0 X200\nG2 Y40 R20",
        "G90.1\nG2 I220 J10",
    ] {
        let refused = from(stray).expect_err(stray);
        assert!(refused.message.contains("does not give"), "{refused}");
        assert!(
            refused.missing.is_none() && refused.help.is_some(),
            "{refused:?}"
        );
    }
    assert!(diagnostic("G2 X230 Y20 I-20").contains("which is unknown"));
    for meant in [
        "G91\nG2 X20 R20",
        "G2 I20",
        "G92 X0 Y0\nG2 X20 R20",
        "G0 X200 Y10\nG2 X220 R20",
    ] {
        assert!(from(meant).is_ok(), "{meant}");
    }
}

#[test]
fn a_placed_program_begins_at_its_own_zero() {
    let placed = |text: &str| {
        let all = actions_with(text, |options| {
            options.placed = true;
            options.start = Some([200.0, 10.0, 30.0]);
        });
        let moves = all.into_iter().filter(|action| action.target().is_some());
        moves.collect::<Vec<_>>()
    };
    let square = [path(120.0, 0.0, 0.0), path(120.0, 120.0, 0.0)];
    let zero = travel(0.0, 0.0, 0.0);
    assert_eq!(
        placed("G1 X120 F1000\nG1 Y120\n"),
        [slice::from_ref(&zero), &square[..]].concat()
    );
    assert_eq!(
        placed("G1 X0 Y0 F1000\nG1 X120\nG1 Y120\n"),
        [&[zero], &square[..]].concat()
    );
    // A program without Z is lifted between its lines.
    assert_eq!(
        placed("G0 X10 Y10\nG1 X20 F600\nG0 X40\nG1 X50\n"),
        [
            travel(10.0, 10.0, 10.0),
            travel(10.0, 10.0, 0.0),
            path(20.0, 10.0, 0.0),
            travel(20.0, 10.0, 10.0),
            travel(40.0, 10.0, 10.0),
            travel(40.0, 10.0, 0.0),
            path(50.0, 10.0, 0.0),
        ]
    );
}

/// Ways in which a program reaches its first point.
#[derive(Clone, Copy, Debug, PartialEq)]
enum First {
    Lift,
    Low,
    XThenY,
    YThenX,
    Feed,
    FeedThenDown,
    FeedByAxis,
    RelativeLift,
    AllRelative,
    ArcAfter,
    Literal,
}

const FIRST_MOVES: [First; 11] = [
    First::Lift,
    First::Low,
    First::XThenY,
    First::YThenX,
    First::Feed,
    First::FeedThenDown,
    First::FeedByAxis,
    First::RelativeLift,
    First::AllRelative,
    First::ArcAfter,
    First::Literal,
];

type Lines = Vec<Vec<[f64; 2]>>;

/// Program of some lines, drawn at z = 0.
fn program(first: First, lines: &Lines) -> String {
    let [x, y] = lines[0][0];
    let mut text = "G21 G90\n".to_owned();
    text += &match first {
        First::Lift => format!("G0 Z40\nG0 X{x} Y{y}\n"),
        First::Low => format!("G0 Z0\nG0 X{x} Y{y}\n"),
        First::XThenY => format!("G0 X{x}\nG0 Y{y}\n"),
        First::YThenX => format!("G0 Y{y}\nG0 X{x}\nG0 Z12\n"),
        First::Feed => format!("G1 X{x} Y{y} Z0 F1800\n"),
        First::FeedThenDown => format!("G1 X{x} Y{y} F1800\n"),
        First::FeedByAxis => format!("G1 X{x} F1800\nG1 Y{y}\n"),
        First::RelativeLift => format!("G91\nG0 Z5\nG90\nG0 X{x} Y{y}\n"),
        First::AllRelative => return relative(lines),
        First::ArcAfter => format!("G0 Z15\nG0 X{x} Y{y}\nG1 Z0\nG2 I0 J0.5\n"),
        First::Literal => format!("G0 X{x} Y{y} Z20\n"),
    };
    for (nth, line) in lines.iter().enumerate() {
        if nth > 0 {
            text += &format!("G0 Z8\nG0 X{} Y{}\n", line[0][0], line[0][1]);
        }
        text += "G1 Z0 F1800\n";
        for [x, y] in &line[1..] {
            text += &format!("G1 X{x} Y{y}\n");
        }
    }
    text + "G0 Z10\nM2\n"
}

/// The same relative to the arm's position, which is its first point.
fn relative(lines: &Lines) -> String {
    let mut text = "G21 G91\n".to_owned();
    let mut at = lines[0][0];
    let mut by = |[x, y]: [f64; 2]| {
        let way = format!("X{:.2} Y{:.2}", x - at[0], y - at[1]);
        at = [x, y];
        way
    };
    for line in lines {
        text += &format!("G0 {}\nG1 Z-{} F1800\n", by(line[0]), START[2]);
        for point in &line[1..] {
            text += &format!("G1 {}\n", by(*point));
        }
        text += &format!("G0 Z{}\n", START[2]);
    }
    text
}

fn lines() -> impl Strategy<Value = Lines> {
    let rounded = |value: f64| (value * 100.0).round() / 100.0;
    let point =
        (195.0..250.0_f64, -55.0..55.0_f64).prop_map(move |(x, y)| [rounded(x), rounded(y)]);
    let line = prop::collection::vec(point, 2..5).prop_filter("a dot is no line", |line| {
        line.windows(2).all(|side| side[0] != side[1])
    });
    prop::collection::vec(line, 1..4)
}

fn setup(placed: bool) -> Setup {
    let mut setup = Setup::default();
    setup.tool = Some(Tool::Pen);
    setup.default_surface = Some(Surface::level(SURFACE));
    setup.placement.frame = if placed { Frame::Own } else { Frame::Default };
    setup
}

fn placed_plan(
    text: &str,
    start: Option<[f64; 3]>,
    placed: bool,
) -> Result<(Plan, Vec<Diagnostic>), Diagnostic> {
    let setup = setup(placed);
    let mut options = ReadOptions::default();
    setup.set_gcode_options(&mut options.gcode, None);
    options.gcode.start = start;
    let reading = read(Format::Gcode, text.as_bytes(), &options)?;
    assert!(matches!(reading.content, Content::Plan(_)));
    let made = setup.plan(Format::Gcode, reading.content)?;
    Ok((made.plan, made.notes))
}

fn standing() -> JointAngles {
    let [x, y, z] = START;
    let geometry = Geometry::magician(ToolBias::PEN);
    let pose = Pose::new(x, y, z, 0.0);
    let joints = geometry.inverse_within(&pose, &ArmModel::MAGICIAN.limits);
    joints.expect("it can stand there")
}

fn drawn(plan: &Plan, table: f64) -> Rehearsal {
    let options = RehearseOptions::default().tool(Tool::Pen).table(table);
    let options = options.watch(Duration::from_millis(8)).standing(standing());
    rehearse(plan, &options).expect("it can be rehearsed")
}

/// Checks that every stroke is one of the lines, moved by `by`, and each line is a stroke.
fn is_exactly(done: &Rehearsal, lines: &Lines, by: [f64; 2]) -> Result<(), String> {
    let finely = |line: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let sides = line.windows(2).flat_map(|side| {
            let [a, b] = [side[0], side[1]];
            (0..=40).map(move |nth| {
                let share = f64::from(nth) / 40.0;
                [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]))
            })
        });
        sides.collect()
    };
    let wanted: Vec<[f64; 2]> = lines.iter().flat_map(|line| finely(line)).collect();
    let wanted: Vec<_> = wanted.iter().map(|[x, y]| [x + by[0], y + by[1]]).collect();
    let strokes = done.drawing.strokes().iter();
    let left: Vec<[f64; 2]> = strokes.flat_map(|stroke| finely(&stroke.points)).collect();
    let far = |from: &[[f64; 2]], to: &[[f64; 2]]| {
        let nearest = from.iter().map(|[x, y]| {
            let away = to.iter().map(|[a, b]| (x - a).hypot(y - b));
            away.fold(f64::INFINITY, f64::min)
        });
        nearest.fold(0.0, f64::max)
    };
    // Points are up to 3 mm apart on the longest lines.
    let (more, less) = (far(&left, &wanted), far(&wanted, &left));
    if more < 2.5 && less < 2.5 {
        Ok(())
    } else {
        Err(format!("{more:.2} mm too much, {less:.2} mm missing"))
    }
}

fn lowest(done: &Rehearsal) -> f64 {
    let heights = done.way.iter().map(|[_, _, z]| *z);
    heights.fold(f64::INFINITY, f64::min)
}

fn assert_drawn_as_programmed(first: First, lines: &Lines) -> Result<(), TestCaseError> {
    let text = program(first, lines);
    let by = match first {
        First::AllRelative => [0, 1].map(|axis| START[axis] - lines[0][0][axis]),
        _ => [0.0; 2],
    };
    for start in [Some(START), None] {
        let made = placed_plan(&text, start, false);
        let (plan, _) = match (made, start) {
            (Err(diagnostic), None) => {
                prop_assert_eq!(diagnostic.missing, Some(Missing::Start), "{}", text);
                continue;
            }
            (made, _) => {
                made.map_err(|diagnostic| TestCaseError::fail(format!("{text}{diagnostic}")))?
            }
        };
        let done = drawn(&plan, 0.0);
        if first == First::AllRelative && !done.is_good() {
            continue;
        }
        prop_assert!(done.is_good(), "{text}{:?}", done.log);
        let same = is_exactly(&done, lines, by);
        prop_assert!(
            same.is_ok(),
            "{first:?} from {start:?}: {same:?}\n{text}{:?}{:?}",
            done.drawing.strokes(),
            plan.steps
        );
        prop_assert!(
            lowest(&done) > -0.01,
            "{first:?}: {}\n{text}",
            lowest(&done)
        );
    }
    if first == First::AllRelative {
        return Ok(());
    }
    let (plan, _) = placed_plan(&text, None, true)
        .map_err(|diagnostic| TestCaseError::fail(format!("{text}{diagnostic}")))?;
    let done = drawn(&plan, SURFACE);
    prop_assert!(done.is_good(), "{text}{:?}", done.log);
    let mut expected = lines.clone();
    if matches!(first, First::FeedThenDown | First::FeedByAxis | First::Feed) {
        // Feed moves use the program's own zero, at Z 0.
        return Ok(());
    }
    if first == First::ArcAfter {
        expected[0].insert(0, lines[0][0]);
    }
    let extent = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        points.fold(
            [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]],
            |[least, most], at| {
                [0, 1].map(|side| {
                    [0, 1].map(|axis| match side {
                        0 => f64::min(least[axis], at[axis]),
                        _ => f64::max(most[axis], at[axis]),
                    })
                })
            },
        )
    };
    let wanted = extent(&mut expected.iter().flatten().copied());
    let bounds = done.drawing.bounds().expect("it draws");
    let by = [0, 1].map(|axis| {
        let middle = |[least, most]: [[f64; 2]; 2]| f64::midpoint(least[axis], most[axis]);
        middle(bounds) - middle(wanted)
    });
    let same = is_exactly(&done, &expected, by);
    prop_assert!(same.is_ok(), "{first:?} placed: {same:?}\n{text}");
    prop_assert!(
        lowest(&done) > SURFACE - 0.01,
        "{first:?}: {}",
        lowest(&done)
    );
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn marks_match_the_programmed_lines(
        first in prop::sample::select(FIRST_MOVES.to_vec()),
        lines in lines(),
    ) {
        assert_drawn_as_programmed(first, &lines)?;
    }
}

#[test]
fn every_kind_of_beginning_is_generated() {
    let lines = vec![
        vec![[220.0, -20.0], [240.0, -20.0], [240.0, 10.0]],
        vec![[200.0, 30.0], [230.0, 40.0]],
    ];
    for first in FIRST_MOVES {
        assert_drawn_as_programmed(first, &lines)
            .unwrap_or_else(|error| panic!("{first:?}: {error}"));
    }
}
