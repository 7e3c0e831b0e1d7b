//! A pseudo-terminal that behaves as the arm's serial port does, whatever its clients do to it.

use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::task::{Context, Poll, ready};

use rustix::fs::{Mode, OFlags};
use rustix::termios::{OptionalActions, QueueSelector};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

use super::hub::{Hub, Peer};
use super::outbox::Outbox;
use super::reactor::register;
use super::{Endpoint, Notice, Port, READS_PER_TURN, ServeError};

mod symlink;
#[cfg(target_os = "linux")]
#[path = "watch_linux.rs"]
mod watch;
#[cfg(not(target_os = "linux"))]
#[path = "watch_portable.rs"]
mod watch;

use symlink::Symlink;
pub(super) use symlink::check;
use watch::{Seen, Watch};

const BUFFER: usize = 4096;
const BOTH: Interest = Interest::READABLE.add(Interest::WRITABLE);

pub(super) struct Pty {
    // Dropped first: the path is gone before what it leads to.
    symlink: Symlink,
    terminal: Terminal,
    watch: Watch,
    peer: Peer,
    outbox: Outbox,
    occupied: bool,
}

/// Both ends of the pseudo-terminal.
///
/// The server keeps the clients' end open too. Without it the system reports a hang-up while no
/// client is there, and an exclusive flag that a killed client left could not be cleared.
struct Terminal {
    device: PathBuf,
    /// `None` only inside [`Terminal::alone`].
    master: Option<AsyncFd<OwnedFd>>,
    /// `None` only inside [`Terminal::alone`].
    slave: Option<OwnedFd>,
}

impl Pty {
    pub(super) fn open(path: &Path, hub: &mut Hub) -> Result<Self, ServeError> {
        let failed =
            |action| move |source: io::Error| ServeError::at(path.display(), action, source);
        check(path)?;
        let terminal = Terminal::open().map_err(failed("make a pseudo-terminal"))?;
        let watch = Watch::new(&terminal.device).map_err(failed("watch the pseudo-terminal"))?;
        let symlink = Symlink::announce(path, &terminal.device)?;
        Ok(Self {
            peer: hub.open(path.display().to_string()),
            symlink,
            terminal,
            watch,
            outbox: Outbox::default(),
            occupied: false,
        })
    }

    /// Reads what clients wrote, at most `most` bytes; false when there was nothing.
    fn read(&mut self, cx: &mut Context<'_>, hub: &mut Hub, most: usize) -> io::Result<bool> {
        let mut bytes = [0; BUFFER];
        let bytes = &mut bytes[..most.min(BUFFER)];
        let Poll::Ready(count) = self.terminal.poll_read(cx, bytes)? else {
            return Ok(false);
        };
        hub.receive(&self.peer, &bytes[..count]);
        self.send(cx, hub)?;
        Ok(true)
    }

    /// Reads all that clients wrote, whether the line has room for it or not.
    fn read_all(&mut self, cx: &mut Context<'_>, hub: &mut Hub) -> io::Result<()> {
        let mut bytes = [0; BUFFER];
        for _ in 0..READS_PER_TURN {
            match self.terminal.read_now(&mut bytes) {
                Ok(count) => hub.receive(&self.peer, &bytes[..count]),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) => return Err(error),
            }
            self.send(cx, hub)?;
        }
        Ok(())
    }

    fn send(&mut self, cx: &mut Context<'_>, hub: &mut Hub) -> io::Result<()> {
        let mut write = |bytes: &[u8]| self.terminal.poll_write(cx, bytes);
        self.outbox.flush(&mut write)?;
        while let Some(reply) = hub.reply(&self.peer) {
            self.outbox.send(reply, &mut write)?;
        }
        Ok(())
    }

    fn seen(&mut self, seen: &Seen, cx: &mut Context<'_>, hub: &mut Hub) -> io::Result<()> {
        if seen.opened && !self.occupied {
            self.occupied = true;
            hub.notice(Notice::Connected(self.symlink.to_string()));
        }
        if seen.closed {
            self.client_left(cx, hub)?;
        }
        if watch::BLIND {
            self.terminal.clear_exclusive()?;
        }
        Ok(())
    }

    /// Some client closed the terminal. If it was the last, the next finds it as new.
    fn client_left(&mut self, cx: &mut Context<'_>, hub: &mut Hub) -> io::Result<()> {
        // All that it wrote comes before anything its successor writes, so it is read before the
        // question who is there; what is read after belongs to a successor.
        self.read_all(cx, hub)?;
        if !self.terminal.alone(&mut self.watch)? {
            return Ok(());
        }
        self.outbox.clear();
        hub.renew(&mut self.peer);
        self.terminal.forget_replies()?;
        if std::mem::take(&mut self.occupied) {
            hub.notice(Notice::Left(self.symlink.to_string()));
        }
        Ok(())
    }
}

