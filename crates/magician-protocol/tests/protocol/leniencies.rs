//! Forms that known hosts and controllers send although a strict sender would not, by erratum.

use crate::material::{
    assert_single_note, fields, frame, notes, reencode_get, reencode_set, request,
};
use magician_protocol::commands::{
    AutoLeveling, CpCmd, CpLeCmd, DeviceVersion, EMotor, EMotorS, HhtTrigMode, PtpJumpParams,
    PtpPoCmd, PtpPoWithLCmd, QueuedCmdLeftSpace, QueuedCmdStartDownload,
};
use magician_protocol::{
    DecodeError, Direction, JogCommand, Layout, PoCmd, Port, PtpMode, Request, Row, Set, describe,
};

fn length(expected: usize, found: usize) -> DecodeError {
    DecodeError::Length { expected, found }
}

#[test]
fn e11_surplus_is_ignored_and_a_short_frame_is_an_error() {
    for row in magician_protocol::TABLE {
        let Some(size) = row.query.and_then(|query| query.size()) else {
            continue;
        };
        if row.set.is_none() {
            assert!(
                request(row.id, 0, &vec![0; size + 1]).is_ok(),
                "{}",
                row.name
            );
            assert_single_note(row.id, 0, &vec![0; size + 1], "E11");
        }
    }
    let long = [&[1][..], &[0; 16], &[9; 3]].concat();
    assert_eq!(reencode_set(84, &long), Ok(long[..17].to_vec()));
    assert_eq!(request(84, 3, &long[..16]), Err(length(17, 16)));
    assert_eq!(request(84, 3, &[]), Err(length(17, 0)));
}

#[test]
fn e11_four_bytes_of_a_motor_are_filled_up() {
    let motor = EMotor::decode(&[1, 1, 0x10, 0x27]).unwrap();
    assert_eq!((motor.speed, motor.is_enabled.is_on()), (10_000, true));
    assert_single_note(135, 1, &[1, 1, 0x10, 0x27], "E11");
    assert_eq!(EMotor::decode(&[1, 1, 0x10]), Err(length(6, 3)));
    assert_eq!(EMotor::decode(&[1, 1, 0x10, 0x27, 0]), Err(length(6, 5)));
}

#[test]
fn e15_rail_with_and_without_its_version() {
    assert_eq!(reencode_set(3, &[1]), Ok(vec![1]));
    assert_eq!(reencode_set(3, &[1, 1]), Ok(vec![1, 1]));
    assert_eq!(fields(3, 1, &[1], Direction::Request), "with_l=1");
    assert_eq!(request(3, 1, &[]), Err(length(1, 0)));
}

#[test]
fn e16_a_version_may_be_longer() {
    let long: Vec<u8> = (1..=14).collect();
    let version = DeviceVersion::decode(&long).unwrap();
    assert_eq!(
        (
            version.major_version,
            version.minor_version,
            version.revision
        ),
        (1, 2, 3)
    );
    assert_eq!(version.extra.as_slice(), &long[3..]);
    assert!(
        DeviceVersion::decode(&[1, 2, 3])
            .unwrap()
            .extra
            .as_slice()
            .is_empty()
    );
    assert_eq!(DeviceVersion::decode(&[1, 2]), Err(length(3, 2)));
    assert_eq!(
        fields(2, 0, &[1, 2, 3], Direction::Reply),
        "major_version=1 minor_version=2 revision=3"
    );
}

#[test]
fn e17_text_ends_at_its_nul_or_without_one() {
    for params in [&b"arm\0"[..], b"arm", b"arm\0\0\0", b"arm\0left"] {
        assert_eq!(reencode_set(1, params), Ok(b"arm\0".to_vec()));
        assert_eq!(fields(1, 1, params, Direction::Request), "device_name=arm");
    }
    assert_eq!(reencode_set(1, b""), Ok(b"\0".to_vec()));
}

#[test]
fn e20_alarm_states_of_any_length_are_read() {
    for len in [1, 16, 32, 40] {
        let mut state = vec![0; len];
        state[0] = 2;
        assert_eq!(
            fields(20, 0, &state, Direction::Reply),
            "alarms_state=0x01 UndefinedInstruction"
        );
    }
    let empty = frame(20, 0, &[]);
    assert!(describe(&empty.frame(), Direction::Reply).is_err());
}

