//! UDP, TCP and all endpoints together, through real sockets.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};

use magician::serve::{Endpoint, Notice, ServeError};

use super::served::{Served, ask, connect, get, get_pose, name, serve, set_name, socket};

fn udp(served: &Served) -> SocketAddr {
    let find = |endpoint: &Endpoint| match endpoint {
        Endpoint::Udp(address) => Some(*address),
        _ => None,
    };
    served.endpoints.iter().find_map(find).unwrap()
}

fn tcp(served: &Served) -> SocketAddr {
    let find = |endpoint: &Endpoint| match endpoint {
        Endpoint::Tcp(address) => Some(*address),
        _ => None,
    };
    served.endpoints.iter().find_map(find).unwrap()
}

fn datagram(socket: &UdpSocket) -> Vec<u8> {
    let mut bytes = [0; 512];
    let count = socket.recv(&mut bytes).expect("a reply");
    bytes[..count].to_vec()
}

#[test]
fn datagrams_are_answered_one_frame_each_to_where_they_came_from() {
    let served = serve(|server| server.udp("127.0.0.1:0")).unwrap();
    let sockets = [socket(), socket(), socket()];
    for socket in &sockets {
        let two = [get_pose(), get(246)].concat();
        socket.send_to(&two, udp(&served)).unwrap();
    }
    for socket in &sockets {
        assert_eq!(datagram(socket).len(), 38);
        assert_eq!(datagram(socket).len(), 14);
    }
}

#[test]
fn each_senders_datagrams_are_a_stream() {
    let served = serve(|server| server.udp("127.0.0.1:0")).unwrap();
    let (a, b) = (socket(), socket());
    let request = get_pose();
    a.send_to(&request[..3], udp(&served)).unwrap();
    b.send_to(&request, udp(&served)).unwrap();
    assert_eq!(datagram(&b).len(), 38);
    a.send_to(&request[3..], udp(&served)).unwrap();
    assert_eq!(datagram(&a).len(), 38);
}

#[test]
fn datagrams_may_be_cut_and_joined_anywhere() {
    let served = serve(|server| server.udp("127.0.0.1:0")).unwrap();
    let socket = socket();
    let requests = [get_pose(), get(246), get_pose(), get(246)].concat();
    for size in 1..requests.len() {
        for datagram in requests.chunks(size) {
            socket.send_to(datagram, udp(&served)).unwrap();
        }
        let lengths = [(); 4].map(|()| datagram(&socket).len());
        assert_eq!(lengths, [38, 14, 38, 14], "{size}");
    }
}

#[test]
fn a_program_that_comes_back_on_another_port_is_answered_there() {
    let served = serve(|server| server.udp("127.0.0.1:0")).unwrap();
    for _ in 0..100 {
        let socket = socket();
        socket.send_to(&get_pose(), udp(&served)).unwrap();
        assert_eq!(datagram(&socket).len(), 38);
    }
    // The first of a hundred peers has been forgotten by now, which costs it nothing.
    served.wait_for(|notice| matches!(notice, Notice::Left(_)));
}

#[test]
fn replies_to_nobody_harm_nobody() {
    let served = serve(|server| server.udp("127.0.0.1:0")).unwrap();
    for _ in 0..20 {
        socket()
            .send_to(&get_pose().repeat(20), udp(&served))
            .unwrap();
    }
    let alive = socket();
    alive.send_to(&get_pose(), udp(&served)).unwrap();
    assert_eq!(datagram(&alive).len(), 38);
}

#[test]
fn connections_are_lines_of_their_own() {
    let served = serve(|server| server.tcp("127.0.0.1:0")).unwrap();
    let (mut a, mut b) = (connect(tcp(&served)), connect(tcp(&served)));
    a.write_all(&get_pose()[..4]).unwrap();
    assert_eq!(ask(&mut b, &get_pose()).len(), 38);
    assert_eq!(ask(&mut a, &get_pose()[4..]).len(), 38);
}

