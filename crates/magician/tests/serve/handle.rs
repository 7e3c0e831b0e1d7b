//! Handle to a served arm: observing it, and pulling its cable under its clients.

use std::io::{Read, Write};
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use magician::serve::{Discovery, Ended, Endpoint, Notice, Server};
use magician_sim::{Controller, Speed};

use super::served::{
    DEADLINE, Served, ask, connect, get, get_pose, name, serve, serve_arms, set_name,
};

fn address(served: &Served, of: impl Fn(&Endpoint) -> Option<SocketAddr>) -> SocketAddr {
    served.endpoints.iter().find_map(of).unwrap()
}

fn tcp(served: &Served) -> SocketAddr {
    address(served, |endpoint| match endpoint {
        Endpoint::Tcp(address) => Some(*address),
        _ => None,
    })
}

/// True if the other end has hung up: end of file, or the error of a broken connection.
fn hung_up(stream: &mut impl Read) -> bool {
    use std::io::ErrorKind::{TimedOut, WouldBlock};
    match stream.read(&mut [0; 16]) {
        Ok(count) => count == 0,
        Err(error) => !matches!(error.kind(), TimedOut | WouldBlock),
    }
}

#[test]
fn a_handle_looks_at_its_arm_and_changes_it() {
    let served = serve_arms(2, |server| server.tcp("127.0.0.1:0")).unwrap();
    let mut stream = connect(tcp(&served));
    // SetQueuedCmdStartExec, on the first arm.
    stream.write_all(&[0xAA, 0xAA, 2, 240, 1, 15]).unwrap();
    stream.read_exact(&mut [0; 6]).unwrap();
    let started = served.handles.iter().map(|handle| {
        let look = handle.with(|runner| runner.controller().state().queue.started);
        look.wait().unwrap()
    });
    assert_eq!(started.collect::<Vec<bool>>(), [true, false]);

    // Not awaited, and still done before the next operation.
    drop(served.handles[0].with(|runner| runner.set_delay(Duration::from_micros(1))));
    let pulls = served.handles[0].with(|runner| {
        runner.set_delay(Duration::ZERO);
        runner.pulls()
    });
    assert_eq!(pulls.wait(), Ok(0));
}

#[test]
fn an_arm_that_has_ended_says_so() {
    let served = serve(|server| server.tcp("127.0.0.1:0")).unwrap();
    let handle = served.handles[0].clone();
    served.stop();
    assert_eq!(handle.plug().wait(), Err(Ended));
    let never = Server::new(Controller::default());
    let handle = never.handle();
    let answer = handle.unplug();
    drop(never);
    assert_eq!(answer.wait(), Err(Ended));
}

#[test]
fn an_answer_can_be_awaited_and_orders_may_come_before_the_server_is_ready() {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    let server = Server::new(Controller::default()).speed(Speed::Max);
    let handle = server.handle();
    let unplugged = handle.unplug();
    let look = async {
        unplugged.await.unwrap();
        let plugged = handle.with(|runner| runner.plugged()).await;
        assert_eq!(plugged, Ok(false));
    };
    runtime.block_on(server.serve_until(look)).unwrap();
}

#[test]
fn without_its_cable_an_arm_closes_connections_until_it_is_back() {
    let served = serve(|server| server.tcp("127.0.0.1:0")).unwrap();
    let address = tcp(&served);
    let mut before = connect(address);
    ask(&mut before, &set_name("kept"));
    served.handles[0].unplug().wait().unwrap();
    served.wait_for(|notice| matches!(notice, Notice::Unplugged));
    assert!(hung_up(&mut before));
    for _ in 0..20 {
        assert!(hung_up(&mut connect(address)));
    }
    served.handles[0].plug().wait().unwrap();
    assert_eq!(name(&ask(&mut connect(address), &get(1))), "kept");
}

#[test]
fn without_its_cable_an_arm_leaves_datagrams_unanswered() {
    let build = |server: Server| {
        let server = server.udp("127.0.0.1:0").tcp("127.0.0.1:0");
        server.discovery(Discovery::At("127.0.0.1:0".to_owned()))
    };
    let served = serve(build).unwrap();
    let [Endpoint::Udp(udp), _, Endpoint::Discovery(discovery)] = served.endpoints[..] else {
        panic!("{:?}", served.endpoints);
    };
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(DEADLINE)).unwrap();
    let mut bytes = [0; 64];
    // Half a request before the unplugging, which is forgotten.
    socket.send_to(&get_pose()[..4], udp).unwrap();
    served.wait_for(|notice| matches!(notice, Notice::Connected(_)));
    served.handles[0].unplug().wait().unwrap();
    socket.send_to(&get_pose(), udp).unwrap();
    socket.send_to(b"Who is Dobot?", discovery).unwrap();
    // A closed connection shows that a round has passed since the datagrams arrived; the operation
    // shows the end of the next one.
    assert!(hung_up(&mut connect(tcp(&served))));
    served.handles[0].with(|_| ()).wait().unwrap();
    served.handles[0].plug().wait().unwrap();
    socket.send_to(&get(246), udp).unwrap();
    let count = socket.recv(&mut bytes).unwrap();
    assert_eq!((count, bytes[3]), (14, 246));
    socket.send_to(b"Who is Dobot?", discovery).unwrap();
    let count = socket.recv(&mut bytes).unwrap();
    assert!(bytes[..count].starts_with(b"127.0.0.1,"));
    served.stop();
    socket.set_nonblocking(true).unwrap();
    assert!(socket.recv(&mut bytes).is_err(), "nothing else was said");
}

