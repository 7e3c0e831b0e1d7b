//! Unplugging and replugging: over a pseudo-terminal, which is another device afterwards, and over
//! TCP.

use std::time::Duration;

use magician::protocol::commands::Pose;
use magician::protocol::{FrameBuf, NoArgs, Readable};
use magician::{Arm, ErrorKind, Options, RawLine, Target};

use crate::{serial, serve};

fn get_pose() -> FrameBuf {
    FrameBuf::get(&NoArgs, Pose::ROW).unwrap()
}

/// Length of the answer to GetPose, bytes.
const POSE: usize = 38;

pub(crate) async fn answers(line: &mut RawLine) -> bool {
    line.send(get_pose().bytes()).await.unwrap();
    let mut come: Vec<u8> = Vec::new();
    while come.len() < POSE {
        let mut bytes = [0; 64];
        let count = line.receive(&mut bytes).await.unwrap();
        come.extend_from_slice(&bytes[..count]);
    }
    come.len() == POSE
}

async fn is_lost(line: &mut RawLine) -> bool {
    let lost = line.receive(&mut [0; 64]).await.unwrap_err();
    lost.kind() == ErrorKind::Port && lost.to_string().contains("broke off")
}

#[tokio::test]
async fn the_same_name_leads_to_the_new_device() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let served = serve(|server| server.pty(&path));
    let mut line = RawLine::open(&serial(&path)).await.unwrap();
    for _ in 0..3 {
        assert!(answers(&mut line).await);
        served.handle.unplug().await.unwrap();
        assert!(is_lost(&mut line).await);
        // The port is missing, and opening it may be tried again.
        for _ in 0..2 {
            let error = line.reopen().await.unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Port);
            assert!(error.to_string().contains("does not exist"), "{error}");
        }
        assert_eq!(line.send(&[0]).await.unwrap_err().kind(), ErrorKind::Port);
        served.handle.plug().await.unwrap();
        line.reopen().await.unwrap();
    }
    assert!(answers(&mut line).await);
}

#[tokio::test]
async fn opening_again_gives_the_port_back_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let _served = serve(|server| server.pty(&path));
    let mut line = RawLine::open(&serial(&path)).await.unwrap();
    line.reopen().await.unwrap();
    assert!(answers(&mut line).await);
    drop(line);
    let mut other = RawLine::open(&serial(&path)).await.unwrap();
    assert!(answers(&mut other).await, "the lock went with the line");
}

#[tokio::test]
async fn a_closed_tcp_connection_is_noticed_and_made_again() {
    let served = serve(|server| server.tcp("127.0.0.1:0"));
    let target: Target = served.endpoints[0].to_string().parse().unwrap();
    let mut line = RawLine::open(&target).await.unwrap();
    assert!(answers(&mut line).await);
    served.handle.unplug().await.unwrap();
    assert!(is_lost(&mut line).await);
    served.handle.plug().await.unwrap();
    line.reopen().await.unwrap();
    assert!(answers(&mut line).await);
}

#[tokio::test]
async fn a_tcp_peer_that_says_nothing_does_not_hold_anybody() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let target = format!("tcp:{}", listener.local_addr().unwrap());
    let options = Options::default().timeout(Duration::from_millis(300));
    let error = Arm::connect_with(target, options).await;
    assert_eq!(error.unwrap_err().kind(), ErrorKind::Timeout);
}

#[tokio::test]
async fn a_virtual_arm_is_the_same_one_when_its_line_is_opened_again() {
    let arm = magician::VirtualArm::default();
    let options = magician::LineOptions::default();
    let mut line = RawLine::simulated(arm.clone(), options).await.unwrap();
    assert!(answers(&mut line).await);
    let before = arm.state().now;
    line.reopen().await.unwrap();
    assert!(answers(&mut line).await);
    assert!(arm.state().now >= before);
}

#[tokio::test]
async fn an_adapter_that_is_not_here_says_where_to_look() {
    for (text, hint) in [
        ("usb:dead:beef", "is not plugged in"),
        ("usb:dead:beef:A7", "list-ports"),
        ("arm:NOBODY", "the arm NOBODY was not found"),
    ] {
        let error = RawLine::open(&text.parse().unwrap()).await.err().unwrap();
        assert_eq!(error.kind(), ErrorKind::Port);
        assert!(format!("{error:?}").contains(hint), "{error:?}");
    }
}
