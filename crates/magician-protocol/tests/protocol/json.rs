//! The JSON shape of values (feature `serde`).
#![cfg(feature = "serde")]

use crate::material;
use magician_protocol::commands::{AlarmsState, DeviceVersion, Pose, PtpPoCmd, SetDeviceWithL};
use magician_protocol::{Ctrl, Description, Direction, FrameBuf, Layout, describe};
use serde_json::{json, to_string};

fn pose(x: f32) -> Pose {
    let mut pose = Pose::decode(&[0; 32]).unwrap();
    pose.x = x;
    pose
}

#[test]
fn numbers_are_the_shortest_that_read_back() {
    let text = to_string(&pose(0.1)).unwrap();
    assert_eq!(
        text,
        r#"{"x":0.1,"y":0.0,"z":0.0,"r":0.0,"joint_angle":[0.0,0.0,0.0,0.0]}"#
    );
}

#[test]
fn nan_and_infinity_serialise_as_strings() {
    for (x, text) in [
        (f32::NAN, "NaN"),
        (f32::INFINITY, "inf"),
        (f32::NEG_INFINITY, "-inf"),
    ] {
        assert_eq!(serde_json::to_value(pose(x)).unwrap()["x"], json!(text));
    }
}

#[test]
fn fields_left_out_are_absent() {
    let rail = |params: &[u8]| to_string(&SetDeviceWithL::decode(params).unwrap()).unwrap();
    assert_eq!(rail(&[1]), r#"{"with_l":1}"#);
    assert_eq!(rail(&[1, 1]), r#"{"with_l":1,"version":1}"#);
    let short = DeviceVersion::decode(&[3, 6, 9]).unwrap();
    let text = to_string(&short).unwrap();
    assert_eq!(
        text,
        r#"{"major_version":3,"minor_version":6,"revision":9}"#
    );
}

#[test]
fn bytes_are_hex_and_lists_are_lists() {
    let long = DeviceVersion::decode(&[3, 6, 9, 0xAB, 0x0C]).unwrap();
    assert_eq!(serde_json::to_value(long).unwrap()["extra"], json!("AB0C"));
    let params = [&[0; 17][..], &[50, 4, 0, 1]].concat();
    let outputs = PtpPoCmd::decode(&params).unwrap();
    assert_eq!(
        serde_json::to_value(outputs).unwrap()["po"],
        json!([{"ratio": 50, "address": 4, "level": 1}])
    );
    let alarms = AlarmsState::decode(&[1, 0, 4]).unwrap();
    assert_eq!(to_string(&alarms).unwrap(), r#"{"alarms_state":[1,0,4]}"#);
}

#[test]
fn a_queued_reply_carries_its_index_as_a_number() {
    let frame = FrameBuf::new(84, Ctrl::QUEUED, &u64::MAX.to_le_bytes()).unwrap();
    let reply = describe(&frame.frame(), Direction::Reply).unwrap();
    let text = to_string(&reply).unwrap();
    assert_eq!(text, r#"{"queued_cmd_index":18446744073709551615}"#);
}

#[test]
fn every_frame_on_record_serialises() {
    for recorded in material::frames() {
        let description = describe(&recorded.frame(), recorded.direction).unwrap();
        let object = serde_json::to_value(&description).unwrap();
        let count = description.values().unwrap().count();
        assert_eq!(object.as_object().unwrap().len(), count, "{}", recorded.id);
        let guess = Description::guess(&recorded.frame()).unwrap();
        assert!(serde_json::to_value(&guess).unwrap().is_object());
    }
}
