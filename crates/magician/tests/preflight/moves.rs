//! Single moves on the virtual arm: moves that pass the check raise no alarm, and refused ones
//! would have raised one. Random starts, tools, jump heights and targets.

use magician::commands::{ClearAlarmsState, EndEffectorParams, Pose, PtpCmd, PtpJump2Params};
use magician::preflight::{Preflight, Readings};
use magician::protocol::PtpMode;
use magician::{Limits, Set};
use magician_motion::ArmModel;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use crate::bench::LoneArm;

const CASES: u32 = 20_000;

#[derive(Clone, Debug)]
struct Case {
    start: [f32; 4],
    tool: [f32; 3],
    heights: [f32; 3],
    mode: u8,
    numbers: [f32; 4],
}

fn joints() -> impl Strategy<Value = [f32; 4]> {
    let Limits { j1, j2, j3, j4, .. } = ArmModel::MAGICIAN.limits;
    let range = |range: magician_motion::Range| range.min as f32..range.max as f32;
    (range(j1), range(j2), range(j3), range(j4)).prop_map(|(a, b, c, d)| [a, b, c, d])
}

fn case() -> impl Strategy<Value = Case> {
    let tool = prop_oneof![
        Just([0.0; 3]),
        Just([59.7, 0.0, 0.0]),
        (-20f32..80.0, -30f32..30.0, -40f32..60.0).prop_map(|(x, y, z)| [x, y, z]),
    ];
    let heights = (0f32..60.0, 0f32..60.0, -50f32..170.0).prop_map(|(a, b, z)| [a, b, z]);
    let pose = (
        -330f32..330.0,
        -330f32..330.0,
        -150f32..175.0,
        -180f32..180.0,
    )
        .prop_map(|(x, y, z, r)| [x, y, z, r]);
    let little = (-60f32..60.0, -60f32..60.0, -60f32..60.0, -60f32..60.0)
        .prop_map(|(x, y, z, r)| [x, y, z, r]);
    let around = (-160f32..160.0, -20f32..110.0, -30f32..110.0, -170f32..170.0)
        .prop_map(|(a, b, c, d)| [a, b, c, d]);
    let command = prop_oneof![
        (0u8..3, pose.clone()),
        (3u8..6, around),
        (6u8..9, little),
        (Just(9u8), pose),
    ];
    (joints(), tool, heights, command).prop_map(|(start, tool, heights, (mode, numbers))| Case {
        start,
        tool,
        heights,
        mode,
        numbers,
    })
}

fn ptp(mode: PtpMode, [x, y, z, r]: [f32; 4]) -> PtpCmd {
    PtpCmd {
        ptp_mode: mode,
        x,
        y,
        z,
        r,
    }
}

#[test]
fn what_passes_raises_no_alarm_and_what_is_refused_would() {
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let (mut reachable, mut refused, mut far) = (0, 0, 0);
    let mut through = Vec::new();
    for _ in 0..CASES {
        let case = case().new_tree(&mut runner).unwrap().current();
        let mut bench = LoneArm::new();
        let [x_bias, y_bias, z_bias] = case.tool;
        let tool = EndEffectorParams {
            x_bias,
            y_bias,
            z_bias,
        };
        let [start_jump_height, end_jump_height, z_limit] = case.heights;
        let jump = PtpJump2Params {
            start_jump_height,
            end_jump_height,
            z_limit,
        };
        bench.set(&tool);
        bench.set(&jump);
        bench.set(&ptp(PtpMode::MovjAngle, case.start));
        if bench.alarmed() {
            bench.set(&ClearAlarmsState {});
            continue;
        }
        let command = ptp(PtpMode::from(case.mode), case.numbers);
        let mut readings = Readings::default();
        readings.pose = Some(bench.get());
        (readings.settings.tool, readings.settings.ptp_jump2) = (tool, jump);
        let mut check = Preflight::new(&readings);
        let passes = check.check(&Set::from(command)).is_ok();
        bench.set(&command);
        match (passes, bench.alarmed()) {
            (true, true) => through.push(case),
            (true, false) => reachable += 1,
            (false, false) => {
                reachable += 1;
                refused += 1;
            }
            (false, true) => far += 1,
        }
        if passes && through.is_empty() {
            let pose = bench.get::<Pose>();
            let end = check.arm().expect("it is known").pose;
            let off = (f64::from(pose.x) - end.x).abs() + (f64::from(pose.z) - end.z).abs();
            assert!(off < 1e-3, "the check believes the arm elsewhere");
        }
    }
    assert!(
        through.is_empty(),
        "{} pass: {:?}",
        through.len(),
        through.first()
    );
    assert!(1000 * refused <= reachable, "{refused} of {reachable}");
    assert!(reachable > 2000 && far > 2000, "{reachable} {far}");
}