#[test]
fn e21_levelling_answers_four_bytes_or_five() {
    let float = 0.25f32.to_le_bytes();
    let five = [&[1][..], &float].concat();
    assert_eq!(AutoLeveling::decode(&float).unwrap().result, 0.25);
    assert_eq!(AutoLeveling::decode(&five).unwrap().result, 0.25);
    assert_eq!(fields(32, 0, &five, Direction::Reply), "result=0.25");
    assert!(notes(32, 0, &five, Direction::Reply)[0].contains("E21"));
}

#[test]
fn e22_homing_takes_none_to_four_bytes() {
    for count in 0..=4 {
        assert_eq!(
            reencode_set(31, &vec![0; count]),
            Ok(vec![0; 4]),
            "{count} bytes"
        );
    }
    assert_single_note(31, 3, &[0], "E22");
}

#[test]
fn e23_a_pose_is_reset_with_or_without_angles() {
    assert_eq!(reencode_set(11, &[0]), Ok(vec![0; 9]));
    assert_eq!(reencode_set(11, &[1; 9]), Ok(vec![1; 9]));
    assert_eq!(request(11, 1, &[1, 0, 0, 0, 0]), Err(length(9, 5)));
    assert_eq!(request(11, 1, &[]), Err(length(1, 0)));
}

#[test]
fn e24_a_teach_mode_is_the_first_of_any_bytes() {
    for count in 1..=8 {
        let mut params = vec![0; count];
        params[0] = 1;
        assert_eq!(u8::from(HhtTrigMode::decode(&params).unwrap().mode), 1);
    }
}

#[test]
fn e25_jogging_knows_the_rail() {
    let named = |value| JogCommand::from(value);
    assert_eq!(
        (named(9), named(10)),
        (JogCommand::RailPlus, JogCommand::RailMinus)
    );
    assert_eq!(named(11), JogCommand::Unknown(11));
}

#[test]
fn e28_motion_modes_go_to_nine_and_pass_beyond() {
    assert_eq!(PtpMode::from(9), PtpMode::JumpMovlXyz);
    let beyond = [&[10][..], &[0; 16]].concat();
    assert_eq!(reencode_set(84, &beyond), Ok(beyond));
}

#[test]
fn e29_outputs_with_and_without_a_count() {
    let outputs = [
        PoCmd {
            ratio: 50,
            address: 4,
            level: 1,
        },
        PoCmd {
            ratio: 75,
            address: 5,
            level: 0,
        },
    ];
    let list = [50, 4, 0, 1, 75, 5, 0, 0];
    let bare = [&[0; 17][..], &list].concat();
    let counted = [&[0; 17][..], &[2], &list].concat();
    for params in [&bare, &counted] {
        assert_eq!(PtpPoCmd::decode(params).unwrap().po.as_slice(), outputs);
        assert_eq!(reencode_set(88, params), Ok(bare.clone()));
    }
    assert_single_note(88, 3, &counted, "E29");
    let wrong = [&[0; 17][..], &[3], &list].concat();
    assert_eq!(request(88, 3, &wrong), Err(DecodeError::List { found: 9 }));
    assert_eq!(
        request(88, 3, &bare[..19]),
        Err(DecodeError::List { found: 2 })
    );
    let none = [&[0; 17][..], &[0]].concat();
    assert!(PtpPoCmd::decode(&none).unwrap().po.counted());
    let rail = [&[0; 21][..], &[1], &list[..4]].concat();
    assert_eq!(
        PtpPoWithLCmd::decode(&rail).unwrap().po.as_slice(),
        &outputs[..1]
    );
}

#[test]
fn e30_jump_parameters_of_a_sibling_are_longer() {
    let long = [
        &60f32.to_le_bytes()[..],
        &90f32.to_le_bytes(),
        &[1, 0, 0, 0],
    ]
    .concat();
    let jump = PtpJumpParams::decode(&long).unwrap();
    assert_eq!((jump.jump_height, jump.z_limit), (60.0, 90.0));
    assert_single_note(82, 1, &long, "E11");
}

#[test]
fn e32_path_segments_of_fourteen_bytes() {
    let short = [&[1][..], &200f32.to_le_bytes(), &[0; 8], &[0]].concat();
    let segment = CpCmd::decode(&short).unwrap();
    assert_eq!((segment.x, segment.velocity_or_power), (200.0, 0.0));
    assert!(CpLeCmd::decode(&short).is_ok());
    assert_single_note(91, 3, &short, "E32");
    assert_eq!(
        fields(91, 3, &short, Direction::Request),
        "cp_mode=1 (Absolute) x=200 y=0 z=0"
    );
    assert_eq!(request(91, 3, &short[..13]), Err(length(17, 13)));
    assert_eq!(request(91, 3, &[0; 15]), Err(length(17, 15)));
}

