//! Turns of connections: a flood from one sender delays other senders by a bounded time and does
//! not delay stop requests.

use std::io;
use std::net::IpAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use crate::api::{Message, Method};
use crate::fair::FairTurns;

/// Longest message that is parsed to see whether it is urgent, bytes. A stop consists of an id and
/// the name of an arm.
pub(super) const URGENT_LENGTH: usize = 1024;

/// Lane of a request: urgent ones do not wait behind others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lane {
    /// Stops, and messages that keep a jog alive.
    Urgent,
    /// Everything else.
    Ordinary,
}

impl Lane {
    /// Returns the lane of a JSON-RPC message.
    pub(crate) fn of(text: &str) -> Self {
        // The length is checked first, so that a long message costs no parsing before its turn.
        if text.len() <= URGENT_LENGTH && is_always_obeyed(text) {
            Self::Urgent
        } else {
            Self::Ordinary
        }
    }
}

/// True for messages without a rate limit: stops and keep-alives.
pub(super) fn is_always_obeyed(text: &str) -> bool {
    let message = Message::parse(text).ok();
    let method = message.and_then(|message| Method::named(&message.method));
    method.is_some_and(|method| method.always)
}

/// Key of a turn: connections with the same key share turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Sender {
    /// All connections without a session from one address.
    Address(IpAddr),
    /// A session.
    Session(u64),
}

/// Turns of a listener. Clones share them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Turns {
    urgent: FairTurns<Sender>,
    ordinary: FairTurns<Sender>,
}

/// Turns of one connection. Clones share them.
#[derive(Clone, Debug)]
pub(crate) struct Pacer {
    turns: Turns,
    address: IpAddr,
    /// Number of the connection within its listener.
    number: u64,
    has_session: Arc<AtomicBool>,
}

impl Pacer {
    pub(super) fn new(turns: Turns, address: IpAddr, number: u64) -> Self {
        Self {
            turns,
            address,
            number,
            has_session: Arc::default(),
        }
    }

    /// Gives the connection its own turns, because it has a session now.
    pub(crate) fn begin_session(&self) {
        self.has_session.store(true, Ordering::Relaxed);
    }

    /// Waits for the next turn of this connection.
    pub(crate) async fn turn(&self, lane: Lane) {
        // Without a session a client is known by its address alone.
        let sender = if self.has_session.load(Ordering::Relaxed) {
            Sender::Session(self.number)
        } else {
            Sender::Address(self.address)
        };
        let turns = match lane {
            Lane::Urgent => &self.turns.urgent,
            Lane::Ordinary => &self.turns.ordinary,
        };
        turns.turn(sender).await;
    }
}

/// Stream that waits for its turn before each read but the first. A client that pauses between
/// reads never waits.
pub(crate) struct Paced<S> {
    stream: S,
    pacer: Pacer,
    /// Turn to await before the next read.
    turn: Option<Pin<Box<dyn Future<Output = ()> + Send>>>,
}

impl<S> Paced<S> {
    pub(crate) fn new(stream: S, pacer: Pacer) -> Self {
        Self {
            stream,
            pacer,
            turn: None,
        }
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Paced<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if let Some(turn) = &mut self.turn {
            ready!(turn.as_mut().poll(cx));
            self.turn = None;
        }
        let before = buffer.filled().len();
        ready!(Pin::new(&mut self.stream).poll_read(cx, buffer))?;
        // The turn is requested after a read and awaited before the next one, so a single message
        // is never delayed.
        if buffer.filled().len() > before {
            let pacer = self.pacer.clone();
            self.turn = Some(Box::pin(async move { pacer.turn(Lane::Ordinary).await }));
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Paced<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(cx, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        slices: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(cx, slices)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }
}
