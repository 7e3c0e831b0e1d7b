//! Hook for preparing files outside the station's own thread.
//!
//! On a page without a server the station has no readers for files. Another WebAssembly module has
//! them and prepares programs in its own worker, so that the worker of the station can still
//! receive a stop. A [`FilePreparer`] therefore returns either a result or a future.

use std::pin::Pin;

use magician_program::PrepareRequest;
use magician_program::wire::FileAnswer;

use crate::api::RpcError;

/// Future that resolves to a prepared file. Dropping it cancels the preparation.
pub type PendingAnswer = Pin<Box<dyn Future<Output = Result<FileAnswer, RpcError>> + Send>>;

/// Result of [`FilePreparer::prepare`]: a program or a future.
#[non_exhaustive]
pub enum FilePreparation {
    /// The file is prepared.
    Ready(FileAnswer),
    /// The file is being prepared elsewhere.
    Pending(PendingAnswer),
}

/// Prepares files into programs.
pub trait FilePreparer: Send + Sync {
    /// Prepares one file. A future must resolve in any case, with an error if necessary.
    fn prepare(&self, request: PrepareRequest) -> FilePreparation;
}

/// Prepares files in place, with the readers that are compiled in.
#[derive(Clone, Copy, Debug, Default)]
pub struct LocalPreparer;

impl FilePreparer for LocalPreparer {
    fn prepare(&self, request: PrepareRequest) -> FilePreparation {
        FilePreparation::Ready(request.prepare())
    }
}
