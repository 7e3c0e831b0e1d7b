//! Serial ports: exclusive use, raw mode, and error messages that say what to do.

use std::io;
use std::path::Path;

use magician_protocol::BAUD_RATE;
use serial2_tokio::SerialPort;

use super::Transport;
#[cfg(unix)]
use super::read_gap::{ReadGap, read_now};
use super::stream::Stream;
use crate::{Act, Error, ErrorCode, Message, Result, message, ports};

/// Serial port in exclusive use.
pub(crate) struct Serial {
    port: Stream<SerialPort>,
    /// Holds the advisory lock (flock) of the port. serial2 does not lock; serialport, and pyserial
    /// on request, use the same lock. It is a second descriptor of the port, so arrived bytes can
    /// be read from it as well.
    #[cfg(unix)]
    lock: std::os::fd::OwnedFd,
    #[cfg(unix)]
    away: ReadGap,
}

/// Opens a port at 115200 8N1, raw, and discards old input.
pub(super) fn open(path: &str) -> Result<Serial> {
    open_at(path, BAUD_RATE)
}

/// Opens as [`open`] does, at another baud rate.
pub(super) fn open_at(path: &str, baud: u32) -> Result<Serial> {
    #[cfg(unix)]
    let lock = lock(path)?;
    let port = SerialPort::open(path, |mut settings: serial2_tokio::Settings| {
        settings.set_raw();
        settings.set_baud_rate(baud)?;
        settings.set_char_size(serial2_tokio::CharSize::Bits8);
        settings.set_stop_bits(serial2_tokio::StopBits::One);
        settings.set_parity(serial2_tokio::Parity::None);
        settings.set_flow_control(serial2_tokio::FlowControl::None);
        Ok(settings)
    })
    .map_err(|error| explain(path, error))?;
    // A pseudo-terminal has no modem lines, and adapters work without them, so errors are ignored.
    for line in [port.set_dtr(true), port.set_rts(true)] {
        if let Err(error) = line {
            tracing::debug!(path, %error, "modem line not set");
        }
    }
    // Replies to an earlier program must not be taken for ours.
    port.discard_input_buffer()
        .map_err(|error| explain(path, error))?;
    Ok(Serial {
        port: Stream(port),
        #[cfg(unix)]
        lock,
        #[cfg(unix)]
        away: ReadGap::default(),
    })
}

impl Transport for Serial {
    fn poll_read(
        &mut self,
        cx: &mut std::task::Context<'_>,
        bytes: &mut [u8],
    ) -> std::task::Poll<io::Result<usize>> {
        let told = self.port.poll_read(cx, bytes);
        #[cfg(unix)]
        let told = (self.away).look(told, || read_now(&self.lock, bytes));
        told
    }

    #[cfg(unix)]
    fn ask(&mut self) {
        self.away.ask();
    }

    fn poll_write(
        &mut self,
        cx: &mut std::task::Context<'_>,
        bytes: &[u8],
    ) -> std::task::Poll<io::Result<usize>> {
        self.port.poll_write(cx, bytes)
    }
}

/// Takes the port's lock before any of its settings are changed.
#[cfg(unix)]
fn lock(path: &str) -> Result<std::os::fd::OwnedFd> {
    use rustix::fs::{FlockOperation, Mode, OFlags, flock};

    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let file = rustix::fs::open(path, flags, Mode::empty())
        .map_err(|errno| explain(path, errno.into()))?;
    match flock(&file, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => Ok(file),
        Err(rustix::io::Errno::WOULDBLOCK) => {
            // Closed first, or the list of holders would include this attempt.
            drop(file);
            Err(held(path))
        }
        // A port that cannot be locked can still be used.
        Err(_) => Ok(file),
    }
}

