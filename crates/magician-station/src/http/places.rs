//! Places of connections in the admission table, for the tasks that serve these connections.
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
    evictions: BTreeMap<u64, Arc<Notify>>,
    connections: u64,
}

/// Place of a connection. Dropping the last clone frees it.
#[derive(Clone)]
pub(crate) struct Place(Arc<HeldPlace>);

struct HeldPlace {
    listener: Arc<ListenerState>,
    key: u64,
    eviction: Arc<Notify>,
    pacer: Pacer,
}

impl Places {
    pub(crate) fn new(limits: AdmissionLimits) -> Self {
        Self(Arc::new(ListenerState {
            started: Instant::now(),
            turns: Turns::default(),
            inner: Mutex::new(Inner {
                table: AdmissionTable::new(limits),
                evictions: BTreeMap::new(),
                connections: 0,
            }),
        }))
    }

    /// Registers an accepted connection. It gets a place at once; another one may be evicted for
    /// it.
    pub(crate) fn enter(&self, address: IpAddr) -> Place {
        let eviction = Arc::new(Notify::new());
        let key = self.0.with(|inner, now| {
            inner.connections += 1;
            let key = inner.connections;
            inner.evictions.insert(key, Arc::clone(&eviction));
            let evicted = inner.table.open(now, key, Origin::of(address));
            inner.notify_evicted(evicted);
            key
        });
        let turns = self.0.turns.clone();
        Place(Arc::new(HeldPlace {
            listener: Arc::clone(&self.0),
            key,
            eviction,
            // Canonical, so that a client has one turn on IPv4 and mapped IPv6.
            pacer: Pacer::new(turns, address.to_canonical(), key),
        }))
    }

    /// Evicts a stranger (a connection without a request of an identified client) because the
    /// process is out of descriptors. Returns false if there is no stranger.
    pub(crate) fn evict_stranger(&self) -> bool {
        self.0.with(|inner, _| {
            let evicted = inner.table.shed();
            inner.notify_evicted(evicted);
            evicted.is_some()
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
    fn notify_evicted(&mut self, evicted: Option<u64>) {
        // `notify_one` stores a permit, so a connection that does not wait yet also learns of it.
        if let Some(eviction) = evicted.and_then(|evicted| self.evictions.remove(&evicted)) {
            eviction.notify_one();
        }
    }
}

impl Place {
    /// Returns the pacer, which gives this connection its turns.
    pub(crate) fn pacer(&self) -> &Pacer {
        &self.0.pacer
    }

    /// Records that the head of a request is complete.
    pub(crate) fn note_head(&self) {
        self.0
            .listener
            .with(|inner, now| inner.table.heard(now, self.0.key));
    }

    /// Records that the client is identified. Until [`claim`](Self::claim) the connection can still
    /// be evicted, so that an incomplete request or an unread answer does not hold its place.
    pub(crate) fn begin(&self) {
        self.0.listener.with(|inner, now| {
            let evicted = inner.table.begin(now, self.0.key);
            inner.notify_evicted(evicted);
        });
    }

    /// Protects the place from eviction while a request is carried out.
    pub(crate) fn claim(&self) -> Result<(), NoPlace> {
        self.0.listener.with(|inner, now| {
            let evicted = inner.table.claim(now, self.0.key)?;
            inner.notify_evicted(evicted);
            Ok(())
        })
    }

    /// Records that a request is over: the connection is idle.
    fn end_request(&self) {
        self.0.listener.with(|inner, now| {
            let evicted = inner.table.end_request(now, self.0.key);
            inner.notify_evicted(evicted);
        });
    }

    /// Resolves when this connection is evicted.
    pub(crate) async fn evicted(&self) {
        self.0.eviction.notified().await;
    }

    /// Counts the request as running until the body of its response is sent or dropped.
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
        inner.evictions.remove(&self.key);
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
