use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};

use super::hub::{Hub, Peer};
use super::outbox::Outbox;
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

    fn accept(&mut self, cx: &mut Context<'_>, hub: &mut Hub) {
        for _ in 0..READS_PER_TURN {
            match self.listener.poll_accept(cx) {
                Poll::Pending => return,
                // The connection was gone before it was taken, or the system is short of
                // descriptors; neither is a reason to leave the others alone.
                Poll::Ready(Err(_)) => return,
                Poll::Ready(Ok(_)) if !hub.runner().plugged() => {}
                Poll::Ready(Ok((stream, from))) => {
                    let name = format!("tcp:{from}");
                    if self.connections.len() >= CONNECTIONS {
                        hub.notice(Notice::Refused(name));
                        continue;
                    }
                    // Frames are small and each is waited for.
                    let _ = stream.set_nodelay(true);
                    hub.notice(Notice::Connected(name.clone()));
                    self.connections.push(Connection {
                        stream,
                        peer: hub.open(name),
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

    fn turn(&mut self, cx: &mut Context<'_>, hub: &mut Hub) -> io::Result<()> {
        self.accept(cx, hub);
        let turn = |connection: &mut Connection| !connection.turn(cx, hub).unwrap_or(false);
        let gone: Vec<Connection> = self.connections.extract_if(.., turn).collect();
        for connection in gone {
            hub.close(connection.peer);
        }
        Ok(())
    }

    fn unplug(&mut self, hub: &mut Hub) {
        for connection in self.connections.drain(..) {
            hub.close(connection.peer);
        }
    }
}

impl Connection {
    /// Reads and writes; false when the client has closed the connection.
    fn turn(&mut self, cx: &mut Context<'_>, hub: &mut Hub) -> io::Result<bool> {
        self.send(cx, hub)?;
        for _ in 0..READS_PER_TURN {
            let mut bytes = [0; BUFFER];
            let room = hub.room(&self.peer).min(BUFFER);
            if room == 0 {
                // The arm's clock wakes us when the line has moved on.
                return Ok(true);
            }
            let mut buffer = ReadBuf::new(&mut bytes[..room]);
            match Pin::new(&mut self.stream).poll_read(cx, &mut buffer) {
                Poll::Pending => return Ok(true),
                Poll::Ready(Ok(())) if buffer.filled().is_empty() => return Ok(false),
                Poll::Ready(Ok(())) => hub.receive(&self.peer, buffer.filled()),
                Poll::Ready(Err(error)) => return Err(error),
            }
            self.send(cx, hub)?;
        }
        cx.waker().wake_by_ref();
        Ok(true)
    }

    fn send(&mut self, cx: &mut Context<'_>, hub: &mut Hub) -> io::Result<()> {
        let stream = &mut self.stream;
        let mut write = |bytes: &[u8]| Pin::new(&mut *stream).poll_write(cx, bytes);
        self.outbox.flush(&mut write)?;
        while let Some(reply) = hub.reply(&self.peer) {
            self.outbox.send(reply, &mut write)?;
        }
        Ok(())
    }
}
