//! Golden exchanges. Do not change a byte here to make a test pass.
//!
//! Requests are frames that real hosts sent to real arms, or that the vendor's staff published.
//! Replies of a real arm are marked "captured". Everything else follows from the protocol document
//! and its errata.

use super::arm;
use super::arm::{arm, arm_with, hex, homing_lasts, running_arm};

#[test]
fn exchanges_of_a_fresh_arm() {
    let exchanges = [
        // captured: forum topic on the raw protocol
        ("AA AA 04 03 01 01 00 FB", "AA AA 02 03 01 FC"),
        // a current host: rail of the second generation
        ("AA AA 04 03 01 01 01 FA", "AA AA 02 03 01 FC"),
        // computed from the kinematics in binary64: x 259.10413 with the suction cup, z -8.485281,
        // J2 and J3 45
        (
            "AA AA 02 0A 00 F6",
            "AA AA 22 0A 00 54 8D 81 43 00 00 00 00 B6 C3 07 C1 00 00 00 00 \
             00 00 00 00 00 00 34 42 00 00 34 42 00 00 00 00 24",
        ),
        // captured: jog coordinate parameters, all 60
        (
            "AA AA 02 47 00 B9",
            "AA AA 22 47 00 00 00 70 42 00 00 70 42 00 00 70 42 00 00 70 42 \
             00 00 70 42 00 00 70 42 00 00 70 42 00 00 70 42 29",
        ),
        // version 3.6.14
        ("AA AA 02 02 00 FE", "AA AA 05 02 00 03 06 0E E7"),
        // one byte too many, as a Java host sends every get
        ("AA AA 03 04 00 00 FC", "AA AA 06 04 00 00 00 00 00 FC"),
        ("AA AA 02 F7 00 09", "AA AA 06 F7 00 20 00 00 00 E9"),
        (
            "AA AA 02 F6 00 0A",
            "AA AA 0A F6 00 00 00 00 00 00 00 00 00 0A",
        ),
        ("AA AA 02 F0 01 0F", "AA AA 02 F0 01 0F"),
        ("AA AA 02 F5 01 0A", "AA AA 02 F5 01 0A"),
        ("AA AA 02 14 01 EB", "AA AA 02 14 01 EB"),
    ];
    for (request, reply) in exchanges {
        arm().exchange(request, reply);
    }
}

/// An arm without a tool bias reports the wrist.
#[test]
fn the_pose_without_a_tool() {
    // computed from the kinematics in binary64: x 199.40411, z -8.485281, J2 and J3 45
    arm_with(|profile| profile.power_up.tool = magician_motion::ToolBias::NONE).exchange(
        "AA AA 02 0A 00 F6",
        "AA AA 22 0A 00 74 67 47 43 00 00 00 00 B6 C3 07 C1 00 00 00 00 \
         00 00 00 00 00 00 34 42 00 00 34 42 00 00 00 00 64",
    );
}

#[test]
fn power_up_alarm() {
    let mut bench = arm::TestArm {
        arm: magician_sim::Controller::default(),
    };
    bench.exchange(
        "AA AA 02 14 00 EC",
        "AA AA 12 14 00 01 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 EB",
    );
}

#[test]
fn queued_frames_of_real_hosts_get_indices_1_2_3() {
    let mut bench = running_arm();
    // MOVJ to 250, 0, 0: a forum user's frame; its index follows the document's numbering
    bench.exchange(
        "AA AA 13 54 03 01 00 00 7A 43 00 00 00 00 00 00 00 00 00 00 00 00 EB",
        "AA AA 0A 54 03 01 00 00 00 00 00 00 00 A8",
    );
    // captured with index 2: SetIODO
    bench.exchange(
        "AA AA 04 83 03 02 01 77",
        "AA AA 0A 83 03 02 00 00 00 00 00 00 00 78",
    );
    // suction, as a popular library sends it
    bench.exchange(
        "AA AA 04 3E 03 01 01 BD",
        "AA AA 0A 3E 03 03 00 00 00 00 00 00 00 BC",
    );
    bench.rest();
    assert_eq!(bench.pose(), [250.0, 0.0, 0.0, 0.0]);
    assert_eq!(bench.current_index(), 3);
}

#[test]
fn captured_queuing_by_bit_1_alone() {
    // captured: SetDeviceWithL with Ctrl 02 was answered with Ctrl 02 and an index
    arm().exchange(
        "AA AA 04 03 02 01 01 F9",
        "AA AA 0A 03 02 01 00 00 00 00 00 00 00 FA",
    );
}

