//! Several arms in one server, each with its own endpoints.

use super::served;
use std::net::{SocketAddr, TcpStream};

use magician::serve::{Endpoint, ServeError};
use magician_protocol::Readable;
use magician_protocol::commands::{DeviceId, DeviceName, DeviceSn};

use super::served::{Served, ask, connect, get, name, serve_arms, set_name};

fn sockets(served: &Served) -> Vec<SocketAddr> {
    let find = |endpoint: &Endpoint| match endpoint {
        Endpoint::Tcp(address) | Endpoint::Udp(address) => Some(*address),
        _ => None,
    };
    served.endpoints.iter().filter_map(find).collect()
}

#[test]
fn every_arm_is_an_arm_of_its_own() {
    let served = serve_arms(5, |server| server.tcp("127.0.0.1:0")).unwrap();
    let mut streams: Vec<TcpStream> = sockets(&served).into_iter().map(connect).collect();
    assert_eq!(streams.len(), 5);
    for id in [DeviceSn::ROW.id, DeviceName::ROW.id, DeviceId::ROW.id] {
        let told = |stream: &mut TcpStream| ask(stream, &get(id));
        let mut told: Vec<Vec<u8>> = streams.iter_mut().map(told).collect();
        told.sort();
        told.dedup();
        assert_eq!(told.len(), 5, "{id}");
    }
    assert_eq!(name(&ask(&mut streams[2], &get(1))), "Dobot 2.0 #3");
    ask(&mut streams[2], &set_name("changed"));
    assert_eq!(name(&ask(&mut streams[2], &get(1))), "changed");
    assert_eq!(name(&ask(&mut streams[3], &get(1))), "Dobot 2.0 #4");
}

#[test]
fn ports_that_do_not_exist_are_an_error() {
    let error = serve_arms(3, |server| server.tcp("127.0.0.1:65534"));
    let error = error.err().unwrap();
    assert!(matches!(error, ServeError::Address { .. }));
    assert!(error.to_string().contains("65535"), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn ports_count_up_from_the_first() {
    let host = served::own_host();
    let first = format!("{host}:21000");
    let served = serve_arms(4, |server| server.tcp(&first).udp(&host)).unwrap();
    let found = sockets(&served).into_iter().map(|address| address.port());
    let expected = [21000, 8899, 21001, 8900, 21002, 8901, 21003, 8902];
    assert_eq!(found.collect::<Vec<u16>>(), expected);
    // Searching hosts connect to the standard port, which only one arm has.
    let discovery = |endpoint: &&Endpoint| matches!(endpoint, Endpoint::Discovery(_));
    assert_eq!(served.endpoints.iter().filter(discovery).count(), 1);
}

#[cfg(target_os = "linux")]
#[test]
fn one_address_that_is_taken_opens_none() {
    use std::net::UdpSocket;

    let host = served::own_host();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let taken = format!("{host}:21002");
    let _taken = UdpSocket::bind(&taken).unwrap();
    let first = format!("{host}:21000");
    let error = serve_arms(3, |server| server.pty(&path).udp(&first));
    let said = error.err().unwrap().to_string();
    assert!(said.starts_with(&taken), "{said}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    for port in [21000, 21001] {
        UdpSocket::bind(format!("{host}:{port}")).unwrap();
    }
}

#[cfg(unix)]
mod terminals {
    use super::*;
    use std::fs;
    use std::path::Path;

    fn open(path: &Path) -> fs::File {
        let mut options = fs::File::options();
        options.read(true).write(true).open(path).unwrap()
    }

    fn left_in(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name());
        let mut names: Vec<_> = names.map(|name| name.into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn paths_are_numbered_and_gone_at_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm");
        let served = serve_arms(3, |server| server.pty(&path).tcp("127.0.0.1:0")).unwrap();
        assert_eq!(left_in(folder.path()), ["arm.1", "arm.2", "arm.3"]);
        for (at, address) in sockets(&served).into_iter().enumerate() {
            let mut terminal = open(&folder.path().join(format!("arm.{}", at + 1)));
            let own = format!("number {at}");
            ask(&mut terminal, &set_name(&own));
            assert_eq!(name(&ask(&mut connect(address), &get(1))), own);
        }
        served.stop();
        assert!(left_in(folder.path()).is_empty());
    }

    #[test]
    fn one_path_that_is_taken_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm");
        std::os::unix::fs::symlink("/somewhere", folder.path().join("arm.1")).unwrap();
        fs::write(folder.path().join("arm.3"), "precious").unwrap();
        let error = serve_arms(3, |server| server.pty(&path)).err().unwrap();
        assert!(matches!(&error, ServeError::Occupied { path } if path.ends_with("arm.3")));
        assert_eq!(left_in(folder.path()), ["arm.1", "arm.3"]);
        let first = fs::read_link(folder.path().join("arm.1")).unwrap();
        assert_eq!(first, Path::new("/somewhere"));
    }

    #[test]
    fn a_server_that_is_dropped_leaves_no_path() {
        use magician::serve::{Server, serve_all};
        use magician_sim::Controller;

        let folder = tempfile::tempdir().unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        let (ready, is_ready) = tokio::sync::oneshot::channel();
        let server = |number| {
            let server = Server::new(Controller::default()).number(number);
            server.pty(folder.path().join("arm"))
        };
        let servers = [server(1), server(2).on_ready(|_| ready.send(()).unwrap())];
        runtime.block_on(async {
            tokio::select! {
                _ = serve_all(servers, std::future::pending()) => {}
                ready = is_ready => ready.unwrap(),
            }
        });
        assert!(left_in(folder.path()).is_empty());
    }
}
