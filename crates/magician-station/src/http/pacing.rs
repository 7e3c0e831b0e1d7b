//! Turns of connections: a flood of one sender costs the others a bounded time, and a stop none.

use std::io;
use std::net::IpAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use crate::api::{Message, Method};
use crate::fair::FairTurns;

/// Longest text that is looked at for an urgent method, bytes. A stop has an id and the name of an arm.
pub(super) const URGENT_LENGTH: usize = 1024;

/// Requests of which nobody is to wait behind others, and all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lane {
    /// Stops, and what keeps a jog up.
    Urgent,
    /// Everything else.
    Ordinary,
}

impl Lane {
    /// The lane of a message of JSON-RPC.
    pub(crate) fn of(text: &str) -> Self {
        if text.len() <= URGENT_LENGTH && is_always_obeyed(text) {
            Self::Urgent
        } else {
            Self::Ordinary
        }
    }
}

/// True if a message is one of those that the station obeys in any number.
pub(super) fn is_always_obeyed(text: &str) -> bool {
    let message = Message::parse(text).ok();
    let method = message.and_then(|message| Method::named(&message.method));
    method.is_some_and(|method| method.always)
}

/// Who shares a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Sender {
    /// All connections from an address that have no session.
    Address(IpAddr),
    /// One session.
    Session(u64),
}

/// The turns of a listener. Clones are of the same listener.
#[derive(Clone, Debug, Default)]
pub(crate) struct Turns {
    urgent: FairTurns<Sender>,
    ordinary: FairTurns<Sender>,
}

/// The turns of one connection. Clones are of the same connection.
#[derive(Clone, Debug)]
pub(crate) struct Pacer {
    turns: Turns,
    address: IpAddr,
    /// Number of the connection at its listener.
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

    /// The connection has a session, which has turns of its own from now on.
    pub(crate) fn begin_session(&self) {
        self.has_session.store(true, Ordering::Relaxed);
    }

    /// Waits until it is this connection's turn.
    pub(crate) async fn turn(&self, lane: Lane) {
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

/// A stream with a turn between one read and the next. What pauses between two reads never waits.
pub(crate) struct Paced<S> {
    stream: S,
    pacer: Pacer,
    /// The turn that is due before the next read.
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