#[test]
fn damaged_frames_get_no_answer_and_have_no_effect() {
    for frame in [
        // a checksum too small by 1, EC for ED, as in S008 of host_frames.txt (EA for EB)
        "AA AA 13 54 01 01 00 00 7A 43 00 00 00 00 00 00 00 00 00 00 00 00 EC",
        "AA AA 02 F0 01 00",
        "AA AA 02 00 D6",
        "AA AA 02 0A 00 F4",
        "AA AA 06 6E 03 00 64 00 00 00",
    ] {
        let mut bench = arm();
        assert!(bench.send(&hex(frame)).is_empty(), "{frame}");
        bench.arm.expire(arm::USB);
        assert!(!bench.state().moving && !bench.state().queue.started);
        bench.exchange("AA AA 02 F7 00 09", "AA AA 06 F7 00 20 00 00 00 E9");
    }
}

#[test]
fn streams_with_noise_and_damage() {
    let mut bench = arm();
    let streams = [
        (
            "AA AA 02 F0 01 0F AA AA 02 F5 01 0A",
            "AA AA 02 F0 01 0F AA AA 02 F5 01 0A",
        ),
        (
            "AA AA 02 F7 00 08 AA AA 02 F7 00 09",
            "AA AA 06 F7 00 20 00 00 00 E9",
        ),
        (
            "AA AA 00 AA AA 02 F7 00 09",
            "AA AA 06 F7 00 20 00 00 00 E9",
        ),
        ("AA AA AA 02 F7 00 09", ""),
        (
            "4D 31 30 0D 0A AA AA 02 F7 00 09",
            "AA AA 06 F7 00 20 00 00 00 E9",
        ),
    ];
    for (stream, replies) in streams {
        bench.arm.close(arm::USB);
        if replies.is_empty() {
            // A third AA is read as a length; silence ends the candidate and uncovers the frame.
            assert!(bench.send(&hex(stream)).is_empty());
            bench.arm.expire(arm::USB);
            bench.exchange("", "AA AA 06 F7 00 20 00 00 00 E9");
        } else {
            bench.exchange(stream, replies);
        }
    }
}

#[test]
fn a_staff_post_moves_home_sucks_and_waits() {
    let mut bench = running_arm();
    for (request, index) in [
        ("AA AA 06 1F 03 00 00 00 00 DE", 1),
        ("AA AA 0A 53 03 00 00 C8 42 00 00 C8 42 96", 2),
        (
            "AA AA 13 54 03 04 00 00 20 41 00 00 A0 41 00 00 F0 41 00 00 20 42 D0",
            3,
        ),
        ("AA AA 06 6E 03 DC 05 00 00 AE", 4),
        ("AA AA 04 83 03 11 01 68", 5),
    ] {
        let replies = bench.send(&hex(request));
        assert_eq!(replies[0].frame().params()[..2], [index, 0], "{request}");
    }
    bench.rest();
    assert_eq!(bench.joints(), [10.0, 20.0, 30.0, 40.0]);
    assert_eq!(bench.current_index(), 5);
    // The wait of 1500 ms is included.
    assert!(bench.arm.now().as_micros() as f64 > 1e6 * (homing_lasts(0.0) + 1.5));
}

#[test]
fn every_frame_that_a_host_is_known_to_have_sent_is_answered_in_kind() {
    let mut seen = 0;
    for line in include_str!("host_frames.txt").lines() {
        let Some((about, bytes)) = line.split_once('|').filter(|_| !line.starts_with('#')) else {
            continue;
        };
        let mut about = about.split_whitespace();
        let (answer, id) = (about.next().unwrap(), about.next().unwrap());
        let bytes = hex(bytes);
        let mut bench = running_arm();
        let replies = bench.send(&bytes);
        bench.arm.expire(arm::USB);
        assert!(bench.replies(arm::USB).is_empty(), "{id}");
        seen += 1;
        if answer == "silence" {
            assert!(replies.is_empty(), "{id}");
            assert!(!bench.state().moving, "{id}");
            continue;
        }
        let [reply] = &replies[..] else {
            panic!("{id}: {replies:?}")
        };
        assert_eq!(reply.bytes()[3..5], bytes[3..5], "{id}: id and Ctrl");
        match answer {
            "empty" => assert_eq!(reply.frame().params(), [0u8; 0], "{id}"),
            "index" => assert_eq!(reply.frame().params(), 1u64.to_le_bytes(), "{id}"),
            "value" => assert!(!reply.frame().params().is_empty(), "{id}"),
            other => panic!("{other}"),
        }
    }
    assert_eq!(seen, 79);
}
