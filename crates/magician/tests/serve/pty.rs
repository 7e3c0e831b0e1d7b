//! Pseudo-terminal, through real descriptors and with misbehaving clients.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::os::fd::OwnedFd;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use magician::serve::{Endpoint, Notice, ServeError};
use magician_protocol::{Deframer, Event};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use tempfile::TempDir;

use super::served::{DEADLINE, Served, get, get_pose, name, serve, set_name};

struct Arm {
    served: Served,
    path: PathBuf,
    folder: TempDir,
}

fn arm() -> Arm {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let served = serve(|server| server.pty(&path)).unwrap();
    Arm {
        served,
        path,
        folder,
    }
}

impl Arm {
    fn device(&self) -> PathBuf {
        match &self.served.endpoints[0] {
            Endpoint::Pty { device, .. } => device.clone(),
            other => panic!("{other}"),
        }
    }

    /// Waits until the server has noticed that the last client left.
    #[cfg(target_os = "linux")]
    fn wait_until_left(&self) {
        self.served
            .wait_for(|notice| matches!(notice, Notice::Left(_)));
    }
}

/// Descriptor of a client.
struct Client(OwnedFd);

impl Client {
    fn open(path: &Path) -> Self {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK;
        Self(rustix::fs::open(path, flags, Mode::empty()).unwrap())
    }

    /// Writes all bytes; panics if that takes longer than anything may.
    fn write(&self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            match rustix::io::write(&self.0, bytes) {
                Ok(count) => bytes = &bytes[count..],
                Err(Errno::AGAIN) => assert!(self.wait(PollFlags::OUT), "the server reads"),
                Err(error) => panic!("{error}"),
            }
        }
    }

    fn read(&self, length: usize) -> Vec<u8> {
        let mut bytes = vec![0; length];
        let mut filled = 0;
        while filled < length {
            match rustix::io::read(&self.0, &mut bytes[filled..]) {
                Ok(count) => filled += count,
                Err(Errno::AGAIN) => assert!(self.wait(PollFlags::IN), "{filled} of {length}"),
                Err(error) => panic!("{error}"),
            }
        }
        bytes
    }

    /// Returns the bytes that can be read without waiting.
    fn read_waiting(&self) -> Vec<u8> {
        let (mut all, mut bytes) = (Vec::new(), [0; 4096]);
        while let Ok(count @ 1..) = rustix::io::read(&self.0, &mut bytes) {
            all.extend_from_slice(&bytes[..count]);
        }
        all
    }

    fn ask(&self, request: &[u8]) -> Vec<u8> {
        self.write(request);
        self.reply()
    }

    /// Reads one frame.
    fn reply(&self) -> Vec<u8> {
        let head = self.read(3);
        let rest = self.read(usize::from(head[2]) + 1);
        [head, rest].concat()
    }

    fn wait(&self, what: PollFlags) -> bool {
        let mut fds = [PollFd::new(&self.0, what)];
        let deadline = Timespec {
            tv_sec: DEADLINE.as_secs() as i64,
            tv_nsec: 0,
        };
        poll(&mut fds, Some(&deadline)).unwrap() > 0
    }
}

fn ids(bytes: &[u8]) -> Vec<u8> {
    let (mut deframer, mut input, mut ids) = (Deframer::new(), bytes, Vec::new());
    while let Some(event) = deframer.next(&mut input) {
        match event {
            Event::Frame { frame, .. } => ids.push(frame.id()),
            other => panic!("{other:?}"),
        }
    }
    assert!(!deframer.pending());
    ids
}

#[test]
fn clients_come_and_go_and_the_arm_remembers() {
    let arm = arm();
    Client::open(&arm.path).ask(&set_name("kept"));
    for _ in 0..200 {
        let reply = Client::open(&arm.path).ask(&get_pose());
        assert_eq!(ids(&reply), [10]);
    }
    assert_eq!(name(&Client::open(&arm.path).ask(&get(1))), "kept");
}

#[test]
fn clients_that_only_open_and_close_do_no_harm() {
    let arm = arm();
    for _ in 0..200 {
        drop(Client::open(&arm.path));
    }
    assert_eq!(ids(&Client::open(&arm.path).ask(&get_pose())), [10]);
}

