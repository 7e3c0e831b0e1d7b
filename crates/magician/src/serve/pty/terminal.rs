//! Both ends of a pseudo-terminal.

use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::task::{Context, Poll, ready};

use rustix::fs::{Mode, OFlags};
use rustix::termios::{OptionalActions, QueueSelector};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

use super::super::reactor::register;
use super::claim::mark;
use super::watch::Watch;

const BOTH: Interest = Interest::READABLE.add(Interest::WRITABLE);

/// Both ends of the pseudo-terminal.
///
/// The server keeps the clients' end open too. Otherwise the system would report a hang-up while
/// there is no client, and an exclusive flag left by a killed client could not be cleared.
pub(super) struct Terminal {
    pub(super) device: PathBuf,
    /// `None` only inside [`Terminal::alone`].
    master: Option<AsyncFd<OwnedFd>>,
    /// `None` only inside [`Terminal::alone`].
    slave: Option<OwnedFd>,
}

impl Terminal {
    pub(super) fn open() -> io::Result<Self> {
        let master = open_master()?;
        rustix::pty::grantpt(&master)?;
        rustix::pty::unlockpt(&master)?;
        let device = rustix::pty::ptsname(&master, Vec::new())?;
        let device = PathBuf::from(String::from_utf8_lossy(device.as_bytes()).into_owned());
        rustix::io::ioctl_fionbio(&master, true)?;
        let slave = open_slave(&device)?;
        make_raw(&slave)?;
        mark(&slave);
        Ok(Self {
            device,
            master: Some(register(master, BOTH)?),
            slave: Some(slave),
        })
    }

    pub(super) fn poll_read(
        &self,
        cx: &mut Context<'_>,
        bytes: &mut [u8],
    ) -> Poll<io::Result<usize>> {
        let master = self.master()?;
        loop {
            let mut guard = ready!(master.poll_read_ready(cx))?;
            match guard.try_io(|fd| would_block(rustix::io::read(fd, &mut *bytes))) {
                Ok(result) => return Poll::Ready(result),
                // The reactor's readiness was stale; `try_io` has cleared it, so ask again.
                Err(_) => continue,
            }
        }
    }

    /// Reads without asking the reactor, which may not know yet that there are bytes.
    pub(super) fn read_now(&self, bytes: &mut [u8]) -> io::Result<usize> {
        would_block(rustix::io::read(self.master()?, bytes))
    }

    /// Writes before asking the reactor, so that pending means there is no space.
    pub(super) fn poll_write(&self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
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

    /// Returns true if no client has the terminal open.
    ///
    /// The system reports that as a hang-up, but only if the server does not hold the clients' end
    /// itself, so it closes that for a moment. The exclusive flag has to be cleared first, or the
    /// end could not be opened again; a remaining client may lose its exclusive access by this.
    pub(super) fn alone(&mut self, watch: &mut Watch) -> io::Result<bool> {
        self.clear_exclusive()?;
        // Hidden from the reactor, which would take the hang-up for final.
        let master = self.master.take().ok_or_else(gone)?.into_inner();
        watch.pause()?;
        self.slave = None;
        let hung_up = hung_up(&master);
        let slave = open_slave(&self.device)?;
        mark(&slave);
        self.slave = Some(slave);
        watch.resume(&self.device)?;
        self.master = Some(register(master, BOTH)?);
        hung_up
    }

    /// Drops unread bytes in both buffers of the terminal, and makes it raw again.
    pub(super) fn forget_replies(&self) -> io::Result<()> {
        rustix::termios::tcflush(self.master()?, QueueSelector::OFlush)?;
        rustix::termios::tcflush(self.slave()?, QueueSelector::IFlush)?;
        make_raw(self.slave()?)
    }

    /// Clears the flag by which a client excludes others (TIOCEXCL). On a pseudo-terminal it
    /// outlives its client, and only the clients' end can clear it.
    pub(super) fn clear_exclusive(&self) -> io::Result<()> {
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

/// Maps EIO, which a master reads while no client end is open, to a read that would block.
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

/// Configures the terminal like a serial port: no echo, no translation, 115200 baud (document 1.1).
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
