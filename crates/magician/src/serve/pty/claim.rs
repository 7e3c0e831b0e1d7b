//! Which process serves a path and its pseudo-terminal, as long as the server lives and however it ends. Known on Linux
//! only.
//!
//! An existing link proves nothing: a killed server leaves it behind, and the system soon reuses the number of its
//! terminal. So a server holds a name that the system releases with the process, an abstract socket's; and a record lock
//! on the clients' end, by which another process can find it. Clients keep each other out by other means (flock,
//! TIOCEXCL).

use std::os::fd::OwnedFd;
use std::path::Path;

use rustix::fs::{FlockOperation, fcntl_lock};

/// A path that no other process serves meanwhile.
#[derive(Debug)]
pub(super) struct Claim {
    #[cfg(target_os = "linux")]
    _name: Option<std::os::unix::net::UnixDatagram>,
}

impl Claim {
    /// Takes the path; none if another server has it.
    #[cfg(target_os = "linux")]
    pub(super) fn take(path: &Path) -> Option<Self> {
        use std::io::ErrorKind;
        use std::os::linux::net::SocketAddrExt;
        use std::os::unix::net::{SocketAddr, UnixDatagram};

        let address = name_of(path).map(SocketAddr::from_abstract_name);
        let name = match address {
            Some(Ok(address)) => UnixDatagram::bind_addr(&address),
            // There is no such folder, which is for others to say.
            None | Some(Err(_)) => return Some(Self { _name: None }),
        };
        match name {
            Ok(name) => Some(Self { _name: Some(name) }),
            Err(error) if error.kind() == ErrorKind::AddrInUse => None,
            // A system without such names has no second server to refuse.
            Err(_) => Some(Self { _name: None }),
        }
    }

    #[cfg(not(target_os = "linux"))]
    pub(super) fn take(_: &Path) -> Option<Self> {
        Some(Self {})
    }
}

/// What the server of a path is called: the same by whatever way the folder is reached.
#[cfg(target_os = "linux")]
fn name_of(path: &Path) -> Option<String> {
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::MetadataExt;

    let parent = match path.parent()? {
        here if here.as_os_str().is_empty() => Path::new("."),
        parent => parent,
    };
    // The number of a folder that is gone is soon another's, while the server that had it may still be ending: its path tells
    // the two apart.
    let place = std::fs::canonicalize(parent).ok()?.join(path.file_name()?);
    let folder = std::fs::metadata(parent).ok()?;
    // FNV-1a, because such names are short and paths may be long.
    let sum = (place.as_os_str().as_bytes().iter()).fold(0xcbf2_9ce4_8422_2325, |sum, byte| {
        (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let (device, number) = (folder.dev(), folder.ino());
    Some(format!("magician-pty/{device:x}/{number:x}/{sum:016x}"))
}

/// Marks the terminal with the process that serves it. Closing any descriptor of it in this process ends that, so it is
/// to be said again then.
pub(super) fn mark(slave: &OwnedFd) {
    // Where there are no such locks the server has no name.
    let _ = fcntl_lock(slave, FlockOperation::NonBlockingLockExclusive);
}

/// The process that serves the terminal, if that is known. The system's table is read, because to open the terminal would look to its
/// server as if a client came.
#[cfg(target_os = "linux")]
pub(super) fn server_of(device: &Path) -> Option<u32> {
    use std::os::unix::fs::{FileTypeExt, MetadataExt};

    let found = std::fs::metadata(device).ok()?;
    if !found.file_type().is_char_device() {
        return None;
    }
    let (major, minor) = (
        rustix::fs::major(found.dev()),
        rustix::fs::minor(found.dev()),
    );
    let file = format!("{major:02x}:{minor:02x}:{}", found.ino());
    holder(&std::fs::read_to_string("/proc/locks").ok()?, &file)
}

#[cfg(not(target_os = "linux"))]
pub(super) fn server_of(_: &Path) -> Option<u32> {
    None
}

/// Reads lines as `3: POSIX  ADVISORY  WRITE 4159 00:1a:3 0 EOF`; those of waiting processes have an arrow before its kind.
#[cfg(target_os = "linux")]
fn holder(table: &str, file: &str) -> Option<u32> {
    table.lines().find_map(|line| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        match fields.as_slice() {
            [_, "POSIX", _, "WRITE", process, of, ..] if *of == file => process.parse().ok(),
            _ => None,
        }
    })
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_locks_tells_who_holds_a_file() {
        let table = "1: POSIX  ADVISORY  READ 7 00:1a:3 0 EOF\n\
                     2: FLOCK  ADVISORY  WRITE 8 00:1a:3 0 EOF\n\
                     3: -> POSIX  ADVISORY  WRITE 9 00:1a:3 0 EOF\n\
                     4: POSIX  ADVISORY  WRITE 10 00:1a:31 0 EOF\n\
                     5: POSIX  ADVISORY  WRITE 11 00:1a:3 0 EOF\n";
        assert_eq!(holder(table, "00:1a:3"), Some(11));
        assert_eq!(holder(table, "00:1a:4"), None);
    }
}
