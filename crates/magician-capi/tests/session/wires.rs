//! Real file descriptors: an arm on a pseudo-terminal, UDP and TCP, and devices that are not an
//! arm.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use magician::serve::{Endpoint, Handle, ServeError, Server};
use magician::sim::{Controller, Profile, Speed};
use magician_capi::session::{Registry, Timeouts};
use tokio::sync::oneshot;

use crate::bench::{
    DEADLINE, UNTOUCHED, connect_v1, connect_v3, connect_without_buffers, fault, home,
    isolated_environment, long_timeouts, pose, registry, run,
};

/// A virtual arm served at endpoints, on a thread.
struct Served {
    endpoints: Vec<Endpoint>,
    handle: Handle,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<Result<(), ServeError>>>,
}

fn serve(build: impl FnOnce(Server) -> Server) -> Served {
    let (ready, is_ready) = channel();
    let (stop, stopped) = oneshot::channel::<()>();
    let server = build(Server::new(Controller::new(Profile::default())).speed(Speed::Max));
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
    Served {
        endpoints: is_ready.recv_timeout(DEADLINE).unwrap(),
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

/// A device on a pseudo-terminal, whose answers a closure computes.
struct Device {
    path: PathBuf,
    heard: Receiver<Vec<u8>>,
    /// Kept open: otherwise the terminal hangs up when a program closes its end.
    terminal: Option<OwnedFd>,
    thread: Option<JoinHandle<()>>,
}

impl Device {
    fn new(mut says: impl FnMut(&[u8]) -> Vec<u8> + Send + 'static) -> Self {
        use rustix::fs::{Mode, OFlags};
        use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
        use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let path = ptsname(&master, Vec::new()).unwrap();
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let terminal = rustix::fs::open(&path, flags, Mode::empty()).unwrap();
        let mut settings = tcgetattr(&terminal).unwrap();
        settings.make_raw();
        tcsetattr(&terminal, OptionalActions::Now, &settings).unwrap();
        let (tell, heard) = channel();
        let thread = std::thread::spawn(move || {
            let mut master = File::from(master);
            let mut bytes = [0; 256];
            // Ends when the last client closes the terminal.
            while let Ok(count @ 1..) = master.read(&mut bytes) {
                let answer = says(&bytes[..count]);
                let _ = tell.send(bytes[..count].to_vec());
                if master.write_all(&answer).is_err() {
                    return;
                }
            }
        });
        Self {
            path: path.into_string().unwrap().into(),
            heard,
            terminal: Some(terminal),
            thread: Some(thread),
        }
    }

    fn silent() -> Self {
        Self::new(|_| Vec::new())
    }

    fn name(&self) -> &str {
        self.path.to_str().unwrap()
    }

    /// Waits until the device has received these bytes.
    fn hears(&self, wanted: &[u8]) {
        let mut all = Vec::new();
        while !all.windows(wanted.len()).any(|bytes| bytes == wanted) {
            all.extend(self.heard.recv_timeout(DEADLINE).unwrap());
        }
    }

    /// Returns everything that the device has received. All programs must have closed it.
    fn all(mut self) -> Vec<u8> {
        drop(self.terminal.take());
        let thread = self.thread.take().unwrap();
        thread.join().unwrap();
        self.heard.try_iter().flatten().collect()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        drop(self.terminal.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Registry with short timeouts for a device that never answers, and `text` as given.
fn with_short_timeouts(text: Duration) -> Registry {
    let short = Duration::from_millis(20);
    let timeouts = Timeouts {
        serial: short,
        network: short,
        text,
        standing: short,
    };
    Registry::new(isolated_environment(), timeouts)
}

const TEXT: &[u8] = b"\nM10\nM10\nM10\nM10\nM10\n";
const GET_POSE: &[u8] = &[0xAA, 0xAA, 2, 10, 0, 0xF6];

fn arm_at(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

#[test]
fn over_a_pseudo_terminal_again_and_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let _served = serve(|server| server.pty(&path));
    let registry = registry();
    for index in 2..5 {
        let said = connect_v1(&registry, &arm_at(&path));
        assert_eq!((said.code, said.firmware.as_str()), (0, "DobotSerial"));
        assert_eq!(home(&registry), (0, index));
        if index == 3 {
            registry.disconnect(0);
        }
    }
}

#[test]
fn over_udp_and_tcp() {
    let served = serve(|server| server.udp("127.0.0.1:0").tcp("127.0.0.1:0"));
    let registry = registry();
    for endpoint in &served.endpoints {
        let (name, firmware) = match endpoint {
            Endpoint::Udp(address) => (format!("udp:{address}"), "DobotWifi"),
            Endpoint::Tcp(address) => (format!("tcp:{address}"), "DobotSerial"),
            other => panic!("{other}"),
        };
        let said = connect_v1(&registry, &name);
        assert_eq!((said.code, said.firmware.as_str()), (0, firmware));
        assert_eq!(pose(&registry).0, 0);
    }
}

#[test]
fn a_port_in_use_is_occupied_until_it_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let _served = serve(|server| server.pty(&path));
    let (first, second) = (registry(), registry());
    assert_eq!(connect_v1(&first, &arm_at(&path)).code, 0);
    assert_eq!(connect_v1(&second, &arm_at(&path)).code, 2);
    assert!(fault().contains("in use"), "{}", fault());
    first.disconnect(0);
    assert_eq!(connect_v1(&second, &arm_at(&path)).code, 0);
}

#[test]
fn unplugged_line_times_out_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let served = serve(|server| server.pty(&path));
    let registry = registry();
    assert_eq!(connect_v1(&registry, &arm_at(&path)).code, 0);
    // With this timeout the call ends in time only if the broken line ends it.
    registry.set_timeout(0, u32::MAX);
    served.handle.unplug().wait().unwrap();
    let (code, bytes) = pose(&registry);
    assert_eq!((code, bytes[0]), (2, UNTOUCHED));
    assert!(fault().contains("broke off"), "{}", fault());
    assert_eq!(home(&registry), (2, 0));
    served.handle.plug().wait().unwrap();
    assert_eq!(connect_v1(&registry, &arm_at(&path)).code, 0);
    assert_eq!(home(&registry), (0, 2), "nothing had been taken");
}

#[test]
fn printer_firmware_is_reported_and_its_port_closed() {
    let marlin = |bytes: &[u8]| {
        if bytes.windows(3).any(|word| word == b"M10") {
            b"start\r\nMARLIN: V1.0.2\r\nok\r\n".to_vec()
        } else {
            Vec::new()
        }
    };
    let device = Device::new(marlin);
    let registry = with_short_timeouts(DEADLINE);
    // Connecting twice works, so the port was closed in between.
    for _ in 0..2 {
        let said = connect_v1(&registry, device.name());
        assert_eq!(said.code, 0);
        assert_eq!(
            (said.firmware.as_str(), said.version.as_str()),
            ("MARLIN", "1.0.2")
        );
        assert_eq!(pose(&registry).0, 2);
        assert!(fault().contains("MARLIN 1.0.2"), "{}", fault());
    }
    let (code, info) = connect_v3(&registry, device.name());
    assert_eq!((code, &info[..8]), (0, &[1, 0, 0, 0, 0, 0, 0, 0][..]));
    assert_eq!(&info[8..15], b"MARLIN\0");
    let text: Vec<u8> = device.all();
    assert!(text.windows(TEXT.len()).any(|bytes| bytes == TEXT));
}

#[test]
fn silent_port_counts_as_connected() {
    let device = Device::silent();
    let registry = with_short_timeouts(Duration::from_millis(20));
    let said = connect_v1(&registry, device.name());
    assert_eq!((said.code, said.firmware.as_str()), (0, "DobotSerial"));
    assert_eq!(said.version, "0.0.0");
    assert!(fault().contains("no arm answers"), "{}", fault());
    registry.set_timeout(0, 1);
    let (code, bytes) = pose(&registry);
    assert_eq!((code, bytes[0]), (2, UNTOUCHED));
    assert_eq!(home(&registry), (2, 0));
    drop(registry);
    let heard = device.all();
    assert!(heard.windows(TEXT.len()).any(|bytes| bytes == TEXT));
    let home = [0xAA, 0xAA, 6, 31, 3];
    assert!(
        !heard.windows(5).any(|bytes| bytes == home),
        "the queue could not be read, so nothing was put into it"
    );
}

#[test]
fn no_text_probe_without_a_firmware_buffer() {
    let device = Device::silent();
    let registry = with_short_timeouts(DEADLINE);
    assert_eq!(connect_without_buffers(&registry, device.name()), 0);
    registry.disconnect(0);
    assert!(!device.all().windows(3).any(|bytes| bytes == b"M10"));
}

#[test]
fn arm_gets_no_text_probe() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let _served = serve(|server| server.pty(&path));
    // If the port were asked in text, this timeout would never expire.
    let timeouts = Timeouts {
        text: Duration::MAX,
        ..long_timeouts()
    };
    let registry = Registry::new(isolated_environment(), timeouts);
    assert_eq!(connect_v1(&registry, &arm_at(&path)).code, 0);
}

#[test]
fn waiting_call_ends_with_its_connection() {
    let device = Device::silent();
    let registry = with_short_timeouts(Duration::from_millis(1));
    assert_eq!(connect_v1(&registry, device.name()).code, 0);
    registry.set_timeout(0, u32::MAX);
    std::thread::scope(|scope| {
        let waits = scope.spawn(|| pose(&registry));
        device.hears(GET_POSE);
        assert_eq!(registry.disconnect(0), 0);
        let (code, bytes) = waits.join().unwrap();
        assert_eq!((code, bytes), (0, [UNTOUCHED; 32]));
    });
    assert_eq!(run(&registry, "GetPose", 0, |_| Ok(())), 2);
}
