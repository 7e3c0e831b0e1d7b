//! Messages between a joining machine and an invitation: one request and one reply, each JSON after
//! its length in four bytes, big endian.

use std::io;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};

use super::Refusal;

/// Largest request, bytes. One with a P-256 key has about 700.
pub(super) const MAX_REQUEST_SIZE: u32 = 8 * 1024;
/// Largest reply, bytes: a certificate, and the largest list as PEM.
pub(super) const MAX_ANSWER_SIZE: u32 = 512 * 1024;

/// Request of a joining machine, sent once it has recognised the authority.
#[derive(Deserialize, Serialize)]
pub(super) struct Request {
    pub(super) secret: String,
    /// Requested name.
    pub(super) name: String,
    /// Certificate request: the public key, signed by the private one (PKCS #10, PEM).
    pub(super) request: String,
}

/// Reply of the invitation.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Answer {
    Joined {
        /// Certificate, PEM.
        certificate: String,
        /// List of revoked certificates, PEM. Empty if no list exists.
        revoked: String,
    },
    Refused(Refusal),
}

/// Reads a message of at most `largest` bytes.
pub(super) async fn read<T: DeserializeOwned>(
    stream: &mut (impl AsyncRead + Unpin),
    largest: u32,
) -> io::Result<T> {
    let length = stream.read_u32().await?;
    if length > largest {
        return Err(io::ErrorKind::InvalidData.into());
    }
    // `read_to_end` grows the buffer with what arrives, so a false length allocates nothing.
    let mut bytes = Vec::new();
    stream.take(length.into()).read_to_end(&mut bytes).await?;
    if bytes.len() as u64 != u64::from(length) {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    serde_json::from_slice(&bytes).map_err(|_| io::ErrorKind::InvalidData.into())
}

/// Writes a message and flushes it.
pub(super) async fn write<T: Serialize>(
    stream: &mut (impl AsyncWrite + Unpin),
    message: &T,
) -> io::Result<()> {
    let text = serde_json::to_vec(message)?;
    let length = u32::try_from(text.len()).map_err(|_| io::ErrorKind::InvalidData)?;
    stream.write_u32(length).await?;
    stream.write_all(&text).await?;
    stream.flush().await
}
