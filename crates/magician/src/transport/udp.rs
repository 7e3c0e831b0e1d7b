//! UDP to the arm's Wi-Fi module.

use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::task::{Context, Poll, ready};

use tokio::io::ReadBuf;
use tokio::net::{UdpSocket, lookup_host};
use tokio::time::timeout;

use super::Transport;
use super::lines::{CONNECT_TIMEOUT, unreachable_host};
#[cfg(unix)]
use super::read_gap::{ReadGap, read_now};
use crate::Result;

/// Socket to the arm's Wi-Fi module. The driver sends one frame per datagram; the module cuts its
/// bytes anywhere.
pub(crate) struct Udp {
    socket: UdpSocket,
    /// Last datagram, and the bytes of it already returned.
    datagram: Box<[u8]>,
    taken: usize,
    filled: usize,
    #[cfg(unix)]
    away: ReadGap,
}

/// Largest possible datagram, bytes.
const DATAGRAM: usize = 65_536;
/// Successive errors after which other tasks get a turn. Choice.
const TURN: usize = 16;

/// Opens a socket connected to the arm.
pub(super) async fn open(host: &str, port: u16) -> Result<Udp> {
    let failed = |error| unreachable_host(host, port, error);
    let looking = timeout(CONNECT_TIMEOUT, lookup_host((host, port))).await;
    let found = looking.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()));
    let mut addresses = found.map_err(failed)?;
    let peer = addresses.next();
    let peer = peer.ok_or_else(|| failed(io::ErrorKind::NotFound.into()))?;
    let any: SocketAddr = match peer {
        SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
        SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
    };
    let socket = UdpSocket::bind(any).await.map_err(failed)?;
    socket.connect(peer).await.map_err(failed)?;
    Ok(Udp {
        socket,
        datagram: vec![0; DATAGRAM].into_boxed_slice(),
        taken: 0,
        filled: 0,
        #[cfg(unix)]
        away: ReadGap::default(),
    })
}

/// True for errors that may pass: no listener at the moment, or no network. Datagrams may be lost,
/// and the timeouts notice it.
fn passing(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::ConnectionRefused
            | io::ErrorKind::ConnectionReset
            | io::ErrorKind::HostUnreachable
            | io::ErrorKind::NetworkUnreachable
            | io::ErrorKind::NetworkDown
    )
}

impl Udp {
    /// Receives the next non-empty datagram.
    fn fetch(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let told = self.told(cx);
        #[cfg(unix)]
        let told = (self.away).look(told, || read_now(&self.socket, &mut self.datagram));
        told.map_ok(|filled| (self.taken, self.filled) = (0, filled))
    }

    /// Receives the next datagram that the reactor reports.
    fn told(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<usize>> {
        for _ in 0..TURN {
            let mut buffer = ReadBuf::new(&mut self.datagram);
            match ready!(self.socket.poll_recv(cx, &mut buffer)) {
                // An empty datagram does not end the line.
                Ok(()) if buffer.filled().is_empty() => {}
                Ok(()) => return Poll::Ready(Ok(buffer.filled().len())),
                Err(error) if passing(&error) => {}
                Err(error) => return Poll::Ready(Err(error)),
            }
        }
        // Errors may never cease on a broken network; other tasks get a turn first.
        cx.waker().wake_by_ref();
        Poll::Pending
    }
}

impl Transport for Udp {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        if self.taken >= self.filled {
            ready!(self.fetch(cx))?;
        }
        let rest = self.datagram.get(self.taken..self.filled);
        let rest = rest.unwrap_or_default();
        let count = rest.len().min(bytes.len());
        bytes[..count].copy_from_slice(&rest[..count]);
        self.taken += count;
        Poll::Ready(Ok(count))
    }

    #[cfg(unix)]
    fn ask(&mut self) {
        self.away.ask();
    }

    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        match ready!(self.socket.poll_send(cx, bytes)) {
            // Counted as sent: the retransmission timeout covers the loss.
            Err(error) if passing(&error) => Poll::Ready(Ok(bytes.len())),
            sent => Poll::Ready(sent),
        }
    }
}
