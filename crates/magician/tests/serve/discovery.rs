//! Discovery socket of the Wi-Fi module, on the loopback interface only.

use std::net::{SocketAddr, UdpSocket};

use magician::serve::{Discovery, Endpoint, ServeError};
use magician_sim::Profile;

use super::served::{Served, get_pose, serve, serve_arm, socket};

const QUESTION: &[u8] = b"Who is Dobot?";

fn discovery(served: &Served) -> SocketAddr {
    let find = |endpoint: &Endpoint| match endpoint {
        Endpoint::Discovery(address) => Some(*address),
        _ => None,
    };
    served.endpoints.iter().find_map(find).unwrap()
}

fn text(socket: &UdpSocket) -> String {
    let mut bytes = [0; 512];
    let count = socket.recv(&mut bytes).expect("an answer");
    String::from_utf8(bytes[..count].to_vec()).unwrap()
}

fn ask(socket: &UdpSocket, to: SocketAddr) -> String {
    socket.send_to(QUESTION, to).unwrap();
    text(socket)
}

fn at(address: &str) -> Discovery {
    Discovery::At(address.to_owned())
}

#[test]
fn the_answer_is_what_the_module_says_and_stays_the_same() {
    let served = serve(|server| server.udp("127.0.0.1:0").discovery(at("127.0.0.1:0"))).unwrap();
    let socket = socket();
    let answer = ask(&socket, discovery(&served));
    let [ip, mac, name, version] = answer.split(',').collect::<Vec<_>>()[..] else {
        panic!("{answer}");
    };
    assert_eq!((ip, name, version), ("127.0.0.1", "USR-C322", "2.17.14"));
    assert_eq!(mac.len(), 12);
    let number = u64::from_str_radix(mac, 16).unwrap();
    assert_eq!(number >> 40, 0x02, "a local address of one device: {mac}");
    // Hosts repeat the request every two seconds, each for itself.
    assert_eq!(ask(&socket, discovery(&served)), answer);
    assert_eq!(ask(&self::socket(), discovery(&served)), answer);
}

#[test]
fn every_arm_has_a_hardware_address_of_its_own() {
    let answers = [1, 2].map(|seed| {
        let mut profile = Profile::default();
        profile.identity.device_id_seed = seed;
        let build = |server: magician::serve::Server| server.discovery(at("127.0.0.1:0"));
        let served = serve_arm(profile, build).unwrap();
        ask(&socket(), discovery(&served))
    });
    assert_ne!(answers[0], answers[1]);
}

#[test]
fn anything_else_is_not_answered() {
    let served = serve(|server| server.discovery(at("127.0.0.1:0"))).unwrap();
    let socket = socket();
    for noise in [&get_pose()[..], b"", b"HF-A11ASSISTHREAD", &[b'W'; 60_000]] {
        socket.send_to(noise, discovery(&served)).unwrap();
    }
    assert!(ask(&socket, discovery(&served)).starts_with("127.0.0.1,"));
    // All answers of the server have arrived by then.
    served.stop();
    socket.set_nonblocking(true).unwrap();
    assert!(socket.recv(&mut [0; 512]).is_err());
}

#[test]
fn behind_all_addresses_the_answer_names_the_one_that_was_reached() {
    let served = serve(|server| server.discovery(at("0.0.0.0:0"))).unwrap();
    let to = (
        "127.0.0.1:0".parse::<SocketAddr>().unwrap().ip(),
        discovery(&served).port(),
    );
    assert!(ask(&socket(), to.into()).starts_with("127.0.0.1,02"));
}

#[test]
fn a_port_that_was_asked_for_and_is_taken_is_an_error() {
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let error = serve(|server| server.discovery(at(&address)))
        .err()
        .unwrap();
    assert!(matches!(error, ServeError::Endpoint { action: "bind", .. }));
    assert!(error.to_string().starts_with(&address), "{error}");
}

#[test]
fn an_arm_on_another_port_is_not_announced() {
    let served = serve(|server| server.udp("127.0.0.1:0")).unwrap();
    assert!(matches!(served.endpoints[..], [Endpoint::Udp(_)]));
}

/// The standard ports.
#[cfg(target_os = "linux")]
mod usual_ports {
    use super::super::served::own_host;
    use super::*;
    use magician::serve::Notice;

    #[test]
    fn an_arm_on_the_usual_port_is_found() {
        let host = own_host();
        let served = serve(|server| server.udp(&host)).unwrap();
        assert_eq!(discovery(&served), format!("{host}:48899").parse().unwrap());
        let answer = ask(&socket(), discovery(&served));
        let ip = answer.split(',').next().unwrap();
        // A host continues at port 8899 of the address in the answer.
        let socket = socket();
        socket.send_to(&get_pose(), format!("{ip}:8899")).unwrap();
        assert_eq!(socket.recv(&mut [0; 64]).unwrap(), 38);
    }

    #[test]
    fn an_arm_that_cannot_be_found_is_served_and_says_so() {
        let host = own_host();
        let first = UdpSocket::bind(format!("{host}:48899")).unwrap();
        let served = serve(|server| server.udp(&host)).unwrap();
        assert!(matches!(served.endpoints[..], [Endpoint::Udp(_)]));
        served.wait_for(|notice| match notice {
            Notice::Undiscoverable { address, .. } => *address == first.local_addr().unwrap(),
            _ => false,
        });
    }

    #[test]
    fn an_arm_may_stay_hidden() {
        let host = own_host();
        let served = serve(|server| server.udp(&host).discovery(Discovery::Off)).unwrap();
        assert!(matches!(served.endpoints[..], [Endpoint::Udp(_)]));
        UdpSocket::bind(format!("{host}:48899")).unwrap();
    }
}