/// Returns the error for a port that could not be opened, with a remedy.
fn explain(path: &str, error: io::Error) -> Error {
    let is_port = |message: Message| Error::new(ErrorCode::NoPort, message);
    match error.kind() {
        io::ErrorKind::NotFound => {
            let known = ports::ports().unwrap_or_default();
            is_port(message!(
                "port {path} does not exist ({found})",
                path,
                found = ports::list(&known)
            ))
            .with_source(error)
        }
        io::ErrorKind::PermissionDenied if cfg!(windows) => held(path).with_source(error),
        io::ErrorKind::PermissionDenied => forbidden(path).with_source(error),
        io::ErrorKind::ResourceBusy => held(path).with_source(error),
        // Opened but without line settings: a regular file, a directory or another device.
        _ if std::fs::metadata(path).is_ok() && !is_terminal(&error) => {
            let known = ports::ports().unwrap_or_default();
            let message = message!(
                "{path} is not a serial port ({found})",
                path,
                found = ports::list(&known)
            );
            is_port(message).with_source(error)
        }
        _ => {
            let message = message!(
                "{path} cannot be opened as a serial port: {cause}",
                path,
                cause = error.to_string()
            );
            Error::port(message, error)
        }
    }
}

/// True if the error is one of a terminal, not of a directory, file or device without line
/// settings.
fn is_terminal(error: &io::Error) -> bool {
    #[cfg(unix)]
    {
        let not_one = [rustix::io::Errno::NOTTY, rustix::io::Errno::INVAL];
        let errno = error.raw_os_error();
        error.kind() != io::ErrorKind::IsADirectory
            && !not_one.map(|one| Some(one.raw_os_error())).contains(&errno)
    }
    #[cfg(not(unix))]
    {
        let _ = error;
        true
    }
}

/// Returns the error for a port in use by another program.
fn held(path: &str) -> Error {
    let holders = holders(Path::new(path));
    let message = match { holders.into_iter() }
        .reduce(|before, next| message!("{before}, {next}", before, next))
    {
        None => message!("{path} is in use by another program; close it first", path),
        Some(by) => message!("{path} is in use by {by}; close it first", path, by),
    };
    Error::new(ErrorCode::PortBusy, message)
}

/// Returns the error for a port that this user may not open.
fn forbidden(path: &str) -> Error {
    if let Err(error) = std::fs::metadata(path) {
        let message = message!(
            "no permission to access {path}: {cause}",
            path,
            cause = error.to_string()
        );
        return Error::new(ErrorCode::PortForbidden, message);
    }
    let owner = owner_group(Path::new(path));
    let forbidden = |message: Message| Error::new(ErrorCode::PortForbidden, message);
    let error = match &owner {
        // A user should not join the group `root` just for a port.
        Some(group) if group == "root" => {
            forbidden(message!("no permission to use {path}; only root may", path))
        }
        Some(group) => {
            let join = Act::System(format!("sudo usermod -aG {group} $USER").into());
            forbidden(message!(
                "no permission to use {path}; it belongs to the group {group}",
                path,
                group
            ))
            .remedy(join, "lets you use it from the next login on")
        }
        None => forbidden(message!("no permission to use {path}", path)),
    };
    if !is_adapter(path) {
        return error;
    }
    error.remedy(
        Act::System(udev().into()),
        "lets every user at this computer use the arm",
    )
}

/// True for the devices of USB adapters, which the udev rule applies to.
fn is_adapter(path: &str) -> bool {
    let name = Path::new(path).file_name().and_then(|name| name.to_str());
    name.is_some_and(|name| name.starts_with("ttyUSB") || name.starts_with("ttyACM"))
}

/// Returns the command that installs the udev rule for the arm's adapters.
fn udev() -> String {
    let rules = ports::udev_rules().map(|rule| format!("'{rule}'"));
    let rules = rules.collect::<Vec<_>>().join(" ");
    format!(
        r"printf '%s\n' {rules} | sudo tee /etc/udev/rules.d/70-magician.rules && sudo udevadm control --reload && sudo udevadm trigger"
    )
}

/// Returns the name of the group that owns a file.
#[cfg(unix)]
fn owner_group(path: &Path) -> Option<String> {
    use std::os::unix::fs::MetadataExt;

    // From the file itself: the name of the group differs by distribution (dialout, uucp).
    let gid = std::fs::metadata(path).ok()?.gid();
    let groups = std::fs::read_to_string("/etc/group").ok()?;
    let line = groups.lines().find(|line| {
        let number = line.split(':').nth(2);
        number.and_then(|number| number.parse::<u32>().ok()) == Some(gid)
    })?;
    line.split(':').next().map(str::to_owned)
}

#[cfg(not(unix))]
fn owner_group(_: &Path) -> Option<String> {
    None
}

