//! Places of a listener: each connection has one, and loses it when the admission table says so.

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

/// The connections of a listener. Clones are of the same listener.
#[derive(Clone)]
pub(crate) struct Places(Arc<Hall>);

struct Hall {
    begun: Instant,
    turns: Turns,
    inner: Mutex<Inner>,
}

struct Inner {
    table: AdmissionTable<u64>,
    /// Tells a connection that it gives way.
    ends: BTreeMap<u64, Arc<Notify>>,
    connections: u64,
}

/// The place of a connection; dropping the last clone frees it.
#[derive(Clone)]
pub(crate) struct Place(Arc<Held>);

struct Held {
    hall: Arc<Hall>,
    key: u64,
    end: Arc<Notify>,
    pacer: Pacer,
}

impl Places {
    pub(crate) fn new(limits: AdmissionLimits) -> Self {
        Self(Arc::new(Hall {
            begun: Instant::now(),
            turns: Turns::default(),
            inner: Mutex::new(Inner {
                table: AdmissionTable::new(limits),
                ends: BTreeMap::new(),
                connections: 0,
            }),
        }))
    }

    /// A connection was accepted. It gets a place at once; another may have to give way.
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
        Place(Arc::new(Held {
            hall: Arc::clone(&self.0),
            key,
            end,
            pacer: Pacer::new(turns, address.to_canonical(), key),
        }))
    }

    /// The system has no descriptor for one more: a stranger gives way, if there is one.
    pub(crate) fn shed(&self) -> bool {
        self.0.with(|inner, _| {
            let gone = inner.table.shed();
            inner.end(gone);
            gone.is_some()
        })
    }
}

impl Hall {
    fn with<T>(&self, act: impl FnOnce(&mut Inner, HostInstant) -> T) -> T {
        let now = HostInstant::ZERO + self.begun.elapsed();
        act(&mut self.lock(), now)
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        // What it holds is whole values, whoever panicked.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    fn end(&mut self, gone: Option<u64>) {
        if let Some(end) = gone.and_then(|gone| self.ends.remove(&gone)) {
            end.notify_one();
        }
    }
}

impl Place {
    /// The turns of this connection.
    pub(crate) fn pacer(&self) -> &Pacer {
        &self.0.pacer
    }

    /// The head of a request is whole.
    pub(crate) fn heard(&self) {
        self.0
            .hall
            .with(|inner, now| inner.table.heard(now, self.0.key));
    }

    /// It is known who asks; the request is not whole yet, or its answer has to be taken.
    pub(crate) fn begin(&self) {
        self.0.hall.with(|inner, now| {
            let gone = inner.table.begin(now, self.0.key);
            inner.end(gone);
        });
    }

    /// A request is carried out from now on.
    pub(crate) fn claim(&self) -> Result<(), NoPlace> {
        self.0.hall.with(|inner, now| {
            let gone = inner.table.claim(now, self.0.key)?;
            inner.end(gone);
            Ok(())
        })
    }

    /// A request is over: the connection waits for the next one, or for nothing.
    fn end_request(&self) {
        self.0.hall.with(|inner, now| {
            let gone = inner.table.end_request(now, self.0.key);
            inner.end(gone);
        });
    }

    /// Awaited for the instant at which this connection gives way.
    pub(crate) async fn gives_way(&self) {
        self.0.end.notified().await;
    }

    /// A response whose request is over when the body was taken, or is not wanted any more.
    pub(super) fn until_taken(&self, response: Response) -> Response {
        let ending = RequestEnd(self.clone());
        response.map(|body| Body::new(Watched { body, _end: ending }))
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        let mut inner = self.hall.lock();
        inner.table.close(self.key);
        inner.ends.remove(&self.key);
    }
}

struct RequestEnd(Place);

impl Drop for RequestEnd {
    fn drop(&mut self) {
        self.0.end_request();
    }
}

/// A body that tells when nobody needs it any more.
struct Watched {
    body: Body,
    _end: RequestEnd,
}

impl HttpBody for Watched {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(cx)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
