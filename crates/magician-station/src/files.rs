//! Files that are prepared here, or elsewhere: a page's station has no readers. Another module has them, beside the worker that
//! must hear a stop.

use std::pin::Pin;

use magician_program::PrepareRequest;
use magician_program::wire::FileAnswer;

use crate::api::RpcError;

/// An answer on its way. Dropping it gives the file up.
pub type AnswerToCome = Pin<Box<dyn Future<Output = Result<FileAnswer, RpcError>> + Send>>;

/// Program of a file, or the promise of one.
#[non_exhaustive]
pub enum FilePreparation {
    /// It is prepared.
    Here(FileAnswer),
    /// It is prepared elsewhere.
    ToCome(AnswerToCome),
}

/// Prepares files.
pub trait FilePreparer: Send + Sync {
    /// Prepares one. An answer to come always comes, as an error if need be.
    fn prepare(&self, request: PrepareRequest) -> FilePreparation;
}

/// Prepares files with the readers that are built in.
#[derive(Clone, Copy, Debug, Default)]
pub struct PrepareHere;

impl FilePreparer for PrepareHere {
    fn prepare(&self, request: PrepareRequest) -> FilePreparation {
        FilePreparation::Here(request.prepare())
    }
}
