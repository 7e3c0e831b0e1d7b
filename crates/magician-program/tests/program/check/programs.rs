//! Random plans: no check panics, and an accepted plan raises no alarm.

use magician::build;
use magician::preflight::{Guards, Preflight};
use magician::protocol::{CpMode, PtpMode, RailVersion, Row, TABLE};
use magician::{Set, ToolBias, commands};
use magician_program::{Action, Grip, Origin, Plan, Tool, Travel, check};
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::RngSeed;

use super::bench::LoneArm;

/// Number of cases with a fixed seed; `PROPTEST_CASES` sets another number with random seeds.
pub(crate) fn cases(count: u32) -> ProptestConfig {
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => config,
        None => ProptestConfig {
            cases: count,
            rng_seed: RngSeed::Fixed(0xD0B07),
            ..config
        },
    }
}

fn travel() -> impl Strategy<Value = Travel> {
    select(vec![Travel::Joints, Travel::Line, Travel::Jump])
}

/// Poses that are mostly within reach.
fn pose() -> impl Strategy<Value = [f32; 4]> {
    prop_oneof![
        3 => (170.0f32..280.0, -120.0f32..120.0, -50.0f32..80.0, -60.0f32..60.0),
        1 => (-340.0f32..340.0, -340.0f32..340.0, -160.0f32..180.0, -180.0f32..180.0),
    ]
    .prop_map(|(x, y, z, r)| [x, y, z, r])
}

fn point() -> impl Strategy<Value = [f32; 3]> {
    pose().prop_map(|[x, y, z, _]| [x, y, z])
}

fn joints() -> impl Strategy<Value = [f32; 4]> {
    (
        -140.0f32..140.0,
        -10.0f32..95.0,
        -20.0f32..95.0,
        -155.0f32..155.0,
    )
        .prop_map(|(a, b, c, d)| [a, b, c, d])
}

fn shift() -> impl Strategy<Value = [f32; 4]> {
    prop::array::uniform4(-40.0f32..40.0)
}

fn setting() -> impl Strategy<Value = Set> {
    let speed = || 5.0f32..500.0;
    prop_oneof![
        (1.0f32..120.0, 1.0f32..120.0).prop_map(|(a, b)| build::speed(a, b)),
        (speed(), speed()).prop_map(|(a, b)| build::line_speed(a, b)),
        (speed(), speed()).prop_map(|(a, b)| build::path_speed(a, b)),
        (speed(), speed()).prop_map(|(a, b)| build::arc_speed(a, b)),
        (speed(), speed()).prop_map(|(a, b)| build::joint_speed([a; 4], [b; 4])),
        (0.0f32..60.0, -50.0f32..170.0).prop_map(|(a, b)| build::jump_height(a, b)),
        (0.0f64..80.0, -20.0f64..20.0, -20.0f64..40.0)
            .prop_map(|(x, y, z)| build::tool(ToolBias::new(x, y, z))),
        any::<bool>().prop_map(|on| build::rail(on, RailVersion::V1)),
        (-200.0f32..200.0).prop_map(build::rail_by),
    ]
}

/// Any command that ends by itself, with any bytes: most are refused.
fn raw() -> impl Strategy<Value = Set> {
    let ends = |row: &&'static Row| row.queueable && row.set.is_some() && row.name != "TRIGCmd";
    let rows: Vec<&'static Row> = TABLE.iter().filter(ends).collect();
    let numbers = prop::collection::vec(prop_oneof![-50.0f32..300.0, 0.0f32..2.0], 16);
    let small = prop::collection::vec(0u8..3, 64);
    (select(rows), numbers, small, any::<bool>()).prop_filter_map(
        "no form",
        |(row, numbers, small, floats)| {
            let layout = row.set?;
            let count = layout.size().unwrap_or(layout.min_size() + 4);
            let wide: Vec<u8> = numbers.into_iter().flat_map(f32::to_le_bytes).collect();
            // A mode, then floats; or flags and bytes.
            let bytes = if floats {
                [&small[..1], &wide[..]].concat()
            } else {
                small
            };
            Set::decode(row.id, bytes.get(..count)?).ok()
        },
    )
}

