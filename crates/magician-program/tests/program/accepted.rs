//! A plan that passes the check runs on a virtual arm: without an alarm, in the reported time,
//! never below the surface.

use std::time::Duration;

use magician_program::artwork::{Layout, Marking, Order};
use magician_program::formats::playback::Playback;
use magician_program::raster::{Engrave, Grid, Tone};
use magician_program::rehearse::{RehearseOptions, rehearse, stage, start_of};
use magician_program::{
    Action, Artwork, Continuation, Origin, Plan, Raster, Stroke, Surface, Tool, Travel, check,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Largest depth of motion below the surface, mm: coordinates have 32 bits.
const DEPTH_TOLERANCE: f64 = 1e-3;

/// Height of the tool above a level surface from which a first joint move stays above it, mm.
const CLEAR_HEIGHT: f64 = 3.0;
/// Largest distance that it may lead outwards, up a slope, before it rises, mm.
const MAX_OUTWARD_LEAD: f64 = 30.0;

fn options() -> RehearseOptions {
    RehearseOptions::default().watch(Duration::from_millis(20))
}

/// True if the check accepts the plan; the arm must then run it.
fn runs_if_accepted(plan: &Plan) -> Result<bool, TestCaseError> {
    let start = start_of(&stage(plan, &options()).unwrap());
    let report = check(plan, &start);
    if !report.is_good() {
        return Ok(false);
    }
    let done = rehearse(plan, &options()).unwrap();
    prop_assert!(done.is_good(), "{:?} {:?}", done.alarms, done.log);
    if let Some(time) = report.time {
        prop_assert_eq!(time, done.time);
    }
    let over = |surface: Surface, [x, y, z]: [f64; 3]| z - surface.at([x, y]);
    let begins = start.arm().map(|at| [at.pose.x, at.pose.y, at.pose.z]);
    // If the stage leaves the tool inside a slope, it must first get out of it.
    if let (Some(surface), Some(begins)) = (plan.surface, begins)
        && over(surface, begins)
            >= CLEAR_HEIGHT + MAX_OUTWARD_LEAD * surface.slope[0].hypot(surface.slope[1])
    {
        for at in &done.way {
            let above = over(surface, *at);
            prop_assert!(
                above > -DEPTH_TOLERANCE,
                "{above} mm above the surface at {at:?}"
            );
        }
    }
    Ok(true)
}

/// Like `runs_if_accepted`, from any step on that allows it.
fn remainder_runs_if_accepted(plan: &Plan, share: f64) -> Result<(), TestCaseError> {
    let start = start_of(&stage(plan, &options()).unwrap());
    let step = (share * plan.steps.len() as f64) as usize;
    if let Ok(rest) = Continuation::from_step(plan, step, &start) {
        prop_assert_eq!(rest.plan.steps.len(), rest.steps.len());
        // The rest starts where the arm stood; another stage may place the arm elsewhere.
        let again = start_of(&stage(&rest.plan, &options()).unwrap());
        if again.arm() == start.arm() {
            prop_assert!(runs_if_accepted(&rest.plan)?, "from step {step}");
        }
    }
    Ok(())
}

fn surfaces() -> impl Strategy<Value = Surface> {
    let slope = || prop_oneof![2 => Just(0.0), 3 => -0.25..0.25];
    (-110.0..60.0, slope(), slope()).prop_map(|(height, x, y)| Surface {
        // About this high in front of the arm.
        height: height - 220.0 * x,
        slope: [x, y],
    })
}

fn drawings() -> impl Strategy<Value = Artwork> {
    let point = || [0.0..120.0, 0.0..90.0];
    let near = [-1e-5..1e-5, -1e-5..1e-5];
    let stroke = prop_oneof![
        4 => proptest::collection::vec(point(), 1..6),
        1 => (point(), near).prop_map(|([x, y], [a, b])| vec![[x, y], [x + a, y + b]]),
        1 => proptest::collection::vec(point(), 3..6).prop_map(|mut points| {
            points.push(points[0]);
            points
        }),
    ];
    proptest::collection::vec(stroke, 1..8).prop_map(|lines| Artwork {
        strokes: lines
            .into_iter()
            .map(|points| Stroke::new(points, Origin::NONE))
            .collect(),
        ..Artwork::default()
    })
}

fn markings() -> impl Strategy<Value = Marking> {
    let tool = prop_oneof![
        Just(Tool::Pen),
        Just(Tool::Laser),
        Just(Tool::Bias([65.0, 12.0, -4.0]))
    ];
    let r = proptest::option::of(-120.0_f32..120.0);
    (tool, 0.5..30.0, 5.0_f32..150.0, r, any::<bool>()).prop_map(|(tool, lift, speed, r, burns)| {
        Marking {
            tool,
            lift,
            speed,
            r,
            ..if burns {
                Marking::laser(60.0)
            } else {
                Marking::pen()
            }
        }
    })
}

fn layouts() -> impl Strategy<Value = Layout> {
    let at = proptest::option::of([-150.0..300.0, -250.0..250.0]);
    (surfaces(), 0.2..4.0, -180.0..180.0, at, any::<bool>()).prop_map(
        |(surface, scale, rotate, at, mirror)| Layout {
            scale,
            rotate,
            at,
            mirror,
            fit: true,
            ..Layout::on(surface)
        },
    )
}

fn images() -> impl Strategy<Value = Raster> {
    (1_usize..9, 1_usize..7).prop_flat_map(|(width, height)| {
        let grey = prop_oneof![2 => Just(255_u8), 1 => Just(0), 2 => any::<u8>()];
        proptest::collection::vec(grey, width * height).prop_map(move |grey| Raster {
            width,
            height,
            grey,
            ..Raster::default()
        })
    })
}

fn engravings() -> impl Strategy<Value = Engrave> {
    let tone = prop_oneof![
        Just(Tone::Grey),
        Just(Tone::Threshold(90)),
        Just(Tone::Dither)
    ];
    let overscan = prop_oneof![Just(None), Just(Some(0.0)), (0.0..8.0).prop_map(Some)];
    let flags = any::<[bool; 3]>();
    (tone, overscan, flags, 5.0..120.0, 0.3..9.0, 0.0..40.0).prop_map(
        |(tone, overscan, [invert, both, skip], speed, spacing, least)| {
            let mut engrave = Engrave::default();
            engrave.tone = tone;
            engrave.overscan = overscan;
            (engrave.invert, engrave.both_directions, engrave.white_skip) = (invert, both, skip);
            (engrave.speed, engrave.spacing) = (speed, spacing);
            engrave.power = [least, 100.0];
            engrave
        },
    )
}

/// Rows of a playback file: style, point, second point, pause, suction.
fn rows() -> impl Strategy<Value = String> {
    let point = || [150.0..300.0, -120.0..120.0, -40.0..120.0, -90.0..90.0];
    let row = (0_u8..4, point(), point(), 0_u8..3, any::<bool>());
    proptest::collection::vec(row, 1..12).prop_map(|rows| {
        let mut xml = String::from("<root>");
        for (nth, (style, first, second, pause, suction)) in rows.into_iter().enumerate() {
            xml += &format!("<row{nth}><item_0>{style}</item_0>");
            for (item, value) in (2..).zip(first.into_iter().chain(second)) {
                xml += &format!("<item_{item}>{value:.2}</item_{item}>");
            }
            let on = u8::from(suction);
            xml += &format!("<item_10>{pause}</item_10><item_12>{on}</item_12></row{nth}>");
        }
        xml + "</root>"
    })
}

/// The same cases in every run.
fn cases() -> ProptestConfig {
    ProptestConfig {
        rng_seed: RngSeed::Fixed(11),
        failure_persistence: None,
        ..ProptestConfig::with_cases(96)
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn accepted_drawing_is_drawn(
        mut drawing in drawings(),
        layout in layouts(),
        marking in markings(),
        share in 0.0..1.0,
        turn in prop_oneof![Just(0.0), -60.0..60.0],
    ) {
        drawing.put_in_order(&Order::default());
        let Ok(placed) = drawing.placed(&layout, &marking) else {
            return Ok(());
        };
        let plan = placed.plan(&marking);
        // A placed plan is within reach.
        let refused_steps = check(&plan, &start_of(&stage(&plan, &options()).unwrap())).refused_steps;
        prop_assert!(runs_if_accepted(&plan)?, "{refused_steps:?}");
        remainder_runs_if_accepted(&plan, share)?;
        if let Ok(turned) = plan.rotated(turn, [0.0, 0.0]) {
            runs_if_accepted(&turned)?;
        }
        let ends = plan.steps.last().and_then(|step| step.action.target()).unwrap().map(f64::from);
        let above = ends[2] - layout.surface.at([ends[0], ends[1]]);
        prop_assert!((above - marking.lift).abs() < DEPTH_TOLERANCE);
    }

    #[test]
    fn accepted_engraving_is_burnt(
        image in images(),
        engrave in engravings(),
        surface in surfaces(),
        size in [2.0..80.0, 2.0..60.0],
        centre in [180.0..280.0, -80.0..80.0],
        turn in -180.0..180.0,
        share in 0.0..1.0,
    ) {
        let grid = Grid::centred(size, centre, turn, false);
        let Ok(plan) = engrave.plan(&image, &grid, surface) else {
            return Ok(());
        };
        for step in &plan.steps {
            // The laser never burns without a stated power.
            prop_assert!(step.action != Action::Laser(true));
        }
        let start = start_of(&stage(&plan, &options()).unwrap());
        // A step left out may leave the laser on.
        if let Some(refused_step) = check(&plan, &start).refused_steps.first() {
            let kind = refused_step.error.kind();
            prop_assert_eq!(kind, magician::ErrorKind::Unreachable, "{}", refused_step.error);
        }
        if runs_if_accepted(&plan)? {
            remainder_runs_if_accepted(&plan, share)?;
        }
    }

    #[test]
    fn accepted_taught_program_is_played(xml in rows(), share in 0.0..1.0, times in 1_usize..3) {
        let mut plan = Playback::read(xml.as_bytes()).unwrap().to_plan().content;
        // A target out of reach would end most of them early.
        loop {
            let start = start_of(&stage(&plan, &options()).unwrap());
            let Some(first) = check(&plan, &start).refused_steps.first().map(|first| first.step) else {
                break;
            };
            plan.steps.remove(first);
        }
        let all = plan.repeated(times).unwrap();
        if runs_if_accepted(&all)? {
            remainder_runs_if_accepted(&all, share)?;
        }
        if let Ok(placed) = plan.placed_on(&magician_program::Pallet::grid(1, 2, [8.0, 8.0])) {
            runs_if_accepted(&placed)?;
        }
    }
}

#[test]
fn distant_lines_on_a_slope_are_left_and_approached_from_above() {
    let surface = Surface {
        height: -100.0,
        slope: [0.2, 0.15],
    };
    let strokes = [[0.0, 0.0], [110.0, 0.0], [0.0, 90.0], [110.0, 90.0]]
        .map(|[x, y]| Stroke::new(vec![[x, y], [x + 3.0, y + 2.0]], Origin::NONE));
    let drawing = Artwork {
        strokes: strokes.to_vec(),
        ..Artwork::default()
    };
    let pen = Marking::pen();
    let layout = Layout {
        fit: true,
        ..Layout::on(surface)
    };
    let plan = drawing.placed(&layout, &pen).unwrap().plan(&pen);
    let mut last: Option<[f64; 3]> = None;
    let mut far = 0;
    for step in &plan.steps {
        let Some([x, y, z]) = step.action.target().map(|to| to.map(f64::from)) else {
            continue;
        };
        let above = |[x, y, z]: [f64; 3]| z - surface.at([x, y]);
        let to = [x, y, z];
        if let Some(from) = last
            && (from[0] - x).hypot(from[1] - y) > 10.0
        {
            let by_line = matches!(
                step.action,
                Action::Move {
                    by: Travel::Line,
                    ..
                }
            );
            assert!(by_line && above(from).min(above(to)) > pen.lift - DEPTH_TOLERANCE);
            far += 1;
        }
        last = Some(to);
    }
    assert_eq!(far, 3);
}
