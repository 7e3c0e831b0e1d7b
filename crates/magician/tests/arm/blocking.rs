//! The handle for programs without a runtime.

use magician::commands::{AlarmsState, Pose, PtpCommonParams};
use magician::protocol::FrameBuf;
use magician::{Ctrl, ErrorKind, Options, Target, words};

use crate::bench::pose_at;

#[tokio::test]
async fn the_blocking_handle_refuses_to_block_a_runtime() {
    let target: Target = "sim".parse().unwrap();
    let error = magician::blocking::Arm::connect(&target).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    let made = tokio::task::spawn_blocking(move || {
        // A thread for blocking work still belongs to the runtime.
        std::thread::spawn(move || magician::blocking::Arm::connect(&target))
            .join()
            .unwrap()
    });
    let arm = made.await.unwrap().unwrap();
    let error = arm.get::<Pose>().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    drop(arm);
}

#[test]
fn the_blocking_handle_works_from_several_threads() {
    let arm = magician::blocking::Arm::connect(&"sim".parse().unwrap()).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..50 {
                    arm.get::<AlarmsState>().unwrap();
                }
            });
        }
    });
    let ratio = PtpCommonParams {
        velocity_ratio: 30.0,
        acceleration_ratio: 40.0,
    };
    arm.set(&ratio).unwrap();
    assert_eq!(arm.get::<PtpCommonParams>().unwrap(), ratio);
    arm.perform(&[words::move_to(210.0, 10.0, 30.0, 0.0)])
        .unwrap();
}

#[test]
fn an_answer_that_came_between_two_blocking_calls_is_not_taken_for_the_next() {
    // Real time, as short as can be: what a blocking handle misses it misses while nothing runs.
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let target: Target = format!("udp:{}", socket.local_addr().unwrap())
        .parse()
        .unwrap();
    let answer = |request: &[u8], x: f32| {
        let pose = pose_at(x);
        let mut reply = FrameBuf::encode(10, Ctrl::GET, &pose).unwrap();
        if request[3] != 10 {
            reply = FrameBuf::new(request[3], Ctrl(request[4]), &[0; 12]).unwrap();
        }
        reply
    };
    let options = Options::default().probe(false);
    let arm = std::thread::spawn(move || {
        let arm = magician::blocking::Arm::connect_with(&target, options).unwrap();
        let first = arm.get::<Pose>().unwrap().x;
        (arm, first)
    });
    let mut bytes = [0; 64];
    let (_, host) = socket.recv_from(&mut bytes).unwrap();
    // The network doubles the answer, and the double comes when the call has ended.
    socket.send_to(answer(&bytes, 1.0).bytes(), host).unwrap();
    let (arm, first) = arm.join().unwrap();
    socket.send_to(answer(&bytes, 1.0).bytes(), host).unwrap();
    let second = std::thread::spawn(move || arm.get::<Pose>().unwrap().x);
    socket.recv_from(&mut bytes).unwrap();
    socket.send_to(answer(&bytes, 2.0).bytes(), host).unwrap();
    assert_eq!((first, second.join().unwrap()), (1.0, 2.0));
}