impl Port for Pty {
    fn endpoint(&self) -> Endpoint {
        Endpoint::Pty {
            path: self.symlink.path().to_owned(),
            device: self.terminal.device.clone(),
        }
    }

    fn turn(&mut self, cx: &mut Context<'_>, hub: &mut Hub) -> io::Result<()> {
        // First, because it may replace the descriptor that the rest registers with.
        while let Poll::Ready(seen) = self.watch.poll(cx)? {
            self.seen(&seen, cx, hub)?;
        }
        self.send(cx, hub)?;
        let mut turns = 0;
        loop {
            match hub.room(&self.peer) {
                // The arm's clock wakes us when the line has moved on.
                0 => break,
                room if self.read(cx, hub, room)? => {}
                _ => break,
            }
            turns += 1;
            if turns == READS_PER_TURN {
                cx.waker().wake_by_ref();
                break;
            }
        }
        Ok(())
    }
}

impl Terminal {
    fn open() -> io::Result<Self> {
        let master = open_master()?;
        rustix::pty::grantpt(&master)?;
        rustix::pty::unlockpt(&master)?;
        let device = rustix::pty::ptsname(&master, Vec::new())?;
        let device = PathBuf::from(String::from_utf8_lossy(device.as_bytes()).into_owned());
        rustix::io::ioctl_fionbio(&master, true)?;
        let slave = open_slave(&device)?;
        make_raw(&slave)?;
        Ok(Self {
            device,
            master: Some(register(master, BOTH)?),
            slave: Some(slave),
        })
    }

    fn poll_read(&self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        let master = self.master()?;
        loop {
            let mut guard = ready!(master.poll_read_ready(cx))?;
            match guard.try_io(|fd| would_block(rustix::io::read(fd, &mut *bytes))) {
                Ok(result) => return Poll::Ready(result),
                Err(_) => continue,
            }
        }
    }

    /// Reads without asking the reactor, which may not have heard yet that there is something.
    fn read_now(&self, bytes: &mut [u8]) -> io::Result<usize> {
        would_block(rustix::io::read(self.master()?, bytes))
    }

    /// Tries before it asks the reactor, so that pending means that there is no space.
    fn poll_write(&self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let master = self.master()?;
        let mut written = would_block(rustix::io::write(master, bytes));
        loop {
            match written {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                written => return Poll::Ready(written),
            }
            let mut guard = ready!(master.poll_write_ready(cx))?;
            written = match guard.try_io(|fd| would_block(rustix::io::write(fd, bytes))) {
                Ok(written) => written,
                Err(_) => Err(io::ErrorKind::WouldBlock.into()),
            };
        }
    }

    /// Whether no client has the terminal open. The system reports that as a hang-up, provided the
    /// server does not hold the clients' end itself, so it lets go for a moment. The flag has to
    /// be cleared before or the end could not be opened again; that a client which stays may lose
    /// its exclusive hold is the price.
    fn alone(&mut self, watch: &mut Watch) -> io::Result<bool> {
        self.clear_exclusive()?;
        // Out of the reactor's sight: it would take the hang-up for final.
        let master = self.master.take().ok_or_else(gone)?.into_inner();
        watch.pause()?;
        self.slave = None;
        let hung_up = hung_up(&master);
        self.slave = Some(open_slave(&self.device)?);
        watch.resume(&self.device)?;
        self.master = Some(register(master, BOTH)?);
        hung_up
    }

    /// Drops what was written and not read, on both sides of the terminal's buffers, and makes it
    /// raw again.
    fn forget_replies(&self) -> io::Result<()> {
        rustix::termios::tcflush(self.master()?, QueueSelector::OFlush)?;
        rustix::termios::tcflush(self.slave()?, QueueSelector::IFlush)?;
        make_raw(self.slave()?)
    }

