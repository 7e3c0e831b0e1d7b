//! The handles over real descriptors: a pseudo-terminal, UDP and TCP.
#![cfg(unix)]

mod datagrams;
mod replug;
mod spoilt;

use std::path::Path;
use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::thread::JoinHandle;
use std::time::Duration;

use magician::commands::{DeviceName, Pose};
use magician::protocol::Text;
use magician::serve::{Endpoint, Handle, ServeError, Server};
use magician::sim::{Controller, Profile, Speed};
use magician::{ErrorKind, Set, Target, blocking, build};
use tokio::sync::oneshot;

/// Virtual arm behind endpoints, on a background thread.
struct Served {
    endpoints: Vec<Endpoint>,
    handle: Handle,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<Result<(), ServeError>>>,
}

fn serve(build: impl FnOnce(Server) -> Server) -> Served {
    let (ready, is_ready) = channel();
    let (stop, stopped) = oneshot::channel::<()>();
    let server = Server::new(Controller::new(Profile::default())).speed(Speed::Max);
    let server = build(server);
    let handle = server.handle();
    let server = server.on_ready(move |endpoints| ready.send(endpoints.to_vec()).unwrap());
    let thread = std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        runtime.block_on(server.serve_until(async move {
            let _ = stopped.await;
        }))
    });
    let endpoints = is_ready.recv_timeout(Duration::from_secs(120)).unwrap();
    Served {
        endpoints,
        handle,
        stop: Some(stop),
        thread: Some(thread),
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn works(target: &Target) {
    let arm = blocking::Arm::connect(target).unwrap();
    let name = DeviceName {
        device_name: Text::new("over the wire").unwrap(),
    };
    arm.set(&name).unwrap();
    assert_eq!(arm.get::<DeviceName>().unwrap(), name);
    arm.run(&[
        build::move_to(210.0, 30.0, 40.0, 0.0),
        build::line_by(0.0, -60.0, 0.0, 0.0),
    ])
    .unwrap();
    let pose: Pose = arm.get().unwrap();
    assert_eq!((pose.x, pose.y, pose.z), (210.0, -30.0, 40.0));
    arm.start(vec![build::wait(Duration::from_millis(2)); 100])
        .wait(|_| {})
        .unwrap();
    arm.stop().unwrap();
}

fn serial(path: &Path) -> Target {
    Target::Serial(path.to_str().unwrap().to_owned())
}

#[test]
fn over_a_pseudo_terminal_again_and_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let _served = serve(|server| server.pty(&path));
    for _ in 0..3 {
        works(&serial(&path));
    }
}

#[test]
fn a_port_in_use_names_its_user() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let _served = serve(|server| server.pty(&path));
    let _first = blocking::Arm::connect(serial(&path)).unwrap();
    let error = blocking::Arm::connect(serial(&path)).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port);
    assert!(error.to_string().contains("in use by"), "{error}");
    #[cfg(target_os = "linux")]
    assert!(error.to_string().contains("this program itself"), "{error}");
}

/// Lock held while a port is closed and reopened, and while a process is started until it has
/// printed something. A child briefly has the open, locked ports of all tests: `spawn` returns
/// before the system has closed them.
static CHILDREN: Mutex<()> = Mutex::new(());

#[cfg(target_os = "linux")]
#[test]
fn a_port_that_another_program_has_locked_is_not_said_to_be_ours() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let _served = serve(|server| server.pty(&path));
    let starting = CHILDREN.lock().unwrap();
    let other = std::process::Command::new("flock")
        .arg(path.canonicalize().unwrap())
        .args(["sh", "-c", "echo locked; read _"])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn();
    let Ok(mut other) = other else { return };
    let mut line = String::new();
    let out = other.stdout.take().unwrap();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(out), &mut line).unwrap();
    drop(starting);
    let message = blocking::Arm::connect(serial(&path))
        .unwrap_err()
        .to_string();
    drop(other.stdin.take());
    other.wait().unwrap();
    assert!(
        message.contains("in use by") && message.contains("(process "),
        "{message}"
    );
    // This program serves the arm, and does not use it.
    assert!(!message.contains("this program itself"), "{message}");
}

#[test]
fn a_runtime_that_goes_first_stops_the_arm_over_a_pseudo_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let _served = serve(|server| server.speed(Speed::Times(1.0)).pty(&path));
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    runtime.block_on(async {
        let arm = magician::Arm::connect(serial(&path)).await.unwrap();
        arm.queue().start().await.unwrap();
        for y in [100.0, -100.0, 100.0, -100.0] {
            let Set::PtpCmd(go) = build::move_to(200.0, y, 40.0, 0.0) else {
                panic!()
            };
            arm.enqueue(&go).await.unwrap();
        }
        // Dropped here; the task that would stop the arm is never polled again.
    });
    let no_children = CHILDREN.lock().unwrap();
    drop(runtime);
    let arm = blocking::Arm::connect(serial(&path)).unwrap();
    drop(no_children);
    arm.wait_still().unwrap();
    assert_eq!(arm.queue().left_space().unwrap(), 32);
}

#[test]
fn over_udp_and_tcp() {
    let served = serve(|server| server.udp("127.0.0.1:0").tcp("127.0.0.1:0"));
    for endpoint in &served.endpoints {
        let target = match endpoint {
            Endpoint::Udp(address) => format!("udp:{address}"),
            Endpoint::Tcp(address) => format!("tcp:{address}"),
            other => panic!("{other}"),
        };
        works(&target.parse().unwrap());
    }
}

#[test]
fn a_host_that_refuses_is_named() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    drop(listener);
    let error = blocking::Arm::connect(format!("tcp:{address}")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port);
    assert!(error.to_string().contains("127.0.0.1"), "{error}");
}
