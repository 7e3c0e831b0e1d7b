//! Travel of a pen between lines: it is lifted before it moves sideways, and hops are faster than
//! full lifts.

use std::time::Duration;

use magician_host::preflight::Preflight;
use magician_host::{JointAngles, ToolBias};
use magician_motion::{Cuboid, Fence};
use magician_program::artwork::{Layout, Marking, Order};
use magician_program::rehearse::{Rehearsal, RehearseOptions, rehearse};
use magician_program::{Action, Artwork, Origin, Plan, Stroke, Surface, Travel, check};
use proptest::prelude::*;

const PAPER: Surface = Surface::level(-60.0);
/// Height below which a tip may leave a mark, mm: more than on the virtual arm, whose paper is
/// flat.
const MARKING_HEIGHT: f64 = 0.5;
/// Distance from all lines at which a mark is a stray one, mm.
const STRAY_DISTANCE: f64 = 0.15;

fn artwork(lines: &[Vec<[f64; 2]>]) -> Artwork {
    let strokes = lines
        .iter()
        .map(|points| Stroke::new(points.clone(), Origin::NONE));
    Artwork {
        strokes: strokes.collect(),
        ..Artwork::default()
    }
}

/// Marking with full lifts instead of hops.
fn lifted(marking: Marking) -> Marking {
    Marking {
        hop: None,
        ..marking
    }
}

fn is_good(plan: &Plan) -> bool {
    check(plan, &Preflight::at(JointAngles::HOME, ToolBias::NONE)).is_good()
}

fn rehearsed(plan: &Plan) -> Rehearsal {
    let watched = RehearseOptions::default().watch(Duration::from_millis(4));
    let done = rehearse(plan, &watched).unwrap();
    assert!(done.is_good(), "{:?}", done.log);
    done
}

/// Distance of a point from the nearest line.
fn distance_to_lines(lines: &[Vec<[f64; 2]>], [x, y]: [f64; 2]) -> f64 {
    let pairs = lines.iter().flat_map(|line| {
        let ends = [line[0], line[0]];
        line.windows(2).map(|pair| [pair[0], pair[1]]).chain([ends])
    });
    let off = pairs.map(|[a, b]| {
        let way = [b[0] - a[0], b[1] - a[1]];
        let square = (way[0] * way[0] + way[1] * way[1]).max(1e-300);
        let share = ((x - a[0]) * way[0] + (y - a[1]) * way[1]) / square;
        let share = share.clamp(0.0, 1.0);
        (a[0] + share * way[0] - x).hypot(a[1] + share * way[1] - y)
    });
    off.fold(f64::INFINITY, f64::min)
}

