//! Files that the page prepares with its other module (`files.wasm`).

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use magician::ErrorKind;
use magician_job::background::BackgroundTurns;
use magician_program::PrepareRequest;
use magician_program::wire::{WireError, answer_yielding};
use magician_station::api::RpcError;
use magician_station::{FilePreparation, FilePreparer};
use tokio::sync::{Semaphore, oneshot};
use tokio::time::timeout;

/// Timeout for reading a file. The page ends its reader earlier, after 60 s
/// (`studio/src/files.ts`).
const READ_TIMEOUT: Duration = Duration::from_secs(90);

/// Largest answer, bytes: about two million steps. For a larger one the module would lack memory to
/// check it.
const MAX_ANSWER_SIZE: usize = 64 << 20;

/// Files to prepare. One at a time is passed to the page; the others wait in order and take no
/// memory there.
#[derive(Clone)]
pub(crate) struct PageFiles {
    queue: Arc<Mutex<RequestQueue>>,
    slot: Arc<Semaphore>,
}

#[derive(Default)]
struct RequestQueue {
    last_id: u32,
    /// Messages for the page: a file to read, or the cancellation of one.
    out: VecDeque<(u32, Vec<u8>)>,
    waiting: BTreeMap<u32, oneshot::Sender<Option<Vec<u8>>>>,
}

impl Default for PageFiles {
    fn default() -> Self {
        Self {
            queue: Arc::default(),
            slot: Arc::new(Semaphore::new(1)),
        }
    }
}

impl PageFiles {
    fn queue(&self) -> MutexGuard<'_, RequestQueue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the next message for the page.
    pub(crate) fn next_message(&self) -> Option<Vec<u8>> {
        let (id, mut request) = self.queue().out.pop_front()?;
        request.splice(..0, id.to_le_bytes());
        Some(request)
    }

    /// Accepts the result for a file, empty if the page's reader failed. A result that nothing
    /// waits for is dropped.
    pub(crate) fn accept_answer(&self, id: u32, answer: &[u8]) {
        let waiting = self.queue().waiting.remove(&id);
        if let Some(waiting) = waiting {
            // The waiting task may have been dropped.
            let _ = waiting.send((answer.len() <= MAX_ANSWER_SIZE).then(|| answer.to_vec()));
        }
    }

    fn enqueue(&self, request: Vec<u8>) -> (PendingRead, oneshot::Receiver<Option<Vec<u8>>>) {
        let (sender, answer) = oneshot::channel();
        let mut queue = self.queue();
        queue.last_id = queue.last_id.wrapping_add(1);
        let id = queue.last_id;
        queue.out.push_back((id, request));
        queue.waiting.insert(id, sender);
        drop(queue);
        let files = self.clone();
        (PendingRead { files, id }, answer)
    }
}

/// A pending request. Dropping it before the answer cancels it at the page.
struct PendingRead {
    files: PageFiles,
    id: u32,
}

impl Drop for PendingRead {
    fn drop(&mut self) {
        let mut queue = self.files.queue();
        if queue.waiting.remove(&self.id).is_none() {
            return;
        }
        let count = queue.out.len();
        let id = self.id;
        queue.out.retain(|(queued_id, _)| *queued_id != id);
        // The page has taken the request already, so it must be told.
        if queue.out.len() == count {
            queue.out.push_back((id, Vec::new()));
        }
    }
}

impl FilePreparer for PageFiles {
    fn prepare(&self, mut request: PrepareRequest) -> FilePreparation {
        let files = self.clone();
        FilePreparation::Pending(Box::pin(async move {
            let _slot = files.slot.acquire().await;
            let bytes = request.to_bytes();
            // The page's worker has the file now; two copies may exceed the memory.
            request.bytes = Arc::default();
            let (pending, answer) = files.enqueue(bytes);
            let answer = timeout(READ_TIMEOUT, answer).await;
            drop(pending);
            let wrong = |kind, why: &str| Err(RpcError::arm(kind, why));
            match answer {
                Err(_) => wrong(ErrorKind::Timeout, "reading the file took too long"),
                Ok(Err(_)) => wrong(ErrorKind::Unexpected, FAILED),
                Ok(Ok(None)) => wrong(ErrorKind::Unsupported, TOO_LARGE),
                Ok(Ok(Some(bytes))) if bytes.is_empty() => wrong(ErrorKind::Unexpected, FAILED),
                Ok(Ok(Some(bytes))) => {
                    answer_yielding(&request, &bytes, &BackgroundTurns).await
                }
                .or_else(|error| match error {
                    WireError::OtherBuild => wrong(ErrorKind::Unsupported, &error.to_string()),
                    _ => wrong(ErrorKind::Unexpected, &error.to_string()),
                }),
            }
        }))
    }
}

/// Message for a program whose answer exceeds [`MAX_ANSWER_SIZE`].
const TOO_LARGE: &str = "the program is too large to be run by a page: run it by a station";
/// Message for an empty answer of the reader.
const FAILED: &str = "the file reader stopped before it had read the file";
