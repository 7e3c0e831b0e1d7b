//! Tests of the clean-up: examples, and a property over random lines.

use magician_host::build;
use proptest::prelude::*;

use super::*;
use crate::{Origin, Pause, PauseCause};

const TRAVEL_HEIGHT: f32 = 5.0;

fn pen(lines: &[&[[f32; 3]]]) -> Plan {
    let mut plan = Plan::new("lines");
    for line in lines {
        draw(&mut plan, line, 20.0);
    }
    plan
}

/// Draws a line as G-code does: above its start, slowly down, along it, up.
fn draw(plan: &mut Plan, line: &[[f32; 3]], speed: f32) {
    let [from, to] = [line[0], line[line.len() - 1]];
    rapid(plan, [from[0], from[1], TRAVEL_HEIGHT]);
    plan.push(build::path_speed(5.0, 100.0), Origin::NONE);
    plan.push(Action::Path { to: from }, Origin::NONE);
    plan.push(build::path_speed(speed, 100.0), Origin::NONE);
    for place in &line[1..] {
        plan.push(Action::Path { to: *place }, Origin::NONE);
    }
    rapid(plan, [to[0], to[1], TRAVEL_HEIGHT]);
}

fn rapid(plan: &mut Plan, [x, y, z]: [f32; 3]) {
    let (to, by) = ([x, y, z, 0.0], Travel::Line);
    plan.push(Action::Move { to, by }, Origin::NONE);
}

/// Burns a line as M3 and M4 do: dark to its start, then along it.
fn burn(plan: &mut Plan, line: &[[f32; 3]], power: f32, speed: f32) {
    let from = line[0];
    plan.push(build::path_speed(speed, 100.0), Origin::NONE);
    plan.push(
        Action::Burn {
            to: from,
            power: 0.0,
        },
        Origin::NONE,
    );
    for to in &line[1..] {
        plan.push(Action::Burn { to: *to, power }, Origin::NONE);
    }
}

fn tidied(plan: &Plan, tidy: &Tidy) -> (Plan, Tidied) {
    let mut plan = plan.clone();
    let tidied = plan.tidy(tidy);
    (plan, tidied)
}

fn once() -> Tidy {
    Tidy {
        merge: 0.0,
        dedupe: true,
        simplify: 0.0,
    }
}

const L_SHAPE: &[[f32; 3]] = &[[200.0, 0.0, 0.0], [220.0, 0.0, 0.0], [220.0, 10.0, 0.0]];
const FAR_LINE: &[[f32; 3]] = &[[240.0, 0.0, 0.0], [240.0, 9.0, 0.0]];

fn reversed(line: &[[f32; 3]]) -> Vec<[f32; 3]> {
    line.iter().rev().copied().collect()
}

#[test]
fn duplicate_line_is_drawn_once_in_either_direction() {
    let back = reversed(L_SHAPE);
    let (plan, found) = tidied(
        &pen(&[L_SHAPE, FAR_LINE, &back, L_SHAPE, FAR_LINE]),
        &once(),
    );
    assert_eq!((found.repeated, found.joined), (3, 0));
    let marks = |plan: &Plan| {
        let marks = plan.steps.iter().filter(|step| step.action.marks());
        marks.count()
    };
    assert_eq!(marks(&plan), marks(&pen(&[L_SHAPE, FAR_LINE])));
    // All that remains of the duplicates is travel above the lines.
    let low = |step: &&Step| step.action.target().is_some_and(|to| to[2] < TRAVEL_HEIGHT);
    assert_eq!(
        plan.steps.iter().filter(low).count(),
        marks(&pen(&[L_SHAPE, FAR_LINE]))
    );
}

#[test]
fn closed_line_is_equal_regardless_of_its_start() {
    let [a, b, c] = [[200.0, 0.0, 0.0], [210.0, 0.0, 0.0], [210.0, 10.0, 0.0]];
    let plan = pen(&[&[a, b, c, a], &[c, b, a, c], &[a, b, c]]);
    assert_eq!(tidied(&plan, &once()).1.repeated, 1);
}