/// Short lines close together, dots, and some lines far away.
fn strokes() -> impl Strategy<Value = Vec<Vec<[f64; 2]>>> {
    let step = || prop_oneof![3 => -4.0..4.0, 1 => -30.0..30.0];
    let point = || (step(), step()).prop_map(|(x, y)| [x, y]);
    let line = (point(), proptest::collection::vec(point(), 0..5));
    proptest::collection::vec(line, 2..8).prop_map(|lines| {
        let mut at = [0.0; 2];
        let mut go = |[x, y]: [f64; 2]| {
            at = [at[0] + x, at[1] + y];
            at
        };
        lines
            .into_iter()
            .map(|(first, others)| std::iter::once(first).chain(others).map(&mut go).collect())
            .collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    /// Wherever the tip is low enough to touch real paper, it is on a line; away from all lines it
    /// is lifted. The virtual pen leaves the same marks as with full lifts, and hops take no more
    /// time.
    #[test]
    fn hopping_pen_leaves_no_tail(
        lines in strokes(),
        at in (200.0..270.0, -90.0..90.0).prop_map(|(x, y)| [x, y]),
        slope in prop_oneof![Just([0.0; 2]), (-0.1..0.1, -0.1..0.1).prop_map(|(x, y)| [x, y])],
        lift in 2.0..40.0,
        hop in prop_oneof![3 => Just(3.0), 1 => Just(40.0)],
        level in any::<bool>(),
    ) {
        let pen = Marking { lift, hop: Some(hop), r: level.then_some(0.0), ..Marking::pen() };
        let surface = Surface { height: -60.0 - 220.0 * slope[0], slope };
        let layout = Layout { at: Some(at), ..Layout::on(surface) };
        let Ok(placed) = artwork(&lines).placed(&layout, &pen) else {
            return Ok(());
        };
        let (plan, before) = (placed.plan(&pen), placed.plan(&lifted(pen)));
        if !is_good(&before) {
            return Ok(());
        }
        let (hopped, before) = (rehearsed(&plan), rehearsed(&before));
        prop_assert!(hopped.time <= before.time, "{:?} {:?}", hopped.time, before.time);
        let drawn: Vec<_> = placed.artwork.strokes.iter().map(|stroke| stroke.points.clone()).collect();
        // The first move leads from any pose to well above the first line.
        let high = lift.min(hop);
        let begun = hopped.way.iter().position(|[x, y, z]| z - surface.at([*x, *y]) < MARKING_HEIGHT);
        for [x, y, z] in &hopped.way[begun.unwrap_or(0)..] {
            let (above, aside) = (z - surface.at([*x, *y]), distance_to_lines(&drawn, [*x, *y]));
            prop_assert!(above > -0.01, "{above} mm above the paper");
            prop_assert!(aside <= STRAY_DISTANCE || above >= 0.74 * high, "{aside} mm aside, {above} mm above the paper");
        }
        // The virtual arm's table is level.
        if slope != [0.0; 2] {
            return Ok(());
        }
        let marks: Vec<_> = hopped.drawing.strokes().iter().map(|stroke| stroke.points.clone()).collect();
        for stroke in hopped.drawing.strokes() {
            for point in &stroke.points {
                prop_assert!(distance_to_lines(&drawn, *point) <= 0.05, "{point:?}");
            }
        }
        for stroke in before.drawing.strokes() {
            for point in &stroke.points {
                prop_assert!(distance_to_lines(&marks, *point) <= 0.05, "{point:?}");
            }
        }
    }
}

/// Lines of 3 mm, 3 mm apart.
fn dashes(count: usize) -> Vec<Vec<[f64; 2]>> {
    let dash = |nth: usize| {
        let x = 6.0 * nth as f64 - 30.0;
        vec![[0.0, x], [0.0, x + 3.0]]
    };
    (0..count).map(dash).collect()
}

fn seconds(plan: &Plan) -> f64 {
    let report = check(plan, &Preflight::at(JointAngles::HOME, ToolBias::NONE));
    assert!(report.is_good());
    report.time.unwrap().as_secs_f64()
}

#[test]
fn short_hop_takes_half_the_time() {
    for marking in [Marking::pen(), Marking::laser(40.0)] {
        let placed = artwork(&dashes(11)).placed(&Layout::on(PAPER), &marking);
        let one = artwork(&dashes(1)).placed(&Layout::on(PAPER), &marking);
        let (placed, one) = (placed.unwrap(), one.unwrap());
        let hop = |marking: &Marking| {
            let (many, one) = (seconds(&placed.plan(marking)), seconds(&one.plan(marking)));
            (many - one) / 10.0
        };
        let (before, now) = (hop(&lifted(marking)), hop(&marking));
        // The dash itself, without its hop, takes 0.35 s.
        let share = if marking.power.is_none() { 0.55 } else { 0.8 };
        assert!(now < share * before, "{now} s of {before} s");
    }
}

#[test]
fn hop_height_is_half_the_distance() {
    let pen = Marking::pen();
    let row = |apart: f64| {
        vec![
            vec![[0.0, 0.0], [3.0, 0.0]],
            vec![[3.0 + apart, 0.0], [6.0 + apart, 0.0]],
        ]
    };
    for (apart, lift) in [(1.0, 3.0), (6.0, 3.0), (12.0, 6.0), (40.0, 10.0)] {
        let plan = artwork(&row(apart))
            .placed(&Layout::on(PAPER), &pen)
            .unwrap()
            .plan(&pen);
        let last = plan
            .steps
            .iter()
            .rposition(|step| step.action.marks())
            .unwrap();
        // Along the first line, up, across.
        let across = plan.steps[..last]
            .iter()
            .rev()
            .find_map(|step| match step.action {
                Action::Move {
                    to: [_, _, z, _], ..
                } if z > -59.0 => Some(f64::from(z)),
                _ => None,
            });
        assert_eq!(across, Some(lift - 60.0), "{apart}");
        // However short the travel, the pen is lifted fully at the end.
        assert_eq!(
            plan.steps.last().unwrap().action.target().unwrap()[2],
            -50.0
        );
    }
}

#[test]
fn pen_stays_down_where_a_line_continues() {
    let lines = [
        vec![[0.0, 0.0], [10.0, 0.0]],
        vec![[10.0, 0.0], [10.0, 10.0]],
    ];
    let pen = Marking::pen();
    let mut drawing = artwork(&lines);
    drawing.put_in_order(&Order::OF_FILE);
    let plan = drawing.placed(&Layout::on(PAPER), &pen).unwrap().plan(&pen);
    let first = plan
        .steps
        .iter()
        .position(|step| step.action.marks())
        .unwrap();
    assert!(
        plan.steps[first..first + 2]
            .iter()
            .all(|step| step.action.marks())
    );
}

#[test]
fn a_slow_pen_hops_slowly() {
    let placed = |marking: &Marking| {
        let placed = artwork(&dashes(8))
            .placed(&Layout::on(PAPER), marking)
            .unwrap();
        seconds(&placed.plan(marking))
    };
    let slow = Marking {
        travel: 50.0,
        ..Marking::pen()
    };
    assert!(placed(&slow) > 1.3 * placed(&Marking::pen()));
}

#[test]
fn joint_moves_respect_the_fence() {
    // A box next to the lines: a joint move towards it would cross them.
    let lines: Vec<Vec<[f64; 2]>> = (0..6)
        .map(|nth| f64::from(nth) * 12.0)
        .map(|y| vec![[0.0, y], [0.0, y + 4.0]])
        .collect();
    let placed = artwork(&lines)
        .placed(
            &Layout {
                at: Some([240.0, 0.0]),
                ..Layout::on(PAPER)
            },
            &Marking::pen(),
        )
        .unwrap();
    let fence = Fence::default()
        .with_box(Cuboid {
            min: [150.0, -200.0, -100.0],
            max: [240.005, 200.0, 150.0],
        })
        .unwrap();
    let start = Preflight::at(JointAngles::HOME, ToolBias::NONE).fence(fence);
    let fenced = Marking {
        fence: Some(fence),
        ..Marking::pen()
    };
    let refused = |plan: &Plan| {
        let steps = check(plan, &start).refused_steps;
        steps.iter().filter(|step| step.step > 4).count()
    };
    assert_eq!(refused(&placed.plan(&fenced)), 0);
    assert!(refused(&placed.plan(&Marking::pen())) > 0);
    let joints = |step: &magician_program::Step| {
        matches!(
            step.action,
            Action::Move {
                by: Travel::Joints,
                ..
            }
        )
    };
    assert!(
        placed
            .plan(&fenced)
            .steps
            .iter()
            .filter(|step| joints(step))
            .count()
            > 1
    );
}
