//! Files that are read and laid before an arm: here, or elsewhere. A page's station has no readers: another module has them, beside the
//! worker that must hear a stop.

use std::pin::Pin;

use magician_program::FileToLay;
use magician_program::wire::FileAnswer;

use crate::api::RpcError;

/// An answer on its way. Who drops it no longer wants it.
pub type AnswerToCome = Pin<Box<dyn Future<Output = Result<FileAnswer, RpcError>> + Send>>;

/// What comes of laying a file.
#[non_exhaustive]
pub enum LaidFile {
    /// It was laid.
    Here(FileAnswer),
    /// It is laid elsewhere.
    ToCome(AnswerToCome),
}

/// Lays files.
pub trait FileLayer: Send + Sync {
    /// Lays one. What is to come comes to an end whatever becomes of that: an error is the answer then.
    fn lay(&self, file: FileToLay) -> LaidFile;
}

/// Lays them with the readers that are built in.
#[derive(Clone, Copy, Debug, Default)]
pub struct LayHere;

impl FileLayer for LayHere {
    fn lay(&self, file: FileToLay) -> LaidFile {
        LaidFile::Here(file.lay())
    }
}
