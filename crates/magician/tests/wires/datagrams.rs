//! Wi-Fi on the loopback interface: discovery, and datagrams that are lost, duplicated, late,
//! reordered, too large, empty, or foreign.

use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use magician::discovery::Search;
use magician::faults::{Faults, Injector, Passed};
use magician::serve::{Discovery, Endpoint};
use magician::{Arm, ErrorKind, QueueIndex, RawLine, Set, Target, build};
use tokio::time::Instant;

use crate::replug::answers;
use crate::{Served, serve};

/// Far beyond the duration of anything here.
const DEADLINE: Duration = Duration::from_secs(120);

fn target(address: SocketAddr) -> Target {
    format!("udp:{address}").parse().unwrap()
}

/// Creates a peer that is no arm, and a line to it.
async fn peer() -> (UdpSocket, RawLine, SocketAddr) {
    let peer = UdpSocket::bind("127.0.0.1:0").unwrap();
    peer.set_read_timeout(Some(DEADLINE)).unwrap();
    let mut line = RawLine::open(&target(peer.local_addr().unwrap()))
        .await
        .unwrap();
    line.send(b"who is there").await.unwrap();
    let (_, from) = peer.recv_from(&mut [0; 64]).unwrap();
    (peer, line, from)
}

async fn receive(line: &mut RawLine) -> Vec<u8> {
    let mut bytes = [0; 1024];
    let count = line.receive(&mut bytes).await.unwrap();
    bytes[..count].to_vec()
}

#[tokio::test]
async fn a_large_datagram_comes_whole_and_an_empty_one_is_not_the_end() {
    let (peer, mut line, host) = peer().await;
    let large: Vec<u8> = (0..40_000u32).map(|n| (n % 251) as u8).collect();
    peer.send_to(&[], host).unwrap();
    peer.send_to(&large, host).unwrap();
    let mut come = Vec::new();
    while come.len() < large.len() {
        come.extend(receive(&mut line).await);
    }
    assert_eq!(come, large);
    peer.send_to(b"next", host).unwrap();
    assert_eq!(receive(&mut line).await, b"next");
}

#[tokio::test]
async fn a_stranger_is_not_heard() {
    let (peer, mut line, host) = peer().await;
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    stranger.send_to(b"I am the arm", host).unwrap();
    peer.send_to(b"I am", host).unwrap();
    assert_eq!(receive(&mut line).await, b"I am");
}

#[tokio::test]
async fn an_arm_that_is_away_for_a_while_is_no_end() {
    let (peer, mut line, host) = peer().await;
    let address = peer.local_addr().unwrap();
    drop(peer);
    // The system reports the missing listener to the writer or to the reader.
    for _ in 0..3 {
        line.send(b"is anybody there").await.unwrap();
    }
    let peer = UdpSocket::bind(address).unwrap();
    peer.send_to(b"again", host).unwrap();
    assert_eq!(receive(&mut line).await, b"again");
}

#[tokio::test]
async fn a_host_that_comes_back_with_another_socket_is_answered_there() {
    let served = serve(|server| server.udp("127.0.0.1:0"));
    let target: Target = served.endpoints[0].to_string().parse().unwrap();
    let mut first = RawLine::open(&target).await.unwrap();
    assert!(answers(&mut first).await);
    let mut second = RawLine::open(&target).await.unwrap();
    assert!(answers(&mut second).await);
    assert!(answers(&mut first).await);
    first.reopen().await.unwrap();
    assert!(answers(&mut first).await);
}

/// Relays datagrams between a host and an arm, with the faults of a bad network.
async fn relay(front: tokio::net::UdpSocket, arm: SocketAddr, [there, here]: [Faults; 2]) {
    let back = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
    back.connect(arm).await.unwrap();
    let begun = Instant::now();
    let now = || begun.elapsed().as_micros() as u64;
    let mut to_arm = Injector::new(there, there.seed);
    let mut to_host = Injector::new(here, here.seed);
    let mut host = None;
    loop {
        let (mut there, mut here) = ([0; 2048], [0; 2048]);
        let next = [to_arm.poll_timeout(), to_host.poll_timeout()];
        let next = next.into_iter().flatten().min();
        let until = begun + Duration::from_micros(next.unwrap_or(3_600_000_000));
        tokio::select! {
            came = front.recv_from(&mut there) => {
                let (count, from) = came.unwrap();
                host = Some(from);
                to_arm.push(now(), &there[..count]);
            }
            // The arm's end is closed when the test has ended.
            came = back.recv(&mut here) => match came {
                Ok(count) => to_host.push(now(), &here[..count]),
                Err(_) => return,
            },
            () = tokio::time::sleep_until(until) => {}
        }
        while let Some(Passed::Bytes(bytes)) = to_arm.poll(now()) {
            if back.send(&bytes).await.is_err() {
                return;
            }
        }
        while let Some(Passed::Bytes(bytes)) = to_host.poll(now()) {
            front.send_to(&bytes, host.unwrap()).await.unwrap();
        }
    }
}