#[test]
fn lines_at_another_height_pen_or_part_are_distinct() {
    let deeper: Vec<[f32; 3]> = L_SHAPE.iter().map(|[x, y, z]| [*x, *y, z - 1.0]).collect();
    assert_eq!(tidied(&pen(&[L_SHAPE, &deeper]), &once()).1.repeated, 0);
    let pause = Action::Pause(Box::new(Pause {
        text: String::new(),
        cause: PauseCause::Program,
    }));
    let part = Action::Part(Box::default());
    for between in [pause, part, Action::Suction(true), Action::Home] {
        let mut plan = pen(&[L_SHAPE]);
        plan.push(between, Origin::NONE);
        draw(&mut plan, L_SHAPE, 20.0);
        assert_eq!(tidied(&plan, &once()).1.repeated, 0, "{plan:?}");
    }
}

#[test]
fn burns_are_equal_with_the_same_power_and_speed() {
    let repeated = |power: f32, speed: f32| {
        let mut plan = Plan::new("burnt");
        burn(&mut plan, L_SHAPE, 40.0, 10.0);
        burn(&mut plan, &reversed(L_SHAPE), power, speed);
        burn(&mut plan, FAR_LINE, 40.0, 10.0);
        let (left, found) = tidied(&plan, &once());
        let lit = |plan: &Plan| {
            let lit = plan.steps.iter().filter(|step| step.action.burns());
            lit.count()
        };
        assert_eq!(lit(&plan) - lit(&left), 2 * found.repeated);
        found.repeated
    };
    assert_eq!(repeated(40.0, 10.0), 1);
    assert_eq!(repeated(41.0, 10.0), 0);
    assert_eq!(repeated(40.0, 11.0), 0);
    // With power in proportion to speed it burns differently.
    let mut plan = Plan::new("burnt");
    burn(&mut plan, L_SHAPE, 40.0, 10.0);
    let first = plan.steps.len();
    burn(&mut plan, L_SHAPE, 40.0, 10.0);
    { plan.steps[first..].iter_mut() }.for_each(|step| step.feed = Some(20.0));
    assert_eq!(tidied(&plan, &once()).1.repeated, 0);
}

#[test]
fn duplicate_line_is_kept_if_its_travel_is_unknown() {
    // In turn: a slanted descent, a slanted lift, a wait at the start, a lift along a curve.
    type Change = fn(&mut Vec<Step>, usize);
    let changes: [Change; 4] = [
        |steps, second| {
            steps.remove(second);
        },
        |steps, second| {
            if let Action::Move { to, .. } = &mut steps[second + 6].action {
                to[0] += 5.0;
            }
        },
        |steps, second| {
            let wait = Step::new(Action::Wait(500), Origin::NONE);
            steps.insert(second + 3, wait);
        },
        |steps, second| {
            if let Action::Move { by, .. } = &mut steps[second + 6].action {
                *by = Travel::Joints;
            }
        },
    ];
    let plan = pen(&[L_SHAPE, L_SHAPE, FAR_LINE]);
    let second = pen(&[L_SHAPE]).steps.len();
    assert_eq!(tidied(&plan, &once()).1.repeated, 1);
    for (nth, change) in changes.into_iter().enumerate() {
        let mut plan = plan.clone();
        change(&mut plan.steps, second);
        let before = plan.clone();
        assert_eq!(plan.tidy(&once()).repeated, 0, "{nth}");
        assert_eq!(plan, before, "{nth}");
    }
    // A plan that switches the laser separately is not touched.
    let mut plan = pen(&[L_SHAPE, L_SHAPE]);
    plan.steps
        .insert(0, Step::new(Action::Laser(true), Origin::NONE));
    assert_eq!(tidied(&plan, &Tidy::default()).0, plan);
}

