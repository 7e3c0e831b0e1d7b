//! Pseudo-terminal with its symlink and clients.

use std::future::Future;
use std::io;
use std::path::Path;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::time::{Sleep, sleep};

use super::super::outbox::Outbox;
use super::super::service::{Peer, Service};
use super::super::{Notice, READS_PER_POLL, ServeError};
use super::symlink::{LinkPath, Symlink};
use super::terminal::Terminal;
use super::watch::{self, Seen, Watch};

const BUFFER: usize = 4096;
/// Delays of repeated checks for clients. inotify reports a close before the kernel releases the
/// terminal, so the closing client may still be counted. Choice.
const RECHECKS: [Duration; 3] = [
    Duration::from_millis(2),
    Duration::from_millis(20),
    Duration::from_millis(200),
];

/// Pseudo-terminal and the symlink to it.
pub(super) struct PtyConnection {
    // Dropped first, so that the path never leads to a terminal that is gone.
    symlink: Symlink,
    terminal: Terminal,
    watch: Watch,
    peer: Peer,
    outbox: Outbox,
    occupied: bool,
    /// Next check for a client that closed the terminal but was still counted, and the number of
    /// checks so far.
    recheck: Option<Pin<Box<Sleep>>>,
    rechecks: usize,
}

impl PtyConnection {
    /// Creates a terminal and a symlink to it.
    pub(super) fn open(way: &LinkPath, service: &mut dyn Service) -> Result<Self, ServeError> {
        let failed = |action| move |source: io::Error| ServeError::at(way, action, source);
        way.check()?;
        let terminal = Terminal::open().map_err(failed("make a pseudo-terminal"))?;
        let watch = Watch::new(&terminal.device).map_err(failed("watch the pseudo-terminal"))?;
        let symlink = Symlink::announce(way, &terminal.device)?;
        Ok(Self {
            peer: Peer::open(way.to_string(), service),
            symlink,
            terminal,
            watch,
            outbox: Outbox::default(),
            occupied: false,
            recheck: None,
            rechecks: 0,
        })
    }

    pub(super) fn device(&self) -> &Path {
        &self.terminal.device
    }

    /// Closes the terminal: clients get a hang-up.
    pub(super) fn close(self, service: &mut dyn Service) {
        if self.occupied {
            self.peer.leave(service);
        } else {
            self.peer.forget(service);
        }
    }

    /// Reads and writes, and detects clients that connect and disconnect.
    pub(super) fn poll(
        &mut self,
        cx: &mut Context<'_>,
        service: &mut dyn Service,
    ) -> io::Result<()> {
        // First, because it may replace the descriptor that later calls register.
        while let Poll::Ready(seen) = self.watch.poll(cx)? {
            self.seen(&seen, cx, service)?;
        }
        while let Some(timer) = &mut self.recheck
            && timer.as_mut().poll(cx).is_ready()
        {
            self.recheck = None;
            self.client_left(cx, service)?;
        }
        self.send(cx, service)?;
        let mut turns = 0;
        loop {
            match service.room(self.peer.link()) {
                // The arm's clock wakes the task when there is room.
                0 => break,
                room if self.read(cx, service, room)? => {}
                // No bytes, or no room: either way another event wakes the task.
                _ => break,
            }
            turns += 1;
            // More bytes may wait; the other endpoints get a turn first.
            if turns == READS_PER_POLL {
                cx.waker().wake_by_ref();
                break;
            }
        }
        Ok(())
    }

    /// Reads up to `most` bytes from clients; false if there were none.
    fn read(
        &mut self,
        cx: &mut Context<'_>,
        service: &mut dyn Service,
        most: usize,
    ) -> io::Result<bool> {
        let mut bytes = [0; BUFFER];
        let bytes = &mut bytes[..most.min(BUFFER)];
        let Poll::Ready(count) = self.terminal.poll_read(cx, bytes)? else {
            return Ok(false);
        };
        service.receive(self.peer.link(), &bytes[..count]);
        self.send(cx, service)?;
        Ok(true)
    }

    /// Reads everything that clients wrote, even without room on the line.
    fn read_all(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()> {
        let mut bytes = [0; BUFFER];
        for _ in 0..READS_PER_POLL {
            match self.terminal.read_now(&mut bytes) {
                Ok(count) => service.receive(self.peer.link(), &bytes[..count]),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) => return Err(error),
            }
            self.send(cx, service)?;
        }
        Ok(())
    }

    fn send(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()> {
        let mut write = |bytes: &[u8]| self.terminal.poll_write(cx, bytes);
        self.outbox.flush(&mut write)?;
        while let Some(reply) = service.reply(self.peer.link()) {
            self.outbox.send(reply, &mut write)?;
        }
        Ok(())
    }

    fn seen(
        &mut self,
        seen: &Seen,
        cx: &mut Context<'_>,
        service: &mut dyn Service,
    ) -> io::Result<()> {
        if seen.opened && !self.occupied {
            self.occupied = true;
            service.notice(Notice::Connected(self.symlink.to_string()));
        }
        if seen.closed {
            (self.recheck, self.rechecks) = (None, 0);
            self.client_left(cx, service)?;
        }
        if watch::BLIND {
            self.terminal.clear_exclusive()?;
        }
        Ok(())
    }

    /// Handles a client that closed the terminal. After the last one, the next client finds it in
    /// its initial state.
    fn client_left(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()> {
        // Bytes of the client precede those of its successor, so they are read before checking for
        // clients; bytes read later belong to a successor.
        self.read_all(cx, service)?;
        if !self.terminal.alone(&mut self.watch)? {
            let delay = RECHECKS.get(self.rechecks);
            self.recheck = delay.map(|delay| Box::pin(sleep(*delay)));
            self.rechecks += 1;
            return Ok(());
        }
        self.outbox.clear();
        self.peer.renew(service);
        self.terminal.forget_replies()?;
        if std::mem::take(&mut self.occupied) {
            service.notice(Notice::Left(self.symlink.to_string()));
        }
        Ok(())
    }
}