#[test]
fn e33_circles_with_and_without_a_count() {
    let Ok(Request::Queue(Set::CircleCmd(circle))) = request(102, 3, &[0; 32]) else {
        panic!()
    };
    assert_eq!(circle.count, 1);
    assert_eq!(reencode_set(102, &[3; 36]), Ok(vec![3; 36]));
    assert_eq!(request(102, 3, &[0; 34]), Err(length(36, 34)));
}

#[test]
fn e38_left_space_of_four_bytes_or_eight() {
    for params in [&[32, 0, 0, 0][..], &[32, 0, 0, 0, 0, 0, 0, 0]] {
        assert_eq!(QueuedCmdLeftSpace::decode(params).unwrap().left_space, 32);
        assert_eq!(fields(247, 0, params, Direction::Reply), "left_space=32");
    }
    assert!(notes(247, 0, &[0; 8], Direction::Reply)[0].contains("E38"));
}

#[test]
fn e39_pin_may_be_omitted() {
    for id in [130, 131, 132, 133, 134] {
        assert_eq!(reencode_get(id, &[]), Ok(vec![]), "id {id}");
        assert_eq!(reencode_get(id, &[18]), Ok(vec![18]), "id {id}");
        assert_single_note(id, 0, &[], "E39");
        assert!(
            Row::with_id(id)
                .unwrap()
                .query
                .unwrap()
                .fields
                .iter()
                .all(|f| !f.optional)
        );
    }
}

#[test]
fn e41_speeds_may_be_floats() {
    let read = |speed: [u8; 4]| {
        let params = [&[0, 1][..], &speed].concat();
        EMotor::decode(&params).unwrap().pulses_per_second()
    };
    for whole in [0, 1, -1, 10_000, -10_000, 1 << 24, -(1 << 24)] {
        assert_eq!(read(i32::to_le_bytes(whole)), f64::from(whole));
        let params = [&[0, 1][..], &whole.to_le_bytes()].concat();
        assert!(notes(135, 1, &params, Direction::Request).is_empty());
    }
    for float in [1.0f32, -1.0, 10_000.0, -10_000.0, 0.5] {
        assert_eq!(read(float.to_le_bytes()), f64::from(float));
        assert_single_note(135, 1, &[&[0, 1][..], &float.to_le_bytes()].concat(), "E41");
    }
    let nan = i32::from_le_bytes(f32::NAN.to_le_bytes());
    assert_eq!(
        read(nan.to_le_bytes()),
        f64::from(nan),
        "no number is no float"
    );
    let params = [&[0, 1][..], &2.5f32.to_le_bytes(), &[0; 4]].concat();
    assert_eq!(EMotorS::decode(&params).unwrap().pulses_per_second(), 2.5);
}

#[test]
fn e42_e43_sensors_with_and_without_version_and_port() {
    for id in [137, 138] {
        assert_eq!(reencode_set(id, &[1, 2]), Ok(vec![1, 2]));
        assert_eq!(reencode_set(id, &[1, 2, 1]), Ok(vec![1, 2, 1]));
        assert_eq!(reencode_get(id, &[]), Ok(vec![]));
        assert_eq!(reencode_get(id, &[3]), Ok(vec![3]));
        assert_eq!(reencode_get(id, &[3, 1, 1]), Ok(vec![3]));
    }
    assert!(notes(137, 0, &[], Direction::Request).is_empty());
    assert_single_note(138, 0, &[], "E43");
    assert_eq!(Port::from(3), Port::Gp5);
}

#[test]
fn e46_downloads_begin_with_two_words_or_two_bytes() {
    let long = [&3u32.to_le_bytes()[..], &5u32.to_le_bytes()].concat();
    for params in [&long[..], &[3, 5]] {
        let start = QueuedCmdStartDownload::decode(params).unwrap();
        assert_eq!((start.total_loop, start.line_per_loop), (3, 5));
        assert_eq!(
            fields(243, 1, params, Direction::Request),
            "total_loop=3 line_per_loop=5"
        );
    }
    assert_single_note(243, 1, &[3, 5], "E46");
}