#[test]
fn a_cable_pulled_and_put_back_in_one_go_was_pulled() {
    let served = serve(|server| server.tcp("127.0.0.1:0")).unwrap();
    let mut stream = connect(tcp(&served));
    ask(&mut stream, &get_pose());
    let both = served.handles[0].with(|runner| {
        runner.unplug();
        runner.plug();
    });
    both.wait().unwrap();
    assert!(hung_up(&mut stream));
    ask(&mut connect(tcp(&served)), &get_pose());
}

#[cfg(unix)]
mod terminals {
    use super::*;
    use magician::serve::ServeError;
    use std::fs;
    use std::path::Path;

    fn open(path: &Path) -> fs::File {
        let mut options = fs::File::options();
        options.read(true).write(true).open(path).unwrap()
    }

    fn is_there(path: &Path) -> bool {
        fs::symlink_metadata(path).is_ok()
    }

    #[test]
    fn a_terminal_vanishes_under_its_clients_and_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm");
        let served = serve(|server| server.pty(&path).tcp("127.0.0.1:0")).unwrap();
        for round in 0..20 {
            let mut client = open(&path);
            ask(&mut client, &set_name(&format!("round {round}")));
            // An unread reply, and half a request.
            client
                .write_all(&[get_pose(), get_pose()[..3].to_vec()].concat())
                .unwrap();

            served.handles[0].unplug().wait().unwrap();
            assert!(!is_there(&path));
            // Bytes that had arrived can still be read, and nothing after them.
            while !hung_up(&mut client) {}
            assert!(client.write_all(&get_pose()).is_err());

            served.handles[0].plug().wait().unwrap();
            assert!(is_there(&path));
            assert!(hung_up(&mut client), "the old terminal stays gone");
            let mut client = open(&path);
            let reply = ask(&mut client, &get(1));
            assert_eq!(name(&reply), format!("round {round}"));
        }
        served.stop();
        assert!(!is_there(&path));
    }

    #[test]
    fn a_client_that_waits_for_a_reply_wakes_up() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm");
        let served = serve(|server| server.pty(&path)).unwrap();
        let mut client = open(&path);
        let (reading, is_reading) = std::sync::mpsc::channel();
        let reader = std::thread::spawn(move || {
            reading.send(()).unwrap();
            hung_up(&mut client)
        });
        is_reading.recv_timeout(DEADLINE).unwrap();
        served.handles[0].unplug().wait().unwrap();
        assert!(reader.join().unwrap());
    }

    #[test]
    fn the_log_names_the_new_terminal() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm");
        let served = serve(|server| server.pty(&path)).unwrap();
        served.handles[0].unplug().wait().unwrap();
        served.handles[0].plug().wait().unwrap();
        let target = fs::read_link(&path).unwrap();
        served.wait_for(|notice| match notice {
            Notice::Plugged(endpoints) => match &endpoints[..] {
                [Endpoint::Pty { path: at, device }] => *at == path && *device == target,
                _ => false,
            },
            _ => false,
        });
    }

    #[test]
    fn an_unplugged_arm_ends_without_a_trace_and_others_go_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm");
        let served = serve_arms(2, |server| server.pty(&path)).unwrap();
        served.handles[0].unplug().wait().unwrap();
        assert!(!is_there(&folder.path().join("arm.1")));
        ask(&mut open(&folder.path().join("arm.2")), &get_pose());
        served.stop();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_path_that_was_taken_meanwhile_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm");
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        let server = Server::new(Controller::default()).pty(&path);
        let handle = server.handle();
        let end = async {
            handle.unplug().await.unwrap();
            fs::write(&path, "precious").unwrap();
            assert_eq!(handle.plug().await, Err(Ended));
        };
        let ended = runtime
            .block_on(async { tokio::join!(server.serve_until(std::future::pending()), end) });
        assert!(matches!(ended.0, Err(ServeError::Occupied { .. })));
        assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
    }
}
