//! UDP endpoint, like that of the arm's Wi-Fi module.

use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::task::{Context, Poll};

use tokio::io::ReadBuf;
use tokio::net::UdpSocket;

use super::service::{Peer, Service};
use super::{Endpoint, Listener, Notice, READS_PER_POLL};

/// Most senders remembered. Choice: bounds the memory that strangers can use.
const PEERS: usize = 32;
/// Largest possible datagram, bytes.
pub(super) const DATAGRAM: usize = 65_536;

/// UDP socket, as the Wi-Fi module has (errata E45).
pub(super) struct Udp {
    socket: UdpSocket,
    address: SocketAddr,
    /// Peers; the most recent one is last.
    peers: VecDeque<(SocketAddr, Peer)>,
    buffer: Box<[u8]>,
}

impl Udp {
    pub(super) fn bind(address: SocketAddr) -> io::Result<Self> {
        let (socket, address) = bound(address)?;
        Ok(Self {
            socket,
            address,
            peers: VecDeque::new(),
            buffer: vec![0; DATAGRAM].into_boxed_slice(),
        })
    }

    /// Moves the sender to the end of the peers; a new one replaces the oldest.
    fn hear(&mut self, from: SocketAddr, service: &mut dyn Service) {
        let known = self.peers.iter().position(|(address, _)| *address == from);
        let peer = match known.and_then(|at| self.peers.remove(at)) {
            Some(peer) => peer,
            None => {
                if self.peers.len() >= PEERS
                    && let Some((_, forgotten)) = self.peers.pop_front()
                {
                    forgotten.leave(service);
                }
                let name = format!("udp:{from}");
                service.notice(Notice::Connected(name.clone()));
                (from, Peer::open(name, service))
            }
        };
        self.peers.push_back(peer);
    }

    fn send(&self, cx: &mut Context<'_>, service: &mut dyn Service) {
        for (address, peer) in &self.peers {
            while let Some(reply) = service.reply(peer.link()) {
                // A datagram without space or reader is lost, as datagrams are.
                let _ = self.socket.poll_send_to(cx, reply.bytes(), *address);
            }
        }
    }
}

impl Listener for Udp {
    fn endpoint(&self) -> Endpoint {
        Endpoint::Udp(self.address)
    }

    fn poll(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()> {
        self.send(cx, service);
        for _ in 0..READS_PER_POLL {
            let mut buffer = ReadBuf::new(&mut self.buffer);
            let from = match self.socket.poll_recv_from(cx, &mut buffer) {
                Poll::Pending => return Ok(()),
                Poll::Ready(Ok(from)) => from,
                Poll::Ready(Err(error)) if refused(&error) => continue,
                Poll::Ready(Err(error)) => return Err(error),
            };
            let count = buffer.filled().len();
            if !service.plugged() {
                continue;
            }
            self.hear(from, service);
            if let Some((_, peer)) = self.peers.back()
                && service.room(peer.link()) > 0
            {
                service.receive(peer.link(), &self.buffer[..count]);
            }
            self.send(cx, service);
        }
        // More datagrams may wait; the other endpoints get a turn first.
        cx.waker().wake_by_ref();
        Ok(())
    }

    fn unplug(&mut self, service: &mut dyn Service) {
        for (_, peer) in self.peers.drain(..) {
            peer.leave(service);
        }
    }
}

/// Binds a socket; returns it with its actual address.
pub(super) fn bound(address: SocketAddr) -> io::Result<(UdpSocket, SocketAddr)> {
    let socket = std::net::UdpSocket::bind(address)?;
    socket.set_nonblocking(true)?;
    let address = socket.local_addr()?;
    Ok((UdpSocket::from_std(socket)?, address))
}

/// True if an earlier datagram reached a closed port, which only concerns its reader.
pub(super) fn refused(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::ConnectionReset | io::ErrorKind::ConnectionRefused
    )
}
