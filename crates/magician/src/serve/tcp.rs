//! TCP endpoint.
//!
//! A listener must not be blocked by idle or silent hosts. A connection has a claim to a place once
//! it has sent a whole frame; before that it gives way to any new one. If all places are claimed, a
//! connection that has been silent for a while gives way (`magician_host::admission`).

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use magician_host::admission::{AdmissionLimits, AdmissionTable, Origin};
use magician_protocol::{Deframer, Event, HostInstant};
use socket2::{SockRef, TcpKeepalive};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::Instant;

use super::outbox::Outbox;
use super::service::{Peer, Service};
use super::{Endpoint, Listener, Notice, READS_PER_POLL};

/// Most connections in use, which have sent a whole frame. Choice.
const CONNECTIONS: usize = 16;
/// Silence after which a connection in use gives way to another: a host that was switched off, or
/// holds connections it does not need, must not exclude others. Choice.
const IDLE: Duration = Duration::from_secs(10);
/// Limits of the admission table. As many connections again may be open without having sent a
/// frame. Four places are reserved for this machine, so that hosts elsewhere do not exclude its own
/// programs.
const LIMITS: AdmissionLimits = AdmissionLimits {
    loopback_strangers: CONNECTIONS,
    strangers: CONNECTIONS,
    claims: CONNECTIONS,
    kept_for_loopback: 4,
    idle: Some(IDLE),
};
/// TCP keep-alive: silence before the first probe, and interval of the probes. The system ends a
/// connection that does not answer. Choice.
const KEEP_ALIVE: [Duration; 2] = [Duration::from_secs(30), Duration::from_secs(10)];
const BUFFER: usize = 4096;

/// TCP listener with its connections; each carries the bytes of a serial line.
pub(super) struct Tcp {
    listener: TcpListener,
    address: SocketAddr,
    connections: Vec<Connection>,
    places: Places,
}

/// Admission of connections.
struct Places {
    table: AdmissionTable<u64>,
    begun: Instant,
    /// Number of connections so far.
    came: u64,
    /// Connections that have to be closed for one in use.
    gone: Vec<u64>,
}

struct Connection {
    key: u64,
    stream: TcpStream,
    peer: Peer,
    outbox: Outbox,
    /// Decoder for the first frame; `None` after it.
    first: Option<Box<Deframer>>,
}

/// Outcome of polling a connection.
enum Turn {
    GoesOn,
    /// The client has closed it, or the line broke.
    Left,
    /// The client sent its first frame while all places were in use.
    Refused,
}

impl Tcp {
    pub(super) fn bind(address: SocketAddr) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            address: listener.local_addr()?,
            listener: TcpListener::from_std(listener)?,
            connections: Vec::new(),
            places: Places {
                table: AdmissionTable::new(LIMITS),
                begun: Instant::now(),
                came: 0,
                gone: Vec::new(),
            },
        })
    }

    fn accept(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) {
        for _ in 0..READS_PER_POLL {
            match self.listener.poll_accept(cx) {
                Poll::Pending => return,
                // The connection was gone before it was accepted, or the system is short of
                // descriptors. Neither should affect the other connections.
                Poll::Ready(Err(_)) => return,
                Poll::Ready(Ok(_)) if !service.plugged() => {}
                Poll::Ready(Ok((stream, from))) => {
                    let name = format!("tcp:{from}");
                    let Some(key) = self.place(from, service) else {
                        service.notice(Notice::Refused(name));
                        continue;
                    };
                    // Frames are small, and each is awaited.
                    let _ = stream.set_nodelay(true);
                    keep_alive(&stream);
                    service.notice(Notice::Connected(name.clone()));
                    self.connections.push(Connection {
                        key,
                        stream,
                        peer: Peer::open(name, service),
                        outbox: Outbox::default(),
                        first: Some(Box::default()),
                    });
                }
            }
        }
        // More connections may wait; open connections are served first.
        cx.waker().wake_by_ref();
    }

    /// Finds a place for one more connection; the oldest without a frame gives way immediately.
    /// `None` if all places are in use.
    fn place(&mut self, from: SocketAddr, service: &mut dyn Service) -> Option<u64> {
        let (now, origin) = (self.places.now(), Origin::of(from.ip()));
        if !self.places.table.has_room(now, origin) {
            return None;
        }
        self.places.came += 1;
        let key = self.places.came;
        let silent = self.places.table.open(now, key, origin);
        self.make_room(silent, service);
        Some(key)
    }

    /// Closes connections that have to give way.
    fn make_room(&mut self, gone: impl IntoIterator<Item = u64>, service: &mut dyn Service) {
        for key in gone {
            if let Some(at) = self.connections.iter().position(|one| one.key == key) {
                self.connections.swap_remove(at).peer.make_room(service);
            }
        }
    }
}