#[cfg(feature = "trace")]
#[test]
fn every_byte_value_reaches_the_arm_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let (path, file) = (folder.path().join("arm"), folder.path().join("trace"));
    let trace = fs::File::create(&file).unwrap();
    let served = serve(|server| server.pty(&path).trace(trace)).unwrap();
    let all: Vec<u8> = (0..=255).collect();
    let client = Client::open(&path);
    client.write(&all);
    // Bytes that a terminal would act on, as a name that is read back.
    let special = "\x11\x13\r\n\x04\x7F\x03\x1A\x1C\x15\x12";
    client.ask(&set_name(special));
    assert_eq!(name(&client.ask(&get(1))), special);
    served.stop();
    let file = fs::read(&file).unwrap();
    let sent: Vec<u8> = magician_record::trace::read_trace(&file)
        .map(Result::unwrap)
        .filter(|packet| packet.direction == Some(magician_protocol::Direction::Request))
        .flat_map(|packet| packet.bytes.to_vec())
        .collect();
    assert_eq!(sent, [&all[..], &set_name(special), &get(1)].concat());
}

#[test]
fn the_terminal_is_raw_from_the_beginning() {
    let arm = arm();
    let settings = rustix::termios::tcgetattr(&Client::open(&arm.path).0).unwrap();
    let mut raw = settings.clone();
    raw.make_raw();
    assert_eq!(settings.local_modes, raw.local_modes);
    assert_eq!(settings.input_modes, raw.input_modes);
    assert_eq!(settings.output_modes, raw.output_modes);
    assert_eq!(settings.output_speed(), 115_200);
}

#[cfg(target_os = "linux")]
#[test]
fn settings_that_a_client_left_are_undone() {
    let arm = arm();
    let client = Client::open(&arm.path);
    let mut settings = rustix::termios::tcgetattr(&client.0).unwrap();
    settings.local_modes |= rustix::termios::LocalModes::ECHO | rustix::termios::LocalModes::ICANON;
    rustix::termios::tcsetattr(&client.0, rustix::termios::OptionalActions::Now, &settings)
        .unwrap();
    drop(client);
    arm.wait_until_left();
    assert_eq!(ids(&Client::open(&arm.path).ask(&get_pose())), [10]);
}

#[cfg(target_os = "linux")]
#[test]
fn replies_that_nobody_read_are_not_for_the_next_client() {
    let arm = arm();
    let client = Client::open(&arm.path);
    client.write(&get_pose().repeat(3_000));
    client.write(&set_name("heard")[..5]);
    drop(client);
    arm.wait_until_left();
    let client = Client::open(&arm.path);
    assert_eq!(ids(&client.ask(&get(246))), [246]);
    assert_eq!(ids(&client.ask(&get_pose())), [10]);
    assert_eq!(client.read_waiting(), b"");
}

#[cfg(target_os = "linux")]
#[test]
fn what_a_client_wrote_before_it_left_is_obeyed() {
    let arm = arm();
    for round in 0..50 {
        let name_set = format!("round {round:02}");
        Client::open(&arm.path).write(&set_name(&name_set));
        arm.wait_until_left();
        assert_eq!(name(&Client::open(&arm.path).ask(&get(1))), name_set);
        arm.wait_until_left();
    }
}

#[test]
fn a_second_client_does_not_disturb_the_first() {
    let arm = arm();
    let first = Client::open(&arm.path);
    for _ in 0..50 {
        first.write(&get_pose());
        assert!(first.wait(PollFlags::IN));
        drop(Client::open(&arm.path));
        // The reply to the second request shows that the server has started, and the reply to the
        // third that it has finished with the departure of the other client, one round later.
        first.write(&get(246));
        assert_eq!(ids(&[first.reply(), first.reply()].concat()), [10, 246]);
        assert_eq!(ids(&first.ask(&get(246))), [246]);
    }
}

#[test]
fn a_client_that_does_not_read_gets_whole_frames_later() {
    let arm = arm();
    let client = Client::open(&arm.path);
    client.write(&get_pose().repeat(3_000));
    let mut received = Vec::new();
    while !ids_so_far(&received).contains(&246) {
        received.extend(client.read_waiting());
        client.write(&get(246));
        assert!(client.wait(PollFlags::IN));
    }
    let ids = ids_so_far(&received);
    let poses = ids.iter().filter(|id| **id == 10).count();
    assert!(poses > 50, "{poses}");
}

/// Returns the ids of all frames; fails on anything else but an unfinished frame at the end.
fn ids_so_far(bytes: &[u8]) -> Vec<u8> {
    let (mut deframer, mut input, mut ids) = (Deframer::new(), bytes, Vec::new());
    while let Some(event) = deframer.next(&mut input) {
        match event {
            Event::Frame { frame, .. } => ids.push(frame.id()),
            other => panic!("{other:?}"),
        }
    }
    ids
}