/// Returns the processes that use a port, as far as this user may know: the holders of its lock, or
/// else the processes that have it open. The process at the other end of a pseudo-terminal has it
/// open too; it is the arm, and ending it would not free the port.
#[cfg(target_os = "linux")]
fn holders(path: &Path) -> Vec<Message> {
    let Ok(wanted) = path.canonicalize() else {
        return Vec::new();
    };
    let entries = |dir: &Path| std::fs::read_dir(dir).into_iter().flatten().flatten();
    let locked = locked_by(&wanted);
    let mut found = Vec::new();
    for process in entries(Path::new("/proc")) {
        let Ok(pid) = process.file_name().to_string_lossy().parse::<u32>() else {
            continue;
        };
        let uses = || {
            let mut files = entries(&process.path().join("fd"));
            let open =
                files.any(|fd| std::fs::read_link(fd.path()).is_ok_and(|file| file == wanted));
            open && !serves(&process.path().join("fdinfo"), &wanted)
        };
        let is_one = if locked.is_empty() {
            uses()
        } else {
            locked.contains(&pid)
        };
        if is_one && pid == std::process::id() {
            found.push(message!("this program itself"));
        } else if is_one {
            // A process that has ended meanwhile is still listed, without its name.
            let name = std::fs::read_to_string(process.path().join("comm")).unwrap_or_default();
            found.push(message!("{name} (process {pid})", name = name.trim(), pid));
        }
    }
    found
}

/// Returns the processes that hold the lock (flock) of a file.
#[cfg(target_os = "linux")]
fn locked_by(path: &Path) -> Vec<u32> {
    use std::os::unix::fs::MetadataExt;

    let Ok(found) = std::fs::metadata(path) else {
        return Vec::new();
    };
    let (major, minor) = (
        rustix::fs::major(found.dev()),
        rustix::fs::minor(found.dev()),
    );
    let file = format!("{major:02x}:{minor:02x}:{}", found.ino());
    let locks = std::fs::read_to_string("/proc/locks").unwrap_or_default();
    // `3: FLOCK  ADVISORY  WRITE 4159 00:1a:3 0 EOF`
    let holder = |line: &str| match line.split_whitespace().collect::<Vec<_>>().as_slice() {
        [_, "FLOCK", _, _, process, of, ..] if *of == file => process.parse().ok(),
        _ => None,
    };
    locks.lines().filter_map(holder).collect()
}

/// True if the process of these descriptors has the other end of a pseudo-terminal (`/dev/pts/3`).
#[cfg(target_os = "linux")]
fn serves(descriptors: &Path, terminal: &Path) -> bool {
    let Some(number) = (terminal.strip_prefix("/dev/pts").ok()).and_then(Path::to_str) else {
        return false;
    };
    let infos = std::fs::read_dir(descriptors)
        .into_iter()
        .flatten()
        .flatten();
    infos.into_iter().any(|info| {
        let text = std::fs::read_to_string(info.path()).unwrap_or_default();
        let mut lines = text.lines();
        lines.any(|line| line.strip_prefix("tty-index:").map(str::trim) == Some(number))
    })
}

#[cfg(not(target_os = "linux"))]
fn holders(_: &Path) -> Vec<Message> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    #[test]
    fn a_port_that_is_not_there_is_named_with_those_that_are() {
        let error = open("/dev/tty-of-no-arm").err().expect("there is none");
        assert_eq!(error.kind(), ErrorKind::Port);
        assert!(
            error
                .to_string()
                .contains("port /dev/tty-of-no-arm does not exist"),
            "{error}"
        );
        assert!(error.to_string().contains("serial port"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_port_is_said_to_be_none() {
        for path in ["/dev/null", "/"] {
            let error = open(path).err().expect("it is no serial port");
            assert!(
                error.to_string().contains("is not a serial port"),
                "{error}"
            );
            assert!(error.to_string().contains("serial port"), "{error}");
        }
    }

    #[test]
    fn a_forbidden_port_says_how_to_be_allowed() {
        let message = format!("{:?}", forbidden("/dev/null"));
        assert!(!message.contains("udevadm"), "{message}");
        assert!(is_adapter("/dev/ttyUSB0") && is_adapter("/dev/ttyACM1"));
        assert!(!is_adapter("/dev/pts/3") && udev().contains("10c4"));
        #[cfg(unix)]
        assert!(!message.contains("usermod -aG root"), "{message}");
    }
}