impl Places {
    fn now(&self) -> HostInstant {
        HostInstant::ZERO + self.begun.elapsed()
    }
}

/// Enables keep-alive, so that a client which disappears is noticed. Errors are ignored: without it
/// the server still works.
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
        let places = &mut self.places;
        let mut ended = Vec::new();
        for connection in &mut self.connections {
            match connection.poll(cx, service, places).unwrap_or(Turn::Left) {
                Turn::GoesOn => {}
                turn => ended.push((connection.key, turn)),
            }
        }
        for (key, turn) in ended {
            let Some(at) = self.connections.iter().position(|one| one.key == key) else {
                continue;
            };
            let peer = self.connections.swap_remove(at).peer;
            self.places.table.close(key);
            match turn {
                Turn::Refused => peer.refuse(service),
                // A closed connection and a broken one are the same to the log.
                _ => peer.leave(service),
            }
        }
        let gone = std::mem::take(&mut self.places.gone);
        self.make_room(gone, service);
        Ok(())
    }

    fn unplug(&mut self, service: &mut dyn Service) {
        for connection in self.connections.drain(..) {
            self.places.table.close(connection.key);
            connection.peer.leave(service);
        }
    }
}

impl Connection {
    /// Reads and writes.
    fn poll(
        &mut self,
        cx: &mut Context<'_>,
        service: &mut dyn Service,
        places: &mut Places,
    ) -> io::Result<Turn> {
        self.send(cx, service)?;
        for _ in 0..READS_PER_POLL {
            let mut bytes = [0; BUFFER];
            let room = service.room(self.peer.link()).min(BUFFER);
            if room == 0 {
                // The arm's clock wakes the task when there is room.
                return Ok(Turn::GoesOn);
            }
            let mut buffer = ReadBuf::new(&mut bytes[..room]);
            match Pin::new(&mut self.stream).poll_read(cx, &mut buffer) {
                Poll::Pending => return Ok(Turn::GoesOn),
                Poll::Ready(Ok(())) if buffer.filled().is_empty() => return Ok(Turn::Left),
                Poll::Ready(Ok(())) => {
                    if !self.is_in_use(buffer.filled(), places) {
                        return Ok(Turn::Refused);
                    }
                    service.receive(self.peer.link(), buffer.filled());
                }
                Poll::Ready(Err(error)) => return Err(error),
            }
            self.send(cx, service)?;
        }
        // More bytes may wait; the other connections get a turn first.
        cx.waker().wake_by_ref();
        Ok(Turn::GoesOn)
    }