/// Creates an arm behind a network with these faults in each direction; also returns its own
/// address.
async fn behind(faults: [String; 2]) -> (Served, Arm, SocketAddr) {
    let served = serve(|server| server.udp("127.0.0.1:0"));
    let Endpoint::Udp(address) = served.endpoints[0] else {
        panic!()
    };
    let front = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let through = target(front.local_addr().unwrap());
    let faults = faults.map(|text| text.parse().unwrap());
    tokio::spawn(relay(front, address, faults));
    let arm = Arm::connect(&through).await.unwrap();
    (served, arm, address)
}

/// Returns the number of commands in the arm's queue, over a line without faults.
async fn stored(address: SocketAddr) -> u64 {
    let clean = Arm::connect(&target(address)).await.unwrap();
    u64::from(32 - clean.queue().left_space().await.unwrap())
}

fn go() -> magician::commands::PtpCmd {
    match build::move_to(200.0, 10.0, 20.0, 0.0) {
        Set::PtpCmd(go) => go,
        other => panic!("{other:?}"),
    }
}

/// With lost, reordered and duplicated datagrams every queued command is accepted once, or the host
/// reports which one is uncertain.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_bad_network_neither_loses_nor_doubles_a_command_in_silence() {
    let faults = "drop-chunk=0.04,swap-chunk=0.1,hold-ms=5";
    let there = format!("{faults},seed=1");
    let here = format!("{faults},duplicate-chunk=0.1,seed=2");
    let (_served, arm, address) = behind([there, here]).await;
    let (mut taken, mut unknown) = (0, 0);
    while taken < 20 && unknown == 0 {
        match arm.enqueue(&go()).await {
            Ok(index) => {
                taken += 1;
                assert_eq!(index.0, taken + 1);
            }
            // The command was certainly not sent.
            Err(error) if error.kind() == ErrorKind::Timeout => {}
            Err(error) => {
                assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
                unknown += 1;
            }
        }
    }
    let stored = stored(address).await;
    let told = taken..=taken + unknown;
    assert!(told.contains(&stored), "{taken} {unknown} {stored}");
}

/// A duplicated request makes the arm accept it twice; the indices show that to the host, which
/// reports it.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_request_that_the_network_doubles_is_told_of() {
    let double = "duplicate-chunk=1".to_owned();
    let (_served, arm, address) = behind([double, String::new()]).await;
    let mut told = 0;
    for _ in 0..3 {
        match arm.enqueue(&go()).await {
            Ok(_) => {}
            Err(error) => {
                assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
                told += 1;
            }
        }
    }
    // The duplicate of the last request arrives while no call is in progress, or so late that the
    // next call reports it. A wait after that only reports that the queue was not started.
    if told == 0 {
        let error = arm.wait(QueueIndex(2)).await.unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
    }
    assert_eq!(stored(address).await % 2, 0);
}

#[tokio::test]
async fn an_arm_is_found_by_asking_for_it() {
    let at = || Discovery::At("127.0.0.1:0".into());
    let served = serve(|server| server.udp("127.0.0.1:0").discovery(at()));
    let find = |endpoint: &Endpoint| match endpoint {
        Endpoint::Discovery(address) => Some(*address),
        _ => None,
    };
    let address = served.endpoints.iter().find_map(find).unwrap();
    // All hosts have answered, so the search ends long before its time.
    let found = Search::host(address.to_string())
        .find(DEADLINE)
        .await
        .unwrap();
    let [arm] = found.as_slice() else {
        panic!("{found:?}")
    };
    assert_eq!(
        (arm.name.as_str(), arm.version.as_deref()),
        ("USR-C322", Some("2.17.14"))
    );
    assert_eq!(arm.target().to_string(), "udp:127.0.0.1:8899");
    assert_eq!(arm.mac.len(), 12);
}

#[test]
fn nobody_and_those_who_say_something_else_are_not_found() {
    let closed = UdpSocket::bind("127.0.0.1:0").unwrap();
    let nobody = closed.local_addr().unwrap();
    drop(closed);
    let chatty = UdpSocket::bind("127.0.0.1:0").unwrap();
    chatty.set_read_timeout(Some(DEADLINE)).unwrap();
    let address = chatty.local_addr().unwrap();
    let chat = std::thread::spawn(move || {
        let (count, from) = chatty.recv_from(&mut [0; 64]).unwrap();
        assert_eq!(count, 13);
        for noise in [
            &b""[..],
            b"Who is Dobot?",
            b"127.0.0.1,xyz,me",
            &[0xFF; 9000],
        ] {
            chatty.send_to(noise, from).unwrap();
        }
    });
    let search = Search::host(nobody.to_string()).and(address.to_string());
    let found = search.find_blocking(Duration::from_millis(300)).unwrap();
    chat.join().unwrap();
    assert_eq!(found, []);
}
