//! Server on a background thread, for tests that talk to it through real descriptors. Every wait
//! has a deadline far beyond its usual duration, and ends as soon as its event occurs.

#![allow(dead_code, reason = "each test uses its part")]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use magician::serve::{Endpoint, Handle, Notice, ServeError, Server, serve_all};
use magician_protocol::{Ctrl, FrameBuf};
use magician_sim::{Controller, Profile, Speed};
use tokio::sync::oneshot;

pub(crate) const DEADLINE: Duration = Duration::from_secs(120);

pub(crate) struct Served {
    pub(crate) endpoints: Vec<Endpoint>,
    /// Handle of each arm.
    pub(crate) handles: Vec<Handle>,
    notices: Receiver<Notice>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<Result<(), ServeError>>>,
}

/// Starts a server and waits until it is ready.
pub(crate) fn serve(build: impl FnOnce(Server) -> Server) -> Result<Served, ServeError> {
    serve_arm(Profile::default(), build)
}

/// Starts a server for this arm and waits until it is ready.
pub(crate) fn serve_arm(
    profile: Profile,
    build: impl FnOnce(Server) -> Server,
) -> Result<Served, ServeError> {
    start([build(server(profile))])
}

/// Starts `count` arms in one server, numbered from 1, and waits until all are ready.
pub(crate) fn serve_arms(
    count: u32,
    build: impl Fn(Server) -> Server,
) -> Result<Served, ServeError> {
    start((1..=count).map(|number| {
        let mut profile = Profile::default();
        profile.identity = profile.identity.numbered(number);
        build(server(profile)).number(number)
    }))
}

fn server(profile: Profile) -> Server {
    Server::new(Controller::new(profile)).speed(Speed::Max)
}

fn start(servers: impl IntoIterator<Item = Server>) -> Result<Served, ServeError> {
    let (ready, is_ready) = channel();
    let (notice, notices) = channel();
    let (stop, stopped) = oneshot::channel();
    let watch = |server: Server| {
        let (ready, notice) = (ready.clone(), notice.clone());
        server
            .on_ready(move |endpoints| ready.send(endpoints.to_vec()).unwrap())
            .on_notice(move |seen| drop(notice.send(seen)))
    };
    let servers: Vec<Server> = servers.into_iter().map(watch).collect();
    let handles: Vec<Handle> = servers.iter().map(Server::handle).collect();
    drop(ready);
    let thread = std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        runtime.block_on(serve_all(servers, async {
            let _ = stopped.await;
        }))
    });
    let mut endpoints = Vec::new();
    for _ in &handles {
        match is_ready.recv_timeout(DEADLINE) {
            Ok(of_one) => endpoints.extend(of_one),
            Err(_) => return Err(thread.join().unwrap().unwrap_err()),
        }
    }
    Ok(Served {
        endpoints,
        handles,
        notices,
        stop: Some(stop),
        thread: Some(thread),
    })
}

impl Served {
    /// Waits for a notice.
    pub(crate) fn wait_for(&self, wanted: impl Fn(&Notice) -> bool) {
        while !wanted(&self.notices.recv_timeout(DEADLINE).expect("a notice")) {}
    }

    /// Ends the server as Ctrl-C does.
    pub(crate) fn stop(mut self) {
        self.end();
    }

    fn end(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            if !std::thread::panicking() {
                ended.unwrap().unwrap();
            }
        }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.end();
    }
}

/// Sends a request and reads one frame.
pub(crate) fn ask(stream: &mut (impl Read + Write), request: &[u8]) -> Vec<u8> {
    stream.write_all(request).unwrap();
    let mut reply = vec![0; 3];
    stream.read_exact(&mut reply).unwrap();
    reply.resize(usize::from(reply[2]) + 4, 0);
    stream.read_exact(&mut reply[3..]).unwrap();
    reply
}

pub(crate) fn get(id: u8) -> Vec<u8> {
    FrameBuf::new(id, Ctrl::GET, &[]).unwrap().bytes().to_vec()
}

pub(crate) fn get_pose() -> Vec<u8> {
    get(10)
}

pub(crate) fn set_name(name: &str) -> Vec<u8> {
    let name = name.as_bytes();
    FrameBuf::new(1, Ctrl::SET, name).unwrap().bytes().to_vec()
}

/// Returns the name in the reply to GetDeviceName.
pub(crate) fn name(reply: &[u8]) -> String {
    let frame = magician_protocol::Frame::new(reply).expect("a whole frame");
    assert_eq!(frame.id(), 1);
    let name = String::from_utf8(frame.params().to_vec()).unwrap();
    name.trim_end_matches('\0').to_owned()
}

/// Returns a loopback address that no other test uses, in this process or another. A socket on an
/// unused port reserves it until the process ends. Other systems have only one loopback address.
#[cfg(target_os = "linux")]
pub(crate) fn own_host() -> String {
    use std::net::UdpSocket;
    use std::sync::Mutex;
    static HELD: Mutex<Vec<UdpSocket>> = Mutex::new(Vec::new());
    let first = std::process::id().wrapping_mul(8);
    let (host, held) = (first..first + 1000)
        .find_map(|number| {
            let [_, a, b, c] = number.to_be_bytes();
            let host = format!("127.{}.{b}.{c}", a | 1);
            let held = UdpSocket::bind(format!("{host}:19999")).ok()?;
            Some((host, held))
        })
        .expect("a loopback address that is free");
    HELD.lock().expect("nobody panics with it").push(held);
    host
}

/// Connects a client to an arm over TCP.
pub(crate) fn connect(address: SocketAddr) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(DEADLINE)).unwrap();
    stream
}

/// Creates a client of an arm over UDP.
pub(crate) fn socket() -> UdpSocket {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(DEADLINE)).unwrap();
    socket
}
