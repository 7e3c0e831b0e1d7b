//! What a joining machine and an invitation say to each other: one message each, JSON behind its length
//! in four bytes, big endian.

use std::io;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};

use super::Refusal;

/// Largest request, bytes. One of P-256 has about 700.
pub(super) const LARGEST_REQUEST: u32 = 8 * 1024;
/// Largest answer, bytes: a certificate, and the largest list as PEM.
pub(super) const LARGEST_ANSWER: u32 = 512 * 1024;

/// What the joining machine says, once it knows the authority.
#[derive(Deserialize, Serialize)]
pub(super) struct Request {
    pub(super) secret: String,
    /// Name that it wants.
    pub(super) name: String,
    /// Its public key, signed by its private one (PKCS #10, PEM).
    pub(super) request: String,
}

/// What the invitation says.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Answer {
    Joined {
        /// PEM.
        certificate: String,
        /// List of revoked certificates, PEM; empty without one.
        revoked: String,
    },
    Refused(Refusal),
}

/// Reads a message.
pub(super) async fn read<T: DeserializeOwned>(
    stream: &mut (impl AsyncRead + Unpin),
    largest: u32,
) -> io::Result<T> {
    let length = stream.read_u32().await?;
    if length > largest {
        return Err(io::ErrorKind::InvalidData.into());
    }
    // The memory grows with what arrives, not with what is announced.
    let mut bytes = Vec::new();
    stream.take(length.into()).read_to_end(&mut bytes).await?;
    if bytes.len() as u64 != u64::from(length) {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    serde_json::from_slice(&bytes).map_err(|_| io::ErrorKind::InvalidData.into())
}

/// Writes a message, whole.
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