#[test]
fn lines_that_nearly_meet_are_joined() {
    let on = [[220.05, 10.0, 0.0], [230.0, 10.0, 0.0]];
    let merge = Tidy {
        merge: 0.1,
        ..once()
    };
    let (plan, found) = tidied(&pen(&[L_SHAPE, &on]), &merge);
    assert_eq!(found.joined, 1);
    let (down, up) = (
        [200.0, 0.0, TRAVEL_HEIGHT, 0.0],
        [230.0, 10.0, TRAVEL_HEIGHT, 0.0],
    );
    let moves: Vec<_> = { plan.steps.iter() }
        .filter_map(|step| match step.action {
            Action::Move { to, .. } => Some(to),
            _ => None,
        })
        .collect();
    assert_eq!(moves, [down, up]);
    // The speed is set once, so the pen does not have to stop at the joint.
    let speeds = plan.steps.iter().filter(|step| sets_speed(&step.action));
    assert_eq!(speeds.count(), 2);
    let apart = [[220.2, 10.0, 0.0], [230.0, 10.0, 0.0]];
    assert_eq!(tidied(&pen(&[L_SHAPE, &apart]), &merge).1.joined, 0);
    // A point drilled between the two lines stays.
    let mut plan = pen(&[L_SHAPE]);
    draw(&mut plan, &[[250.0, 0.0, 0.0]], 20.0);
    draw(&mut plan, &on, 20.0);
    assert_eq!(tidied(&plan, &merge).1.joined, 0);
    // A zero-length burn stays too.
    let mut plan = Plan::new("burnt");
    burn(&mut plan, L_SHAPE, 40.0, 10.0);
    burn(&mut plan, &[[250.0, 0.0, 0.0]; 2], 60.0, 10.0);
    burn(&mut plan, &on, 40.0, 10.0);
    let (left, found) = tidied(&plan, &merge);
    assert_eq!((found.joined, left), (0, plan));
    // The second line is weaker.
    let mut plan = Plan::new("burnt");
    burn(&mut plan, L_SHAPE, 40.0, 10.0);
    burn(&mut plan, &on, 30.0, 10.0);
    assert_eq!(tidied(&plan, &merge).1.joined, 0);
    burn(
        &mut plan,
        &[[230.0, 10.0, 0.0], [240.0, 0.0, 0.0]],
        30.0,
        10.0,
    );
    assert_eq!(tidied(&plan, &merge).1.joined, 1);
}

#[test]
fn collinear_points_are_dropped_between_setting_changes() {
    let thin = Tidy {
        merge: 0.0,
        dedupe: false,
        simplify: 0.02,
    };
    let straight: Vec<[f32; 3]> = (0..100)
        .map(|nth| {
            [
                200.0 + nth as f32 * 0.5,
                if nth % 2 == 0 { 0.0 } else { 0.01 },
                0.0,
            ]
        })
        .collect();
    let (plan, _) = tidied(&pen(&[&straight]), &thin);
    assert_eq!(plan.steps.len(), pen(&[&straight[..2]]).steps.len());
    // In z a ramp is straight, but a step is not.
    let ramp: Vec<[f32; 3]> = { straight.iter().enumerate() }
        .map(|(nth, [x, y, _])| [*x, *y, -0.01 * nth as f32])
        .collect();
    let (plan, _) = tidied(&pen(&[&ramp]), &thin);
    assert_eq!(plan.steps.len(), pen(&[&ramp[..2]]).steps.len());
    let mut plan = Plan::new("burnt");
    burn(&mut plan, &straight[..50], 40.0, 10.0);
    for to in &straight[50..] {
        let (to, power) = (*to, 30.0);
        plan.push(Action::Burn { to, power }, Origin::NONE);
    }
    let (plan, _) = tidied(&plan, &thin);
    let powers: Vec<f32> = { plan.steps.iter() }
        .filter_map(|step| match step.action {
            Action::Burn { power, .. } => Some(power),
            _ => None,
        })
        .collect();
    assert_eq!(powers, [0.0, 40.0, 30.0]);
}

