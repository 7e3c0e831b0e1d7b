//! Places of connections: connects the admission table to the tasks that serve them.
//!
//! The table decides who is evicted; this module applies the decision. A connection awaits
//! [`Place::evicted`] beside its work, and dropping its place frees it.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};

use axum::body::{Body, Bytes, HttpBody};
use axum::response::Response;
use hyper::body::{Frame, SizeHint};
use magician::admission::{AdmissionLimits, AdmissionTable, NoPlace, Origin};
use magician_protocol::HostInstant;
use tokio::sync::Notify;
use tokio::time::Instant;

use super::pacing::{Pacer, Turns};

/// Connections of a listener. Clones share them.
#[derive(Clone)]
pub(crate) struct Places(Arc<ListenerState>);

struct ListenerState {
    started: Instant,
    turns: Turns,
    inner: Mutex<Inner>,
}

struct Inner {
    table: AdmissionTable<u64>,
    /// Notifies a connection that it is evicted.
    ends: BTreeMap<u64, Arc<Notify>>,
    connections: u64,
}

/// Place of a connection. Dropping the last clone frees it.
#[derive(Clone)]
pub(crate) struct Place(Arc<HeldPlace>);

struct HeldPlace {
    listener: Arc<ListenerState>,
    key: u64,
    end: Arc<Notify>,
    pacer: Pacer,
}

impl Places {
    pub(crate) fn new(limits: AdmissionLimits) -> Self {
        Self(Arc::new(ListenerState {
            started: Instant::now(),
            turns: Turns::default(),
            inner: Mutex::new(Inner {
                table: AdmissionTable::new(limits),
                ends: BTreeMap::new(),
                connections: 0,
            }),
        }))
    }

    /// Registers an accepted connection. It gets a place at once; another one may be evicted for
    /// it.
    pub(crate) fn enter(&self, address: IpAddr) -> Place {
        let end = Arc::new(Notify::new());
        let key = self.0.with(|inner, now| {
            inner.connections += 1;
            let key = inner.connections;
            inner.ends.insert(key, Arc::clone(&end));
            let gone = inner.table.open(now, key, Origin::of(address));
            inner.end(gone);
            key
        });
        let turns = self.0.turns.clone();
        Place(Arc::new(HeldPlace {
            listener: Arc::clone(&self.0),
            key,
            end,
            // Canonical, so that a client has one turn on IPv4 and mapped IPv6.
            pacer: Pacer::new(turns, address.to_canonical(), key),
        }))
    }

    /// Evicts a stranger because the process is out of descriptors. Returns false without a
    /// stranger.
    pub(crate) fn evict_stranger(&self) -> bool {
        self.0.with(|inner, _| {
            let gone = inner.table.shed();
            inner.end(gone);
            gone.is_some()
        })
    }
}

impl ListenerState {
    fn with<T>(&self, act: impl FnOnce(&mut Inner, HostInstant) -> T) -> T {
        let now = HostInstant::ZERO + self.started.elapsed();
        act(&mut self.lock(), now)
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        // After a panic elsewhere the state is still consistent: it holds whole values.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    fn end(&mut self, gone: Option<u64>) {
        // `notify_one` stores a permit, so a connection that does not wait yet also learns of it.
        if let Some(end) = gone.and_then(|gone| self.ends.remove(&gone)) {
            end.notify_one();
        }
    }
}

impl Place {
    /// Returns the turns of this connection.
    pub(crate) fn pacer(&self) -> &Pacer {
        &self.0.pacer
    }

    /// Records that the head of a request is complete.
    pub(crate) fn note_head(&self) {
        self.0
            .listener
            .with(|inner, now| inner.table.heard(now, self.0.key));
    }

    /// Records that the client is identified. The request may be incomplete, or its answer not yet
    /// read.
    pub(crate) fn begin(&self) {
        self.0.listener.with(|inner, now| {
            let gone = inner.table.begin(now, self.0.key);
            inner.end(gone);
        });
    }

    /// Claims a place because a request is being carried out.
    pub(crate) fn claim(&self) -> Result<(), NoPlace> {
        self.0.listener.with(|inner, now| {
            let gone = inner.table.claim(now, self.0.key)?;
            inner.end(gone);
            Ok(())
        })
    }

    /// Records that a request is over: the connection is idle.
    fn end_request(&self) {
        self.0.listener.with(|inner, now| {
            let gone = inner.table.end_request(now, self.0.key);
            inner.end(gone);
        });
    }

    /// Resolves when this connection is evicted.
    pub(crate) async fn evicted(&self) {
        self.0.end.notified().await;
    }

    /// Extends a request until the body of its response was taken or dropped.
    pub(super) fn hold_until_sent(&self, response: Response) -> Response {
        let ending = RequestEnd(self.clone());
        response.map(|body| Body::new(TrackedBody { body, _end: ending }))
    }
}

impl Drop for HeldPlace {
    fn drop(&mut self) {
        let mut inner = self.listener.lock();
        inner.table.close(self.key);
        // Already gone if the connection was evicted.
        inner.ends.remove(&self.key);
    }
}

struct RequestEnd(Place);

impl Drop for RequestEnd {
    fn drop(&mut self) {
        self.0.end_request();
    }
}

/// Body that ends the request when it is dropped.
struct TrackedBody {
    body: Body,
    _end: RequestEnd,
}

impl HttpBody for TrackedBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(cx)
    }

    fn is_end_stream(&self) -> bool {
        // Forwarded, as is the size below, so that hyper knows the length of the answer.
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
