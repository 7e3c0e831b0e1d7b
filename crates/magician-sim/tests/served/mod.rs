//! A server on a thread of its own, for tests that talk to it through real descriptors. Every wait
//! has a deadline far beyond what it can take, and ends as soon as what it waits for is there.

#![allow(dead_code, reason = "each test uses its part")]

use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use magician_protocol::{Ctrl, FrameBuf};
use magician_sim::serve::{Endpoint, Notice, ServeError, Server};
use magician_sim::{Controller, Profile, Speed};
use tokio::sync::oneshot;

pub(crate) const DEADLINE: Duration = Duration::from_secs(20);

pub(crate) struct Served {
    pub(crate) endpoints: Vec<Endpoint>,
    notices: Receiver<Notice>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<Result<(), ServeError>>>,
}

/// Starts a server and waits until it is ready.
pub(crate) fn serve(build: impl FnOnce(Server) -> Server) -> Result<Served, ServeError> {
    serve_arm(Profile::default(), build)
}

/// Starts a server of this arm and waits until it is ready.
pub(crate) fn serve_arm(
    profile: Profile,
    build: impl FnOnce(Server) -> Server,
) -> Result<Served, ServeError> {
    let (ready, is_ready) = channel();
    let (notice, notices) = channel();
    let (stop, stopped) = oneshot::channel();
    let server = Server::new(Controller::new(profile)).speed(Speed::Max);
    let server = build(server)
        .on_ready(move |endpoints| ready.send(endpoints.to_vec()).unwrap())
        .on_notice(move |seen| drop(notice.send(seen)));
    let thread = std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        runtime.block_on(server.serve_until(async {
            let _ = stopped.await;
        }))
    });
    match is_ready.recv_timeout(DEADLINE) {
        Ok(endpoints) => Ok(Served {
            endpoints,
            notices,
            stop: Some(stop),
            thread: Some(thread),
        }),
        Err(_) => Err(thread.join().unwrap().unwrap_err()),
    }
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

/// The name in the reply to GetDeviceName.
pub(crate) fn name(reply: &[u8]) -> String {
    let frame = magician_protocol::Frame::new(reply).expect("a whole frame");
    assert_eq!(frame.id(), 1);
    let name = String::from_utf8(frame.params().to_vec()).unwrap();
    name.trim_end_matches('\0').to_owned()
}
