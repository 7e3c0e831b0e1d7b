//! Shared arms: a virtual arm of this process at endpoints, and any arm behind a proxy.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use magician::proxy::{Event, Settings};
use magician::serve::{Endpoint, Endpoints, ProxyNotice, ProxyServer, ServeError, ServedArm};
use magician::sim::ExternalEvent;
use magician::{ErrorKind, LineOptions, Options, RawLine, VirtualArm, blocking, build};
use tokio::sync::oneshot;

use super::served::{DEADLINE, ask, get_pose, set_name};

/// Service over TCP on a background thread, until it is dropped.
struct Shared {
    address: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<Result<(), ServeError>>>,
}

impl Shared {
    fn start(
        serve: impl AsyncFnOnce(
            &Endpoints,
            &dyn Fn(&[Endpoint]),
            oneshot::Receiver<()>,
        ) -> Result<(), ServeError>
        + Send
        + 'static,
    ) -> Self {
        let (ready, is_ready) = channel();
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build();
            let endpoints = Endpoints::new().tcp("127.0.0.1:0");
            let ready = |endpoints: &[Endpoint]| match endpoints {
                [Endpoint::Tcp(address), ..] => ready.send(*address).unwrap(),
                other => panic!("{other:?}"),
            };
            runtime
                .unwrap()
                .block_on(serve(&endpoints, &ready, stopped))
        });
        Self {
            address: is_ready.recv_timeout(DEADLINE).expect("it is served"),
            stop: Some(stop),
            thread: Some(thread),
        }
    }

    fn arm(arm: &VirtualArm) -> Self {
        let arm = arm.clone();
        Self::start(async move |endpoints, ready, stopped| {
            let served = ServedArm::open(arm, endpoints)?;
            ready(&served.endpoints());
            served.serve_until(stopped).await.map(drop)
        })
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(DEADLINE)).unwrap();
        stream
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(ended) = self.thread.take().map(JoinHandle::join)
            && !std::thread::panicking()
        {
            ended.unwrap().unwrap();
        }
    }
}

#[test]
fn other_programs_talk_to_the_arm_that_this_one_looks_at() {
    for cell in [
        VirtualArm::default(),
        VirtualArm::default().in_virtual_time(),
    ] {
        let shared = Shared::arm(&cell);
        let mut other = shared.connect();
        let own = blocking::Arm::simulated(cell.clone(), Options::default()).unwrap();
        own.clear_alarms().unwrap();
        own.run(&[build::move_to(220.0, 40.0, 30.0, 0.0)]).unwrap();
        let pose = ask(&mut other, &get_pose());
        let x = f32::from_le_bytes(pose[5..9].try_into().unwrap());
        assert!((f64::from(x) - cell.state().pose.x).abs() < 1e-3, "{x}");
        assert!((x - 220.0).abs() < 1e-3, "{x}");
        ask(&mut other, &set_name("from outside\0"));
        assert_eq!(
            own.get::<magician::commands::DeviceName>()
                .unwrap()
                .device_name
                .as_str()
                .unwrap(),
            "from outside"
        );
    }
}

#[cfg(unix)]
#[test]
fn an_arm_is_put_back_where_no_client_has_spoken() {
    let cell = VirtualArm::default().in_virtual_time();
    let before = cell.snapshot();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("arm");
    let (arm, terminal) = (cell.clone(), path.clone());
    let shared = Shared::start(async move |_, ready, stopped| {
        let endpoints = Endpoints::new().tcp("127.0.0.1:0").pty(terminal);
        let served = ServedArm::open(arm, &endpoints)?;
        ready(&served.endpoints());
        served.serve_until(stopped).await.map(drop)
    });
    cell.restore(&before).expect("nobody has spoken");
    let mut terminal = std::fs::File::options()
        .read(true)
        .write(true)
        .open(&path)
        .unwrap();
    ask(&mut terminal, &set_name("changed\0"));
    let refused = cell.restore(&before).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::InvalidInput);
    // The symlink existed until now.
    drop(terminal);
    drop(shared);
    assert!(!path.is_symlink());
    cell.restore(&before).expect("its clients are gone with it");
}

#[test]
fn its_cable_is_that_of_its_endpoints() {
    // The clock of the arm stands, so only the cable wakes the endpoints.
    let cell = VirtualArm::default().in_virtual_time();
    let shared = Shared::arm(&cell);
    let plug = |plugged| cell.with(|arm| arm.inject(ExternalEvent::Cable { plugged }));
    let answered = || {
        let mut client = TcpStream::connect(shared.address).ok()?;
        client.set_read_timeout(Some(DEADLINE)).ok()?;
        client.write_all(&get_pose()).ok()?;
        client.read_exact(&mut [0; 38]).ok()?;
        Some(client)
    };
    // Repeated, because the endpoints may still be awake for their client.
    for _ in 0..20 {
        // While the endpoints follow the cable, connections are refused.
        let mut client = loop {
            if let Some(client) = answered() {
                break client;
            }
        };
        plug(false);
        assert!(matches!(client.read(&mut [0; 8]), Ok(0)), "it is hung up");
        plug(true);
    }
}

#[test]
fn a_proxy_tells_what_passes_and_writes_it_down() {
    let cell = VirtualArm::default();
    let told = Arc::new(Mutex::new(Vec::new()));
    let file = tempfile::NamedTempFile::new().unwrap();
    let (hears, trace) = (Arc::clone(&told), file.reopen().unwrap());
    let shared = Shared::start(async move |endpoints, ready, stopped| {
        let line = RawLine::simulated(cell, LineOptions::default())
            .await
            .unwrap();
        let proxy = ProxyServer::open(line, endpoints, Settings::default())?;
        ready(&proxy.endpoints());
        let observer = move |notice: ProxyNotice<'_>| {
            let said = match notice {
                ProxyNotice::Traffic { event, client } => {
                    let word = match event {
                        Event::Request { .. } => "request",
                        Event::Reply { .. } => "reply",
                        _ => "other",
                    };
                    format!(
                        "{word} {}",
                        client.is_some_and(|who| who.starts_with("tcp:"))
                    )
                }
                ProxyNotice::Client(notice) => {
                    format!("{notice:?}").split('(').next().unwrap().to_owned()
                }
                other => format!("{other:?}"),
            };
            hears.lock().unwrap().push(said);
        };
        let proxy = proxy.observed(observer).traced(trace).unwrap();
        proxy.serve_until(stopped).await.map(drop)
    });
    let mut client = shared.connect();
    assert_eq!(ask(&mut client, &get_pose()).len(), 38);
    drop(shared);
    assert_eq!(
        *told.lock().unwrap(),
        ["Connected", "request true", "reply true"]
    );
    let trace = std::fs::read(file.path()).unwrap();
    let packets = magician_record::trace::read_trace(&trace).map(Result::unwrap);
    assert_eq!(packets.count(), 4, "to the arm and back, on two links");
}
