//! Behaviour that known hosts rely on; each test reproduces a habit of an existing program.

use super::arm::{SECOND, USB, arm, home, joints_to, ptp, running_arm, wait};
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, FrameBuf, TABLE};
use magician_sim::LinkId;

#[test]
fn one_reply_per_request_in_order_and_nothing_unsolicited() {
    let mut bench = running_arm();
    let ids: Vec<u8> = TABLE
        .iter()
        .filter(|row| row.value.is_some())
        .map(|row| row.id)
        .collect();
    let requests: Vec<u8> = ids
        .iter()
        .flat_map(|id| {
            FrameBuf::new(*id, Ctrl::GET, &[0; 17])
                .unwrap()
                .bytes()
                .to_vec()
        })
        .collect();
    let replies = bench.send(&requests);
    assert_eq!(
        replies
            .iter()
            .map(|reply| reply.frame().id())
            .collect::<Vec<_>>(),
        ids
    );
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&ptp(1, [900.0, 0.0, 0.0, 0.0]));
    bench.rest();
    assert!(bench.replies(USB).is_empty(), "not even about an alarm");
}

#[test]
fn ctrl_is_echoed_with_destination_and_slave_bits() {
    let mut bench = arm();
    for ctrl in 0..=255u8 {
        bench.frame(10, Ctrl(ctrl & !4), &[]);
    }
}

#[test]
fn when_the_index_shows_the_pose_is_there() {
    let mut bench = running_arm();
    let target = [220.0, 30.0, 10.0, 5.0];
    let index = bench.enqueue(&ptp(1, target));
    let mut looks = 0;
    while bench.current_index() != index {
        bench.pass(20_000);
        looks += 1;
    }
    assert!(looks > 10, "moves take time");
    assert_eq!(bench.pose(), target);
    bench.pass(60 * SECOND);
    assert_eq!(
        bench.current_index(),
        index,
        "it stays while nothing follows"
    );
    let reply = bench.frame(246, Ctrl::SET, &[]);
    assert_eq!(reply.frame().params(), index.to_le_bytes());
}

#[test]
fn a_host_that_waits_for_a_move_to_begin_sees_it() {
    let mut bench = running_arm();
    let before = bench.pose();
    bench.enqueue(&ptp(7, [0.0, 30.0, 0.0, 0.0]));
    bench.pass(20_000);
    assert_ne!(bench.pose(), before);
}

#[test]
fn immediate_motion_and_home_move_the_arm_and_are_answered_empty() {
    let mut bench = arm();
    bench.set(&ptp(1, [220.0, 30.0, 10.0, 5.0]));
    assert!(bench.state().moving);
    bench.rest();
    assert_eq!(bench.pose(), [220.0, 30.0, 10.0, 5.0]);
    bench.set(&home());
    bench.rest();
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0]);
}

#[test]
fn a_queued_jog_completes_its_index_at_once() {
    let mut bench = running_arm();
    let reply = bench.frame(73, Ctrl::QUEUED, &[1, 1]);
    assert_eq!(reply.frame().params()[0], 1);
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn the_short_and_long_forms_that_hosts_send_are_taken() {
    let forms: [(u8, usize); 16] = [
        (31, 0),  // home without its reserved number
        (91, 14), // continuous path of 14 bytes
        (92, 14),
        (88, 17), // no output
        (88, 21),
        (88, 22), // a count byte before the one output
        (89, 25),
        (83, 12), // surplus bytes
        (82, 12),
        (3, 1), // rail and sensors without version
        (137, 2),
        (138, 2),
        (138, 3),
        (135, 4), // a shortened speed
        (11, 1),
        (102, 32), // a circle without its count
    ];
    for (id, count) in forms {
        let mut bench = running_arm();
        let mut params = vec![0; count];
        if (id, count) == (88, 22) {
            params[17] = 1;
        }
        bench.frame(id, Ctrl::QUEUED, &params);
        let refused = bench.events().into_iter().any(|event| {
            matches!(
                event,
                magician_sim::Event::Refused {
                    reason: magician_sim::Refusal::Parameters,
                    ..
                }
            )
        });
        assert!(!refused, "id {id} with {count} bytes");
    }
}

#[test]
fn strings_come_with_and_without_nul() {
    let mut bench = arm();
    for sent in [&b"arm"[..], b"arm\0", b"arm\0\0\0"] {
        bench.frame(1, Ctrl::SET, sent);
        assert_eq!(bench.frame(1, Ctrl::GET, &[]).frame().params(), b"arm\0");
    }
}

#[test]
fn several_links_serve_one_arm_and_answers_go_to_the_asker() {
    let mut bench = running_arm();
    let (usb, udp) = (LinkId(0), LinkId(7));
    let pose = FrameBuf::new(10, Ctrl::GET, &[]).unwrap();
    let (first, rest) = pose.bytes().split_at(3);
    bench.arm.receive(usb, first);
    assert_eq!(bench.send_over(udp, pose.bytes()).len(), 1);
    assert_eq!(
        bench.send_over(usb, rest).len(),
        1,
        "a half frame waits on its own link"
    );
    assert_eq!(bench.enqueue(&wait(0)), 1);
    let queued = FrameBuf::new(110, Ctrl::QUEUED, &[0; 4]).unwrap();
    assert_eq!(
        bench.send_over(udp, queued.bytes())[0].frame().params()[0],
        2
    );
}

#[test]
fn closing_a_link_forgets_its_half_frame_and_its_replies() {
    let mut bench = arm();
    let pose = FrameBuf::new(10, Ctrl::GET, &[]).unwrap();
    bench.arm.receive(USB, pose.bytes());
    bench.arm.receive(USB, &pose.bytes()[..4]);
    bench.arm.close(USB);
    assert_eq!(bench.send(pose.bytes()).len(), 1);
}

#[test]
fn one_request_at_a_time_leaves_the_rest_for_later() {
    let mut bench = running_arm();
    let mut bytes = FrameBuf::new(110, Ctrl::QUEUED, &[10, 0, 0, 0])
        .unwrap()
        .bytes()
        .to_vec();
    bytes.extend_from_slice(FrameBuf::new(246, Ctrl::GET, &[]).unwrap().bytes());
    let mut input = &bytes[..];
    assert!(bench.arm.receive_one(USB, &mut input));
    bench.rest();
    assert!(bench.arm.receive_one(USB, &mut input));
    assert!(!bench.arm.receive_one(USB, &mut input));
    assert!(input.is_empty());
    let replies = bench.replies(USB);
    assert_eq!(
        replies[1].frame().params()[0],
        1,
        "the wait was over before the look"
    );
}

#[test]
fn a_peer_that_never_reads_costs_bounded_memory() {
    let mut bench = arm();
    let pose = FrameBuf::new(10, Ctrl::GET, &[]).unwrap();
    for _ in 0..10_000 {
        bench.arm.receive(USB, pose.bytes());
    }
    let waiting = bench.replies(USB).len();
    assert!((500..1000).contains(&waiting), "{waiting}");
    assert_eq!(
        bench.send(pose.bytes()).len(),
        1,
        "and the link works again"
    );
}

#[test]
fn peers_that_come_and_go_push_out_the_one_silent_longest() {
    let mut bench = arm();
    let pose = FrameBuf::new(10, Ctrl::GET, &[]).unwrap();
    for peer in 0..1000 {
        bench.arm.receive(LinkId(peer), pose.bytes());
    }
    assert!(bench.replies(LinkId(0)).is_empty());
    assert!(!bench.replies(LinkId(999)).is_empty());
    assert_eq!(bench.get::<QueuedCmdLeftSpace>().left_space, 32);
}
