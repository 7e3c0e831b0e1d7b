use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use socket2::{SockRef, TcpKeepalive};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::Instant;

use super::outbox::Outbox;
use super::service::{Peer, Service};
use super::{Endpoint, Listener, Notice, READS_PER_POLL};

/// Connections that are kept open at a time.
const CONNECTIONS: usize = 16;
/// When there is no room for one more, a connection that has been silent for so long makes it.
const IDLE: Duration = Duration::from_secs(10);
/// A connection that is silent for so long is asked whether its host is still there, and then so often; the system ends one
/// that does not answer.
const KEEP_ALIVE: [Duration; 2] = [Duration::from_secs(30), Duration::from_secs(10)];
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
    /// When its client said something last.
    heard: Instant,
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
        for _ in 0..READS_PER_POLL {
            match self.listener.poll_accept(cx) {
                Poll::Pending => return,
                // The connection was gone before it was taken, or the system is short of
                // descriptors; neither is a reason to leave the others alone.
                Poll::Ready(Err(_)) => return,
                Poll::Ready(Ok(_)) if !service.plugged() => {}
                Poll::Ready(Ok((stream, from))) => {
                    let name = format!("tcp:{from}");
                    if !self.has_room(service) {
                        service.notice(Notice::Refused(name));
                        continue;
                    }
                    // Frames are small and each is waited for.
                    let _ = stream.set_nodelay(true);
                    keep_alive(&stream);
                    service.notice(Notice::Connected(name.clone()));
                    self.connections.push(Connection {
                        stream,
                        peer: Peer::open(name, service),
                        outbox: Outbox::default(),
                        heard: Instant::now(),
                    });
                }
            }
        }
        cx.waker().wake_by_ref();
    }

    /// Whether one more may come. If there are as many as may be, the one that has been idle longest goes: a host that was
    /// switched off, or holds connections that it does not use, keeps no other client out.
    fn has_room(&mut self, service: &mut dyn Service) -> bool {
        if self.connections.len() < CONNECTIONS {
            return true;
        }
        let oldest = (self.connections.iter().enumerate()).min_by_key(|(_, one)| one.heard);
        let Some((at, _)) = oldest.filter(|(_, one)| one.heard.elapsed() >= IDLE) else {
            return false;
        };
        let gone = self.connections.swap_remove(at);
        gone.peer.make_room(service);
        true
    }
}

/// A client that is gone without a word is noticed. A system that cannot do that serves all the same.
fn keep_alive(stream: &TcpStream) {
    let [time, interval] = KEEP_ALIVE;
    let settings = TcpKeepalive::new().with_time(time).with_interval(interval);
    let _ = SockRef::from(stream).set_tcp_keepalive(&settings);
}

impl Listener for Tcp {
    fn endpoint(&self) -> Endpoint {
        Endpoint::Tcp(self.address)
    }

    fn poll(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()> {
        self.accept(cx, service);
        let turn = |connection: &mut Connection| !connection.poll(cx, service).unwrap_or(false);
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
    fn poll(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<bool> {
        self.send(cx, service)?;
        for _ in 0..READS_PER_POLL {
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
                Poll::Ready(Ok(())) => {
                    self.heard = Instant::now();
                    service.receive(self.peer.link(), buffer.filled());
                }
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

#[cfg(test)]
mod tests {
    use std::future::poll_fn;

    use magician_protocol::FrameBuf;
    use tokio::io::AsyncReadExt;
    use tokio::time::advance;

    use super::*;
    use magician_sim::LinkId;

    /// Hears and says nothing; remembers what it is told.
    #[derive(Default)]
    struct Nobody {
        links: u32,
        told: Vec<String>,
    }

    impl Service for Nobody {
        fn open(&mut self, _: &str) -> LinkId {
            self.links += 1;
            LinkId(self.links)
        }

        fn close(&mut self, _: LinkId) {}

        fn room(&self, _: LinkId) -> usize {
            BUFFER
        }

        fn receive(&mut self, _: LinkId, _: &[u8]) {}

        fn reply(&mut self, _: LinkId) -> Option<FrameBuf> {
            None
        }

        fn notice(&mut self, notice: Notice) {
            self.told.push(format!("{notice:?}"));
        }
    }

    /// A new client, and the endpoint's turns until it has been taken or refused.
    async fn comes(tcp: &mut Tcp, service: &mut Nobody) -> TcpStream {
        let before = service.told.len();
        let stream = TcpStream::connect(tcp.address).await.unwrap();
        turns(tcp, service, |service| service.told.len() > before).await;
        stream
    }

    async fn turns(tcp: &mut Tcp, service: &mut Nobody, enough: impl Fn(&Nobody) -> bool) {
        poll_fn(|cx| {
            tcp.poll(cx, service).unwrap();
            match enough(service) {
                true => Poll::Ready(()),
                false => Poll::Pending,
            }
        })
        .await;
    }

    #[tokio::test(start_paused = true)]
    async fn idle_connections_make_room_and_busy_ones_do_not() {
        let mut tcp = Tcp::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let mut service = Nobody::default();
        let mut clients = Vec::new();
        for _ in 0..CONNECTIONS {
            clients.push(comes(&mut tcp, &mut service).await);
        }
        comes(&mut tcp, &mut service).await;
        assert!(
            service.told.last().unwrap().starts_with("Refused"),
            "{:?}",
            service.told
        );
        advance(IDLE).await;
        // All but the second have said something since.
        let now = Instant::now();
        for (nth, connection) in tcp.connections.iter_mut().enumerate() {
            connection.heard = if nth == 1 { connection.heard } else { now };
        }
        let late = comes(&mut tcp, &mut service).await;
        let second = clients[1].local_addr().unwrap();
        let [.., made, came] = service.told.as_slice() else {
            panic!("{:?}", service.told)
        };
        assert_eq!(made, &format!("MadeRoom(\"tcp:{second}\")"));
        assert!(
            came.contains(&late.local_addr().unwrap().to_string()),
            "{came}"
        );
        assert_eq!(clients[1].read(&mut [0]).await.unwrap(), 0, "it is told so");
        comes(&mut tcp, &mut service).await;
        assert!(service.told.last().unwrap().starts_with("Refused"));
    }

    #[tokio::test]
    async fn a_client_that_is_silent_is_asked_whether_it_is_there() {
        let mut tcp = Tcp::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let _client = comes(&mut tcp, &mut Nobody::default()).await;
        let stream = SockRef::from(&tcp.connections[0].stream);
        assert!(stream.keepalive().unwrap());
    }
}
