use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};

use super::outbox::Outbox;
use super::service::{Peer, Service};
use super::{Endpoint, Notice, Port, READS_PER_TURN};

/// Connections that are kept open at a time.
const CONNECTIONS: usize = 16;
const BUFFER: usize = 4096;

/// A TCP listener and its connections: each the bytes of a serial line.
pub(super) struct Tcp {
    listener: TcpListener,
    address: SocketAddr,
    connections: Vec<Connection>,
}

struct Connection {
    stream: TcpStream,
    peer: Peer,
    outbox: Outbox,
}

impl Tcp {
    pub(super) fn bind(address: SocketAddr) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            address: listener.local_addr()?,
            listener: TcpListener::from_std(listener)?,
            connections: Vec::new(),
        })
    }

    fn accept(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) {
        for _ in 0..READS_PER_TURN {
            match self.listener.poll_accept(cx) {
                Poll::Pending => return,
                // The connection was gone before it was taken, or the system is short of
                // descriptors; neither is a reason to leave the others alone.
                Poll::Ready(Err(_)) => return,
                Poll::Ready(Ok(_)) if !service.plugged() => {}
                Poll::Ready(Ok((stream, from))) => {
                    let name = format!("tcp:{from}");
                    if self.connections.len() >= CONNECTIONS {
                        service.notice(Notice::Refused(name));
                        continue;
                    }
                    // Frames are small and each is waited for.
                    let _ = stream.set_nodelay(true);
                    service.notice(Notice::Connected(name.clone()));
                    self.connections.push(Connection {
                        stream,
                        peer: Peer::open(name, service),
                        outbox: Outbox::default(),
                    });
                }
            }
        }
        cx.waker().wake_by_ref();
    }
}

impl Port for Tcp {
    fn endpoint(&self) -> Endpoint {
        Endpoint::Tcp(self.address)
    }

    fn turn(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()> {
        self.accept(cx, service);
        let turn = |connection: &mut Connection| !connection.turn(cx, service).unwrap_or(false);
        let gone: Vec<Connection> = self.connections.extract_if(.., turn).collect();
        for connection in gone {
            connection.peer.leave(service);
        }
        Ok(())
    }

    fn unplug(&mut self, service: &mut dyn Service) {
        for connection in self.connections.drain(..) {
            connection.peer.leave(service);
        }
    }
}

impl Connection {
    /// Reads and writes; false when the client has closed the connection.
    fn turn(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<bool> {
        self.send(cx, service)?;
        for _ in 0..READS_PER_TURN {
            let mut bytes = [0; BUFFER];
            let room = service.room(self.peer.link()).min(BUFFER);
            if room == 0 {
                // The arm's clock wakes us when the line has moved on.
                return Ok(true);
            }
            let mut buffer = ReadBuf::new(&mut bytes[..room]);
            match Pin::new(&mut self.stream).poll_read(cx, &mut buffer) {
                Poll::Pending => return Ok(true),
                Poll::Ready(Ok(())) if buffer.filled().is_empty() => return Ok(false),
                Poll::Ready(Ok(())) => service.receive(self.peer.link(), buffer.filled()),
                Poll::Ready(Err(error)) => return Err(error),
            }
            self.send(cx, service)?;
        }
        cx.waker().wake_by_ref();
        Ok(true)
    }

    fn send(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()> {
        let stream = &mut self.stream;
        let mut write = |bytes: &[u8]| Pin::new(&mut *stream).poll_write(cx, bytes);
        self.outbox.flush(&mut write)?;
        while let Some(reply) = service.reply(self.peer.link()) {
            self.outbox.send(reply, &mut write)?;
        }
        Ok(())
    }
}
