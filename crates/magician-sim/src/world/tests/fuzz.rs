//! Random calls in any order: no panic, no endless loop, and the same result twice.

use proptest::prelude::*;

use super::{Arm, SECOND, TimedPath};
use crate::Micros;
use crate::world::{JointState, ToolState};

const TEXT: &str = r#"
[tool]
kind = "TOOL"
[table]
height = -70
x = [100, 300]
[conveyor]
start = [180, -100]
direction = 75
length = 120
width = 50
height = -40
stepper = 0
[[sensor]]
kind = "infrared"
port = "GP1"
belt_at = 60
[[sensor]]
kind = "color"
port = "GP5"
at = [220, 60, -50]
[[object]]
name = "a"
size = [20, 20, 20]
at = [185, -80]
on = "belt"
[[object]]
name = "b"
size = [10, 10, 10]
at = [186, -79]
on = "a"
[[object]]
name = "c"
size = [25, 25, 15]
at = [220, 60]
[[object]]
name = "d"
size = [25, 25, 15]
at = [250, 60]
z = 10
[[input]]
address = 3
level = 1
at = 2
[[fault]]
kind = "cable"
index = 2
for = 1
"#;

#[derive(Clone, Debug)]
enum Told {
    Go([f64; 3], Micros, Micros),
    Wild(f64, Micros),
    ToolState(bool, bool, f64),
    Stepper(f64),
    Wait(Micros),
    Index(u64),
}

fn told() -> impl Strategy<Value = Told> {
    let place = [170.0..260.0_f64, -90.0..90.0_f64, -80.0..20.0_f64];
    let wild = prop_oneof![
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(-1e300),
        -400.0..400.0_f64
    ];
    prop_oneof![
        4 => (place, 1..3 * SECOND, 0..3 * SECOND).prop_map(|(to, lasting, cut)| Told::Go(to, lasting, cut.min(lasting))),
        1 => (wild, 0..SECOND).prop_map(|(angle, lasting)| Told::Wild(angle, lasting)),
        3 => (any::<bool>(), any::<bool>(), 0.0..120.0_f64).prop_map(|(one, two, power)| Told::ToolState(one, two, power)),
        2 => prop_oneof![-2e4..2e4_f64, Just(0.0), Just(1e300), Just(f64::NAN)].prop_map(Told::Stepper),
        1 => (0..5 * SECOND).prop_map(Told::Wait),
        1 => (0..4_u64).prop_map(Told::Index),
    ]
}

fn run(tool: &str, all: &[Told]) -> String {
    let mut arm = Arm::new(&TEXT.replace("TOOL", tool), [200.0, 0.0, 0.0, 0.0]);
    for told in all {
        match *told {
            Told::Go([x, y, z], lasting, cut) => arm.go_until([x, y, z, 0.0], lasting, cut),
            Told::Wild(angle, lasting) => {
                let at = |_| JointState {
                    joints: [angle; 4].into(),
                    rail: angle,
                };
                let path = TimedPath::new(arm.now, arm.now + lasting, &at);
                arm.world.begin(&path);
                arm.wait_until(path.to);
                arm.world.end(&path);
            }
            Told::ToolState(sucking, closed, laser) => arm.set_tool(ToolState {
                sucking,
                closed,
                laser,
            }),
            Told::Stepper(pulses) => arm.world.stepper(arm.now, 0, pulses),
            Told::Wait(time) => arm.wait_until(arm.now + time),
            Told::Index(index) => arm.world.index_started(arm.now, index),
        }
        arm.wait_until(arm.now);
        assert!(arm.world.next_event().is_none_or(|at| at > arm.now));
    }
    let places: Vec<_> = arm.look().objects().map(|object| object.place()).collect();
    format!("{places:?} {:?} {:?}", arm.happened, arm.world.drawing())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_telling_upsets_the_world(
        all in prop::collection::vec(told(), 1..25),
        tool in prop::sample::select(vec!["none", "suction", "gripper", "pen", "laser"]),
    ) {
        prop_assert_eq!(run(tool, &all), run(tool, &all));
    }
}