    /// Clears the flag by which a client keeps others out (TIOCEXCL). On a pseudo-terminal it
    /// outlives the client that set it, and only the clients' end can clear it.
    fn clear_exclusive(&self) -> io::Result<()> {
        Ok(rustix::termios::ioctl_tiocnxcl(self.slave()?)?)
    }

    fn master(&self) -> io::Result<&AsyncFd<OwnedFd>> {
        self.master.as_ref().ok_or_else(gone)
    }

    fn slave(&self) -> io::Result<&OwnedFd> {
        self.slave.as_ref().ok_or_else(gone)
    }
}

fn gone() -> io::Error {
    io::Error::other("the pseudo-terminal is gone")
}

/// A master reads EIO while no client's end is open, which passes.
fn would_block(result: rustix::io::Result<usize>) -> io::Result<usize> {
    match result {
        Ok(0) | Err(rustix::io::Errno::IO) => Err(io::ErrorKind::WouldBlock.into()),
        other => Ok(other?),
    }
}

fn open_master() -> io::Result<OwnedFd> {
    use rustix::pty::OpenptFlags;
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
    #[cfg(any(target_os = "linux", target_os = "freebsd", target_os = "netbsd"))]
    let flags = flags | OpenptFlags::CLOEXEC;
    Ok(rustix::pty::openpt(flags)?)
}

fn open_slave(device: &Path) -> io::Result<OwnedFd> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    Ok(rustix::fs::open(device, flags, Mode::empty())?)
}

/// As a serial port that a program has set up: no echo, no translation, 115200 baud (document 1.1).
fn make_raw(slave: &OwnedFd) -> io::Result<()> {
    let mut settings = rustix::termios::tcgetattr(slave)?;
    settings.make_raw();
    settings.set_speed(magician_protocol::BAUD_RATE)?;
    Ok(rustix::termios::tcsetattr(
        slave,
        OptionalActions::Now,
        &settings,
    )?)
}

fn hung_up(master: &OwnedFd) -> io::Result<bool> {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let mut fds = [PollFd::new(master, PollFlags::empty())];
    let now = Timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    poll(&mut fds, Some(&now))?;
    Ok(fds[0].revents().contains(PollFlags::HUP))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::poll_fn;

    #[tokio::test(flavor = "current_thread")]
    async fn every_byte_value_passes_unchanged_both_ways() {
        let terminal = Terminal::open().unwrap();
        let client = open_slave(&terminal.device).unwrap();
        let all: Vec<u8> = (0..=255).collect();
        let mut read = [0; 512];

        assert_eq!(rustix::io::write(&client, &all), Ok(256));
        let count = poll_fn(|cx| terminal.poll_read(cx, &mut read)).await;
        assert_eq!(&read[..count.unwrap()], all);

        let count = poll_fn(|cx| terminal.poll_write(cx, &all)).await;
        assert_eq!(count.unwrap(), 256);
        let count = rustix::io::read(&client, &mut read).unwrap();
        assert_eq!(&read[..count], all);
        assert!(terminal.read_now(&mut read).is_err(), "nothing is echoed");
    }

    #[tokio::test(flavor = "current_thread")]
    async fn a_terminal_is_alone_when_all_clients_have_closed() {
        let mut terminal = Terminal::open().unwrap();
        let mut watch = Watch::new(&terminal.device).unwrap();
        assert!(terminal.alone(&mut watch).unwrap());
        let clients = [0, 1].map(|_| open_slave(&terminal.device).unwrap());
        for client in clients {
            assert!(!terminal.alone(&mut watch).unwrap());
            drop(client);
        }
        assert!(terminal.alone(&mut watch).unwrap());
    }

    #[tokio::test(flavor = "current_thread")]
    async fn nobodys_replies_are_forgotten() {
        let terminal = Terminal::open().unwrap();
        let written = poll_fn(|cx| {
            let mut written = 0;
            while let Poll::Ready(count) = terminal.poll_write(cx, &[7; 1000])? {
                written += count;
            }
            Poll::Ready(io::Result::Ok(written))
        });
        assert!(written.await.unwrap() > 4096);
        terminal.forget_replies().unwrap();
        let client = open_slave(&terminal.device).unwrap();
        rustix::io::ioctl_fionbio(&client, true).unwrap();
        assert_eq!(
            rustix::io::read(&client, &mut [0; 16]),
            Err(rustix::io::Errno::AGAIN)
        );
    }
}
