//! Connections to a station that is identified by the name in its certificate instead of its
//! address.
//!
//! On a site addresses come from a bus that anyone can write to, so an address is only a hint.
//! Nothing is sent, the token least of all, before the station has shown a certificate with its
//! name.

use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use futures_util::future::select_ok;
use http::StatusCode;
use tokio::net::TcpStream;
use tokio::time::{sleep, timeout};
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::ClientConfig;
use tokio_rustls::rustls::pki_types::ServerName;

use super::request::exchange;
use super::task::{NO_ANSWER, OPEN_TIMEOUT, refused, upgrade};
use super::trust::{Stream, no_station, refused_certificate};
use super::{ClientError, RawSocket};

/// Delay before opening a socket is retried after the process or the system ran out of descriptors.
const DESCRIPTOR_RETRY_DELAY: Duration = Duration::from_millis(50);

/// Station identified by the name in its certificate, with addresses at which it may answer.
#[derive(Clone)]
pub struct StationDial {
    name: String,
    addresses: Vec<SocketAddr>,
    connector: TlsConnector,
}

impl fmt::Debug for StationDial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StationDial")
            .field("name", &self.name)
            .field("addresses", &self.addresses)
            .finish_non_exhaustive()
    }
}

impl StationDial {
    /// Describes the station with this name. `config` contains the trusted certificates, and this
    /// program's own certificate if stations ask for one.
    #[must_use]
    pub fn new(name: &str, addresses: Vec<SocketAddr>, config: Arc<ClientConfig>) -> Self {
        Self {
            name: name.to_owned(),
            addresses,
            connector: TlsConnector::from(config),
        }
    }

    /// Sends one JSON-RPC request by POST. Returns the text of the answer, empty for a
    /// notification.
    ///
    /// # Errors
    /// With [`ClientError::Unreachable`], [`ClientError::Untrusted`] or [`ClientError::Busy`]
    /// nothing was done, except that a busy station still carries out a stop. With
    /// [`ClientError::Lost`] the request may have been carried out.
    pub async fn post(&self, token: Option<&str>, text: String) -> Result<String, ClientError> {
        let stream = self.open().await?;
        let (status, body) = exchange(stream, &self.name, token, text).await?;
        match status {
            StatusCode::OK | StatusCode::NO_CONTENT => {
                String::from_utf8(body.to_vec()).map_err(|_| ClientError::Lost)
            }
            status => Err(refused(&self.name, status, Some(&body))),
        }
    }

    /// True if a station with this name answers with a trusted certificate.
    pub async fn is_reachable(&self) -> bool {
        self.open().await.is_ok()
    }

    /// Opens a WebSocket, without saying hello.
    ///
    /// # Errors
    /// The same as [`post`](Self::post).
    pub async fn socket(&self) -> Result<RawSocket, ClientError> {
        let opening = async {
            let stream = self.open().await?;
            upgrade(stream, "wss", &self.name).await
        };
        let opened = timeout(OPEN_TIMEOUT, opening).await;
        opened.unwrap_or_else(|_| Err(no_station(&self.name, NO_ANSWER)))
    }

    /// Connects to the first address at which a station with this name answers.
    async fn open(&self) -> Result<Box<dyn Stream>, ClientError> {
        if self.addresses.is_empty() {
            return Err(no_station(&self.name, "it has not said where it listens"));
        }
        // All addresses at once: a dead one would otherwise delay a stop by its whole timeout.
        let tries = self.addresses.iter().map(|at| Box::pin(self.open_at(*at)));
        let opened = timeout(OPEN_TIMEOUT, select_ok(tries)).await;
        let opened = opened.unwrap_or_else(|_| Err(no_station(&self.name, NO_ANSWER)));
        opened.map(|(stream, _)| stream)
    }

    async fn open_at(&self, at: SocketAddr) -> Result<Box<dyn Stream>, ClientError> {
        let stream = with_descriptor(|| TcpStream::connect(at)).await;
        let stream = stream.map_err(|error| no_station(&self.name, error))?;
        // A stop is one small message and must not wait for Nagle's algorithm.
        let _ = stream.set_nodelay(true);
        let name = ServerName::try_from(self.name.clone())
            .map_err(|_| ClientError::Address(format!("{} is no name of a host", self.name)))?;
        match self.connector.connect(name, stream).await {
            Ok(stream) => Ok(Box::new(stream)),
            Err(error) => Err(refused_certificate(&self.name, &error)),
        }
    }
}

/// Opens a socket, and retries while the process is out of descriptors. It can run out during a
/// stop of all arms of a large site, which dials every station at several addresses at once. The
/// caller limits the time.
async fn with_descriptor<T, Opening: Future<Output = io::Result<T>>>(
    mut open: impl FnMut() -> Opening,
) -> io::Result<T> {
    loop {
        match open().await {
            Err(error) if is_exhausted(&error) => sleep(DESCRIPTOR_RETRY_DELAY).await,
            opened => return opened,
        }
    }
}

/// True for EMFILE and ENFILE, and WSAEMFILE on Windows.
fn is_exhausted(error: &io::Error) -> bool {
    let codes: &[i32] = if cfg!(windows) { &[10_024] } else { &[23, 24] };
    { error.raw_os_error() }.is_some_and(|code| codes.contains(&code))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn open_retries_without_descriptors_and_reports_other_errors() {
        let exhausted = if cfg!(windows) { 10_024 } else { 24 };
        let mut left = 3;
        let opened = with_descriptor(|| {
            left -= 1;
            let error = (left > 0).then(|| io::Error::from_raw_os_error(exhausted));
            async move { error.map_or(Ok(7), Err) }
        });
        assert_eq!(opened.await.unwrap(), 7);
        assert_eq!(left, 0);
        let refused = with_descriptor(|| async {
            io::Result::<()>::Err(io::ErrorKind::ConnectionRefused.into())
        });
        let kind = refused.await.unwrap_err().kind();
        assert_eq!(kind, io::ErrorKind::ConnectionRefused);
    }
}