#[test]
fn a_symlink_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    symlink("/nowhere", &path).unwrap();
    let served = serve(|server| server.pty(&path)).unwrap();
    assert_eq!(ids(&Client::open(&path).ask(&get_pose())), [10]);
    served.stop();
    assert!(fs::symlink_metadata(&path).is_err());
}

#[cfg(target_os = "linux")]
#[test]
fn a_symlink_is_replaced_unless_its_server_lives() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    let first = serve(|server| server.pty(&path)).unwrap();
    for _ in 0..2 {
        let error = serve(|server| server.pty(&path)).err().unwrap();
        assert!(matches!(error, ServeError::Served { .. }), "{error}");
        // A client that came and went takes nothing from the server.
        assert_eq!(ids(&Client::open(&path).ask(&get_pose())), [10]);
    }
    first.stop();
    // The number of its terminal may belong to another server by now.
    let other = arm();
    let theirs = fs::read_link(&other.path).unwrap();
    symlink(theirs, &path).unwrap();
    let second = serve(|server| server.pty(&path)).unwrap();
    assert_eq!(ids(&Client::open(&path).ask(&get_pose())), [10]);
    second.stop();
    other.served.stop();
}

#[test]
fn anything_else_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (file, directory) = (folder.path().join("file"), folder.path().join("directory"));
    fs::write(&file, "precious").unwrap();
    fs::create_dir(&directory).unwrap();
    for path in [&file, &directory] {
        let error = serve(|server| server.pty(path)).err().unwrap();
        assert!(matches!(error, ServeError::Occupied { .. }));
        assert!(error.to_string().contains("is not a symlink"), "{error}");
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "precious");
    assert!(directory.is_dir());
    let error = serve(|server| server.pty(folder.path().join("no/where")))
        .err()
        .unwrap();
    assert!(error.to_string().contains("no/where: cannot"), "{error}");
}

#[test]
fn another_servers_symlink_stays() {
    let arm = arm();
    fs::remove_file(&arm.path).unwrap();
    symlink("/dev/pts/another", &arm.path).unwrap();
    arm.served.stop();
    assert!(fs::symlink_metadata(&arm.path).unwrap().is_symlink());
    drop(arm.folder);
}

#[test]
fn a_server_that_fails_later_leaves_no_symlink() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm");
    assert!(serve(|server| server.pty(&path).tcp("nonsense")).is_err());
    assert!(fs::symlink_metadata(&path).is_err());
}

const CHILD: &str = "MAGICIAN_TEST_TERMINAL";

/// Not a test by itself: the client that the next test runs as a separate process.
#[test]
fn child_that_keeps_others_out() {
    let Ok(path) = std::env::var(CHILD) else {
        return;
    };
    let flags = OFlags::RDWR | OFlags::NOCTTY;
    match rustix::fs::open(&path, flags, Mode::empty()) {
        Err(Errno::BUSY) => println!("\nrefused"),
        Err(error) => panic!("{error}"),
        Ok(terminal) => {
            rustix::termios::ioctl_tiocexcl(&terminal).unwrap();
            println!("\nheld");
            let _ = std::io::stdin().read(&mut [0; 1]);
        }
    }
}

/// Starts a client process; as user nobody if we are root, since no exclusive flag stops root.
fn client_process(path: &Path) -> (std::process::Child, String) {
    let this = std::env::current_exe().unwrap();
    let mut command = if rustix::process::geteuid().is_root() {
        let mut command = Command::new("setpriv");
        command
            .args(["--reuid=65534", "--regid=65534", "--clear-groups"])
            .arg(this);
        command
    } else {
        Command::new(this)
    };
    let mut child = command
        .args(["--exact", "pty::child_that_keeps_others_out", "--nocapture"])
        .env(CHILD, path)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.as_mut().unwrap()).lines();
    let said = lines
        .map(Result::unwrap)
        .find(|line| line.starts_with("held") || line.starts_with("refused"));
    (child, said.unwrap_or_default())
}

#[cfg(target_os = "linux")]
#[test]
fn a_killed_client_that_kept_others_out_does_not_lock_the_next_out() {
    let arm = arm();
    if rustix::process::geteuid().is_root() {
        if Command::new("setpriv").arg("--version").output().is_err() {
            return; // No way to be anybody else.
        }
        fs::set_permissions(arm.device(), fs::Permissions::from_mode(0o666)).unwrap();
        fs::set_permissions(arm.folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
    }
    for _ in 0..3 {
        let (mut holder, said) = client_process(&arm.path);
        assert_eq!(said, "held");
        let (mut other, said) = client_process(&arm.path);
        assert_eq!(said, "refused");
        other.wait().unwrap();
        holder.kill().unwrap();
        holder.wait().unwrap();
        arm.wait_until_left();
    }
}