fn action() -> impl Strategy<Value = Action> {
    prop_oneof![
        4 => (pose(), travel()).prop_map(|(to, by)| Action::Move { to, by }),
        2 => (joints(), travel()).prop_map(|(to, by)| Action::Joints { to, by }),
        2 => (shift(), any::<bool>()).prop_map(|(by, line)| Action::Shift { by, line }),
        2 => (pose(), pose()).prop_map(|(via, to)| Action::Arc { via, to }),
        4 => point().prop_map(|to| Action::Path { to }),
        3 => (point(), 0.0f32..100.0).prop_map(|(to, power)| Action::Burn { to, power }),
        2 => shift().prop_map(|[x, y, z, _]| {
            Action::from(Set::from(commands::CpCmd { cp_mode: CpMode::Relative, x, y, z, velocity_or_power: 0.0 }))
        }),
        1 => (pose(), pose(), 0u32..3).prop_map(|(cir_point, to_point, count)| {
            Action::from(Set::from(commands::CircleCmd { cir_point, to_point, count }))
        }),
        1 => pose().prop_map(|[x, y, z, r]| {
            Action::from(Set::from(commands::PtpCmd { ptp_mode: PtpMode::JumpMovlXyz, x, y, z, r }))
        }),
        1 => any::<bool>().prop_map(Action::Suction),
        1 => select(vec![Grip::Off, Grip::Open, Grip::Close]).prop_map(Action::Gripper),
        1 => any::<bool>().prop_map(Action::Laser),
        1 => (0u32..3000).prop_map(Action::Wait),
        1 => Just(Action::Home),
        3 => setting().prop_map(Action::from),
        2 => raw().prop_map(Action::from),
    ]
}

/// Plans of all commands, some of them impossible.
pub(crate) fn plan() -> impl Strategy<Value = Plan> {
    let tools: Vec<Option<Tool>> = Tool::NAMED_TOOLS
        .iter()
        .map(|(_, tool)| Some(*tool))
        .chain([None])
        .collect();
    (select(tools), prop::collection::vec(action(), 1..40)).prop_map(|(tool, actions)| {
        let mut plan = Plan::new("chance");
        plan.tool = tool;
        for action in actions {
            plan.push(action, Origin::NONE);
        }
        plan
    })
}

/// The plan without its refused steps, with the laser off at the end.
pub(crate) fn accepted(mut plan: Plan, start: &Preflight) -> Plan {
    let report = check(&plan, start);
    let refused = |at: &usize| {
        report
            .refused_steps
            .iter()
            .any(|refused_step| refused_step.step == *at)
    };
    let steps = plan.steps.iter().enumerate();
    let steps = steps
        .filter(|(at, _)| !refused(at))
        .map(|(_, step)| step.clone())
        .collect();
    plan.steps = steps;
    plan.push(Action::Laser(false), Origin::NONE);
    plan
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn accepted_plan_raises_no_alarm_and_takes_the_checked_time(plan in plan()) {
        let mut bench = LoneArm::new();
        let start = Preflight::new(&bench.readings());
        let plan = accepted(plan, &start);
        let report = check(&plan, &start);
        prop_assert!(report.is_good(), "{:?}", report.refused_steps);
        let done = bench.run_plan(&plan);
        prop_assert_eq!(&done.alarm, &None);
        prop_assert!(done.finished, "{:?}", done);
        if let Some(time) = report.time {
            let told = time.as_micros() as u64;
            prop_assert!(told.abs_diff(done.took) * 1000 <= done.took.max(20_000), "{} {:?}", told, done);
        }
    }

    #[test]
    fn numbers_of_any_size_are_refused_and_no_check_panics(
        mut plan in plan(),
        wild in prop::collection::vec((any::<usize>(), any::<[u32; 4]>()), 1..6),
        guarded in any::<bool>(),
    ) {
        for (at, bits) in wild {
            let at = at % plan.steps.len();
            let to = bits.map(f32::from_bits);
            plan.steps[at].action = Action::Move { to, by: Travel::Line };
        }
        let mut bench = LoneArm::new();
        let guards = if guarded { Guards::ALL } else { Guards::NONE };
        let start = Preflight::new(&bench.readings()).guards(guards);
        let report = check(&plan, &start);
        prop_assert_eq!(report.steps, plan.steps.len());
        prop_assert_eq!(report.counts.values().sum::<usize>(), report.steps);
        prop_assert!(report.drawn >= 0.0 && report.travelled >= 0.0);
    }
}
