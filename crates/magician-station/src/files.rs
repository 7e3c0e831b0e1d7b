//! Files that are read elsewhere. A page's station has no readers but that of plans: another module has them, beside the worker that
//! must hear a stop.

use std::pin::Pin;
use std::sync::Arc;

use magician::ErrorKind;
use magician_program::wire::{FileAnswer, FileRequest};
use magician_program::{Format, ReadOptions};

use crate::api::RpcError;
use crate::job::Reader;

/// An answer on its way. Who drops it no longer wants it.
pub type AnswerToCome = Pin<Box<dyn Future<Output = Result<FileAnswer, RpcError>> + Send>>;

/// Reads files elsewhere.
pub trait FileReader: Send + Sync {
    /// Reads one. It comes to an end whatever becomes of the reader: an error is the answer then.
    fn read(&self, request: FileRequest) -> AnswerToCome;
}

/// More files are not read for one program: it is read as it is, and where it depends on that, once more from where the arm stands.
const MOST: usize = 4;

/// What was read elsewhere for one program, as long as that is being read.
#[derive(Clone, Debug, Default)]
pub struct FilesRead(Vec<(FileRequest, Arc<FileAnswer>)>);

impl FilesRead {
    /// Adds what came of a request.
    pub fn add(&mut self, request: FileRequest, answer: FileAnswer) {
        self.0.push((request, Arc::new(answer)));
    }

    /// What came of such a file.
    pub(crate) fn find(
        &self,
        format: Format,
        bytes: &[u8],
        options: &ReadOptions,
    ) -> Option<FileAnswer> {
        let is_it = |asked: &FileRequest| {
            asked.format == format && asked.options == *options && *asked.bytes == *bytes
        };
        let (_, answer) = self.0.iter().find(|(asked, _)| is_it(asked))?;
        Some((**answer).clone())
    }

    /// Has one read by who reads files for a reader.
    pub(crate) async fn read(
        &mut self,
        reader: &dyn Reader,
        request: FileRequest,
    ) -> Result<(), RpcError> {
        if self.0.len() >= MOST {
            return Err(RpcError::internal("the program is read without end"));
        }
        let answer = reader.read_file(request.clone()).await?;
        self.add(request, answer);
        Ok(())
    }
}

/// Where nobody reads files.
pub(crate) fn nobody() -> AnswerToCome {
    let why = "this station reads plans only";
    let error = RpcError::arm(ErrorKind::Unsupported, why);
    Box::pin(std::future::ready(Err(error)))
}