/// Distance between samples, mm.
const SAMPLE_DISTANCE: f64 = 0.2;

/// Samples of everything marked, each with its kind. A pen marks wherever it touches the surface.
fn marked(plan: &Plan) -> Vec<(u32, [f64; 2])> {
    let burns = plan.steps.iter().any(|step| step.action.is_of_a_laser());
    let (mut at, mut speed, mut all): (Option<Point>, f32, Vec<_>) = (None, 0.0, Vec::new());
    for step in &plan.steps {
        if let Action::Command(command) = &step.action
            && let Set::CpParams(params) = **command
        {
            speed = params.junction_vel;
        }
        let Some(to) = step.action.target().map(wide) else {
            continue;
        };
        let kind = match step.action {
            Action::Burn { power, .. } => (power > 0.0).then_some((100.0 * power + speed) as u32),
            _ => (!burns).then_some(0),
        };
        if let (Some(kind), Some(from)) = (kind, at) {
            let count = (distance(from, to) / SAMPLE_DISTANCE).ceil().max(1.0);
            for nth in 0..=count as u32 {
                let share = f64::from(nth) / count;
                let [x, y, z] =
                    [0, 1, 2].map(|axis: usize| from[axis] + share * (to[axis] - from[axis]));
                if burns || z <= 0.01 {
                    all.push((kind, [x, y]));
                }
            }
        }
        at = Some(to);
    }
    all
}

/// Largest distance of a sample in `some` from the nearest of the same kind in `others`.
fn largest_deviation(some: &[(u32, [f64; 2])], others: &[(u32, [f64; 2])]) -> f64 {
    let nearest = |(kind, [x, y]): &(u32, [f64; 2])| {
        let alike = others.iter().filter(|(other, _)| other == kind);
        let far = alike.map(|(_, [to_x, to_y])| libm::hypot(to_x - x, to_y - y));
        far.fold(f64::INFINITY, f64::min)
    };
    some.iter().map(nearest).fold(0.0, f64::max)
}

/// Lines over few points, so that many are duplicates and many nearly meet.
fn lines() -> impl Strategy<Value = Vec<(Vec<[f32; 3]>, bool)>> {
    let place = (0..3_i8, 0..3_i8, 0..3_i8).prop_map(|(x, y, off)| {
        [
            200.0 + 4.0 * f32::from(x) + 0.07 * f32::from(off),
            4.0 * f32::from(y),
            0.0,
        ]
    });
    let line = (prop::collection::vec(place, 2..5), any::<bool>());
    prop::collection::vec(line, 1..8).prop_map(|mut lines| {
        let again: Vec<_> = { lines.iter().step_by(2) }
            .map(|(line, strong)| (reversed(line), *strong))
            .collect();
        lines.extend(again);
        lines
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn marks_stay_within_merge_and_simplify(lines in lines(), laser in any::<bool>()) {
        let mut plan = Plan::new("any");
        for (line, strong) in &lines {
            match (laser, strong) {
                (false, _) => draw(&mut plan, line, 20.0),
                (true, true) => burn(&mut plan, line, 80.0, 10.0),
                (true, false) => burn(&mut plan, line, 30.0, 15.0),
            }
        }
        let tidy = Tidy { merge: 0.1, dedupe: true, simplify: 0.05 };
        let (left, _) = tidied(&plan, &tidy);
        prop_assert!(left.steps.len() <= plan.steps.len());
        let (before, after) = (marked(&plan), marked(&left));
        let most = tidy.merge + tidy.simplify + SAMPLE_DISTANCE;
        prop_assert!(largest_deviation(&after, &before) <= most, "{left:?}");
        prop_assert!(largest_deviation(&before, &after) <= most, "{left:?}");
    }
}
