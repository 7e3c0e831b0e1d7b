//! Clients that come and go, as Linux tells: by inotify on the terminal's device file.

use std::io;
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;
use std::path::Path;
use std::task::{Context, Poll};

use rustix::fs::inotify::{self, CreateFlags, ReadFlags, WatchFlags};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

use super::super::reactor::register;

pub(super) struct Watch {
    inotify: AsyncFd<OwnedFd>,
    watch: Option<i32>,
}

/// What happened to the terminal.
pub(super) enum Seen {
    /// A client opened it.
    Opened,
    /// A client closed it. Equal events in a row are reported as one, so these are no count.
    Closed,
    /// Nothing, for a while: only where closing cannot be seen.
    #[expect(dead_code, reason = "the watch of other systems says so")]
    Nothing,
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

    /// What the server does itself from here on is not reported.
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

    /// What happened since, closing before opening: a client that went and one that came are told
    /// apart by asking the terminal who is there.
    pub(super) fn poll(&mut self, cx: &mut Context<'_>) -> io::Result<Poll<Seen>> {
        loop {
            let Poll::Ready(guard) = self.inotify.poll_read_ready(cx) else {
                return Ok(Poll::Pending);
            };
            let mut guard = guard?;
            match guard.try_io(|fd| events(fd.get_ref())) {
                Ok(Ok(seen)) if seen.intersects(CLOSED) => return Ok(Poll::Ready(Seen::Closed)),
                Ok(Ok(seen)) if seen.contains(ReadFlags::OPEN) => {
                    return Ok(Poll::Ready(Seen::Opened));
                }
                Ok(Ok(_)) | Err(_) => {}
                Ok(Err(error)) => return Err(error),
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
