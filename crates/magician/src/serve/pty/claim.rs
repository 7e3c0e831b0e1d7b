//! Detection of the process that serves a path and its pseudo-terminal. Linux only.
//!
//! An existing symlink proves nothing: a killed server leaves it behind, and the system soon reuses
//! the number of its terminal. So a server holds two marks that the system releases with the
//! process, however it ends: an abstract socket name, and a record lock on the clients' end, which
//! shows other processes its owner. Clients exclude each other by other means (flock, TIOCEXCL).

use std::os::fd::OwnedFd;
use std::path::Path;

use rustix::fs::{FlockOperation, fcntl_lock};

/// Exclusive claim of a path among processes.
#[derive(Debug)]
pub(super) struct Claim {
    #[cfg(target_os = "linux")]
    _name: Option<std::os::unix::net::UnixDatagram>,
}

impl Claim {
    /// Claims a path; `None` if another server has it.
    #[cfg(target_os = "linux")]
    pub(super) fn take(path: &Path) -> Option<Self> {
        use std::io::ErrorKind;
        use std::os::linux::net::SocketAddrExt;
        use std::os::unix::net::{SocketAddr, UnixDatagram};

        let address = name_of(path).map(SocketAddr::from_abstract_name);
        let name = match address {
            Some(Ok(address)) => UnixDatagram::bind_addr(&address),
            // The folder does not exist; a later step reports that.
            None | Some(Err(_)) => return Some(Self { _name: None }),
        };
        match name {
            Ok(name) => Some(Self { _name: Some(name) }),
            Err(error) if error.kind() == ErrorKind::AddrInUse => None,
            // Without abstract names, two servers cannot be distinguished.
            Err(_) => Some(Self { _name: None }),
        }
    }

    #[cfg(not(target_os = "linux"))]
    pub(super) fn take(_: &Path) -> Option<Self> {
        Some(Self {})
    }
}

/// Returns the socket name for a path, independent of how its folder is reached.
#[cfg(target_os = "linux")]
fn name_of(path: &Path) -> Option<String> {
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::MetadataExt;

    let parent = match path.parent()? {
        here if here.as_os_str().is_empty() => Path::new("."),
        parent => parent,
    };
    // The inode number of a removed folder is soon reused, while the server of the old one may
    // still be shutting down. The path distinguishes the two.
    let place = std::fs::canonicalize(parent).ok()?.join(path.file_name()?);
    let folder = std::fs::metadata(parent).ok()?;
    // FNV-1a hash: socket names are short, and paths may be long.
    let sum = (place.as_os_str().as_bytes().iter()).fold(0xcbf2_9ce4_8422_2325, |sum, byte| {
        (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let (device, number) = (folder.dev(), folder.ino());
    Some(format!("magician-pty/{device:x}/{number:x}/{sum:016x}"))
}

/// Marks the terminal with this process by a record lock. Closing any descriptor of the terminal in
/// this process releases it, so it has to be repeated then.
pub(super) fn mark(slave: &OwnedFd) {
    // Without such locks only the name of the server stays unknown.
    let _ = fcntl_lock(slave, FlockOperation::NonBlockingLockExclusive);
}

/// Returns the process that serves the terminal, if known. This reads the system's lock table,
/// because opening the terminal would look like a new client to its server.
#[cfg(target_os = "linux")]
pub(super) fn server_of(device: &Path) -> Option<u32> {
    use std::os::unix::fs::{FileTypeExt, MetadataExt};

    // A dangling link, left by a server whose terminal is gone.
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

/// Parses lines such as `3: POSIX  ADVISORY  WRITE 4159 00:1a:3 0 EOF`; an arrow before the kind
/// marks a waiting process.
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
