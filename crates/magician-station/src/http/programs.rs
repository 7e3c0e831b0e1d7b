//! Programs of the library over HTTP: raw bytes, streamed in both directions.

use std::io::{self, Read};
use std::sync::Arc;
use std::time::Duration;

use axum::body::{Body, BodyDataStream, Bytes};
use axum::extract::Request;
use axum::http::header::{CONTENT_LENGTH, CONTENT_TYPE, EXPECT};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use futures_util::{StreamExt, stream};
use magician::message;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

use super::routes::text;
use crate::Role;
use crate::library::{LibraryError, MAX_PROGRAM_SIZE, ProgramName, ProgramStore, Upload};

/// Path prefix. The name of a program follows.
const PATH_PREFIX: &str = "/api/v1/programs/";
/// Most uploads at once. Chosen to bound the number of open part files.
const MAX_UPLOADS: usize = 8;
/// Longest pause within an upload.
const UPLOAD_TIMEOUT: Duration = Duration::from_secs(30);
/// Time for reading the rest of a refused upload.
const DRAIN_TIMEOUT: Duration = Duration::from_secs(10);
/// Bytes read from a file at once.
const CHUNK_SIZE: u64 = 64 * 1024;

/// Limiter of the number of uploads in progress.
#[derive(Clone, Debug)]
pub struct Uploads(Arc<Semaphore>);

impl Default for Uploads {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(MAX_UPLOADS)))
    }
}

impl Uploads {
    fn begin(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.0).try_acquire_owned().ok()
    }
}

/// Returns the percent-decoded name of a program in a path. `None` if it is not a valid name.
pub(super) fn name_in(path: &str) -> Option<ProgramName> {
    let mut rest = path.strip_prefix(PATH_PREFIX)?.bytes();
    let mut name = Vec::new();
    while let Some(sign) = rest.next() {
        let decoded = match sign {
            b'%' => {
                let digit = |sign: u8| char::from(sign).to_digit(16);
                let [high, low] = [digit(rest.next()?)?, digit(rest.next()?)?];
                u8::try_from(16 * high + low).ok()?
            }
            plain => plain,
        };
        name.push(decoded);
    }
    ProgramName::new(std::str::from_utf8(&name).ok()?)
}

/// Streams a program to the client.
pub(super) async fn get(store: Arc<dyn ProgramStore>, name: ProgramName) -> Response {
    let opened = tokio::task::spawn_blocking(move || store.open(&name)).await;
    let (size, from) = match opened {
        Ok(Ok(opened)) => opened,
        Ok(Err(error)) => return refused(&error),
        Err(_) => return refused(&LibraryError::Other(message!("it cannot be read"))),
    };
    // Piece by piece on a blocking thread: a program of 64 MiB is never in memory as a whole.
    let pieces = stream::unfold(Some(from), |from| async move {
        let read = tokio::task::spawn_blocking(move || read_chunk(from?)).await;
        read.ok().flatten()
    });
    let mut response = Body::from_stream(pieces).into_response();
    let headers = response.headers_mut();
    headers.insert(CONTENT_LENGTH, HeaderValue::from(size));
    let bytes = HeaderValue::from_static("application/octet-stream");
    headers.insert(CONTENT_TYPE, bytes);
    response
}

type From = Box<dyn Read + Send>;

/// Reads the next piece. Returns it with the rest of the file.
fn read_chunk(mut from: From) -> Option<(io::Result<Bytes>, Option<From>)> {
    let mut bytes = Vec::new();
    match from.by_ref().take(CHUNK_SIZE).read_to_end(&mut bytes) {
        // End of the file; the length was sent before.
        Ok(0) => None,
        Ok(_) => Some((Ok(bytes.into()), Some(from))),
        Err(error) => Some((Err(error), None)),
    }
}

