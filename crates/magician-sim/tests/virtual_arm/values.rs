//! Values read back as they were set, bit for bit; before a set they are those of the profile.

use super::arm;
use super::arm::{TestArm, arm, arm_with, running_arm};
use magician_motion::Ceilings;
use magician_motion::ToolBias;
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, FieldType, Flag, IoFunction, Row, TABLE, Text};
use magician_sim::{Controller, Event, ExternalEvent, Profile, Scenario, World};

/// Bytes that are unnatural values: NaN payloads, signalling NaNs and subnormals among them.
fn pattern(count: usize, seed: u8) -> Vec<u8> {
    let byte = |at: usize| {
        (at as u8)
            .wrapping_mul(37)
            .wrapping_add(seed.wrapping_mul(91))
            ^ 0xA5
    };
    (0..count).map(byte).collect()
}

/// Rows whose value is exactly the content of a set.
fn params() -> impl Iterator<Item = &'static Row> {
    TABLE.iter().filter(|row| match (row.value, row.set) {
        (Some(value), Some(set)) => value.name == set.name,
        _ => false,
    })
}

/// Parameters for a row: arbitrary bits for fixed layouts, letters for texts, preceded by an EIO
/// address if there is one.
fn sample(row: &Row, seed: u8) -> Vec<u8> {
    let info = row.set.unwrap();
    let mut bytes = match info.fields {
        [field] if field.ty == FieldType::Text => {
            let mut text = vec![b'a' + seed % 26; 5 + usize::from(seed % 11)];
            text.push(0);
            text
        }
        _ => pattern(info.size().expect("fixed"), seed),
    };
    if is_pin(row) {
        bytes[0] = 1 + seed % 20;
    }
    bytes
}

fn is_pin(row: &Row) -> bool {
    matches!(row.query, Some(query) if !query.fields.is_empty())
}

