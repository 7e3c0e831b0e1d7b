//! Blocking handle, for programs without a runtime.

use std::net::{SocketAddr, UdpSocket};
use std::panic::AssertUnwindSafe;
use std::time::Duration;

use magician::commands::{AlarmsState, Pose, PtpCommonParams};
use magician::protocol::FrameBuf;
use magician::{Ctrl, ErrorKind, Options, Target, build};

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
    let arm = magician::blocking::Arm::connect("sim").unwrap();
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
    arm.run(&[build::move_to(210.0, 10.0, 30.0, 0.0)]).unwrap();
}

/// Far beyond the duration of a call, so that no deadline interferes.
const DEADLINE: Duration = Duration::from_secs(600);

/// Plays the far end of a network: answers every request with this position until the call has
/// ended.
fn answering<T: Send>(arm: &UdpSocket, x: f32, call: impl FnOnce() -> T + Send) -> (T, SocketAddr) {
    let bell = UdpSocket::bind("127.0.0.1:0").unwrap();
    let (over, address) = (bell.local_addr().unwrap(), arm.local_addr().unwrap());
    std::thread::scope(|scope| {
        let call = scope.spawn(move || {
            let outcome = std::panic::catch_unwind(AssertUnwindSafe(call));
            // Received after all requests.
            bell.send_to(&[], address).unwrap();
            outcome.unwrap()
        });
        let (mut host, mut bytes) = (None, [0; 64]);
        loop {
            let (_, from) = arm.recv_from(&mut bytes).unwrap();
            if from == over {
                return (call.join().unwrap(), host.unwrap());
            }
            host = Some(from);
            arm.send_to(pose(x).bytes(), from).unwrap();
        }
    })
}

fn pose(x: f32) -> FrameBuf {
    FrameBuf::encode(10, Ctrl::GET, &pose_at(x)).unwrap()
}

#[test]
fn an_answer_that_came_between_two_blocking_calls_is_not_taken_for_the_next() {
    let far = UdpSocket::bind("127.0.0.1:0").unwrap();
    let target: Target = format!("udp:{}", far.local_addr().unwrap())
        .parse()
        .unwrap();
    let options = Options::default().probe(false).timeout(DEADLINE);
    let ((arm, first), host) = answering(&far, 1.0, || {
        let arm = magician::blocking::Arm::connect_with(&target, options).unwrap();
        let first = arm.get::<Pose>().unwrap().x;
        (arm, first)
    });
    assert_eq!(first, 1.0);
    for next in [2.0, 3.0, 4.0] {
        // The network duplicates the answer, and the duplicate arrives after the end of the call.
        far.send_to(pose(next - 1.0).bytes(), host).unwrap();
        let (second, _) = answering(&far, next, || arm.get::<Pose>().unwrap().x);
        assert_eq!(second, next);
    }
}
