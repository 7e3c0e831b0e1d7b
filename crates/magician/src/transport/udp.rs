use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::task::{Context, Poll, ready};

use tokio::io::ReadBuf;
use tokio::net::{UdpSocket, lookup_host};

use super::{Transport, unreachable_host};
use crate::Result;

/// Datagrams to the arm's Wi-Fi module and back: one frame each from here, any cut from there.
pub(crate) struct Udp(UdpSocket);

/// A socket whose peer is the arm.
pub(super) async fn open(host: &str, port: u16) -> Result<Udp> {
    let failed = |error| unreachable_host(host, port, error);
    let mut addresses = lookup_host((host, port)).await.map_err(failed)?;
    let peer = addresses.next();
    let peer = peer.ok_or_else(|| failed(io::ErrorKind::NotFound.into()))?;
    let any: SocketAddr = match peer {
        SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
        SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
    };
    let socket = UdpSocket::bind(any).await.map_err(failed)?;
    socket.connect(peer).await.map_err(failed)?;
    Ok(Udp(socket))
}

/// Nobody listens at the moment: datagrams may come to nothing, and the timeouts tell.
fn passing(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::ConnectionRefused | io::ErrorKind::ConnectionReset
    )
}

impl Transport for Udp {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        loop {
            let mut buffer = ReadBuf::new(bytes);
            match ready!(self.0.poll_recv(cx, &mut buffer)) {
                // An empty datagram is not the end.
                Ok(()) if buffer.filled().is_empty() => {}
                Ok(()) => return Poll::Ready(Ok(buffer.filled().len())),
                Err(error) if passing(&error) => {}
                Err(error) => return Poll::Ready(Err(error)),
            }
        }
    }

    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        match ready!(self.0.poll_send(cx, bytes)) {
            Err(error) if passing(&error) => Poll::Ready(Ok(bytes.len())),
            sent => Poll::Ready(sent),
        }
    }
}