#[test]
fn more_connections_than_are_kept_are_closed_at_once() {
    let served = serve(|server| server.tcp("127.0.0.1:0")).unwrap();
    let mut kept: Vec<TcpStream> = (0..16).map(|_| connect(tcp(&served))).collect();
    for stream in &mut kept {
        assert_eq!(ask(stream, &get_pose()).len(), 38);
    }
    assert_eq!(connect(tcp(&served)).read(&mut [0; 1]).unwrap(), 0);
    kept.pop();
    served.wait_for(|notice| matches!(notice, Notice::Left(_)));
    assert_eq!(ask(&mut connect(tcp(&served)), &get_pose()).len(), 38);
}

#[test]
fn a_client_that_never_reads_holds_nobody_up() {
    let served = serve(|server| server.tcp("127.0.0.1:0").udp("127.0.0.1:0")).unwrap();
    let mut deaf = connect(tcp(&served));
    // More replies than any socket buffer holds.
    for _ in 0..2_000 {
        deaf.write_all(&get_pose().repeat(600)).unwrap();
    }
    let socket = socket();
    socket.send_to(&get_pose(), udp(&served)).unwrap();
    assert_eq!(datagram(&socket).len(), 38);
}

#[test]
fn a_stopped_server_is_gone() {
    let served = serve(|server| server.tcp("127.0.0.1:0")).unwrap();
    let address = tcp(&served);
    let mut open = connect(address);
    assert_eq!(ask(&mut open, &get_pose()).len(), 38);
    served.stop();
    assert_eq!(open.read(&mut [0; 1]).unwrap(), 0);
    assert!(TcpStream::connect(address).is_err());
}

#[test]
fn an_address_in_use_or_without_sense_is_named() {
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let error = serve(|server| server.udp(&address)).err().unwrap();
    assert!(matches!(error, ServeError::Endpoint { action: "bind", .. }));
    assert!(error.to_string().starts_with(&address), "{error}");
    let error = serve(|server| server.tcp("127.0.0.1")).err().unwrap();
    assert_eq!(error.to_string(), "127.0.0.1: a port is missing: HOST:PORT");
}

#[cfg(unix)]
#[test]
fn all_endpoints_serve_the_same_arm_at_the_same_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let served = serve(|server| server.pty(&path).udp("127.0.0.1:0").tcp("127.0.0.1:0")).unwrap();
    let options = |file: &mut std::fs::OpenOptions| file.read(true).write(true).open(&path);
    let mut pty = options(&mut std::fs::OpenOptions::new()).unwrap();
    let (socket, mut stream) = (socket(), connect(tcp(&served)));

    assert_eq!(ask(&mut pty, &set_name("terminal")).len(), 6);
    socket.send_to(&get(1), udp(&served)).unwrap();
    assert_eq!(name(&datagram(&socket)), "terminal");

    socket.send_to(&set_name("datagram"), udp(&served)).unwrap();
    assert_eq!(datagram(&socket).len(), 6);
    assert_eq!(name(&ask(&mut stream, &get(1))), "datagram");

    assert_eq!(ask(&mut stream, &set_name("connection")).len(), 6);
    assert_eq!(name(&ask(&mut pty, &get(1))), "connection");
}

#[cfg(feature = "trace")]
#[test]
fn the_trace_has_every_frame_of_every_client() {
    use magician_protocol::Direction;
    use std::fs;

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trace.pcapng");
    let file = fs::File::create(&path).unwrap();
    let served = serve(|server| server.tcp("127.0.0.1:0").udp("127.0.0.1:0").trace(file)).unwrap();
    let mut stream = connect(tcp(&served));
    let pose = ask(&mut stream, &get_pose());
    let socket = socket();
    socket.send_to(&get(246), udp(&served)).unwrap();
    let index = datagram(&socket);
    served.stop();
    let file = fs::read(&path).unwrap();
    let packets: Vec<_> = magician_record::trace::read_trace(&file)
        .map(Result::unwrap)
        .collect();
    let seen: Vec<_> = packets
        .iter()
        .map(|packet| (packet.direction, packet.bytes))
        .collect();
    assert_eq!(
        seen,
        [
            (Some(Direction::Request), &get_pose()[..]),
            (Some(Direction::Reply), &pose[..]),
            (Some(Direction::Request), &get(246)[..]),
            (Some(Direction::Reply), &index[..]),
        ]
    );
    let client = format!("udp:{}", socket.local_addr().unwrap());
    assert_eq!(packets[2].link_name, client);
    assert!(packets.is_sorted_by_key(|packet| packet.time));
}