    /// Notes received bytes: the first whole frame is the client's claim to a place. False if there
    /// is no place.
    fn is_in_use(&mut self, mut bytes: &[u8], places: &mut Places) -> bool {
        let now = places.now();
        let Some(first) = &mut self.first else {
            places.table.heard(now, self.key);
            return true;
        };
        // Only up to the first frame: the service decodes everything again itself.
        let mut events = std::iter::from_fn(|| {
            first
                .next(&mut bytes)
                .map(|event| matches!(event, Event::Frame { .. }))
        });
        if events.any(|is_frame| is_frame) {
            self.first = None;
            match places.table.claim(now, self.key) {
                Ok(gone) => places.gone.extend(gone),
                Err(_) => return false,
            }
        }
        true
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

    use magician_protocol::commands::Pose;
    use magician_protocol::{FrameBuf, NoArgs, Readable};
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::time::advance;

    use super::*;
    use magician_sim::LinkId;

    /// Service without replies; it records notices.
    #[derive(Default)]
    struct Nobody {
        links: u32,
        heard: usize,
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

        fn receive(&mut self, _: LinkId, bytes: &[u8]) {
            self.heard += bytes.len();
        }

        fn reply(&mut self, _: LinkId) -> Option<FrameBuf> {
            None
        }

        fn notice(&mut self, notice: Notice) {
            self.told.push(format!("{notice:?}"));
        }
    }

    /// Connects a client, and polls the endpoint until it was accepted or refused.
    async fn comes(tcp: &mut Tcp, service: &mut Nobody) -> TcpStream {
        let stream = TcpStream::connect(tcp.address).await.unwrap();
        let name = stream.local_addr().unwrap().to_string();
        turns(tcp, service, |service| {
            service.told.iter().any(|told| told.contains(&name))
        })
        .await;
        stream
    }

    /// Sends a whole frame, and polls the endpoint until it was received or refused.
    async fn asks(client: &mut TcpStream, tcp: &mut Tcp, service: &mut Nobody) {
        let frame = FrameBuf::get(&NoArgs, Pose::ROW).unwrap();
        let (heard, told) = (service.heard, service.told.len());
        client.write_all(frame.bytes()).await.unwrap();
        turns(tcp, service, |service| {
            service.heard > heard || service.told.len() > told
        })
        .await;
    }

    async fn turns(tcp: &mut Tcp, service: &mut Nobody, enough: impl Fn(&Nobody) -> bool) {
        poll_fn(|cx| {
            tcp.poll(cx, service).unwrap();
            if enough(service) {
                Poll::Ready(())
            } else {
                Poll::Pending
            }
        })
        .await;
    }

    fn name(client: &TcpStream) -> String {
        format!("tcp:{}", client.local_addr().unwrap())
    }

    #[tokio::test]
    async fn connections_without_a_whole_frame_give_way_at_once_oldest_first() {
        let mut tcp = Tcp::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let mut service = Nobody::default();
        let mut clients = Vec::new();
        for _ in 0..CONNECTIONS {
            let mut client = comes(&mut tcp, &mut service).await;
            // Part of a frame does not count.
            client.write_all(&[0xAA, 0xAA, 2]).await.unwrap();
            clients.push(client);
        }
        // This client completes its frame, so its connection is in use.
        clients[1].write_all(&[10, 0, 246]).await.unwrap();
        turns(&mut tcp, &mut service, |service| {
            service.heard == 3 * CONNECTIONS + 3
        })
        .await;
        let mut hosts = Vec::new();
        for _ in 0..3 {
            hosts.push(comes(&mut tcp, &mut service).await);
        }
        let made: Vec<_> = { service.told.iter() }
            .filter(|told| told.starts_with("MadeRoom"))
            .cloned()
            .collect();
        let expected = [0, 2].map(|nth| format!("MadeRoom({:?})", name(&clients[nth])));
        assert_eq!(made, expected, "one place was free");
        for host in &mut hosts {
            asks(host, &mut tcp, &mut service).await;
        }
        assert!(!service.told.iter().any(|told| told.starts_with("Refused")));
    }

    #[tokio::test(start_paused = true)]
    async fn idle_connections_make_room_for_a_frame_and_busy_ones_do_not() {
        let mut tcp = Tcp::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let mut service = Nobody::default();
        let mut clients = Vec::new();
        for _ in 0..CONNECTIONS {
            let mut client = comes(&mut tcp, &mut service).await;
            asks(&mut client, &mut tcp, &mut service).await;
            clients.push(client);
        }
        comes(&mut tcp, &mut service).await;
        assert!(
            service.told.last().unwrap().starts_with("Refused"),
            "{:?}",
            service.told
        );
        advance(IDLE).await;
        // All but the second have sent something since.
        for (nth, client) in clients.iter_mut().enumerate() {
            if nth != 1 {
                asks(client, &mut tcp, &mut service).await;
            }
        }
        let mut late = comes(&mut tcp, &mut service).await;
        assert!(service.told.last().unwrap().starts_with("Connected"));
        asks(&mut late, &mut tcp, &mut service).await;
        let made = format!("MadeRoom({:?})", name(&clients[1]));
        assert_eq!(service.told.last(), Some(&made));
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
