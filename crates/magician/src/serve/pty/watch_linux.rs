//! Detection of clients on Linux: inotify on the terminal's device file.

use std::io;
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;
use std::path::Path;
use std::task::{Context, Poll};

use rustix::fs::inotify::{self, CreateFlags, ReadFlags, WatchFlags};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

use super::super::reactor::register;

/// True if clients cannot be detected.
pub(super) const BLIND: bool = false;

pub(super) struct Watch {
    inotify: AsyncFd<OwnedFd>,
    watch: Option<i32>,
}

/// Events at the terminal. inotify merges equal events in a row, and their order is lost, so the
/// current clients have to be checked.
pub(super) struct Seen {
    /// A client opened it.
    pub(super) opened: bool,
    /// A client closed it.
    pub(super) closed: bool,
}

impl Watch {
    pub(super) fn new(device: &Path) -> io::Result<Self> {
        let inotify = inotify::init(CreateFlags::CLOEXEC | CreateFlags::NONBLOCK)?;
        let mut watch = Self {
            inotify: register(inotify, Interest::READABLE)?,
            watch: None,
        };
        watch.resume(device)?;
        Ok(watch)
    }

    /// Ignores the server's own actions from here on.
    pub(super) fn pause(&mut self) -> io::Result<()> {
        if let Some(watch) = self.watch.take() {
            inotify::remove_watch(self.inotify.get_ref(), watch)?;
        }
        Ok(())
    }

    pub(super) fn resume(&mut self, device: &Path) -> io::Result<()> {
        let events = WatchFlags::OPEN | WatchFlags::CLOSE_WRITE | WatchFlags::CLOSE_NOWRITE;
        let watch = inotify::add_watch(self.inotify.get_ref(), device, events)?;
        self.watch = Some(watch);
        Ok(())
    }

    /// Returns the events since the last call.
    pub(super) fn poll(&mut self, cx: &mut Context<'_>) -> io::Result<Poll<Seen>> {
        loop {
            let Poll::Ready(guard) = self.inotify.poll_read_ready(cx) else {
                return Ok(Poll::Pending);
            };
            match guard?.try_io(|fd| events(fd.get_ref())) {
                Ok(seen) => {
                    let seen = seen?;
                    return Ok(Poll::Ready(Seen {
                        opened: seen.contains(ReadFlags::OPEN),
                        closed: seen.intersects(CLOSED),
                    }));
                }
                // The readiness was stale; `try_io` has cleared it, so ask again.
                Err(_) => continue,
            }
        }
    }
}

const CLOSED: ReadFlags = ReadFlags::CLOSE_WRITE.union(ReadFlags::CLOSE_NOWRITE);

fn events(inotify: &OwnedFd) -> io::Result<ReadFlags> {
    let mut buffer = [MaybeUninit::uninit(); 512];
    let mut reader = inotify::Reader::new(inotify, &mut buffer);
    let mut seen = reader.next()?.events();
    while !reader.is_buffer_empty() {
        seen |= reader.next()?.events();
    }
    Ok(seen)
}