/// Stores a program, as a whole or not at all.
pub(super) async fn put(
    store: Arc<dyn ProgramStore>,
    uploads: &Uploads,
    name: ProgramName,
    by: Role,
    request: Request,
) -> Response {
    let length = request.headers().get(CONTENT_LENGTH);
    let length = length.and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    // Held until the upload is stored or dropped.
    let Some(_permit) = uploads.begin() else {
        let why = "the station takes other programs already: try again";
        return text(StatusCode::SERVICE_UNAVAILABLE, why);
    };
    let opened = tokio::task::spawn_blocking(move || store.upload(&name, by, length)).await;
    let mut upload = match opened {
        Ok(Ok(upload)) => BlockingUpload(Some(upload)),
        Ok(Err(error)) => {
            // Refused before the bytes arrive; they are read and dropped in the background.
            drain_request(request);
            return refused(&error);
        }
        Err(_) => return refused(&lost()),
    };
    let mut pieces = request.into_body().into_data_stream();
    loop {
        let piece = match timeout(UPLOAD_TIMEOUT, pieces.next()).await {
            Ok(Some(Ok(piece))) => piece,
            Ok(Some(Err(_))) => {
                // The part file is removed when `upload` is dropped.
                return text(StatusCode::BAD_REQUEST, "the program ended before its end");
            }
            Ok(None) => break,
            Err(_) => return text(StatusCode::REQUEST_TIMEOUT, "nothing more came"),
        };
        if let Err(error) = upload.write(piece).await {
            // The part file is removed before the sender learns of the failure, so that a retry
            // finds its room free.
            upload.give_up().await;
            drain_body(&mut pieces).await;
            return refused(&error);
        }
    }
    let Some(upload) = upload.0.take() else {
        return refused(&lost());
    };
    match tokio::task::spawn_blocking(move || upload.finish()).await {
        Ok(Ok(true)) => StatusCode::CREATED.into_response(),
        Ok(Ok(false)) => StatusCode::OK.into_response(),
        Ok(Err(error)) => refused(&error),
        Err(_) => refused(&lost()),
    }
}

/// Reads the rest of an upload after an early answer, because many clients read the answer only
/// after sending everything. With `Expect: 100-continue` the client has not sent the bytes and is
/// not asked to.
fn drain_request(request: Request) {
    if request.headers().contains_key(EXPECT) {
        return;
    }
    let mut pieces = request.into_body().into_data_stream();
    tokio::spawn(async move {
        let _ = timeout(DRAIN_TIMEOUT, drain_body(&mut pieces)).await;
    });
}

/// Reads the rest of an upload, up to the size of the largest program.
async fn drain_body(pieces: &mut BodyDataStream) {
    let mut left = MAX_PROGRAM_SIZE;
    while let Ok(Some(Ok(piece))) = timeout(UPLOAD_TIMEOUT, pieces.next()).await {
        left = left.saturating_sub(piece.len() as u64);
        if left == 0 {
            return;
        }
    }
}

/// Upload whose file is accessed on blocking threads only, also when it is dropped.
struct BlockingUpload(Option<Box<dyn Upload>>);

impl BlockingUpload {
    async fn write(&mut self, piece: Bytes) -> Result<(), LibraryError> {
        let mut upload = self.0.take().ok_or_else(lost)?;
        let written = tokio::task::spawn_blocking(move || {
            let written = upload.write(&piece);
            (upload, written)
        });
        let (upload, written) = written.await.map_err(|_| lost())?;
        self.0 = Some(upload);
        written
    }

    async fn give_up(&mut self) {
        let upload = self.0.take();
        let _ = tokio::task::spawn_blocking(move || drop(upload)).await;
    }
}

impl Drop for BlockingUpload {
    fn drop(&mut self) {
        // Dropping removes the part file, which may block.
        if let Some(upload) = self.0.take() {
            match tokio::runtime::Handle::try_current() {
                Ok(runtime) => drop(runtime.spawn_blocking(move || drop(upload))),
                Err(_) => drop(upload),
            }
        }
    }
}

fn lost() -> LibraryError {
    LibraryError::Other(message!("the program is not kept"))
}

/// Removes a program.
pub(super) async fn delete(store: Arc<dyn ProgramStore>, name: ProgramName) -> Response {
    match tokio::task::spawn_blocking(move || store.delete(&name)).await {
        Ok(Ok(())) => StatusCode::NO_CONTENT.into_response(),
        Ok(Err(error)) => refused(&error),
        Err(_) => refused(&LibraryError::Other(message!("it is not removed"))),
    }
}

fn refused(error: &LibraryError) -> Response {
    let status = match error {
        LibraryError::Unknown => StatusCode::NOT_FOUND,
        LibraryError::TooLarge | LibraryError::Quota(_) => StatusCode::PAYLOAD_TOO_LARGE,
        LibraryError::Full => StatusCode::INSUFFICIENT_STORAGE,
        LibraryError::Other(_) => StatusCode::INTERNAL_SERVER_ERROR,
    };
    text(status, &error.to_string())
}