#[test]
fn every_parameter_set_reads_back_as_it_was_set() {
    let mut seen = 0;
    for row in params() {
        for (seed, queued) in [(3, false), (8, true), (200, false), (251, true)] {
            if queued && !row.queueable {
                continue;
            }
            // High ceilings, so that these values are stored unchanged.
            let mut bench = arm_with(|profile| {
                profile.ceilings = Ceilings {
                    joint_velocity: [f64::MAX; 4],
                    joint_acceleration: f64::MAX,
                    linear_velocity: f64::MAX,
                    linear_acceleration: f64::MAX,
                    rotation_velocity: f64::MAX,
                    rotation_acceleration: f64::MAX,
                };
            });
            bench.start();
            let sent = sample(row, seed);
            let ctrl = if queued { Ctrl::QUEUED } else { Ctrl::SET };
            let reply = bench.frame(row.id, ctrl, &sent);
            assert_eq!(reply.frame().params().len(), if queued { 8 } else { 0 });
            let query: &[u8] = if is_pin(row) { &sent[..1] } else { &[] };
            let read = bench.frame(row.id, Ctrl::GET, query);
            assert_eq!(read.frame().params(), sent, "{} {}", row.id, row.name);
            let read = bench.frame(row.id, Ctrl::GET, &[]);
            assert_eq!(read.frame().params(), sent, "the pin addressed last");
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen} round trips");
}

#[test]
fn every_readable_command_answers_with_its_own_size() {
    for row in TABLE {
        let Some(value) = row.value else { continue };
        let mut bench = arm();
        let query = row.query.map_or(0, |query| query.size().unwrap_or(0));
        let reply = bench.frame(row.id, Ctrl::GET, &pattern(query, 1));
        if let Some(size) = value.size() {
            assert_eq!(reply.frame().params().len(), size, "{}", row.name);
        }
        assert!(
            value.normalise(reply.frame().params().len()).is_ok(),
            "{}",
            row.name
        );
    }
}

#[test]
fn every_writable_command_is_answered_at_once_and_finishes_when_queued() {
    for row in TABLE {
        let Some(set) = row.set else { continue };
        let mut bench = running_arm();
        let params = vec![0; set.size().unwrap_or(set.min_size())];
        let reply = bench.frame(row.id, Ctrl::SET, &params);
        assert_eq!(reply.frame().params(), [0u8; 0], "{}", row.name);
        if row.steers_queue() {
            continue;
        }
        let mut bench = running_arm();
        let reply = bench.frame(row.id, Ctrl::QUEUED, &params);
        assert_eq!(
            reply.frame().params(),
            [1, 0, 0, 0, 0, 0, 0, 0],
            "{}",
            row.name
        );
        bench.rest();
        assert_eq!(bench.current_index(), 1, "{}", row.name);
    }
}

#[test]
fn set_only_commands_with_rw_0_are_answered_empty_and_do_nothing() {
    let mut bench = running_arm();
    for row in TABLE.iter().filter(|row| row.value.is_none()) {
        let params = vec![0; row.set.and_then(|set| set.size()).unwrap_or(21)];
        let reply = bench.frame(row.id, Ctrl::GET, &params);
        assert_eq!(reply.frame().params(), [0u8; 0], "{}", row.name);
    }
    assert!(!bench.state().moving);
    assert!(bench.alarms().is_empty());
}

#[test]
fn read_only_commands_answer_whatever_ctrl_says() {
    for row in TABLE.iter().filter(|row| row.set.is_none()) {
        let mut bench = arm();
        let query = vec![0; row.query.map_or(0, |query| query.size().unwrap_or(0))];
        let plain = bench.frame(row.id, Ctrl::GET, &query);
        for ctrl in [1, 2, 3, 0x10, 0x53] {
            let reply = bench.frame(row.id, Ctrl(ctrl), &query);
            assert_eq!(
                reply.frame().params(),
                plain.frame().params(),
                "{}",
                row.name
            );
        }
    }
}

#[test]
fn defaults_are_the_models() {
    let mut bench = arm();
    let ptp = bench.get::<PtpJointParams>();
    assert_eq!((ptp.velocity, ptp.acceleration), ([200.0; 4], [200.0; 4]));
    let space = bench.get::<PtpCoordinateParams>();
    assert_eq!((space.xyz_velocity, space.r_velocity), (200.0, 100.0));
    assert_eq!(
        (space.xyz_acceleration, space.r_acceleration),
        (200.0, 100.0)
    );
    let ratio = bench.get::<PtpCommonParams>();
    assert_eq!(
        (ratio.velocity_ratio, ratio.acceleration_ratio),
        (50.0, 50.0)
    );
    let jump = bench.get::<PtpJumpParams>();
    assert_eq!((jump.jump_height, jump.z_limit), (20.0, 100.0));
    let jump2 = bench.get::<PtpJump2Params>();
    assert_eq!(
        (jump2.start_jump_height, jump2.end_jump_height),
        (20.0, 20.0)
    );
    let jog = bench.get::<JogJointParams>();
    assert_eq!(jog.velocity, [15.0, 15.0, 15.0, 30.0]);
    assert_eq!(jog.acceleration, [50.0; 4]);
    let cp = bench.get::<CpParams>();
    assert_eq!(
        (cp.plan_acc, cp.junction_vel, cp.acc_or_period),
        (100.0, 100.0, 100.0)
    );
    let arc = bench.get::<ArcParams>();
    assert_eq!((arc.xyz_velocity, arc.r_acceleration), (200.0, 200.0));
    let arc = bench.get::<ArcCommonParams>();
    assert_eq!((arc.velocity_ratio, arc.acceleration_ratio), (100.0, 100.0));
    let bias = bench.get::<EndEffectorParams>();
    assert_eq!([bias.x_bias, bias.y_bias, bias.z_bias], [59.7, 0.0, 0.0]);
    let home = bench.get::<HomeParams>();
    assert_eq!(
        [home.x, home.y, home.z, home.r],
        [259.104_13, 0.0, -8.485_281, 0.0]
    );
    assert_eq!(bench.get::<UserParams>().params, [0.0; 8]);
    assert_eq!(bench.get::<PoseL>().pose_l, 0.0);
}

#[test]
fn setting_jump_also_sets_jump2() {
    let mut bench = arm();
    bench.set(&PtpJumpParams {
        jump_height: 7.0,
        z_limit: 66.0,
    });
    let jump2 = bench.get::<PtpJump2Params>();
    assert_eq!(
        [
            jump2.start_jump_height,
            jump2.end_jump_height,
            jump2.z_limit
        ],
        [7.0, 7.0, 66.0]
    );
    bench.set(&PtpJump2Params {
        start_jump_height: 1.0,
        ..jump2
    });
    assert_eq!(bench.get::<PtpJumpParams>().jump_height, 7.0);
}

#[test]
fn pins_start_at_nothing_and_a_get_without_address_is_pin_1() {
    let mut bench = arm();
    let read = bench.frame(131, Ctrl::GET, &[]);
    assert_eq!(read.frame().params(), [1, 0]);
    for address in [0, 21, 200, 255] {
        bench.set(&IoDo {
            address,
            level: Flag::ON,
        });
        assert_eq!(
            bench.frame(131, Ctrl::GET, &[address]).frame().params(),
            [address, 0]
        );
    }
}

#[test]
fn a_function_that_a_pin_lacks_is_stored_unless_the_profile_is_strict() {
    let pwm_on_a_switch = IoMultiplexing {
        address: 17,
        multiplex: IoFunction::Pwm,
    };
    let mut bench = arm();
    bench.set(&pwm_on_a_switch);
    assert_eq!(bench.frame(130, Ctrl::GET, &[17]).frame().params(), [17, 2]);
    assert!(
        bench
            .events()
            .iter()
            .any(|event| matches!(event, Event::NotSimulated { row } if row.id == 130))
    );
    let mut bench = arm_with(|profile| profile.io.strict = true);
    bench.set(&pwm_on_a_switch);
    assert_eq!(bench.frame(130, Ctrl::GET, &[17]).frame().params(), [17, 0]);
    bench.set(&IoMultiplexing {
        address: 4,
        multiplex: IoFunction::Pwm,
    });
    assert_eq!(bench.frame(130, Ctrl::GET, &[4]).frame().params(), [4, 2]);
}

#[test]
fn suction_takes_300_ms_and_the_gripper_500() {
    let mut bench = arm();
    bench.set(&arm::suck(true));
    assert!(
        bench.get::<EndEffectorSuctionCup>().is_sucked.is_on(),
        "reads as set"
    );
    bench.pass(299_999);
    assert!(!bench.state().suction.reached);
    bench.pass(1);
    assert!(bench.state().suction.reached);
    // Control off switches the pump off, whatever the second byte is.
    bench.frame(62, Ctrl::SET, &[0, 1]);
    assert!(!bench.state().suction.commanded && bench.state().suction.reached);
    bench.pass(300_000);
    assert!(!bench.state().suction.reached);
    assert_eq!(bench.frame(62, Ctrl::GET, &[]).frame().params(), [0, 1]);
    bench.set(&arm::grip(true));
    bench.pass(499_999);
    assert!(!bench.state().gripper.reached);
    bench.pass(1);
    assert!(bench.state().gripper.reached);
}

#[test]
fn texts_are_bounded_and_answered_with_one_nul() {
    let mut bench = arm();
    bench.frame(1, Ctrl::SET, &[b'x'; 200]);
    let name = bench.frame(1, Ctrl::GET, &[]);
    assert_eq!(name.frame().params(), [&[b'x'; 64][..], &[0]].concat());
    bench.frame(0, Ctrl::SET, &[b'y'; 200]);
    assert_eq!(bench.frame(0, Ctrl::GET, &[]).frame().params().len(), 24);
    bench.frame(1, Ctrl::SET, b"Hello\0after");
    assert_eq!(bench.frame(1, Ctrl::GET, &[]).frame().params(), b"Hello\0");
    // The longest text that fits a frame, for texts without a bound.
    bench.frame(152, Ctrl::SET, &[b'p'; 248]);
    assert_eq!(
        bench.frame(152, Ctrl::GET, &[]).frame().params(),
        [b'p'; 248]
    );
}

#[test]
fn identity_is_the_profiles() {
    let mut bench = arm_with(|profile| profile.identity.name = "Ada".into());
    assert_eq!(
        bench.get::<DeviceName>().device_name,
        Text::new("Ada").unwrap()
    );
    assert_eq!(bench.frame(2, Ctrl::GET, &[]).frame().params(), [3, 6, 14]);
    let id = bench.get::<DeviceId>().device_id;
    let mut other = arm_with(|profile| profile.identity.device_id_seed = 2);
    assert_ne!(other.get::<DeviceId>().device_id, id);
    assert_eq!(arm().get::<DeviceId>().device_id, id);
}

#[test]
fn device_time_is_in_ms_and_wraps() {
    let mut bench = arm();
    bench.pass(1_234_567);
    assert_eq!(bench.get::<DeviceTime>().g_systick, 1234);
    bench.arm.advance(arm::at((1 << 32) * 1000 + 5000));
    assert_eq!(bench.get::<DeviceTime>().g_systick, 5);
}

#[test]
fn what_is_not_simulated_says_so_and_finishes() {
    let mut bench = running_arm();
    bench.events();
    let row = Row::with_id(32).unwrap();
    let params = vec![0; row.set.unwrap().size().unwrap()];
    bench.frame(32, Ctrl::QUEUED, &params);
    let told = bench
        .events()
        .into_iter()
        .any(|event| matches!(event, Event::NotSimulated { row } if row.id == 32));
    assert!(told, "{}", row.name);
    assert_eq!(bench.current_index(), 1);
}

/// An arm keeps its tool: a host's choice lasts until a reset, that of the profile, the scenario or
/// the caller forever.
#[test]
fn the_tool_at_power_up_is_the_one_that_was_chosen() {
    let bias = |arm: Controller| {
        let mut bench = TestArm { arm };
        let mut x = || bench.get::<EndEffectorParams>().x_bias;
        let first = x();
        bench.set(&EndEffectorParams {
            x_bias: 5.0,
            y_bias: 0.0,
            z_bias: 0.0,
        });
        bench.arm.inject(ExternalEvent::Reset);
        (first, bench.get::<EndEffectorParams>().x_bias)
    };
    let in_world = |text: &str| {
        let world = World::from_scenario(&Scenario::from_toml(text).unwrap());
        Controller::in_world(Profile::continuous(), world)
    };
    assert_eq!(bias(Controller::default()), (59.7, 59.7));
    assert_eq!(
        bias(Controller::default().with_tool(ToolBias::NONE)),
        (0.0, 0.0)
    );
    let mut profile = Profile::continuous();
    profile.power_up.tool = ToolBias::PEN;
    assert_eq!(bias(Controller::new(profile)), (61.0, 61.0));
    assert_eq!(bias(in_world("[tool]\nkind = \"laser\"")), (70.0, 70.0));
    assert_eq!(bias(in_world("[tool]\nkind = \"none\"")), (0.0, 0.0));
    assert_eq!(bias(in_world("[table]\nheight = -60")), (59.7, 59.7));
    let chosen = in_world("[tool]\nkind = \"laser\"").with_tool(ToolBias::PEN);
    assert_eq!(bias(chosen), (61.0, 61.0));
}
